//! How accurate medial surfaces are by their number of balls, from the table in
//! `docs/accuracy-medial.md`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use plotters::prelude::*;

use super::curves::{self, Area, Curve, Drawn, Look};
use super::sheet::{Cell, Sheet};

const WIDTH: u32 = 1200;
const HEAD: u32 = 44;
const PANELS: u32 = 460;
const LEGEND: u32 = 60;

/// Muscles that are told from the others.
const NAMED: [(&str, Look); 4] = [
    ("gluteus medius", Look::new(0x1f, 0x6f, 0xb4)),
    ("gluteus maximus", Look::new(0x2c, 0x8c, 0x3c)),
    ("iliacus", Look::new(0xe0, 0x7b, 0x00)),
    ("psoas major", Look::new(0xb5, 0x26, 0x2e)),
];
const OTHERS: Look = Look::new(0xc0, 0xc0, 0xc0).hollow();

/// Numbers of balls in the table.
const BALLS: [f64; 5] = [25.0, 50.0, 100.0, 200.0, 400.0];

/// What the table tells of one medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    balls: f64,
    rms: f64,
    bound: f64,
}

/// By muscle.
type Rows = BTreeMap<String, Vec<Row>>;

/// Draws the table beside the folder.
///
/// # Errors
///
/// When there is no table, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let path = folder.join("../accuracy-medial.md");
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let rows = read(&text);
    if rows.is_empty() {
        return Err(format!("{} has no table of muscles", path.display()).into());
    }
    let svg = Some(draw(&rows)?);
    let settings = vec![("from", "docs/accuracy-medial.md".to_owned())];
    let columns = vec!["muscle", "balls", "rms [mm]", "larger bound [mm]"];
    let cells = |muscle: &str, row: &Row| {
        let mut cells = vec![Cell::text(muscle)];
        cells.extend([row.balls, row.rms, row.bound].map(Cell::Number));
        cells
    };
    let of_muscle = |(muscle, rows): (&String, &Vec<Row>)| {
        rows.iter().map(|row| cells(muscle, row)).collect::<Vec<_>>()
    };
    let rows = rows.iter().flat_map(of_muscle).collect();
    Ok(Sheet { name: "medial", svg, settings, columns, rows }.write(folder)?)
}

/// The rows of the table by number of balls: those with a name and twelve values.
fn read(text: &str) -> Rows {
    let mut rows = Rows::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let number = |column: usize| cells.get(column)?.trim_matches('*').parse::<f64>().ok();
        if cells.len() != 13 {
            continue;
        }
        if let [Some(balls), Some(rms), Some(out), Some(over)] = [3, 5, 7, 9].map(number) {
            let row = Row { balls, rms, bound: out.max(over) };
            rows.entry(cells[0].to_owned()).or_default().push(row);
        }
    }
    rows
}

fn draw(rows: &Rows) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (WIDTH, HEAD + PANELS + LEGEND));
    let area = area.into_drawing_area();
    area.fill(&WHITE)?;
    let (head, rest) = area.split_vertically(HEAD);
    let (body, foot) = rest.split_vertically(PANELS);
    curves::heading(&head, "Muscles of a thigh as balls: error over their number")?;
    let (left, right) = body.split_horizontally(WIDTH / 2);
    panel(&left, "root mean square over the surface [mm]", rows, |row| row.rms)?;
    panel(&right, "bound on every distance, both ways [mm]", rows, |row| row.bound)?;
    legend(&foot)?;
    area.present()?;
    drop((head, foot, body, rest, left, right));
    drop(area);
    Ok(svg)
}

fn panel(area: &Area<'_>, title: &str, rows: &Rows, of: fn(&Row) -> f64) -> Drawn {
    let across = (BALLS[0] / 1.2..1.2 * BALLS[4]).log_scale();
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(across.with_key_points(BALLS.to_vec()), (0.02..10.0).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4))
        .x_desc("balls")
        .y_desc(title)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .draw()?;
    // The named last, so that they lie on top.
    let mut curves: Vec<(bool, Curve)> = Vec::new();
    for (muscle, rows) in rows {
        let named = NAMED.iter().find(|(name, _)| name == muscle);
        let look = named.map_or(OTHERS, |(_, look)| *look);
        let points = rows.iter().map(|row| [row.balls, of(row)]).collect();
        curves.push((named.is_some(), Curve { look, points }));
    }
    curves.sort_by_key(|(is_named, _)| *is_named);
    for (_, Curve { look, points }) in curves {
        let points: Vec<(f64, f64)> = points.into_iter().map(|[x, y]| (x, y)).collect();
        chart.draw_series(LineSeries::new(points.clone(), look.colour.stroke_width(2)))?;
        let marks = points.into_iter().map(|point| Circle::new(point, 3, look.colour.filled()));
        chart.draw_series(marks)?;
    }
    Ok(())
}

fn legend(area: &Area<'_>) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let all = NAMED.iter().copied().chain([("the other muscles", OTHERS)]);
    for (number, (name, look)) in (0..).zip(all) {
        let left = 60 + 220 * number;
        look.sample(area, [left, 20])?;
        area.draw_text(name, &text, (left + 40, 12))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_muscles_are_read_and_no_others() {
        let text = "\
| muscle | faces | extent | balls | slabs | rms | 95 % | s to b | sampled | b to s | sampled | parts and holes | s |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|--:|
| iliacus | 22330 | 253 | 25 | 29 | 0.737 | 1.419 | 4.05 | 3.79 | 3.97 | 3.88 | as the muscle | 0.7 |
| iliacus | 22330 | 253 | 400 | 780 | **0.125** | 0.150 | 0.65 | 0.42 | 0.87 | 0.38 | 1 parts, 1 tunnels | 7.7 |
| iliacus | at rest | 0.3 |
";
        let rows = read(text);
        let iliacus = [
            Row { balls: 25.0, rms: 0.737, bound: 4.05 },
            Row { balls: 400.0, rms: 0.125, bound: 0.87 },
        ];
        assert_eq!(rows.len(), 1);
        assert_eq!(rows["iliacus"], iliacus);
        assert!(draw(&rows).expect("a picture").contains("gluteus maximus"));
    }
}
