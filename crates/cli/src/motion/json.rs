//! Motion files of this program:
//!
//! ```json
//! {
//!   "skin": {"axis": [0, 0, 1], "segments": ["tibia", "femur", null], "blends": [[469, 549], [833, 933]]},
//!   "frames": [
//!     {"t": 0.0, "femur": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1], "tibia": […]},
//!     …
//!   ]
//! }
//! ```
//!
//! A frame's lists of 16 numbers are rigid 4 × 4 maps from rest, row by row. All lengths are in the
//! scene's unit, unless the file has another one (`"unit": "m"`). Times, in seconds, must rise. Other
//! content of a frame is ignored, unless it has the name of a body. Each map must move a rigid body or a segment of the skin,
//! unless all rigid bodies have maps or the list `ignore` has its name.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use glam::{DMat4, DVec3};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;

use super::skin::Skin;
use super::{Motion, MotionProblem, keeps_lengths};
use crate::scene::Unit;

#[derive(Debug, Deserialize)]
struct MotionFile {
    /// Unit of all lengths; that of the scene by default.
    unit: Option<Unit>,
    frames: Vec<FrameEntries>,
    skin: Option<SkinEntry>,
    #[serde(default)]
    ignore: BTreeSet<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SkinEntry {
    axis: [f64; 3],
    segments: Vec<Option<String>>,
    blends: Vec<[f64; 2]>,
}

/// All entries of a frame in the order of the file, keys that occur twice included.
#[derive(Debug)]
struct FrameEntries(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for FrameEntries {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(EntryVisitor)
    }
}

struct EntryVisitor;

impl<'de> Visitor<'de> for EntryVisitor {
    type Value = FrameEntries;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a frame with maps by name")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<FrameEntries, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = map.next_entry()? {
            entries.push(entry);
        }
        Ok(FrameEntries(entries))
    }
}

/// Content of a frame.
#[derive(Debug, Default)]
struct Frame {
    time: Option<f64>,
    maps: BTreeMap<String, DMat4>,
    /// Descriptions of all other entries, by name.
    others: BTreeMap<String, String>,
}

impl Motion {
    /// Parses and checks the content of a file.
    pub(crate) fn parse(text: &str, scene_unit: Unit) -> Result<Self, MotionProblem> {
        let file: MotionFile = serde_json::from_str(text)?;
        let factor = file.unit.unwrap_or(scene_unit).meters() / scene_unit.meters();
        if file.frames.len() < 2 {
            return Err(MotionProblem::TooFewFrames(file.frames.len()));
        }

        // Each entry is checked by itself, then frames against each other.
        let skin = match file.skin {
            Some(SkinEntry { axis, segments, mut blends }) => {
                blends.iter_mut().flatten().for_each(|height| *height *= factor);
                Some(Skin::new(DVec3::from(axis), segments, blends)?)
            }
            None => None,
        };

        let mut frames = Vec::new();
        for (number, entries) in file.frames.into_iter().enumerate() {
            frames.push(Frame::new(number, entries)?);
        }
        check_times(&frames)?;
        check_names(&frames, skin.as_ref(), &file.ignore)?;

        // Entries that are no maps may still have the name of a body.
        let mut motion = Self { skin, ignored: file.ignore, ..Self::default() };
        for (number, frame) in frames.into_iter().enumerate() {
            motion.times.push(frame.time);
            let in_unit = |(name, map): (String, DMat4)| {
                let to = factor * map.w_axis.truncate();
                (name, DMat4 { w_axis: to.extend(1.0), ..map })
            };
            motion.maps.push(frame.maps.into_iter().map(in_unit).collect());
            for (name, found) in frame.others {
                motion.others.entry(name).or_insert((number, found));
            }
        }
        Ok(motion)
    }
}

impl Frame {
    fn new(frame: usize, FrameEntries(entries): FrameEntries) -> Result<Self, MotionProblem> {
        let mut content = Self::default();
        let mut names = BTreeSet::new();
        for (name, value) in entries {
            // A map that occurs twice is a mistake that the last one would hide.
            if !names.insert(name.clone()) {
                return Err(MotionProblem::DuplicateKey { frame, name });
            }

            if name == "t" {
                let problem = || MotionProblem::TimeKind { frame, value: value.to_string() };
                content.time = Some(value.as_f64().ok_or_else(problem)?);
            } else if let Some(rows) = sixteen_numbers(&value) {
                let map = rigid_map(frame, &name, rows)?;
                content.maps.insert(name, map);
            } else {
                content.others.insert(name, description(&value));
            }
        }
        Ok(content)
    }
}

/// Describes an entry that is no map.
fn description(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(_) => "a truth value".to_owned(),
        Value::Number(number) => format!("the number {number}"),
        Value::String(_) => "text".to_owned(),
        Value::Array(list) if list.iter().all(Value::is_number) => {
            format!("a list of {} numbers", list.len())
        }
        Value::Array(_) => "a list of more than numbers".to_owned(),
        Value::Object(_) => "an object".to_owned(),
    }
}

fn sixteen_numbers(value: &Value) -> Option<[f64; 16]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

fn rigid_map(frame: usize, name: &str, rows: [f64; 16]) -> Result<DMat4, MotionProblem> {
    let map = DMat4::from_cols_array(&rows).transpose();
    if !map.is_finite() {
        return Err(MotionProblem::NotFinite { frame, name: name.to_owned() });
    }

    if !keeps_lengths(map) {
        return Err(MotionProblem::NotRigid { frame, name: name.to_owned() });
    }
    if map.determinant() < 0.0 {
        return Err(MotionProblem::Mirrors { frame, name: name.to_owned() });
    }
    Ok(map)
}

/// Checks that times rise from frame to frame, where frames have them.
fn check_times(frames: &[Frame]) -> Result<(), MotionProblem> {
    let mut last: Option<(usize, f64)> = None;
    for (frame, Frame { time, .. }) in frames.iter().enumerate() {
        let Some(time) = *time else { continue };

        // Frames without a time are passed over.
        if let Some((last_frame, last_time)) = last
            && time <= last_time
        {
            return Err(MotionProblem::TimeOrder { frame, time, last_frame, last_time });
        }
        last = Some((frame, time));
    }
    Ok(())
}

/// Checks that every frame has the same maps, among them those that the skin follows and
/// those to ignore.
fn check_names(
    frames: &[Frame],
    skin: Option<&Skin>,
    ignored: &BTreeSet<String>,
) -> Result<(), MotionProblem> {
    // Names of all frames must be in each.
    let names: BTreeSet<&String> = frames.iter().flat_map(|frame| frame.maps.keys()).collect();
    for (frame, Frame { maps, others, .. }) in frames.iter().enumerate() {
        let Some(&name) = names.iter().find(|&&name| !maps.contains_key(name)) else { continue };
        let name = name.clone();
        return Err(match others.get(&name) {
            Some(found) => MotionProblem::NotAMap { frame, name, found: found.clone() },
            None => MotionProblem::MissingMap { frame, name },
        });
    }

    // Names that the rest of the file refers to must exist.
    let mut followed = skin.into_iter().flat_map(Skin::maps);
    if let Some(name) = followed.find(|&name| !names.contains(name)) {
        return Err(MotionProblem::SkinMap { name: name.clone() });
    }
    match ignored.iter().find(|&name| !names.contains(name)) {
        Some(name) => Err(MotionProblem::IgnoredMap { name: name.clone() }),
        None => Ok(()),
    }
}
