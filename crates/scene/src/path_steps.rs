//! Step of a scene along paths: what moves rigidly, and pieces for the rest.

use std::fmt;

use ccd::{CcdParams, chord_deviation};
use glam::DVec3;
use surface::{Aabb, Path, RelativePath, SurfaceError, mean_edge, parallel};

use crate::rigid_paths::{MAX_PIECES, RigidPair};
use crate::sweep::NearLines;
use crate::{Body, BodyId, PairId, Scene, SceneError};

/// Deviation from chords, relative to the mean edge of a body, that a piece may have.
///
/// Smaller takes more pieces, each with its bounds; larger finds more candidates that do not meet.
const DEVIATION: f64 = 0.25;

/// Roundings of a coordinate in the position of a path.
const ROUNDINGS: f64 = 64.0;

/// Path of a body during a step.
#[derive(Clone, Copy)]
pub struct PathMove<'a> {
    /// The body.
    pub body: BodyId,
    /// Paths of its vertices, from where they are.
    pub path: &'a dyn Path,
}

impl fmt::Debug for PathMove<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PathMove").field("body", &self.body).finish_non_exhaustive()
    }
}

/// Step of a scene along paths, divided into pieces.
pub(crate) struct Steps<'a> {
    pub(crate) moves: &'a [PathMove<'a>],
    /// Path of each body, by its number; `None` where it rests.
    paths: Vec<Option<&'a dyn Path>>,
    /// Pairs of rigid bodies that may meet, ascending.
    pub(crate) rigid_pairs: Vec<PairId>,
    /// Pieces for other pairs; 0 without any.
    pub(crate) pieces: u32,
    /// Positions of each moving body at the end of the step.
    pub(crate) ends: Vec<Vec<DVec3>>,
    /// Bound of the second derivative of each particle's path.
    bends: Vec<f64>,
    /// Distances of particles from their chords over a piece.
    pub(crate) near: NearLines,
    /// Bound of the rounding of the positions of two primitives.
    pub(crate) rounding: f64,
}

/// Extent of a path of a body.
struct PathExtent {
    /// Bound of the second derivative of each vertex's path, and the largest.
    bends: Vec<f64>,
    bend: f64,
    /// Box around the body during the step.
    bounds: Aabb,
    /// Positions at the end of the step.
    end: Vec<DVec3>,
}

impl PathExtent {
    fn new(body: &Body, path: &dyn Path) -> Result<Self, SceneError> {
        let (mut bends, mut bend) = (Vec::with_capacity(body.positions().len()), 0.0_f64);
        for vertex in (0_u32..).take(body.positions().len()) {
            let of_vertex = path.bend(vertex);
            bends.push(of_vertex);
            bend = bend.max(of_vertex);
        }

        // Both ends of an arc bound it, but for its deviation from the chord.
        let end = positions(path, body.positions().len(), 1.0);
        let mut bounds = Aabb::EMPTY;
        for ((vertex, &x), &at) in body.positions().iter().enumerate().zip(&end) {
            if !at.is_finite() {
                return Err(body.surface_error(SurfaceError::NotFinite { vertex, at }));
            }
            bounds = bounds.with_point(x).with_point(at);
        }
        let bounds = bounds.inflate(chord_deviation(bend, 1.0));
        Ok(Self { bends, bend, bounds, end })
    }

    /// Returns the largest coordinate.
    fn reach(&self) -> f64 {
        self.bounds.min.abs().max(self.bounds.max.abs()).max_element()
    }
}

