//! Charted methods, at several settings each.

mod baselines;
mod field;
pub(super) mod medial;
mod surfaces;

use std::cell::OnceCell;
use std::error::Error;

use ::medial::FootRule;
use distance_field::FieldDetector;

use super::score::Answer;
use super::task::{PairGroup, Task};
use crate::chart::poster::MethodKey;

/// Error of any method.
pub(super) type Failure = Box<dyn Error>;

/// A method with its structures, which follows the bodies from frame to frame.
pub(super) trait Detector {
    /// Moves the bodies to a frame and detects there.
    ///
    /// # Errors
    ///
    /// When the method refuses a body.
    fn step(&mut self, frame: usize) -> Result<(), Failure>;

    /// Returns the time to build structures that another detector built already \[ms\].
    fn milliseconds_before(&self) -> f64 {
        0.0
    }

    /// Returns what the last step found.
    fn answer(&self) -> Answer;
}

/// Builds a detector for the bodies at rest.
type Build<'a> = Box<dyn Fn() -> Result<Box<dyn Detector + 'a>, Failure> + 'a>;

/// A method at one setting.
pub(super) struct Candidate<'a> {
    /// The method.
    pub(super) method: MethodKey,
    /// The setting.
    pub(super) setting: String,
    /// Builds its structures.
    pub(super) build: Build<'a>,
}

const SPACINGS: &str = "spacing 4, 2, 1, 0.5 mm";
const BALLS: &str = "25, 50, 100, 200, 400 balls";

const SURFACES: MethodKey = MethodKey::new("exact surfaces", "full", 0);
const REDUCED: MethodKey =
    MethodKey::new("reduced surfaces", "within 2, 1, 0.5, 0.2 mm", 0x80_80_80);
const FIELD: MethodKey = MethodKey::new("distance field (exact band)", SPACINGS, 0x1f_6f_b4);
const VOXEL_FIELD: MethodKey =
    MethodKey::new("distance field (voxels)", SPACINGS, 0x1f_6f_b4).hollow();
const MEDIAL: MethodKey = MethodKey::new("medial (exact feet)", BALLS, 0x2c_8c_3c);
const MEDIAL_BARE_FACE: MethodKey =
    MethodKey::new("medial (bare faces)", BALLS, 0x2c_8c_3c).hollow();
const HASH: MethodKey =
    MethodKey::new("spatial hash", "cells of 8, 4, 2, 1, 0.5 edges", 0xe0_7b_00);
const IMAGES: MethodKey =
    MethodKey::new("layered depth images", "16, 32, 64, 128, 256 pixels", 0xb5_26_2e);
const AVERAGE_CASE: MethodKey =
    MethodKey::new("average-case trees", "accepted from 0.5, 0.9, 0.99, 1 on", 0x7a_4f_b0);
const SELECTED_PAIRS: MethodKey =
    MethodKey::new("selected pairs", "100, 1000, 10,000, 100,000 tests per step", 0xd0_4f_a6);

/// Methods in the order of the legend; rings mark methods of the source that are improved on.
pub(super) const METHODS: [MethodKey; 10] = [
    SURFACES,
    REDUCED,
    FIELD,
    VOXEL_FIELD,
    MEDIAL,
    MEDIAL_BARE_FACE,
    HASH,
    IMAGES,
    AVERAGE_CASE,
    SELECTED_PAIRS,
];

/// Structures that several detectors share.
#[derive(Debug, Default)]
pub(super) struct SharedStructures {
    /// Fields of the bone, exact then voxel, which detectors refer to.
    fields: [[OnceCell<FieldDetector>; 4]; 2],
    medial: medial::GeneratedBalls,
}

/// Returns all candidates for a task.
///
/// Fields are of the bone, so they cannot detect contacts between muscles.
#[must_use]
pub(super) fn candidates<'a>(
    task: &'a Task<'a>,
    shared: &'a SharedStructures,
) -> Vec<Candidate<'a>> {
    let mut list = CandidateList(Vec::new());

    // Surfaces, full and reduced.
    list.add(SURFACES, "exact", || surfaces::exact(task));
    for deviation in [2.0, 1.0, 0.5, 0.2] {
        let setting = format!("within {deviation} mm");
        list.add(REDUCED, setting, move || surfaces::reduced(task, deviation));
    }

    // Fields of the bone, and balls of the muscles.
    if task.group == PairGroup::Bone {
        for (key, fields) in [FIELD, VOXEL_FIELD].into_iter().zip(&shared.fields) {
            for (spacing, field) in [4.0, 2.0, 1.0, 0.5].into_iter().zip(fields) {
                let by_voxels = key.name == VOXEL_FIELD.name;
                let build = move || field::detector(task, by_voxels, spacing, field);
                list.add(key, format!("{spacing} mm"), build);
            }
        }
    }
    for (key, rule) in [(MEDIAL, FootRule::Exact), (MEDIAL_BARE_FACE, FootRule::BareFace)] {
        for balls in [25, 50, 100, 200, 400] {
            let build = move || medial::detector(task, balls, rule, &shared.medial);
            list.add(key, format!("{balls} balls"), build);
        }
    }

    // Methods to compare with.
    for edges in [8.0, 4.0, 2.0, 1.0, 0.5] {
        let build = move || Ok(baselines::spatial_hash(task, edges));
        list.add(HASH, format!("cells of {edges} edges"), build);
    }
    for resolution in [16, 32, 64, 128, 256] {
        let build = move || Ok(baselines::layered_depth(task, resolution));
        list.add(IMAGES, format!("{resolution} pixels"), build);
    }
    for acceptance in [0.5, 0.9, 0.99, 1.0] {
        let build = move || baselines::average_case(task, acceptance);
        list.add(AVERAGE_CASE, format!("from {acceptance} on"), build);
    }
    for max_tests in [100, 1000, 10_000, 100_000] {
        let build = move || Ok(baselines::selected_pairs(task, max_tests));
        list.add(SELECTED_PAIRS, format!("{max_tests} tests"), build);
    }
    list.0
}

struct CandidateList<'a>(Vec<Candidate<'a>>);

impl<'a> CandidateList<'a> {
    fn add<D: Detector + 'a>(
        &mut self,
        method: MethodKey,
        setting: impl Into<String>,
        build: impl Fn() -> Result<D, Failure> + 'a,
    ) {
        let build: Build<'a> = Box::new(move || Ok(Box::new(build()?)));
        self.0.push(Candidate { method, setting: setting.into(), build });
    }
}
