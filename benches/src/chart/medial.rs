//! Accuracy of medial surfaces by number of balls, from the table in `docs/accuracy-medial.md`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use plotters::prelude::*;
use serde::Serialize;

use super::axes::{Area, Axis, Drawn};
use super::curves::{Curve, CurveStyle, Panel, picture};
use super::palette;
use super::sheet::Sheet;

const WIDTH: u32 = 1000;
const PANELS: u32 = 460;
const LEGEND: u32 = 60;

/// Muscles with a color of their own.
const NAMED: [(&str, CurveStyle); 4] = [
    ("gluteus medius", CurveStyle::new(palette::BLUE)),
    ("gluteus maximus", CurveStyle::new(palette::GREEN)),
    ("iliacus", CurveStyle::new(palette::ORANGE)),
    ("psoas major", CurveStyle::new(palette::VERMILION)),
];
const OTHERS: CurveStyle = CurveStyle::new(0xc0_c0_c0).hollow();

/// Numbers of balls in the table.
const BALLS: [f64; 5] = [25.0, 50.0, 100.0, 200.0, 400.0];

/// Errors of one medial surface: a row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct BallErrors {
    muscle: String,
    balls: f64,
    #[serde(rename = "rms [mm]")]
    rms: f64,
    #[serde(rename = "larger bound [mm]")]
    bound: f64,
}

/// Errors by muscle.
type Table = BTreeMap<String, Vec<BallErrors>>;

/// Draws the table of the document above the folder.
///
/// # Errors
///
/// When there is no table, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let path = folder.join("../accuracy-medial.md");
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let table = read(&text);
    if table.is_empty() {
        return Err(format!("{} has no table of muscles", path.display()).into());
    }

    let svg = Some(draw(&table)?);
    let settings = vec![("from", "docs/accuracy-medial.md".to_owned())];
    let rows: Vec<&BallErrors> = table.values().flatten().collect();
    Ok(Sheet::new("medial", settings, &rows)?.write(folder, svg)?)
}

/// Reads the rows of the table by number of balls: those with a name and twelve values.
fn read(text: &str) -> Table {
    let mut table = Table::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if cells.len() != 13 {
            continue;
        }
        // Number of balls, error, and both bounds.
        let number = |column: usize| cells[column].parse::<f64>().ok();
        if let [Some(balls), Some(rms), Some(outward), Some(inward)] = [3, 5, 7, 9].map(number) {
            let muscle = cells[0].to_owned();
            let errors = BallErrors { muscle, balls, rms, bound: outward.max(inward) };
            table.entry(errors.muscle.clone()).or_default().push(errors);
        }
    }
    table
}

fn draw(table: &Table) -> Result<String, Box<dyn Error>> {
    let heading = "Muscles of a thigh as balls: error over their number";
    picture(heading, WIDTH, [PANELS, LEGEND], |body, foot| {
        let (left, right) = body.split_horizontally(WIDTH / 2);
        panel("root mean square over the surface [mm]", table, |errors| errors.rms).draw(&left)?;
        panel("two-sided bound on the distance [mm]", table, |errors| errors.bound).draw(&right)?;
        legend(foot)
    })
}

fn panel(label: &str, table: &Table, error: fn(&BallErrors) -> f64) -> Panel {
    let mut curves = Vec::new();
    for (muscle, all) in table {
        let mut curve = Curve { style: OTHERS, points: Vec::new() };
        for (name, style) in NAMED {
            if name == muscle {
                curve.style = style;
            }
        }
        for errors in all {
            curve.points.push([errors.balls, error(errors)]);
        }
        curves.push(curve);
    }
    // Named muscles last, so that they lie on top.
    curves.sort_by_key(|curve| curve.style != OTHERS);

    let ticks = BALLS.map(f64::log10).to_vec();
    let range = [ticks[0], ticks[ticks.len() - 1]];
    Panel {
        title: String::new(),
        x: Axis { ticks, ..Axis::powers("balls", range) },
        y_label: label.to_owned(),
        curves,
        has_front: false,
    }
}

fn legend(area: &Area<'_>) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let all = NAMED.iter().copied().chain([("the other muscles", OTHERS)]);
    for (number, (name, style)) in (0..).zip(all) {
        let left = 40 + 190 * number;
        style.sample(area, [left, 20])?;
        area.draw_text(name, &text, (left + 40, 12))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rows_of_muscles_are_read() {
        let text = "\
| muscle | faces | extent | balls | slabs | rms | 95 % | s to b | sampled | b to s | sampled | parts and holes | s |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|--:|
| iliacus | 22330 | 253 | 25 | 29 | 0.737 | 1.419 | 4.05 | 3.79 | 3.97 | 3.88 | as the muscle | 0.7 |
| iliacus | 22330 | 253 | 400 | 780 | 0.125 | 0.150 | 0.65 | 0.42 | 0.87 | 0.38 | 1 parts, 1 tunnels | 7.7 |
| iliacus | at rest | 0.3 |
";
        let table = read(text);
        let errors = |balls, rms, bound| BallErrors { muscle: "iliacus".into(), balls, rms, bound };
        let iliacus = [errors(25.0, 0.737, 4.05), errors(400.0, 0.125, 0.87)];
        assert_eq!(table.len(), 1);
        assert_eq!(table["iliacus"], iliacus);
        assert!(draw(&table).expect("a picture").contains("gluteus maximus"));
    }
}
