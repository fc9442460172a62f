//! Picture of time and memory over the number of faces.

use std::error::Error;

use super::Measurement;
use super::operations::OPERATIONS;
use crate::chart::axes::Axis;
use crate::chart::curves::{
    CAPTION_LINE, Curve, CurveStyle, Panel, caption, draw_caption, picture,
};
use crate::chart::palette;
use crate::chart::sheet::Settings;
use crate::measure::as_f64;

const WIDTH: u32 = 1000;
const BODY: u32 = 520;

/// Colors of the operations, in their order: of Okabe and Ito's palette, for all kinds of eyes.
const STYLES: [CurveStyle; OPERATIONS.len()] = [
    CurveStyle::new(palette::BLACK),
    CurveStyle::new(palette::BLUE),
    CurveStyle::new(palette::SKY),
    CurveStyle::new(palette::VERMILION),
    CurveStyle::new(palette::GREEN),
    CurveStyle::new(palette::PURPLE),
];

/// Decimal logarithms of the numbers of faces that are shown.
const FACES: [f64; 2] = [3.0, 6.3];

pub(super) fn draw(rows: &[Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings, WIDTH);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "Time and memory over the number of faces";
    picture(heading, WIDTH, [BODY, foot], |body, foot| {
        let (left, right) = body.split_horizontally(WIDTH / 2);
        let (time, names) = panel("time", "time [ms]", rows, |row| Some(row.time));
        time.draw_named(&left, &names)?;
        let (memory, names) = panel("memory", "memory [MB]", rows, |row| row.memory);
        memory.draw_named(&right, &names)?;
        draw_caption(foot, &lines, 5)
    })
}

/// Returns a panel with a curve per operation and number of threads, and the names and slopes of
/// those of one thread.
fn panel(
    title: &str,
    y_label: &str,
    rows: &[Measurement],
    value: fn(&Measurement) -> Option<f64>,
) -> (Panel, Vec<String>) {
    let (mut curves, mut names) = (Vec::new(), Vec::new());
    for (operation, style) in OPERATIONS.iter().zip(STYLES) {
        for (threads, style) in [(1, style), (2, style.hollow())] {
            let mut points = Vec::new();
            for row in rows {
                let is_of_curve = row.operation == operation.name() && row.threads == threads;
                if let (true, Some(value)) = (is_of_curve, value(row)) {
                    points.push([as_f64(row.faces), value]);
                }
            }

            // One thread has the name, beside its slope.
            let name = format!("{}, slope {:.2}", operation.name(), slope(&points));
            names.push(if threads == 1 { name } else { String::new() });
            curves.push(Curve { style, points });
        }
    }
    let panel = Panel {
        title: title.to_owned(),
        x: Axis::powers("faces", FACES),
        y_label: y_label.to_owned(),
        curves,
        has_front: false,
    };
    (panel, names)
}

/// Returns the power of the number of faces by which a value grows over the last two points.
fn slope(points: &[[f64; 2]]) -> f64 {
    match points {
        [.., [x0, y0], [x1, y1]] => (y1 / y0).ln() / (x1 / x0).ln(),
        _ => f64::NAN,
    }
}
