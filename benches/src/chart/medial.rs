//! Accuracy of medial surfaces by number of balls, from the table in `docs/accuracy-medial.md`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use plotters::prelude::*;
use serde_json::json;

use super::curves::{Area, CurveStyle, Drawn, draw_heading, svg};
use super::sheet::Sheet;

const WIDTH: u32 = 1200;
const HEADING: u32 = 44;
const PANELS: u32 = 460;
const LEGEND: u32 = 60;

/// Muscles with a color of their own.
const NAMED: [(&str, CurveStyle); 4] = [
    ("gluteus medius", CurveStyle::new(0x1f_6f_b4)),
    ("gluteus maximus", CurveStyle::new(0x2c_8c_3c)),
    ("iliacus", CurveStyle::new(0xe0_7b_00)),
    ("psoas major", CurveStyle::new(0xb5_26_2e)),
];
const OTHERS: CurveStyle = CurveStyle::new(0xc0_c0_c0).hollow();

/// Numbers of balls in the table.
const BALLS: [f64; 5] = [25.0, 50.0, 100.0, 200.0, 400.0];

/// Errors of one medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BallErrors {
    balls: f64,
    rms: f64,
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
    let columns = &["muscle", "balls", "rms [mm]", "larger bound [mm]"];
    let mut rows = Vec::new();
    for (muscle, all) in &table {
        for BallErrors { balls, rms, bound } in all {
            rows.push(json!([muscle, balls, rms, bound]));
        }
    }
    Ok(Sheet { name: "medial", svg, settings, columns, rows }.write(folder)?)
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
            let errors = BallErrors { balls, rms, bound: outward.max(inward) };
            table.entry(cells[0].to_owned()).or_default().push(errors);
        }
    }
    table
}

fn draw(table: &Table) -> Result<String, Box<dyn Error>> {
    svg((WIDTH, HEADING + PANELS + LEGEND), |area| {
        let (head, rest) = area.split_vertically(HEADING);
        let (body, foot) = rest.split_vertically(PANELS);
        let (left, right) = body.split_horizontally(WIDTH / 2);
        draw_heading(&head, "Muscles of a thigh as balls: error over their number")?;
        panel(&left, "root mean square over the surface [mm]", table, |errors| errors.rms)?;
        panel(&right, "two-sided bound on the distance [mm]", table, |errors| errors.bound)?;
        legend(&foot)
    })
}

fn panel(area: &Area<'_>, title: &str, table: &Table, of: fn(&BallErrors) -> f64) -> Drawn {
    let x_range = (BALLS[0] / 1.2..1.2 * BALLS[4]).log_scale();
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x_range.with_key_points(BALLS.to_vec()), (0.02..10.0).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4))
        .x_desc("balls")
        .y_desc(title)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .draw()?;

    // Named muscles last, so that they lie on top.
    let style_of = |muscle: &str| NAMED.iter().find(|(name, _)| *name == muscle);
    let mut muscles: Vec<&String> = table.keys().collect();
    muscles.sort_by_key(|muscle| style_of(muscle).is_some());
    for muscle in muscles {
        let color = style_of(muscle).map_or(OTHERS, |(_, style)| *style).color;
        let points = || table[muscle].iter().map(|errors| (errors.balls, of(errors)));
        chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?;
        chart.draw_series(points().map(|point| Circle::new(point, 3, color.filled())))?;
    }
    Ok(())
}

fn legend(area: &Area<'_>) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let all = NAMED.iter().copied().chain([("the other muscles", OTHERS)]);
    for (number, (name, style)) in (0..).zip(all) {
        let left = 60 + 220 * number;
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
        let iliacus = [
            BallErrors { balls: 25.0, rms: 0.737, bound: 4.05 },
            BallErrors { balls: 400.0, rms: 0.125, bound: 0.87 },
        ];
        assert_eq!(table.len(), 1);
        assert_eq!(table["iliacus"], iliacus);
        assert!(draw(&table).expect("a picture").contains("gluteus maximus"));
    }
}
