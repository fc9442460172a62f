//! Motions: successive states of a scene, as rigid maps from rest for its bones and a
//! blend of these for its soft bodies.

mod arguments;
mod attached;
mod frame_path;
mod json;
mod names;
mod opensim;
mod pose_rows;
mod pose_table;
mod replay;
mod skin;

#[cfg(test)]
mod gait_tests;
#[cfg(test)]
mod path_tests;
#[cfg(test)]
mod table_tests;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::iter;
use std::path::Path;

use glam::{DMat3, DMat4, DVec3, DVec4};
use musculo_collide::surface::{Aabb, MAX_COORDINATE};
use musculo_collide::{Body, BodyKind, Scene};
use serde::Serialize;

pub(crate) use self::arguments::{MotionArgs, MotionParams};
use self::attached::Between;
pub(crate) use self::attached::{Attached, AttachedBody};
pub(crate) use self::frame_path::FramePath;
use self::pose_table::TableProblem;
use self::skin::Skin;
use crate::failure::Failure;
use crate::scene::Unit;

/// Reason why a motion cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MotionProblem {
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error("is not a motion: {0}")]
    Syntax(#[from] serde_json::Error),
    #[error(transparent)]
    Table(#[from] TableProblem),
    #[error(
        "has maps from rest in the scene's unit: {0} is for tables of poses (.csv, .sto, .mot)"
    )]
    TableOption(&'static str),
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
    #[error("map {name:?} of frame {frame} is not rigid: it mirrors (its determinant is -1)")]
    Mirrors { frame: usize, name: String },
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
        "map {name:?} moves no body: the nearest names of bodies without a map are {nearest}; rename the map, let a body follow it (--follow), or {}",
        if *is_table { "leave it out of the table" } else { "add it to the list \"ignore\"" }
    )]
    UnusedMap { name: String, nearest: String, is_table: bool },
    #[error(
        "map {name:?} of frame {frame} moves by {to:e}, but magnitudes end at {MAX_COORDINATE:e}: products of coordinates would overflow"
    )]
    TooFar { frame: usize, name: String, to: f64 },
    #[error(
        "{body} is to follow {name:?}, but the frames have no such map: the nearest names are {nearest}"
    )]
    FollowedMap { body: String, name: String, nearest: String },
    #[error(
        "no body follows the motion: its maps are {maps}, the rigid bodies are {bodies}; say who follows what by --follow or the key `follows`"
    )]
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
    /// True if the maps are from a table of poses.
    is_table: bool,
    /// Other entries by name: the first frame that has them, and what they are.
    others: BTreeMap<String, (usize, String)>,
}

/// Motion bound to the bodies of a scene at rest.
#[derive(Debug)]
pub(crate) struct Replay {
    motion: Motion,
    followers: Vec<Follower>,
    resting: Vec<RestingBody>,
    /// Middle of the bodies at rest that follow each map, by its name: bodies of one map turn about
    /// one point.
    centers: BTreeMap<String, DVec3>,
}

/// Body that follows a motion, with its positions at rest.
#[derive(Debug)]
struct Follower {
    rest: Vec<DVec3>,
    /// Box around its faces at rest.
    bounds: Aabb,
    follows: Follows,
}

/// Part of a motion that a body follows.
#[derive(Debug, PartialEq)]
enum Follows {
    Nothing,
    /// The map of a name.
    Map(String),
    Skin,
    Between(Between),
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
    /// A soft body that is attached to others at rest.
    Attached,
    /// A soft body that is attached to more than two that move apart.
    AttachedToMany,
}

impl Motion {
    /// Reads a motion file and binds it to a scene at rest.
    pub(crate) fn replay(
        path: &Path,
        params: &MotionParams,
        scene: &Scene,
    ) -> Result<Replay, Failure> {
        let motion = Self::read(path, params).and_then(|motion| {
            check_places(&motion.maps)?;
            motion.bind(scene, &params.follows)
        });
        motion.map_err(|problem| Failure::in_file(path, problem))
    }

    /// Reads and checks a file, in the format of its extension.
    fn read(path: &Path, params: &MotionParams) -> Result<Self, MotionProblem> {
        let text = mesh_io::read_text(path)?;
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
        let (table, unit) = match extension.as_ref().and_then(|extension| extension.to_str()) {
            // OpenSim computes in meters.
            Some("sto" | "mot") => (opensim::parse(&text)?, Unit::Meter),
            Some("csv") => (pose_rows::parse(&text)?, params.scene_unit),
            _ => {
                let motion = Self::parse(&text, params.scene_unit)?;
                let option = params.table_option.map(MotionProblem::TableOption);
                return option.map_or(Ok(motion), Err);
            }
        };

        let factor = params.table_unit.unwrap_or(unit).meters() / params.scene_unit.meters();
        let times = table.times.iter().copied().map(Some).collect();
        let maps = table.maps(factor, params.meshes);
        check_frames(&maps)?;
        Ok(Self { times, maps, is_table: true, ..Self::default() })
    }

    /// Returns true if a text is a table of poses, in either format.
    pub(crate) fn is_table(text: &str) -> bool {
        opensim::parse(text).is_ok() || pose_rows::parse(text).is_ok()
    }

