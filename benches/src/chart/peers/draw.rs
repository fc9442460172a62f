//! Picture of the answers: a panel per question, a mark per library over the time.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::libraries::{LIBRARIES, Library};
use super::{Measurement, QUESTIONS};
use crate::chart::curves::{
    Area, Axis, CAPTION_LINE, Drawn, caption, draw_caption, picture, power,
};
use crate::chart::sheet::Settings;
use crate::measure::as_f64;

const WIDTH: u32 = 1500;

/// Heights of a panel, and of a library's row in it.
const PANEL: u32 = 185;

/// Decimal logarithms of times per pair \[us\] that are shown.
const TIMES: [f64; 2] = [0.0, 5.0];

/// Draws the rows of one scene as SVG.
pub(super) fn draw(rows: &[&Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let body = PANEL * u32::try_from(QUESTIONS.len().div_ceil(2))?;
    let heading = "The same pairs of bodies, asked of each library";
    picture(heading, WIDTH, [body, foot], |body, foot| {
        let panels = body.split_evenly((QUESTIONS.len().div_ceil(2), 2));
        for (area, question) in panels.iter().zip(QUESTIONS) {
            let mut asked = rows.to_vec();
            asked.retain(|row| row.question == question.text());
            draw_panel(area, &asked)?;
        }
        draw_caption(foot, &lines, 5)
    })
}

fn draw_panel(area: &Area<'_>, rows: &[&Measurement]) -> Drawn {
    let Some(first) = rows.first() else { return Ok(()) };
    let title = format!("{} ({} pairs)", first.question, first.pairs);
    let x = Axis { range: TIMES, ..Axis::powers("time per pair [µs]", TIMES) };
    let y =
        Axis { ticks: Vec::new(), ..Axis::new("", [-0.6, as_f64(rows.len()) - 0.4], 1.0, power) };
    let mut plot = Axis::draw(area, &title, [x, y])?;

    // The first library at the top; each mark with its name and what is wrong with its answers.
    let middle = Pos::new(HPos::Left, VPos::Center);
    for (row, place) in rows.iter().rev().zip(0_u8..) {
        let color = color(row.library);
        let at = (row.time.log10().clamp(TIMES[0], TIMES[1]), f64::from(place));
        let is_right = row.wrong + row.refused == 0;
        let fill = if is_right { color } else { WHITE };
        plot.draw_series([Circle::new(at, 6, fill.filled())])?;
        plot.draw_series([Circle::new(at, 6, color.stroke_width(2))])?;

        let style = ("sans-serif", 14).into_font().color(&color).pos(middle);
        let text = EmptyElement::at(at) + Text::new(label(row), (12, 0), style);
        plot.draw_series([text])?;
    }
    Ok(())
}

fn color(library: &str) -> RGBColor {
    let known = LIBRARIES.into_iter().find(|known| known.name() == library);
    match known {
        Some(Library::Own) => RGBColor(0x1f, 0x6f, 0xb4),
        Some(Library::Parry) => RGBColor(0xb5, 0x26, 0x2e),
        Some(Library::Boolmesh) => RGBColor(0xb0, 0x5f, 0x00),
        None => BLACK,
    }
}

/// Formats the name of a library, its time, and how many of its answers are not right.
fn label(row: &Measurement) -> String {
    let mut text = format!("{}: {:.0} µs", row.library, row.time);
    if row.wrong > 0 {
        text += &format!(", {} wrong", row.wrong);
    }
    if row.refused > 0 {
        text += &format!(", {} refused", row.refused);
    }
    if row.wrong + row.refused == 0 {
        text += ", all right";
    }
    text
}
