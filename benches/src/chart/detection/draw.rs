//! Picture of the detection methods: a row per group of pairs, a column per measure of error.

use std::error::Error;

use super::measure::Measurement;
use super::methods::ChartedMethod;
use super::task::PairGroup;
use crate::chart::poster::{Charted, ErrorAxis, Group, MethodKey, Poster, Quantity};

const ERRORS: [ErrorAxis<Measurement>; 3] = [
    ErrorAxis {
        error: Quantity { label: "max error of a depth [mm]", of: |m| m.score.max() },
        range: [-3.0, 1.0],
    },
    ErrorAxis {
        error: Quantity { label: "rms error of depths [mm]", of: |m| m.score.rms() },
        range: [-3.0, 1.0],
    },
    ErrorAxis {
        error: Quantity { label: "missed or invented [share]", of: wrong },
        range: [-4.0, 1.0],
    },
];

const FIGURES: [Quantity<Measurement>; 5] = [
    Quantity { label: "build [ms]", of: |m| Some(m.build) },
    Quantity { label: "held [MB]", of: |m| Some(m.held) },
    Quantity { label: "frame [ms]", of: |m| Some(m.frame) },
    Quantity { label: "max error [mm]", of: |m| m.score.max() },
    Quantity { label: "missed, invented", of: wrong },
];

fn wrong(m: &Measurement) -> Option<f64> {
    Some(m.score.missed() + m.score.invented())
}

impl Charted for Measurement {
    fn key(&self) -> MethodKey {
        self.method.key()
    }

    fn time(&self) -> f64 {
        self.frame
    }
}

/// Draws the picture as SVG.
///
/// # Errors
///
/// When it cannot be drawn.
pub(super) fn draw(
    measured: &[Measurement],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let of_group = |group| measured.iter().filter(|m| m.group == group).collect();
    let poster = Poster {
        heading: "Depths of vertices inside other bodies: time per frame over error, by method",
        time_label: "time per frame [ms]",
        row_height: 400,
        methods: &ChartedMethod::ALL.map(ChartedMethod::key),
        errors: &ERRORS,
        figures: &FIGURES,
        groups: vec![
            Group { title: "bone and muscles", rows: of_group(PairGroup::Bone) },
            Group { title: "muscles with each other", rows: of_group(PairGroup::Muscles) },
        ],
        legend_group: 0,
        settings,
    };
    poster.draw()
}
