//! Motions: successive states of a scene, as maps from rest for its bones and a
//! blend of these for what is soft.

mod file;
mod skin;

#[cfg(test)]
mod gait_tests;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DMat4, DQuat, DVec3};
use musculo_collide::distance_field::Pose;
use musculo_collide::{Body, BodyKind, Scene};

pub(crate) use self::file::parse;
use self::skin::Skin;

/// Why a motion cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}", path = .path.display())]
pub(crate) struct MotionError {
    path: PathBuf,
    problem: Problem,
}

/// What is wrong with a motion.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum Problem {
    #[error("cannot be read: {0}")]
    Unreadable(String),
    #[error("is not a motion: {0}")]
    Syntax(String),
    #[error("has {0} frames; a motion needs two at least")]
    TooFewFrames(usize),
    #[error("frame {frame} has no map {name:?}, which other frames have")]
    MissingMap { frame: usize, name: String },
    #[error(
        "map {name:?} of frame {frame} is not rigid: it changes lengths or has another last row than 0 0 0 1"
    )]
    NotRigid { frame: usize, name: String },
    #[error("map {name:?} of frame {frame} holds a number that is not finite")]
    NotFinite { frame: usize, name: String },
    #[error(
        "the skin has {segments} segments and {blends} blends; it needs one blend fewer than segments"
    )]
    SkinCounts { segments: usize, blends: usize },
    #[error(
        "blend {blend} of the skin runs from {low} to {high}; blends must rise and not overlap"
    )]
    SkinBlend { blend: usize, low: f64, high: f64 },
    #[error("the skin's axis is {0}, which has no direction")]
    SkinAxis(DVec3),
    #[error("the skin follows {name:?}, of which the frames have no map")]
    SkinMap { name: String },
    #[error("no body follows it: it maps {known}, and the rigid bodies are {bodies}")]
    NoFollower { known: String, bodies: String },
}

/// Rigid maps from rest by name, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    path: PathBuf,
    /// Seconds, where the file tells them.
    pub(crate) times: Vec<Option<f64>>,
    maps: Vec<BTreeMap<String, DMat4>>,
    skin: Option<Skin>,
}

/// A motion bound to the bodies of a scene at rest.
#[derive(Debug)]
pub(crate) struct Replay<'a> {
    motion: &'a Motion,
    bodies: Vec<Follower>,
}

/// How a body follows a motion, from its positions at rest.
#[derive(Debug)]
enum Follower {
    Still(Vec<DVec3>),
    Map { name: String, rest: Vec<DVec3> },
    Skin(Vec<DVec3>),
}

impl Motion {
    /// Reads a motion file.
    pub(crate) fn read(path: &Path) -> Result<Self, MotionError> {
        file::read(path)
            .map_err(|problem| MotionError { path: path.to_owned(), problem })
            .map(|motion| Self { path: path.to_owned(), ..motion })
    }

    pub(crate) fn frame_count(&self) -> usize {
        self.maps.len()
    }

    /// Finds for each body what it follows: a rigid body the map of its name,
    /// or of its name after the first underscore (`bone_femur` follows
    /// `femur`); a soft one the skin. Others stay where they are.
    pub(crate) fn bind(&self, scene: &Scene) -> Result<Replay<'_>, MotionError> {
        let bodies: Vec<Follower> = scene.bodies().iter().map(|body| self.follower(body)).collect();
        if bodies.iter().all(|body| matches!(body, Follower::Still(_))) {
            let rigid = scene.bodies().iter().filter(|body| body.kind() == BodyKind::Rigid);
            let problem = Problem::NoFollower {
                known: listed(self.maps[0].keys().map(String::as_str)),
                bodies: listed(rigid.map(Body::name)),
            };
            return Err(MotionError { path: self.path.clone(), problem });
        }
        Ok(Replay { motion: self, bodies })
    }

    fn follower(&self, body: &Body) -> Follower {
        let rest = body.positions().to_vec();
        if body.kind() != BodyKind::Rigid {
            return if self.skin.is_some() { Follower::Skin(rest) } else { Follower::Still(rest) };
        }
        let after_prefix = body.name().split_once('_').map_or("", |(_, after)| after);
        let names = [body.name(), after_prefix];
        match names.into_iter().find(|&name| self.maps[0].contains_key(name)) {
            Some(name) => Follower::Map { name: name.to_owned(), rest },
            None => Follower::Still(rest),
        }
    }
}

impl Replay<'_> {
    /// Where each body's vertices are in a frame.
    pub(crate) fn positions(&self, frame: usize) -> Vec<Vec<DVec3>> {
        let maps = &self.motion.maps[frame];
        let of_body = |body: &Follower| match (body, &self.motion.skin) {
            (Follower::Map { name, rest }, _) => {
                rest.iter().map(|&x| maps[name].transform_point3(x)).collect()
            }
            (Follower::Skin(rest), Some(skin)) => skin.deform(rest, maps),
            (Follower::Skin(rest) | Follower::Still(rest), _) => rest.clone(),
        };
        self.bodies.iter().map(of_body).collect()
    }

    /// The pose of a body in a frame, by their numbers; none for one that is not
    /// mapped as a whole.
    pub(crate) fn pose(&self, body: usize, frame: usize) -> Option<Pose> {
        match &self.bodies[body] {
            Follower::Map { name, .. } => {
                let map = self.motion.maps[frame][name];
                Some(Pose::new(DQuat::from_mat4(&map), map.w_axis.truncate()))
            }
            Follower::Still(_) | Follower::Skin(_) => None,
        }
    }

    pub(crate) fn frame_count(&self) -> usize {
        self.motion.frame_count()
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
