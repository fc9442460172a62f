//! The methods that are charted, at several settings each.

mod chance;
mod field;
mod images;
pub(super) mod medial;
mod surfaces;

use std::cell::OnceCell;
use std::error::Error;

use ::medial::FootRule;
use distance_field::DistanceField;

use super::question::{Pairs, Question};
use super::score::Told;

/// Why a method could not do it.
pub(super) type Failure = Box<dyn Error>;

/// A method with its structures, which follows the bodies from frame to frame.
pub(super) trait Detector {
    /// Goes to a frame and detects there.
    ///
    /// # Errors
    ///
    /// What the method refuses.
    fn step(&mut self, frame: usize) -> Result<(), Failure>;

    /// Time that structures took which were made for another detector \[ms\].
    fn built_before(&self) -> f64 {
        0.0
    }

    /// What the last step found.
    fn told(&self) -> Told;
}

/// Makes a detector where the bodies are at rest.
pub(super) type Build<'a> = Box<dyn Fn() -> Result<Box<dyn Detector + 'a>, Failure> + 'a>;

/// A method at one setting.
pub(super) struct Candidate<'a> {
    /// Name of the method.
    pub(super) method: Method,
    /// The setting.
    pub(super) setting: String,
    /// Makes its structures.
    pub(super) build: Build<'a>,
}

impl Candidate<'_> {
    /// In words, for the caption.
    pub(super) fn refusal(&self, error: &dyn Error) -> String {
        format!("{}, {}: {error}", self.method.name(), self.setting)
    }
}

/// The methods, in the order of the legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Method {
    /// Surfaces as they are.
    Surfaces,
    /// Surfaces on fewer of their own vertices.
    Reduced,
    /// Fields with exact distances near the surface.
    Field,
    /// Fields of distances between voxels.
    SeedField,
    /// Balls, cones and slabs.
    Medial,
    /// The same, with balls of the bare faces.
    MedialBareFace,
    /// Faces in the cells of a hash table.
    Hash,
    /// Layered depth images.
    Images,
    /// Trees of boxes with chances.
    AverageCase,
    /// Pairs of faces drawn at random.
    SelectedPairs,
}

impl Method {
    /// All of them.
    pub(super) const ALL: [Self; 10] = [
        Self::Surfaces,
        Self::Reduced,
        Self::Field,
        Self::SeedField,
        Self::Medial,
        Self::MedialBareFace,
        Self::Hash,
        Self::Images,
        Self::AverageCase,
        Self::SelectedPairs,
    ];

    /// Name for the legend.
    #[must_use]
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Surfaces => "exact surfaces",
            Self::Reduced => "reduced surfaces",
            Self::Field => "distance field (exact band)",
            Self::SeedField => "distance field (voxels)",
            Self::Medial => "medial (exact feet)",
            Self::MedialBareFace => "medial (bare faces)",
            Self::Hash => "spatial hash",
            Self::Images => "layered depth images",
            Self::AverageCase => "average-case trees",
            Self::SelectedPairs => "selected pairs",
        }
    }

    /// What the settings are.
    #[must_use]
    pub(super) const fn settings(self) -> &'static str {
        match self {
            Self::Surfaces => "as they are",
            Self::Reduced => "within 2, 1, 0.5, 0.2 mm",
            Self::Field | Self::SeedField => "spacing 4, 2, 1, 0.5 mm",
            Self::Medial | Self::MedialBareFace => "25, 50, 100, 200, 400 balls",
            Self::Hash => "cells of 8, 4, 2, 1, 0.5 edges",
            Self::Images => "16, 32, 64, 128, 256 pixels",
            Self::AverageCase => "accepted from 0.5, 0.9, 0.99, 1 on",
            Self::SelectedPairs => "100, 1000, 10,000, 100,000 tests a step",
        }
    }
}

/// Spacings of fields \[mm\].
const SPACINGS: [f64; 4] = [4.0, 2.0, 1.0, 0.5];

/// What is kept for several detectors.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// Fields of the bone, which detectors refer to.
    fields: [OnceCell<DistanceField>; 8],
    medial: medial::Generated,
}

/// All candidates for a question. Fields are of the bone, so they cannot tell how muscles meet.
#[must_use]
pub(super) fn all<'a>(question: &'a Question<'a>, kept: &'a Kept) -> Vec<Candidate<'a>> {
    let mut all = vec![candidate(Method::Surfaces, "exact", || surfaces::exact(question))];
    for within in [2.0, 1.0, 0.5, 0.2] {
        let setting = format!("within {within} mm");
        all.push(candidate(Method::Reduced, setting, move || surfaces::reduced(question, within)));
    }
    if question.of == Pairs::Bone {
        let (exact, voxels) = kept.fields.split_at(SPACINGS.len());
        for (method, cells) in [(Method::Field, exact), (Method::SeedField, voxels)] {
            for (spacing, cell) in SPACINGS.into_iter().zip(cells) {
                let build = move || field::detector(question, method, spacing, cell);
                all.push(candidate(method, format!("{spacing} mm"), build));
            }
        }
    }
    for (method, rule) in
        [(Method::Medial, FootRule::Exact), (Method::MedialBareFace, FootRule::BareFace)]
    {
        for balls in [25, 50, 100, 200, 400] {
            let build = move || medial::detector(question, (balls, rule), &kept.medial);
            all.push(candidate(method, format!("{balls} balls"), build));
        }
    }
    for edges in [8.0, 4.0, 2.0, 1.0, 0.5] {
        let setting = format!("cells of {edges} edges");
        all.push(candidate(Method::Hash, setting, move || images::hash(question, edges)));
    }
    for resolution in [16, 32, 64, 128, 256] {
        let build = move || images::layered(question, resolution);
        all.push(candidate(Method::Images, format!("{resolution} pixels"), build));
    }
    for acceptance in [0.5, 0.9, 0.99, 1.0] {
        let build = move || chance::average_case(question, acceptance);
        all.push(candidate(Method::AverageCase, format!("from {acceptance} on"), build));
    }
    for most_tests in [100, 1000, 10_000, 100_000] {
        let build = move || chance::selected_pairs(question, most_tests);
        all.push(candidate(Method::SelectedPairs, format!("{most_tests} tests"), build));
    }
    all
}

fn candidate<'a, D: Detector + 'a>(
    method: Method,
    setting: impl Into<String>,
    build: impl Fn() -> Result<D, Failure> + 'a,
) -> Candidate<'a> {
    let build: Build<'a> =
        Box::new(move || build().map(|detector| Box::new(detector) as Box<dyn Detector + 'a>));
    Candidate { method, setting: setting.into(), build }
}
