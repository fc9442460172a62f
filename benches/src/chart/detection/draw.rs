//! The picture: a row for each kind of pairs, a column for each measure of error, and a table.

use std::error::Error;

use plotters::prelude::*;

use super::measure::Measured;
use super::methods::Method;
use super::question::Pairs;
use crate::chart::curves::{
    self, Area, CAPTION_LINE, Curve, Drawn, Line, Look, Panel, front_sample, short,
};

const WIDTH: u32 = 1500;
const HEAD: u32 = 44;
const PANELS: u32 = 2 * 400;
const LEGEND: u32 = 300;

/// A measure of error: its name, how to take it, and decimal logarithms of what is shown; what is
/// less is drawn at the lower end.
struct Measure {
    title: &'static str,
    of: fn(&Measured) -> Option<f64>,
    shown: [f64; 2],
}

const MEASURES: [Measure; 3] = [
    Measure { title: "worst error of a depth [mm]", of: |m| m.score.worst(), shown: [-3.0, 1.0] },
    Measure { title: "rms error of depths [mm]", of: |m| m.score.rms(), shown: [-3.0, 1.0] },
    Measure { title: "missed or invented [share]", of: wrong, shown: [-4.0, 1.0] },
];

fn wrong(m: &Measured) -> Option<f64> {
    Some(m.score.missed() + m.score.invented())
}

const ROWS: [(Pairs, &str); 2] =
    [(Pairs::Bone, "bone and muscles"), (Pairs::Muscles, "muscles with each other")];

/// Draws the picture as SVG.
pub(super) fn draw(
    measured: &[Measured],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let caption = curves::caption(settings);
    let foot = LEGEND + CAPTION_LINE * u32::try_from(caption.len())? + 16;
    let mut svg = String::new();
    let size = (WIDTH, HEAD + PANELS + foot);
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, rest) = area.split_vertically(HEAD);
    let (body, foot) = rest.split_vertically(PANELS);
    curves::heading(&head, "Who is how deep in whom: time of a frame over error, by method")?;
    let panels = body.split_evenly((ROWS.len(), MEASURES.len()));
    for (number, area) in panels.iter().enumerate() {
        let row = ROWS[number / MEASURES.len()];
        panel(row, &MEASURES[number % MEASURES.len()], measured).draw(area)?;
    }
    table(&foot, measured)?;
    curves::write_caption(&foot, &caption, LEGEND)?;
    area.present()?;
    drop((head, foot, body, rest, panels));
    drop(area);
    Ok(svg)
}

fn panel((of, title): (Pairs, &str), measure: &Measure, measured: &[Measured]) -> Panel {
    let curve = |method: Method| {
        let shown = measured.iter().filter(|m| m.of == of && m.method == method);
        let points = shown.filter_map(|m| Some([(measure.of)(m)?, m.frame])).collect();
        Curve { look: look(method), points }
    };
    Panel {
        title: title.to_owned(),
        across: measure.title.to_owned(),
        up: "time of a frame [ms]".to_owned(),
        shown: measure.shown,
        curves: Method::ALL.map(curve).into(),
    }
}

/// The ways of the source that are improved on have rings for marks.
fn look(method: Method) -> Look {
    match method {
        Method::Surfaces => Look::new(0, 0, 0),
        Method::Reduced => Look::new(0x80, 0x80, 0x80),
        Method::Field => Look::new(0x1f, 0x6f, 0xb4),
        Method::SeedField => Look::new(0x1f, 0x6f, 0xb4).hollow(),
        Method::Medial => Look::new(0x2c, 0x8c, 0x3c),
        Method::MedialBareFace => Look::new(0x2c, 0x8c, 0x3c).hollow(),
        Method::Hash => Look::new(0xe0, 0x7b, 0x00),
        Method::Images => Look::new(0xb5, 0x26, 0x2e),
        Method::AverageCase => Look::new(0x7a, 0x4f, 0xb0),
        Method::SelectedPairs => Look::new(0xd0, 0x4f, 0xa6),
    }
}

/// Right edges of the columns of values.
const COLUMNS: [i32; 5] = [720, 900, 1080, 1260, 1440];

/// What colours mean, with the settings, what structures cost, and the errors.
fn table(area: &Area<'_>, measured: &[Measured]) -> Drawn {
    let heads = ["build [ms]", "held [MB]", "a frame [ms]", "worst error [mm]", "missed, invented"];
    let heads = Line {
        name: (None, "bone and muscles".to_owned()),
        settings: "settings, small marks to large".to_owned(),
        values: heads.map(str::to_owned).into(),
    };
    heads.draw(area, 24, &COLUMNS)?;
    for (number, method) in (0..).zip(Method::ALL) {
        line(method, measured).draw(area, 48 + Line::HEIGHT * number, &COLUMNS)?;
    }
    front_sample(area, 48 + Line::HEIGHT * i32::try_from(Method::ALL.len())?)
}

fn line(method: Method, measured: &[Measured]) -> Line {
    let of = |m: &&Measured| m.method == method && m.of == Pairs::Bone;
    let first = measured.iter().find(of);
    let last = measured.iter().rfind(of);
    let range = |value: fn(&Measured) -> Option<f64>| match (
        first.and_then(value).map(short),
        last.and_then(value).map(short),
    ) {
        (Some(from), Some(to)) if from == to => from,
        (Some(from), Some(to)) => format!("{from} … {to}"),
        _ => "–".to_owned(),
    };
    let values = [
        range(|m| Some(m.build)),
        range(|m| Some(m.held)),
        range(|m| Some(m.frame)),
        range(|m| m.score.worst()),
        range(wrong),
    ];
    Line {
        name: (Some(look(method)), method.name().to_owned()),
        settings: method.settings().to_owned(),
        values: values.into(),
    }
}