impl<'a> Steps<'a> {
    pub(crate) fn new(
        scene: &mut Scene,
        moves: &'a [PathMove<'a>],
        params: &CcdParams,
    ) -> Result<Self, SceneError> {
        let mut boxes = scene.boxes();
        let scene = &*scene;
        let mut paths = vec![None; scene.bodies().len()];
        let mut extents: Vec<Option<PathExtent>> = paths.iter().map(|_| None).collect();
        let mut extent = 0.0_f64;
        for bounds in &boxes {
            extent = extent.max(bounds.min.abs().max(bounds.max.abs()).max_element());
        }
        for PathMove { body, .. } in moves {
            scene.get(*body)?;
        }
        let of_moves = parallel::map_slice_with(
            moves,
            || (),
            |(), moving| PathExtent::new(scene.body(moving.body), moving.path),
        );
        let mut ends = Vec::with_capacity(moves.len());
        for (PathMove { body: id, path }, of_path) in moves.iter().zip(of_moves) {
            let mut of_path = of_path?;
            extent = extent.max(of_path.reach());

            // A rigid motion is rounded as its center is, which may be far away.
            if let Some(rigid) = path.rigid() {
                extent = extent.max(rigid.path.center().abs().max_element());
            }
            boxes[id.index()] = of_path.bounds;
            ends.push(std::mem::take(&mut of_path.end));
            (paths[id.index()], extents[id.index()]) = (Some(*path), Some(of_path));
        }
        let rounding = 2.0 * ROUNDINGS * f64::EPSILON * extent;

        let mut steps = Self {
            moves,
            paths,
            rigid_pairs: Vec::new(),
            pieces: 0,
            ends,
            bends: Vec::new(),
            near: NearLines::default(),
            rounding,
        };

        // Rigid bodies are swept by themselves; others decide the length of pieces.
        let mut is_member = vec![false; steps.paths.len()];
        for pair in scene.candidate_pairs(&boxes, params.min_separation + rounding) {
            let [a, b] = pair.bodies().map(BodyId::index);
            if steps.is_rigid(a) && steps.is_rigid(b) {
                steps.rigid_pairs.push(pair);
            } else {
                (is_member[a], is_member[b]) = (true, true);
                steps.pieces = 1;
            }
        }
        let mut max_bends = Vec::new();
        for ((body, extent), is_member) in scene.bodies().iter().zip(extents).zip(is_member) {
            let count = steps.bends.len() + body.positions().len();
            let mut bend = 0.0;
            if let Some(extent) = extent {
                bend = if is_member { extent.bend } else { 0.0 };
                steps.bends.extend(extent.bends);
            }
            steps.bends.resize(count, 0.0);
            max_bends.push(bend);
        }
        steps.divide(scene, &max_bends);
        Ok(steps)
    }

    /// Divides the step into pieces, by how much the path of each body bends at most.
    fn divide(&mut self, scene: &Scene, max_bends: &[f64]) {
        for (body, &bend) in scene.bodies().iter().zip(max_bends) {
            if bend > 0.0 {
                let edge = mean_edge(body.surface(), body.checked_positions());
                self.pieces = self.pieces.max(pieces_for(bend, DEVIATION * edge));
            }
        }
        let piece = 1.0 / f64::from(self.pieces.max(1));
        let deviations = |bends: &[f64]| bends.iter().map(|b| chord_deviation(*b, piece)).collect();
        self.near.max_of_bodies = deviations(max_bends);
        self.near.deviations = deviations(&self.bends);
    }

    /// Returns true if a body rests, or moves rigidly.
    fn is_rigid(&self, body: usize) -> bool {
        self.paths[body].is_none_or(|path| path.rigid().is_some())
    }

    /// Returns the relative motion of two rigid bodies.
    pub(crate) fn rigid_pair<'b>(&self, scene: &'b Scene, id: PairId) -> RigidPair<'b> {
        // Deviations add up: either body may be off its rigid path.
        let (mut paths, mut deviation) = ([None; 2], 0.0);
        for (path, body) in paths.iter_mut().zip(id.bodies()) {
            if let Some(motion) = self.paths[body.index()].and_then(Path::rigid) {
                *path = Some(motion.path);
                deviation += motion.deviation;
            }
        }

        let [a, b] = paths;
        RigidPair {
            bodies: id.bodies().map(|body| scene.body(body)),
            relative: RelativePath::new(a, b),
            rounding: deviation * (1.0 + 4.0 * f64::EPSILON) + 4.0 * self.rounding,
        }
    }

    /// Writes where some vertices of a body are at a time.
    pub(crate) fn place(
        &self,
        body: &Body,
        id: BodyId,
        vertices: &[u32],
        time: f64,
        out: &mut [DVec3],
    ) {
        match self.paths[id.index()] {
            Some(path) => path.positions(vertices, time, out),
            None => {
                for (out, &vertex) in out.iter_mut().zip(vertices) {
                    *out = body.positions()[vertex as usize];
                }
            }
        }
    }

    /// Returns the largest bend of some particles.
    pub(crate) fn max_bend(&self, particles: &[u32]) -> f64 {
        let mut largest = 0.0_f64;
        for &particle in particles {
            largest = largest.max(self.bends[particle as usize]);
        }
        largest
    }

    /// Returns the start and the end of a piece: neighbors share theirs to the bit.
    pub(crate) fn interval(&self, piece: u32) -> [f64; 2] {
        [piece, piece + 1].map(|k| f64::from(k) / f64::from(self.pieces))
    }
}

