//! Picture of the continuous queries: a row per set of queries, a column per kind of error.

use std::error::Error;

use super::{CcdMethod, Measurement};
use crate::chart::poster::{Charted, ErrorAxis, Group, MethodKey, Poster, Quantity};

const FALSE_ALARMS: Quantity<Measurement> =
    Quantity { label: "false alarms [share]", of: |m| Some(m.false_alarms()) };
const MISSED: Quantity<Measurement> =
    Quantity { label: "missed [share]", of: |m| Some(m.missed()) };
const EARLINESS: Quantity<Measurement> =
    Quantity { label: "earliness, 99 of 100 [step]", of: |m| Some(m.earliness()) };

const ERRORS: [ErrorAxis<Measurement>; 3] = [
    ErrorAxis { error: FALSE_ALARMS, range: [-5.0, 0.0] },
    ErrorAxis { error: MISSED, range: [-5.0, 0.0] },
    ErrorAxis { error: EARLINESS, range: [-16.0, 0.0] },
];

const FIGURES: [Quantity<Measurement>; 5] = [
    Quantity { label: "time [ns]", of: |m| Some(m.time) },
    FALSE_ALARMS,
    MISSED,
    Quantity { label: "late [share]", of: |m| Some(m.late()) },
    EARLINESS,
];

impl Charted for Measurement {
    fn key(&self) -> MethodKey {
        self.method.key()
    }

    fn time(&self) -> f64 {
        self.time
    }
}

/// Draws the picture as SVG. The legend has the figures of the last set, the hardest.
pub(super) fn draw(
    measured: &[Measurement],
    titles: &[&str],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let mut groups = Vec::new();
    for &title in titles {
        groups.push(Group { title, rows: measured.iter().filter(|m| m.title == title).collect() });
    }
    let poster = Poster {
        heading: "First contacts of moving primitives: time per query over error",
        time_label: "time per query [ns]",
        row_height: 360,
        methods: &CcdMethod::ALL.map(CcdMethod::key),
        errors: &ERRORS,
        figures: &FIGURES,
        legend_group: groups.len().saturating_sub(1),
        groups,
        settings,
    };
    poster.draw()
}
