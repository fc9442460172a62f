//! Motions: successive states of a scene, as rigid maps from rest for its bones and a
//! blend of these for its soft bodies.

mod file;
mod skin;

#[cfg(test)]
mod gait_tests;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3};
use musculo_collide::distance_field::Pose;
use musculo_collide::{Body, BodyId, BodyKind, Scene, SceneError};

use self::skin::Skin;
use crate::failure::Failure;

/// Reason why a motion cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MotionProblem {
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error("is not a motion: {0}")]
    Syntax(#[from] serde_json::Error),
    #[error("has {0} frames, but a motion needs at least two")]
    TooFewFrames(usize),
    #[error("frame {frame} has no map {name:?}, which other frames have")]
    MissingMap { frame: usize, name: String },
    #[error(
        "map {name:?} of frame {frame} is not rigid: it changes lengths, or its last row is not 0 0 0 1"
    )]
    NotRigid { frame: usize, name: String },
    #[error("map {name:?} of frame {frame} has a number that is not finite")]
    NotFinite { frame: usize, name: String },
    #[error(
        "the skin has {segments} segments and {blends} blends, but needs one blend fewer than segments"
    )]
    SkinCounts { segments: usize, blends: usize },
    #[error(
        "blend {blend} of the skin runs from {low} to {high}, but blends must rise and not overlap"
    )]
    SkinBlend { blend: usize, low: f64, high: f64 },
    #[error("the skin's axis is {0}, which has no direction")]
    SkinAxis(DVec3),
    #[error("the skin follows {name:?}, but the frames have no such map")]
    SkinMap { name: String },
    #[error("no body follows the motion: its maps are {maps}, the rigid bodies are {bodies}")]
    NoFollower { maps: String, bodies: String },
}

/// Rigid maps from rest by name, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    /// Time of each frame in seconds, where the file has one.
    pub(crate) times: Vec<Option<f64>>,
    maps: Vec<BTreeMap<String, DMat4>>,
    skin: Option<Skin>,
}

/// Motion bound to the bodies of a scene at rest.
#[derive(Debug)]
pub(crate) struct Replay {
    motion: Motion,
    followers: Vec<Follower>,
}

/// Body that follows a motion, with its positions at rest.
#[derive(Debug)]
struct Follower {
    rest: Vec<DVec3>,
    follows: Follows,
}

/// Part of a motion that a body follows.
#[derive(Debug, PartialEq, Eq)]
enum Follows {
    Nothing,
    /// The map of a name.
    Map(String),
    Skin,
}

impl Motion {
    /// Reads a motion file and binds it to a scene at rest.
    pub(crate) fn replay(path: &Path, scene: &Scene) -> Result<Replay, Failure> {
        let motion = Self::read(path).and_then(|motion| motion.bind(scene));
        motion.map_err(|problem| Failure::in_file(path, problem))
    }

    /// Selects for each body the part of the motion that it follows.
    ///
    /// A rigid body follows the map of its name, or of its name after the first
    /// underscore (`bone_femur` follows `femur`). Other bodies follow the skin. Bodies
    /// without a map or a skin rest.
    fn bind(self, scene: &Scene) -> Result<Replay, MotionProblem> {
        let mut followers = Vec::new();
        for body in scene.bodies() {
            let (rest, follows) = (body.positions().to_vec(), self.part_of(body));
            followers.push(Follower { rest, follows });
        }
        if followers.iter().all(|follower| follower.follows == Follows::Nothing) {
            let rigid = scene.bodies().iter().filter(|body| body.kind() == BodyKind::Rigid);
            return Err(MotionProblem::NoFollower {
                maps: listed(self.maps[0].keys().map(String::as_str)),
                bodies: listed(rigid.map(Body::name)),
            });
        }
        Ok(Replay { motion: self, followers })
    }

    fn part_of(&self, body: &Body) -> Follows {
        if body.kind() != BodyKind::Rigid {
            return if self.skin.is_some() { Follows::Skin } else { Follows::Nothing };
        }
        let after_prefix = body.name().split_once('_').map_or("", |(_, after)| after);
        let mut names = [body.name(), after_prefix].into_iter();
        match names.find(|&name| self.maps[0].contains_key(name)) {
            Some(name) => Follows::Map(name.to_owned()),
            None => Follows::Nothing,
        }
    }
}

impl Replay {
    pub(crate) fn frame_count(&self) -> usize {
        self.motion.maps.len()
    }

    /// Returns the time of a frame in seconds, where the file has one.
    pub(crate) fn time(&self, frame: usize) -> Option<f64> {
        self.motion.times[frame]
    }

    /// Computes the positions of all bodies in a frame.
    pub(crate) fn positions(&self, frame: usize) -> Vec<Vec<DVec3>> {
        let maps = &self.motion.maps[frame];
        let mut positions = Vec::new();
        for Follower { rest, follows } in &self.followers {
            positions.push(match (follows, &self.motion.skin) {
                (Follows::Map(name), _) => {
                    rest.iter().map(|&x| maps[name].transform_point3(x)).collect()
                }
                (Follows::Skin, Some(skin)) => skin.deform(rest, maps),
                (Follows::Skin | Follows::Nothing, _) => rest.clone(),
            });
        }
        positions
    }

    /// Moves all bodies of the scene to a frame.
    pub(crate) fn place(&self, scene: &mut Scene, frame: usize) -> Result<(), SceneError> {
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
            Follows::Nothing | Follows::Skin => None,
        }
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
