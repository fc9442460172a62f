//! Picture of the detection methods: a row per group of pairs, a column per measure of error.

use std::error::Error;

use super::measure::Measurement;
use super::methods::ChartedMethod;
use super::task::PairGroup;
use crate::chart::curves::{self, Curve, CurveStyle, LegendRow, Panel, Poster, range};

const ROW_HEIGHT: u32 = 400;

/// A measure of error, with decimal logarithms of the ends of its axis.
struct ErrorMeasure {
    label: &'static str,
    of: fn(&Measurement) -> Option<f64>,
    range: [f64; 2],
}

const ERRORS: [ErrorMeasure; 3] = [
    ErrorMeasure { label: "max error of a depth [mm]", of: |m| m.score.max(), range: [-3.0, 1.0] },
    ErrorMeasure { label: "rms error of depths [mm]", of: |m| m.score.rms(), range: [-3.0, 1.0] },
    ErrorMeasure { label: "missed or invented [share]", of: wrong, range: [-4.0, 1.0] },
];

fn wrong(m: &Measurement) -> Option<f64> {
    Some(m.score.missed() + m.score.invented())
}

const ROWS: [(PairGroup, &str); 2] =
    [(PairGroup::Bone, "bone and muscles"), (PairGroup::Muscles, "muscles with each other")];

/// Draws the picture as SVG.
///
/// # Errors
///
/// When it cannot be drawn.
pub(super) fn draw(
    measured: &[Measurement],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let mut panels = Vec::new();
    for (group, title) in ROWS {
        let rows: Vec<&Measurement> = measured.iter().filter(|m| m.group == group).collect();
        panels.push(ERRORS.iter().map(|error| panel(title, error, &rows)).collect());
    }

    let columns = ["build [ms]", "held [MB]", "frame [ms]", "max error [mm]", "missed, invented"];
    let of_bone: Vec<&Measurement> =
        measured.iter().filter(|m| m.group == PairGroup::Bone).collect();
    let mut legend =
        vec![LegendRow::head("bone and muscles", "settings, small marks to large", columns)];
    legend.extend(ChartedMethod::ALL.map(|method| legend_row(method, &of_bone)));
    let poster = Poster {
        heading: "Depths of vertices inside other bodies: time per frame over error, by method",
        panels,
        row_height: ROW_HEIGHT,
        legend,
        caption: curves::caption(settings),
    };
    poster.draw()
}

fn panel(title: &str, error: &ErrorMeasure, rows: &[&Measurement]) -> Panel {
    let curve = |method: ChartedMethod| {
        let rows = rows.iter().filter(|m| m.method == method);
        let points = rows.filter_map(|m| Some([(error.of)(m)?, m.frame])).collect();
        Curve { style: style(method), points }
    };
    Panel {
        title: title.to_owned(),
        x_label: error.label.to_owned(),
        y_label: "time per frame [ms]".to_owned(),
        x_range: error.range,
        curves: ChartedMethod::ALL.map(curve).into(),
    }
}

/// Returns the style of a method; rings mark methods of the source that are improved on.
fn style(method: ChartedMethod) -> CurveStyle {
    match method {
        ChartedMethod::Surfaces => CurveStyle::new(0, 0, 0),
        ChartedMethod::Reduced => CurveStyle::new(0x80, 0x80, 0x80),
        ChartedMethod::Field => CurveStyle::new(0x1f, 0x6f, 0xb4),
        ChartedMethod::VoxelField => CurveStyle::new(0x1f, 0x6f, 0xb4).hollow(),
        ChartedMethod::Medial => CurveStyle::new(0x2c, 0x8c, 0x3c),
        ChartedMethod::MedialBareFace => CurveStyle::new(0x2c, 0x8c, 0x3c).hollow(),
        ChartedMethod::Hash => CurveStyle::new(0xe0, 0x7b, 0x00),
        ChartedMethod::Images => CurveStyle::new(0xb5, 0x26, 0x2e),
        ChartedMethod::AverageCase => CurveStyle::new(0x7a, 0x4f, 0xb0),
        ChartedMethod::SelectedPairs => CurveStyle::new(0xd0, 0x4f, 0xa6),
    }
}

fn legend_row(method: ChartedMethod, rows: &[&Measurement]) -> LegendRow {
    let rows: Vec<&&Measurement> = rows.iter().filter(|m| m.method == method).collect();
    let range_of = |value: fn(&Measurement) -> Option<f64>| {
        range(&rows.iter().map(|m| value(m)).collect::<Vec<_>>())
    };
    let values = vec![
        range_of(|m| Some(m.build)),
        range_of(|m| Some(m.held)),
        range_of(|m| Some(m.frame)),
        range_of(|m| m.score.max()),
        range_of(wrong),
    ];
    let (name, settings) = (method.name().to_owned(), method.settings().to_owned());
    LegendRow { style: Some(style(method)), name, settings, values }
}
