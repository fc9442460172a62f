//! Motions: successive states of a scene, as rigid maps from rest for its bones and a
//! blend of these for its soft bodies.

mod file;
mod names;
mod skin;

#[cfg(test)]
mod gait_tests;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DMat4, DQuat, DVec3};
use musculo_collide::distance_field::Pose;
use musculo_collide::{Body, BodyId, BodyKind, Scene, SceneError};
use serde::Serialize;

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
    #[error("{name:?} of frame {frame} is {found}, but a map is a list of 16 numbers")]
    NotAMap { frame: usize, name: String, found: String },
    #[error("frame {frame} has more than one entry {name:?}")]
    DuplicateKey { frame: usize, name: String },
    #[error("\"t\" of frame {frame} is {value}, but a time is a number")]
    TimeKind { frame: usize, value: String },
    #[error(
        "\"t\" of frame {frame} is {time}, but times must rise: that of frame {last_frame} is {last_time}"
    )]
    TimeOrder { frame: usize, time: f64, last_frame: usize, last_time: f64 },
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
    #[error("the list \"ignore\" has {name:?}, but the frames have no such map")]
    IgnoredMap { name: String },
    #[error(
        "map {name:?} moves no body: the nearest names of bodies without a map are {nearest}; rename the map, or add it to the list \"ignore\""
    )]
    UnusedMap { name: String, nearest: String },
    #[error("no body follows the motion: its maps are {maps}, the rigid bodies are {bodies}")]
    NoFollower { maps: String, bodies: String },
}

/// Rigid maps from rest by name, frame by frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Motion {
    /// Time of each frame in seconds, where the file has one.
    pub(crate) times: Vec<Option<f64>>,
    maps: Vec<BTreeMap<String, DMat4>>,
    skin: Option<Skin>,
    /// Maps that may move nothing.
    ignored: BTreeSet<String>,
    /// Other entries by name: the first frame that has them, and what they are.
    others: BTreeMap<String, (usize, String)>,
}

/// Motion bound to the bodies of a scene at rest.
#[derive(Debug)]
pub(crate) struct Replay {
    motion: Motion,
    followers: Vec<Follower>,
    resting: Vec<RestingBody>,
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

/// Body that rests in all frames.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct RestingBody {
    pub(crate) body: String,
    pub(crate) reason: RestReason,
}

/// Reason why a body rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum RestReason {
    /// A rigid body whose name no map has.
    NoMap,
    /// A soft body of a motion without a skin.
    NoSkin,
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
        let (mut followers, mut resting) = (Vec::new(), Vec::new());
        for body in scene.bodies() {
            let (rest, follows) = (body.positions().to_vec(), self.part_of(body)?);
            if follows == Follows::Nothing {
                let is_rigid = body.kind() == BodyKind::Rigid;
                let reason = if is_rigid { RestReason::NoMap } else { RestReason::NoSkin };
                resting.push(RestingBody { body: body.name().to_owned(), reason });
            }
            followers.push(Follower { rest, follows });
        }

        // A motion that moves nothing is that of another scene.
        if followers.iter().all(|follower| follower.follows == Follows::Nothing) {
            let rigid = scene.bodies().iter().filter(|body| body.is_rigid());
            return Err(MotionProblem::NoFollower {
                maps: listed(self.maps[0].keys().map(String::as_str)),
                bodies: listed(rigid.map(Body::name)),
            });
        }
        self.check_use(&followers, &resting)?;
        Ok(Replay { motion: self, followers, resting })
    }

    fn part_of(&self, body: &Body) -> Result<Follows, MotionProblem> {
        // The skin moves all that is soft.
        if body.kind() != BodyKind::Rigid {
            return Ok(if self.skin.is_some() { Follows::Skin } else { Follows::Nothing });
        }

        let names = [body.name(), after_prefix(body.name())];
        if let Some(name) = names.into_iter().find(|&name| self.maps[0].contains_key(name)) {
            return Ok(Follows::Map(name.to_owned()));
        }

        // An entry of the body's name that is no map is a mistake.
        for name in names {
            if let Some((frame, found)) = self.others.get(name) {
                let (name, found) = (name.to_owned(), found.clone());
                return Err(MotionProblem::NotAMap { frame: *frame, name, found });
            }
        }
        Ok(Follows::Nothing)
    }

    /// Checks that each map moves a body or the skin, if a rigid body rests that its name
    /// may mean.
    fn check_use(
        &self,
        followers: &[Follower],
        resting: &[RestingBody],
    ) -> Result<(), MotionProblem> {
        // Maps move the skin or a body, or are to be ignored.
        let mut used: BTreeSet<&str> = self.ignored.iter().map(String::as_str).collect();
        used.extend(self.skin.iter().flat_map(Skin::maps).map(String::as_str));
        for follower in followers {
            if let Follows::Map(name) = &follower.follows {
                used.insert(name);
            }
        }

        // Where every rigid body has its map, more maps are those of bodies that are left out.
        let mut rigid = Vec::new();
        for RestingBody { body, reason } in resting {
            if *reason == RestReason::NoMap {
                rigid.push(body.as_str());
            }
        }
        let unused = self.maps[0].keys().find(|&name| !used.contains(name.as_str()));
        match unused {
            Some(name) if !rigid.is_empty() => {
                let nearest = listed(names::nearest(name, rigid.into_iter()).into_iter());
                Err(MotionProblem::UnusedMap { name: name.clone(), nearest })
            }
            _ => Ok(()),
        }
    }
}

/// Returns the part of a name after its first underscore.
fn after_prefix(name: &str) -> &str {
    name.split_once('_').map_or("", |(_, after)| after)
}

impl Replay {
    pub(crate) fn frame_count(&self) -> usize {
        self.motion.maps.len()
    }

    /// Returns the time of a frame in seconds, where the file has one.
    pub(crate) fn time(&self, frame: usize) -> Option<f64> {
        self.motion.times[frame]
    }

    /// Returns the bodies that rest in all frames.
    pub(crate) fn resting(&self) -> &[RestingBody] {
        &self.resting
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
            Follows::Nothing | Follows::Skin => None,
        }
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
