//! Picture of time and memory over the number of faces.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Measurement;
use super::operations::OPERATIONS;
use crate::chart::curves::{
    Area, Axis, CAPTION_LINE, CurveStyle, Drawn, caption, draw_caption, picture,
};
use crate::chart::sheet::Settings;
use crate::measure::as_f64;

const WIDTH: u32 = 1500;
const BODY: u32 = 520;

/// Colors of the operations, in their order: of Okabe and Ito's palette, for all kinds of eyes.
const STYLES: [CurveStyle; OPERATIONS.len()] = [
    CurveStyle::new(0x00_00_00),
    CurveStyle::new(0x1f_6f_b4),
    CurveStyle::new(0x56_b4_e9),
    CurveStyle::new(0xd5_5e_00),
    CurveStyle::new(0x00_9e_73),
    CurveStyle::new(0xcc_79_a7),
];

/// Decimal logarithms that are shown: faces with room for names, times \[ms\], memory \[MB\].
const FACES: [f64; 2] = [1.7, 7.0];
const TIMES: [f64; 2] = [-2.3, 4.6];
const MEMORY: [f64; 2] = [-2.3, 3.6];

pub(super) fn draw(rows: &[Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "Time and memory over the number of faces";
    picture(heading, WIDTH, [BODY, foot], |body, foot| {
        let (left, right) = body.split_horizontally(WIDTH / 2);
        draw_panel(&left, "time", Axis::powers("time [ms]", TIMES), rows, |row| Some(row.time))?;
        let memory = Axis::powers("memory [MB]", MEMORY);
        draw_panel(&right, "memory", memory, rows, |row| row.memory)?;
        draw_caption(foot, &lines, 5)
    })
}

fn draw_panel(
    area: &Area<'_>,
    title: &str,
    y: Axis,
    rows: &[Measurement],
    value: fn(&Measurement) -> Option<f64>,
) -> Drawn {
    let x = Axis::powers("faces", FACES);
    let [bottom, top] = y.range;
    let mut plot = Axis::draw(area, title, [x, y])?;
    for (operation, style) in OPERATIONS.iter().zip(STYLES) {
        for (threads, style) in [(1, style), (2, style.hollow())] {
            // A curve from size to size.
            let mut of_both: Vec<&Measurement> = rows.iter().collect();
            of_both.retain(|row| row.operation == operation.name() && row.threads == threads);
            let mut points = Vec::new();
            for row in &of_both {
                if let Some(value) = value(row) {
                    points.push((as_f64(row.faces).log10(), value.log10().clamp(bottom, top)));
                }
            }
            plot.draw_series(LineSeries::new(points.clone(), style.color.stroke_width(2)))?;
            for &point in &points {
                let fill = if style.is_hollow { WHITE } else { style.color };
                plot.draw_series([Circle::new(point, 4, fill.filled())])?;
                plot.draw_series([Circle::new(point, 4, style.color.stroke_width(2))])?;
            }

            // The name stands at the end of the curve of one thread.
            if let (1, Some(&end), Some(last)) = (threads, points.last(), of_both.last()) {
                let middle = Pos::new(HPos::Left, VPos::Center);
                let font = ("sans-serif", 14).into_font().color(&style.color).pos(middle);
                let text = format!("{}, slope {:.2}", last.operation, slope(&points));
                plot.draw_series([EmptyElement::at(end) + Text::new(text, (10, 0), font)])?;
            }
        }
    }
    Ok(())
}

/// Returns the slope over the last two points.
fn slope(points: &[(f64, f64)]) -> f64 {
    match points {
        [.., (x0, y0), (x1, y1)] => (y1 - y0) / (x1 - x0),
        _ => f64::NAN,
    }
}
