//! Motion files:
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
//! A frame's lists of 16 numbers are rigid 4 × 4 maps from rest, row by row, in the
//! scene's unit. Other content of a frame is ignored.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DMat3, DMat4, DVec3, DVec4};
use serde::Deserialize;
use serde_json::Value;

use super::skin::Skin;
use super::{Motion, MotionProblem};

#[derive(Debug, Deserialize)]
struct MotionFile {
    frames: Vec<BTreeMap<String, Value>>,
    skin: Option<SkinEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SkinEntry {
    axis: [f64; 3],
    segments: Vec<Option<String>>,
    blends: Vec<[f64; 2]>,
}

impl Motion {
    /// Reads and checks a file.
    pub(super) fn read(path: &Path) -> Result<Self, MotionProblem> {
        Self::parse(&mesh_io::read_text(path)?)
    }

    /// Parses and checks the content of a file.
    pub(crate) fn parse(text: &str) -> Result<Self, MotionProblem> {
        let file: MotionFile = serde_json::from_str(text)?;
        if file.frames.len() < 2 {
            return Err(MotionProblem::TooFewFrames(file.frames.len()));
        }
        let skin = match file.skin {
            Some(SkinEntry { axis, segments, blends }) => {
                Some(Skin::new(DVec3::from(axis), segments, blends)?)
            }
            None => None,
        };

        let (mut times, mut maps) = (Vec::new(), Vec::new());
        for (number, frame) in file.frames.iter().enumerate() {
            times.push(frame.get("t").and_then(Value::as_f64));
            maps.push(rigid_maps(number, frame)?);
        }
        check_names(&maps, skin.as_ref())?;
        Ok(Self { times, maps, skin })
    }
}

fn rigid_maps(
    frame: usize,
    entries: &BTreeMap<String, Value>,
) -> Result<BTreeMap<String, DMat4>, MotionProblem> {
    let mut maps = BTreeMap::new();
    for (name, value) in entries {
        if let Some(rows) = sixteen_numbers(value) {
            maps.insert(name.clone(), rigid_map(frame, name, rows)?);
        }
    }
    Ok(maps)
}

fn sixteen_numbers(value: &Value) -> Option<[f64; 16]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

/// Largest deviation of a map's axes from unit and orthogonal. Files round to some nine
/// digits; a scale or shear that matters to contact is far larger.
const RIGID_TOLERANCE: f64 = 1e-6;

fn rigid_map(frame: usize, name: &str, rows: [f64; 16]) -> Result<DMat4, MotionProblem> {
    let map = DMat4::from_cols_array(&rows).transpose();
    if !map.is_finite() {
        return Err(MotionProblem::NotFinite { frame, name: name.to_owned() });
    }
    let rotation = DMat3::from_mat4(map);
    let residue = rotation.transpose() * rotation - DMat3::IDENTITY;
    let is_orthonormal = residue.abs_diff_eq(DMat3::ZERO, RIGID_TOLERANCE);
    if !is_orthonormal || rotation.determinant() <= 0.0 || map.row(3) != DVec4::W {
        return Err(MotionProblem::NotRigid { frame, name: name.to_owned() });
    }
    Ok(map)
}

/// Checks that every frame has the same maps, and those that the skin follows.
fn check_names(maps: &[BTreeMap<String, DMat4>], skin: Option<&Skin>) -> Result<(), MotionProblem> {
    let names: BTreeSet<&String> = maps.iter().flat_map(BTreeMap::keys).collect();
    for (frame, maps) in maps.iter().enumerate() {
        if let Some(&name) = names.iter().find(|&&name| !maps.contains_key(name)) {
            return Err(MotionProblem::MissingMap { frame, name: name.clone() });
        }
    }
    let mut followed = skin.into_iter().flat_map(Skin::maps);
    match followed.find(|&name| !names.contains(name)) {
        Some(name) => Err(MotionProblem::SkinMap { name: name.clone() }),
        None => Ok(()),
    }
}
