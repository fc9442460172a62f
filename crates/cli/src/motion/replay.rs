//! A motion that is bound to the bodies of a scene, frame by frame.

use glam::{DMat4, DQuat, DVec3};
use musculo_collide::surface::{Aabb, Pose};
use musculo_collide::{BodyId, Scene, SceneError};

use super::{Follower, Follows, FramePath, Replay, RestingBody};

impl Replay {
    pub(crate) fn frame_count(&self) -> usize {
        self.motion.maps.len()
    }

    /// Returns the time of a frame in seconds, where the file has one.
    pub(crate) fn time(&self, frame: usize) -> Option<f64> {
        self.motion.times[frame]
    }

    /// Returns the time of a frame in a series of files: its number, unless all frames have a time.
    pub(crate) fn series_time(&self, frame: usize) -> f64 {
        let has_times = self.motion.times.iter().all(Option::is_some);
        let time = self.time(frame).filter(|_| has_times);
        time.unwrap_or_else(|| f64::from(u32::try_from(frame).unwrap_or(u32::MAX)))
    }

    /// Returns the bodies that rest in all frames.
    pub(crate) fn resting(&self) -> &[RestingBody] {
        &self.resting
    }

    /// Computes the positions of all bodies in a frame.
    pub(crate) fn positions(&self, frame: usize) -> Vec<Vec<DVec3>> {
        let maps = &self.motion.maps[frame];
        let mut positions = Vec::new();
        for Follower { rest, follows, .. } in &self.followers {
            positions.push(match (follows, &self.motion.skin) {
                (Follows::Map(name), _) => {
                    rest.iter().map(|&x| maps[name].transform_point3(x)).collect()
                }
                (Follows::Skin, Some(skin)) => skin.deform(rest, maps),
                (Follows::Between(between), _) => between.deform(rest, maps),
                (Follows::Skin | Follows::Nothing, _) => rest.clone(),
            });
        }
        positions
    }

    /// Returns the path of a body from a frame to the next.
    pub(crate) fn path(&self, body: usize, frame: usize) -> FramePath<'_> {
        FramePath::new(self, body, frame)
    }

    /// Returns the positions of a body at rest.
    pub(crate) fn rest(&self, body: usize) -> &[DVec3] {
        &self.followers[body].rest
    }

    /// Returns the box around the faces of a body at rest.
    pub(crate) fn rest_bounds(&self, body: usize) -> Aabb {
        self.followers[body].bounds
    }

    /// Returns the maps of a frame, in the order of their names.
    pub(crate) fn maps(&self, frame: usize) -> impl Iterator<Item = &DMat4> {
        self.motion.maps[frame].values()
    }

    /// Returns the maps that a body follows, by their numbers in a frame: one, or one per segment
    /// of the skin, or two between which it moves; none for a part at rest.
    pub(crate) fn maps_of(&self, body: usize) -> Vec<Option<usize>> {
        let number = |name: &String| self.motion.maps[0].keys().position(|known| known == name);
        match (&self.followers[body].follows, &self.motion.skin) {
            (Follows::Map(name), _) => vec![number(name)],
            (Follows::Skin, Some(skin)) => {
                skin.segments().iter().map(|name| name.as_ref().and_then(number)).collect()
            }
            (Follows::Between(between), _) => {
                between.maps.iter().map(|name| name.as_ref().and_then(number)).collect()
            }
            (Follows::Skin | Follows::Nothing, _) => vec![None],
        }
    }

    /// Returns the largest number of maps that one body follows.
    pub(crate) fn max_maps(&self) -> usize {
        (0..self.followers.len()).map(|body| self.maps_of(body).len()).max().unwrap_or(0)
    }

    /// Returns which of its maps a vertex of a body follows, and the share of the next one.
    pub(crate) fn share(&self, body: usize, vertex: u32) -> (usize, f64) {
        let Follower { rest, follows, .. } = &self.followers[body];
        match (follows, &self.motion.skin) {
            (Follows::Skin, Some(skin)) => skin.share(rest[vertex as usize]),
            (Follows::Between(between), _) => (0, between.shares[vertex as usize]),
            _ => (0, 0.0),
        }
    }

    /// Moves all bodies of the scene to a frame.
    pub(crate) fn place(&self, scene: &mut Scene, frame: usize) -> Result<(), SceneError> {
        // The scene is borrowed by its numbers while bodies move.
        let ids: Vec<BodyId> = scene.ids().collect();
        for (id, x) in ids.into_iter().zip(self.positions(frame)) {
            scene.move_body(id, &x)?;
        }
        Ok(())
    }

    /// Returns the pose of a body in a frame, if it follows a map.
    pub(crate) fn pose(&self, body: usize, frame: usize) -> Option<Pose> {
        match &self.followers[body].follows {
            Follows::Map(name) => {
                let map = self.motion.maps[frame][name];
                Some(Pose::new(DQuat::from_mat4(&map), map.w_axis.truncate()))
            }
            Follows::Nothing | Follows::Skin | Follows::Between(_) => None,
        }
    }
}