/// Returns the number of pieces over which a path deviates by no more than a length.
fn pieces_for(bend: f64, deviation: f64) -> u32 {
    let mut pieces = 1;
    while pieces < MAX_PIECES && chord_deviation(bend, 1.0 / f64::from(pieces)) > deviation {
        pieces += 1;
    }
    pieces
}

/// Computes the positions of all vertices at a time.
pub(crate) fn positions(path: &dyn Path, count: usize, time: f64) -> Vec<DVec3> {
    /// Vertices per task: some hundred times what a task costs.
    const CHUNK: usize = 2048;

    let mut positions = vec![DVec3::ZERO; count];
    parallel::for_each(positions.chunks_mut(CHUNK).collect(), |chunk, out| {
        // Surfaces have fewer than 2³² vertices.
        let first = u32::try_from(chunk * CHUNK).unwrap_or(u32::MAX);
        let vertices: Vec<u32> = (first..).take(out.len()).collect();
        path.positions(&vertices, time, out);
    });
    positions
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::icosphere;
    use surface::{RigidBodyPath, RigidPath};

    use super::*;
    use crate::BodyKind;

    /// A small turn about a far center is rounded by more than the coordinates of the body are.
    #[test]
    fn rounding_bounds_turns_about_far_centers() {
        let mut scene = Scene::new();
        for number in 0..2 {
            let ball = icosphere(5.0, 1).translated(DVec3::X * 11.0 * f64::from(number));
            let (surface, x) = (ball.surface(), ball.positions);
            scene.add(number.to_string(), BodyKind::Rigid, surface, x).expect("a body");
        }
        let [first, second] = [0, 1].map(BodyId);
        let from = scene.body(first).positions().to_vec();
        let turn = RigidPath::turn(DVec3::new(3e9, 1e9, 0.0), DVec3::new(0.1, 0.2, 1.0), 1e-9);
        let path = RigidBodyPath { from: &from, path: turn };
        let moves = [PathMove { body: first, path: &path }];
        let steps = Steps::new(&mut scene, &moves, &CcdParams::EXACT).expect("finite");
        let pair = steps.rigid_pair(&scene, PairId::new(first, second));

        let mut largest = 0.0_f64;
        for (vertex, &x) in (0_u32..).zip(&from) {
            for time in [0.3, 0.7, 1.0] {
                let at = pair.relative.map(time).transform_point3(x);
                largest = largest.max(at.distance(path.position(vertex, time)));
            }
        }
        assert!(largest > 1e-9, "{largest} is no rounding to speak of");
        assert!(largest <= pair.rounding, "{largest} above {}", pair.rounding);
    }
}
