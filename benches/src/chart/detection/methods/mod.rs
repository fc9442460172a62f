//! Charted methods, at several settings each.

mod baselines;
mod field;
mod medial;
mod permanent;
mod plan;
mod surfaces;
mod volumes;

use std::error::Error;

use ::medial::FootRule;

use super::score::Answer;
use super::task::{PairGroup, Task};
use crate::chart::palette;
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

    /// Returns what the last step found.
    fn answer(&self) -> Answer;
}

/// A detector of any method, or its refusal.
pub(super) type Built<'a> = Result<Box<dyn Detector + 'a>, Failure>;

/// A method with its settings.
pub(super) struct Method {
    pub(super) key: MethodKey,
    /// Values of the setting, small marks to large.
    pub(super) settings: &'static [f64],
    /// Text of a setting, with `_` for its value.
    text: &'static str,
    /// Builds a detector for the bodies at rest.
    pub(super) build: for<'a> fn(&'a Task<'a>, f64) -> Built<'a>,
}

impl Method {
    /// Returns true if the method detects contacts of a group: fields are of the bone, so they
    /// cannot detect contacts between muscles.
    pub(super) fn detects(&self, group: PairGroup) -> bool {
        group == PairGroup::Bone || !self.key.name.starts_with("distance field")
    }

    pub(super) fn text_of(&self, setting: f64) -> String {
        self.text.replace('_', &setting.to_string())
    }
}

const SPACINGS: &[f64] = &[4.0, 2.0, 1.0, 0.5];
const BALLS: &[f64] = &[25.0, 50.0, 100.0, 200.0];

/// Methods in the order of the legend; rings mark methods of the source that are improved on.
pub(super) const METHODS: [Method; 15] = [
    Method {
        key: MethodKey::new("exact surfaces", "full", palette::BLACK),
        settings: &[0.0],
        text: "exact",
        build: |task, _| surfaces::exact(task),
    },
    Method {
        key: MethodKey::new("exact crossings", "volumes of 6, 14, 18, 26 planes", palette::BLACK)
            .hollow(),
        settings: &[6.0, 14.0, 18.0, 26.0],
        text: "_ planes",
        build: |task, planes| volumes::detector(task, planes),
    },
    Method {
        key: MethodKey::new("measures of overlaps", "depth to 1, 0.1, 0.01 mm", palette::SKY),
        settings: &[1.0, 0.1, 0.01],
        text: "to _ mm",
        build: |task, width| surfaces::measured(task, width),
    },
    Method {
        key: MethodKey::new(
            "permanent contacts",
            "gaps up to 0.5, 1, 2, 4 mm at rest",
            palette::SKY,
        )
        .hollow(),
        settings: &[0.5, 1.0, 2.0, 4.0],
        text: "up to _ mm",
        build: |task, gap| permanent::detector(task, gap),
    },
    Method {
        key: MethodKey::new("plan", "within 2, 1, 0.5, 0.2, 0.1 mm", palette::VERMILION),
        settings: &[2.0, 1.0, 0.5, 0.2, 0.1],
        text: "within _ mm",
        build: |task, tolerance| plan::detector(task, tolerance),
    },
    Method {
        key: MethodKey::new("reduced surfaces", "within 2, 1, 0.5, 0.2 mm", palette::GRAY),
        settings: &[2.0, 1.0, 0.5, 0.2],
        text: "within _ mm",
        build: |task, deviation| surfaces::reduced(task, deviation),
    },
    Method {
        key: MethodKey::new(
            "distance field (exact band)",
            "spacing 4, 2, 1, 0.5 mm",
            palette::BLUE,
        ),
        settings: SPACINGS,
        text: "_ mm",
        build: |task, spacing| field::detector(task, false, spacing),
    },
    Method {
        key: MethodKey::new("distance field (voxels)", "spacing 4, 2, 1, 0.5 mm", palette::BLUE)
            .hollow(),
        settings: SPACINGS,
        text: "_ mm",
        build: |task, spacing| field::detector(task, true, spacing),
    },
    Method {
        key: MethodKey::new("medial (exact feet)", "25, 50, 100, 200 balls", palette::GREEN),
        settings: BALLS,
        text: "_ balls",
        build: |task, balls| medial::detector(task, balls, FootRule::Exact),
    },
    Method {
        key: MethodKey::new("medial (bare faces)", "25, 50, 100, 200 balls", palette::GREEN)
            .hollow(),
        settings: BALLS,
        text: "_ balls",
        build: |task, balls| medial::detector(task, balls, FootRule::BareFace),
    },
    Method {
        key: MethodKey::new("balls with balls, simulated", "25, 50, 100, 200 balls", palette::GRAY)
            .hollow(),
        settings: BALLS,
        text: "_ balls",
        build: |task, balls| medial::simulated(task, balls),
    },
    Method {
        key: MethodKey::new("spatial hash", "cells of 8, 4, 2, 1, 0.5 edges", palette::ORANGE),
        settings: &[8.0, 4.0, 2.0, 1.0, 0.5],
        text: "cells of _ edges",
        build: |task, edges| Ok(Box::new(baselines::spatial_hash(task, edges))),
    },
    Method {
        key: MethodKey::new("layered depth images", "16, 32, 64, 128, 256 pixels", palette::ORANGE)
            .hollow(),
        settings: &[16.0, 32.0, 64.0, 128.0, 256.0],
        text: "_ pixels",
        build: |task, pixels| Ok(Box::new(baselines::layered_depth(task, whole(pixels)))),
    },
    Method {
        key: MethodKey::new(
            "average-case trees",
            "accepted from 0.5, 0.9, 0.99, 1 on",
            palette::PURPLE,
        ),
        settings: &[0.5, 0.9, 0.99, 1.0],
        text: "from _ on",
        build: |task, acceptance| baselines::average_case(task, acceptance),
    },
    Method {
        key: MethodKey::new(
            "selected pairs",
            "100, 1000, 10,000, 100,000 tests per step",
            palette::PURPLE,
        )
        .hollow(),
        settings: &[1e2, 1e3, 1e4, 1e5],
        text: "_ tests",
        build: |task, tests| Ok(Box::new(baselines::selected_pairs(task, whole(tests).into()))),
    },
];

/// Returns a setting that is a count.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "settings are small")]
const fn whole(setting: f64) -> u32 {
    setting as u32
}
