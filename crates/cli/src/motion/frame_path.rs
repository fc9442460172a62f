//! Paths of bodies from one frame to the next.
//!
//! Bones turn with a constant angular velocity about the middle of what follows their map. Skin
//! follows the blend of the motions of its segments, with the weights that it has at rest, and so does
//! tissue between two bodies to which it is attached.

use glam::{DMat4, DQuat, DVec3};
use musculo_collide::surface::RigidPlace;
use musculo_collide::{NearRigidPath, Path, RigidPath};

use super::{Follows, Replay};

/// Path of a body from a frame to the next.
#[derive(Debug)]
pub(crate) struct FramePath<'a> {
    replay: &'a Replay,
    body: usize,
    /// Motions of the parts that move the body: one, one per segment of the skin, or two that it is between.
    parts: Vec<PartPath>,
    /// Motion of the whole body, if it is one.
    rigid: Option<NearRigidPath>,
}

/// Motion of a bone, or of a segment of the skin.
#[derive(Debug)]
struct PartPath {
    /// Map from rest to the first frame.
    map: DMat4,
    /// Motion from the first frame; `None` for a part at rest.
    path: Option<RigidPath>,
    /// Map from rest to the difference of the second frame and the end of the motion: the rounding
    /// of a file's maps, which are rigid to some digits only. It is added evenly.
    residual: DMat4,
}

/// Place of a part at one time.
struct PartPlace {
    map: DMat4,
    place: Option<RigidPlace>,
    /// Share of the residual.
    residual: DMat4,
}

impl PartPlace {
    fn transform_point(&self, rest: DVec3) -> DVec3 {
        let x = self.map.transform_point3(rest);
        let Some(place) = self.place else { return x };
        place.transform_point(x) + self.residual.transform_point3(rest)
    }
}

impl<'a> FramePath<'a> {
    pub(super) fn new(replay: &'a Replay, body: usize, frame: usize) -> Self {
        let mut parts = Vec::new();
        match (&replay.followers[body].follows, &replay.motion.skin) {
            (Follows::Map(name), _) => parts.push(PartPath::new(replay, Some(name), frame)),
            (Follows::Skin, Some(skin)) => {
                for name in skin.segments() {
                    parts.push(PartPath::new(replay, name.as_ref(), frame));
                }
            }
            (Follows::Between(between), _) => {
                for name in &between.maps {
                    parts.push(PartPath::new(replay, name.as_ref(), frame));
                }
            }
            (Follows::Skin | Follows::Nothing, _) => parts.push(PartPath::at_rest()),
        }
        let mut path = Self { replay, body, parts, rigid: None };
        path.rigid = path.find_rigid();
        path
    }

    /// Returns the motion of a body that follows one map.
    fn find_rigid(&self) -> Option<NearRigidPath> {
        let [part] = self.parts.as_slice() else { return None };
        let Some(path) = part.path else {
            let path = RigidPath::at_rest(DVec3::ZERO);
            return Some(NearRigidPath { path, deviation: 0.0 });
        };

        // The residual is linear in time, and largest at the end.
        let mut deviation = 0.0_f64;
        for &x in self.replay.rest(self.body) {
            deviation = deviation.max(part.residual.transform_point3(x).length());
        }
        Some(NearRigidPath { path, deviation })
    }

    /// Returns a vertex at rest, and the one or two parts that it follows with their shares.
    fn parts_of(&self, vertex: u32) -> (DVec3, [(usize, f64); 2]) {
        let rest = self.replay.rest(self.body)[vertex as usize];
        let (part, share) = self.replay.share(self.body, vertex);
        let next = (part + 1).min(self.parts.len() - 1);
        (rest, [(part, 1.0 - share), (next, share)])
    }
}

impl Path for FramePath<'_> {
    fn position(&self, vertex: u32, time: f64) -> DVec3 {
        let mut position = [DVec3::ZERO];
        self.positions(&[vertex], time, &mut position);
        position[0]
    }

    fn positions(&self, vertices: &[u32], time: f64, out: &mut [DVec3]) {
        // The turn of each part is computed once for all vertices.
        let mut places = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            places.push(part.place(time));
        }

        for (out, &vertex) in out.iter_mut().zip(vertices) {
            let (rest, [first, second]) = self.parts_of(vertex);
            let mut position = DVec3::ZERO;
            for (part, share) in [first, second] {
                if share > 0.0 {
                    position += share * places[part].transform_point(rest);
                }
            }
            *out = position;
        }
    }

    fn bend(&self, vertex: u32) -> f64 {
        let (rest, parts) = self.parts_of(vertex);
        let mut bend = 0.0;
        for (part, share) in parts {
            bend += share * self.parts[part].bend(rest);
        }
        bend * (1.0 + 8.0 * f64::EPSILON)
    }

    fn rigid(&self) -> Option<NearRigidPath> {
        self.rigid
    }
}

impl PartPath {
    fn at_rest() -> Self {
        Self { map: DMat4::IDENTITY, path: None, residual: DMat4::ZERO }
    }

    /// Returns the motion of a map from a frame to the next; a segment without a map rests.
    fn new(replay: &Replay, name: Option<&String>, frame: usize) -> Self {
        let Some(name) = name else { return Self::at_rest() };
        let [from, to] = [frame, frame + 1].map(|frame| replay.motion.maps[frame][name]);
        if from == to {
            return Self { map: from, path: None, residual: DMat4::ZERO };
        }

        // The map from the first frame to the next.
        let step = to * from.inverse();
        let center = replay.centers.get(name).copied().unwrap_or(DVec3::ZERO);
        let (rotation, shift) = (DQuat::from_mat4(&step), step.w_axis.truncate());
        let path = RigidPath::new(rotation, shift, from.transform_point3(center));
        let end = DMat4::from_cols(
            path.transform_vector(from.x_axis.truncate()).extend(0.0),
            path.transform_vector(from.y_axis.truncate()).extend(0.0),
            path.transform_vector(from.z_axis.truncate()).extend(0.0),
            path.transform_point(from.w_axis.truncate(), 1.0).extend(1.0),
        );
        Self { map: from, path: Some(path), residual: to - end }
    }

    /// Returns the place of the part at a time.
    fn place(&self, time: f64) -> PartPlace {
        let place = self.path.map(|path| path.place(time));
        PartPlace { map: self.map, place, residual: time * self.residual }
    }

    fn bend(&self, rest: DVec3) -> f64 {
        self.path.map_or(0.0, |path| path.bend(self.map.transform_point3(rest)))
    }
}
