//! The picture: a row for each set of queries, a column for each way to be wrong, and a table.

use std::error::Error;

use plotters::prelude::*;

use super::{Measured, Way};
use crate::chart::curves::{
    self, Area, CAPTION_LINE, Curve, Drawn, Line, Look, Panel, front_sample, short,
};

const WIDTH: u32 = 1500;
const HEAD: u32 = 44;
const ROW: u32 = 360;
const LEGEND: u32 = 216;

/// A way to be wrong, and decimal logarithms of what is shown.
struct Measure {
    title: &'static str,
    of: fn(&Measured) -> f64,
    shown: [f64; 2],
}

const MEASURES: [Measure; 3] = [
    Measure { title: "false alarms [share]", of: Measured::false_alarms, shown: [-5.0, 0.0] },
    Measure { title: "missed [share]", of: Measured::missed, shown: [-5.0, 0.0] },
    Measure {
        title: "earliness, 99 of 100 [share of the step]",
        of: |m| m.answers.earliness(99).max(0.0),
        shown: [-16.0, 0.0],
    },
];

pub(super) fn draw(
    measured: &[Measured],
    titles: &[&str],
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let caption = curves::caption(settings);
    let panels = ROW * u32::try_from(titles.len())?;
    let foot = LEGEND + CAPTION_LINE * u32::try_from(caption.len())? + 16;
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (WIDTH, HEAD + panels + foot));
    let area = area.into_drawing_area();
    area.fill(&WHITE)?;
    let (head, rest) = area.split_vertically(HEAD);
    let (body, foot) = rest.split_vertically(panels);
    curves::heading(&head, "When moving primitives meet: time of a query over what is wrong")?;
    let panels = body.split_evenly((titles.len(), MEASURES.len()));
    for (number, area) in panels.iter().enumerate() {
        let set = number / MEASURES.len();
        panel((set, titles[set]), &MEASURES[number % MEASURES.len()], measured).draw(area)?;
    }
    table(&foot, measured, titles)?;
    curves::write_caption(&foot, &caption, LEGEND)?;
    area.present()?;
    drop((head, foot, body, rest, panels));
    drop(area);
    Ok(svg)
}

fn panel((set, title): (usize, &str), measure: &Measure, measured: &[Measured]) -> Panel {
    let curve = |method: Way| {
        let shown = measured.iter().filter(|m| m.set == set && m.method == method);
        Curve { look: look(method), points: shown.map(|m| [(measure.of)(m), m.time]).collect() }
    };
    Panel {
        title: title.to_owned(),
        across: measure.title.to_owned(),
        up: "time of a query [ns]".to_owned(),
        shown: measure.shown,
        curves: Way::ALL.map(curve).into(),
    }
}

fn look(method: Way) -> Look {
    match method {
        Way::DelGeo => Look::new(0xb5, 0x26, 0x2e),
        Way::Plain => Look::new(0xe0, 0x7b, 0x00),
        Way::Intervals => Look::new(0x80, 0x80, 0x80),
        Way::Certified => Look::new(0x1f, 0x6f, 0xb4),
        Way::Exact => Look::new(0, 0, 0),
        Way::Separated => Look::new(0x2c, 0x8c, 0x3c).hollow(),
    }
}

/// Right edges of the columns of values.
const COLUMNS: [i32; 5] = [720, 900, 1080, 1230, 1440];

/// Figures of the first set and of the last, which is the hardest.
fn table(area: &Area<'_>, measured: &[Measured], titles: &[&str]) -> Drawn {
    let heads = ["time [ns]", "false alarms", "missed", "late", "99 % earliness"];
    let heads = Line {
        name: (None, format!("queries {}", titles.last().unwrap_or(&""))),
        settings: String::new(),
        values: heads.map(str::to_owned).into(),
    };
    heads.draw(area, 12, &COLUMNS)?;
    for (number, method) in (0..).zip(Way::ALL) {
        line(method, measured, titles.len() - 1).draw(
            area,
            36 + Line::HEIGHT * number,
            &COLUMNS,
        )?;
    }
    front_sample(area, 36 + Line::HEIGHT * i32::try_from(Way::ALL.len())?)
}

fn line(method: Way, measured: &[Measured], set: usize) -> Line {
    let of = |m: &&Measured| m.method == method && m.set == set;
    let ends = [measured.iter().find(of), measured.iter().rfind(of)];
    let range = |value: fn(&Measured) -> f64| match ends.map(|end| end.map(value).map(short)) {
        [Some(from), Some(to)] if from == to => from,
        [Some(from), Some(to)] => format!("{from} … {to}"),
        _ => "–".to_owned(),
    };
    let values = [
        range(|m| m.time),
        range(Measured::false_alarms),
        range(Measured::missed),
        range(Measured::late),
        range(|m| m.answers.earliness(99).max(0.0)),
    ];
    Line {
        name: (Some(look(method)), method.name().to_owned()),
        settings: method.settings().to_owned(),
        values: values.into(),
    }
}
