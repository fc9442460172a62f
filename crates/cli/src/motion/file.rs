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
//! A frame's lists of 16 numbers are rigid 4 × 4 maps from rest, row by row, in
//! the scene's unit; whatever else it holds is somebody else's. Instead of
//! `skin`, a file may tell `ambient_skin` by the heights `hip_z` and `knee_z` of
//! a leg whose parts are `femur` and `tibia`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3, DVec4};
use serde::Deserialize;
use serde_json::Value;

use super::skin::Skin;
use super::{Motion, Problem};

#[derive(Debug, Deserialize)]
struct MotionFile {
    frames: Vec<BTreeMap<String, Value>>,
    skin: Option<SkinEntry>,
    ambient_skin: Option<LegEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SkinEntry {
    axis: [f64; 3],
    segments: Vec<Option<String>>,
    blends: Vec<[f64; 2]>,
}

#[derive(Debug, Deserialize)]
struct LegEntry {
    hip_z: f64,
    knee_z: f64,
}

/// Reads and checks a file.
pub(super) fn read(path: &Path) -> Result<Motion, Problem> {
    let text =
        std::fs::read_to_string(path).map_err(|error| Problem::Unreadable(error.to_string()))?;
    parse(&text)
}

pub(crate) fn parse(text: &str) -> Result<Motion, Problem> {
    let file: MotionFile =
        serde_json::from_str(text).map_err(|error| Problem::Syntax(error.to_string()))?;
    if file.frames.len() < 2 {
        return Err(Problem::TooFewFrames(file.frames.len()));
    }
    let skin = match (file.skin, file.ambient_skin) {
        (Some(entry), _) => Some(Skin::new(DVec3::from(entry.axis), entry.segments, entry.blends)?),
        (None, Some(leg)) => Some(skin_of_a_leg(&leg)?),
        (None, None) => None,
    };
    let maps: Vec<BTreeMap<String, DMat4>> = file
        .frames
        .iter()
        .enumerate()
        .map(|(k, frame)| maps(k, frame))
        .collect::<Result<_, _>>()?;
    check_names(&maps, skin.as_ref())?;
    let times = file.frames.iter().map(|frame| frame.get("t").and_then(Value::as_f64)).collect();
    Ok(Motion { path: PathBuf::new(), times, maps, skin })
}

/// Goes over from the thigh to the pelvis within 50 of the hip, and from the
/// shank to the thigh within 40 of the knee.
fn skin_of_a_leg(leg: &LegEntry) -> Result<Skin, Problem> {
    let segments = vec![Some("tibia".to_owned()), Some("femur".to_owned()), None];
    let blends = vec![[leg.knee_z - 40.0, leg.knee_z + 40.0], [leg.hip_z - 50.0, leg.hip_z + 50.0]];
    Skin::new(DVec3::Z, segments, blends)
}

fn maps(
    frame: usize,
    entries: &BTreeMap<String, Value>,
) -> Result<BTreeMap<String, DMat4>, Problem> {
    let mut maps = BTreeMap::new();
    for (name, value) in entries {
        if let Some(rows) = sixteen_numbers(value) {
            maps.insert(name.clone(), rigid(frame, name, rows)?);
        }
    }
    Ok(maps)
}

fn sixteen_numbers(value: &Value) -> Option<[f64; 16]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

/// How far a map's axes may be from unit and orthogonal: files round to some
/// nine digits; a scale or shear that matters to contact is far larger.
const RIGID_TOLERANCE: f64 = 1e-6;

fn rigid(frame: usize, name: &str, rows: [f64; 16]) -> Result<DMat4, Problem> {
    let map = DMat4::from_cols_array(&rows).transpose();
    if !map.is_finite() {
        return Err(Problem::NotFinite { frame, name: name.to_owned() });
    }
    let turn = glam::DMat3::from_mat4(map);
    let residue = turn.transpose() * turn - glam::DMat3::IDENTITY;
    let orthonormal = residue.abs_diff_eq(glam::DMat3::ZERO, RIGID_TOLERANCE);
    if orthonormal && turn.determinant() > 0.0 && map.row(3) == DVec4::W {
        Ok(map)
    } else {
        Err(Problem::NotRigid { frame, name: name.to_owned() })
    }
}

/// Every frame has the same maps, and those that the skin follows.
fn check_names(maps: &[BTreeMap<String, DMat4>], skin: Option<&Skin>) -> Result<(), Problem> {
    let names: std::collections::BTreeSet<&String> = maps.iter().flat_map(BTreeMap::keys).collect();
    for (frame, maps) in maps.iter().enumerate() {
        if let Some(&name) = names.iter().find(|&&name| !maps.contains_key(name)) {
            return Err(Problem::MissingMap { frame, name: name.clone() });
        }
    }
    let mut followed = skin.into_iter().flat_map(Skin::maps);
    match followed.find(|&name| !names.contains(name)) {
        Some(name) => Err(Problem::SkinMap { name: name.clone() }),
        None => Ok(()),
    }
}