    /// Selects for each body the part of the motion that it follows.
    ///
    /// A body follows the map that `chosen` has for its name. Without one, a rigid body follows the
    /// map of its name, or of its name after the first underscore (`bone_femur` follows `femur`),
    /// and other bodies follow the skin. Bodies without a map or a skin rest.
    fn bind(
        self,
        scene: &Scene,
        chosen: &BTreeMap<String, String>,
    ) -> Result<Replay, MotionProblem> {
        let (mut followers, mut resting) = (Vec::new(), Vec::new());
        for body in scene.bodies() {
            let follows = match chosen.get(body.name()) {
                Some(name) => self.chosen_part(body, name)?,
                None => self.part_of(body)?,
            };
            let rest = body.positions().to_vec();
            if follows == Follows::Nothing {
                let is_rigid = body.kind() == BodyKind::Rigid;
                let reason = if is_rigid { RestReason::NoMap } else { RestReason::NoSkin };
                resting.push(RestingBody { body: body.name().to_owned(), reason });
            }
            followers.push(Follower { rest, bounds: body.face_bounds(), follows });
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
        let centers = centers(&followers);
        Ok(Replay { motion: self, followers, resting, centers })
    }

    /// Returns the map that a body is to follow, whatever its kind.
    fn chosen_part(&self, body: &Body, name: &str) -> Result<Follows, MotionProblem> {
        if self.maps[0].contains_key(name) {
            return Ok(Follows::Map(name.to_owned()));
        }
        let known = self.maps[0].keys().map(String::as_str);
        Err(MotionProblem::FollowedMap {
            body: body.name().to_owned(),
            name: name.to_owned(),
            nearest: listed(names::nearest(name, known).into_iter()),
        })
    }

    fn part_of(&self, body: &Body) -> Result<Follows, MotionProblem> {
        // The skin moves all that is soft.
        if body.kind() != BodyKind::Rigid {
            return Ok(if self.skin.is_some() { Follows::Skin } else { Follows::Nothing });
        }

        let names = || iter::once(body.name()).chain(after_prefix(body.name()));
        if let Some(name) = names().find(|&name| self.maps[0].contains_key(name)) {
            return Ok(Follows::Map(name.to_owned()));
        }

        // An entry of the body's name that is no map is a mistake.
        for name in names() {
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
                let (name, is_table) = (name.clone(), self.is_table);
                Err(MotionProblem::UnusedMap { name, nearest, is_table })
            }
            _ => Ok(()),
        }
    }
}

/// Returns the middle of the bodies at rest that follow each map.
fn centers(followers: &[Follower]) -> BTreeMap<String, DVec3> {
    let mut boxes: BTreeMap<String, Aabb> = BTreeMap::new();
    for Follower { bounds, follows, .. } in followers {
        if let Follows::Map(name) = follows {
            let around = boxes.entry(name.clone()).or_insert(Aabb::EMPTY);
            *around = around.union(*bounds);
        }
    }

    let mut centers = BTreeMap::new();
    for (name, bounds) in boxes {
        centers.insert(name, bounds.center());
    }
    centers
}

/// Checks that there are frames, all with the same maps.
fn check_frames(frames: &[BTreeMap<String, DMat4>]) -> Result<(), MotionProblem> {
    if frames.len() < 2 {
        return Err(MotionProblem::TooFewFrames(frames.len()));
    }
    let names: BTreeSet<&String> = frames.iter().flat_map(BTreeMap::keys).collect();
    for (frame, maps) in frames.iter().enumerate() {
        if let Some(&name) = names.iter().find(|&&name| !maps.contains_key(name)) {
            return Err(MotionProblem::MissingMap { frame, name: name.clone() });
        }
    }
    Ok(())
}

/// Checks that maps move nothing beyond the range of coordinates.
fn check_places(frames: &[BTreeMap<String, DMat4>]) -> Result<(), MotionProblem> {
    for (frame, maps) in frames.iter().enumerate() {
        for (name, map) in maps {
            let to = map.w_axis.truncate();
            if !to.abs().cmple(DVec3::splat(MAX_COORDINATE)).all() {
                let (name, to) = (name.clone(), to.abs().max_element());
                return Err(MotionProblem::TooFar { frame, name, to });
            }
        }
    }
    Ok(())
}

/// Largest deviation of a map's axes from unit and orthogonal. Files round to some nine
/// digits; a scale or shear that matters to contact is far larger.
const RIGID_TOLERANCE: f64 = 1e-6;

/// Returns true if a map keeps all lengths: it turns and shifts, and may mirror.
fn keeps_lengths(map: DMat4) -> bool {
    let rotation = DMat3::from_mat4(map);
    let residue = rotation.transpose() * rotation - DMat3::IDENTITY;
    residue.abs_diff_eq(DMat3::ZERO, RIGID_TOLERANCE) && map.row(3) == DVec4::W
}

/// Returns the part of a name after its first underscore, if it has one.
fn after_prefix(name: &str) -> Option<&str> {
    name.split_once('_').map(|(_, after)| after).filter(|after| !after.is_empty())
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
