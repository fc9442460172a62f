//! Picture of the continuous queries: a row per set of queries, a column per kind of error.

use std::error::Error;

use super::{CcdMethod, Measurement};
use crate::chart::curves::{self, Curve, CurveStyle, LegendRow, Panel, Poster, range};

const ROW_HEIGHT: u32 = 360;

/// A kind of error, with decimal logarithms of the ends of its axis.
struct ErrorMeasure {
    label: &'static str,
    of: fn(&Measurement) -> f64,
    range: [f64; 2],
}

const ERRORS: [ErrorMeasure; 3] = [
    ErrorMeasure {
        label: "false alarms [share]",
        of: Measurement::false_alarms,
        range: [-5.0, 0.0],
    },
    ErrorMeasure { label: "missed [share]", of: Measurement::missed, range: [-5.0, 0.0] },
    ErrorMeasure {
        label: "earliness, 99 of 100 [share of the step]",
        of: Measurement::earliness,
        range: [-16.0, 0.0],
    },
];

/// Draws the picture as SVG. The legend has the figures of the last set, the hardest.
pub(super) fn draw(
    measured: &[Measurement],
    titles: &[&str],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let of_set = |title: &str| measured.iter().filter(|m| m.title == title).collect::<Vec<_>>();
    let mut panels = Vec::new();
    for title in titles {
        let rows = of_set(title);
        panels.push(ERRORS.iter().map(|error| panel(title, error, &rows)).collect());
    }

    let columns = ["time [ns]", "false alarms", "missed", "late", "99 % earliness"];
    let last = titles.last().copied().unwrap_or("");
    let hardest = of_set(last);
    let mut legend = vec![LegendRow::head(format!("queries {last}"), "", columns)];
    legend.extend(CcdMethod::ALL.map(|method| legend_row(method, &hardest)));
    let poster = Poster {
        heading: "First contacts of moving primitives: time per query over error",
        panels,
        row_height: ROW_HEIGHT,
        legend,
        caption: curves::caption(settings),
    };
    poster.draw()
}

fn panel(title: &str, error: &ErrorMeasure, rows: &[&Measurement]) -> Panel {
    let curve = |method: CcdMethod| {
        let rows = rows.iter().filter(|m| m.method == method);
        Curve { style: style(method), points: rows.map(|m| [(error.of)(m), m.time]).collect() }
    };
    Panel {
        title: title.to_owned(),
        x_label: error.label.to_owned(),
        y_label: "time per query [ns]".to_owned(),
        x_range: error.range,
        curves: CcdMethod::ALL.map(curve).into(),
    }
}

fn style(method: CcdMethod) -> CurveStyle {
    match method {
        CcdMethod::DelGeo => CurveStyle::new(0xb5, 0x26, 0x2e),
        CcdMethod::Plain => CurveStyle::new(0xe0, 0x7b, 0x00),
        CcdMethod::Intervals => CurveStyle::new(0x80, 0x80, 0x80),
        CcdMethod::Certified => CurveStyle::new(0x1f, 0x6f, 0xb4),
        CcdMethod::Exact => CurveStyle::new(0, 0, 0),
        CcdMethod::Separated => CurveStyle::new(0x2c, 0x8c, 0x3c).hollow(),
    }
}

fn legend_row(method: CcdMethod, rows: &[&Measurement]) -> LegendRow {
    let rows: Vec<&&Measurement> = rows.iter().filter(|m| m.method == method).collect();
    let range_of = |value: fn(&Measurement) -> f64| {
        range(&rows.iter().map(|m| Some(value(m))).collect::<Vec<_>>())
    };
    let values = vec![
        range_of(|m| m.time),
        range_of(Measurement::false_alarms),
        range_of(Measurement::missed),
        range_of(Measurement::late),
        range_of(Measurement::earliness),
    ];
    let (name, settings) = (method.name().to_owned(), method.settings().to_owned());
    LegendRow { style: Some(style(method)), name, settings, values }
}
