//! Picture of the answers: a panel per question, a mark per library over the time.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::chart::axes::{Area, Axis, Drawn, power};
use crate::chart::curves::{CAPTION_LINE, caption, draw_caption, picture};
use crate::chart::sheet::Settings;
use crate::measure::as_f64;
use crate::peers::libraries::{LIBRARIES, Library};
use crate::peers::{Measurement, QUESTIONS, Question};

const WIDTH: u32 = 1000;

/// Heights of a panel without its rows, and of a row.
const PANEL: u32 = 84;
const ROW: u32 = 21;

/// Decimal logarithms of times per pair \[us\] that are shown.
const TIMES: [f64; 2] = [0.0, 6.0];

/// Colors of this library, of those in Rust, and of packages for Python: three of Okabe and Ito's,
/// for all kinds of eyes.
const OWN: RGBColor = RGBColor(0x00, 0x72, 0xb2);
const RUST: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
const PYTHON: RGBColor = BLACK;

/// Draws the rows of one scene as SVG.
pub(super) fn draw(rows: &[&Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings, WIDTH);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let of = |question: Question| rows.iter().filter(move |row| row.question == question.text());
    let most = QUESTIONS.map(|question| of(question).count()).into_iter().max().unwrap_or(0);
    let body = (PANEL + ROW * u32::try_from(most)?) * u32::try_from(QUESTIONS.len().div_ceil(2))?;
    let heading = "The same pairs of bodies, asked of each library";
    picture(heading, WIDTH, [body, foot], |body, foot| {
        let panels = body.split_evenly((QUESTIONS.len().div_ceil(2), 2));
        for (area, question) in panels.iter().zip(QUESTIONS) {
            draw_panel(area, &of(question).copied().collect::<Vec<_>>(), most)?;
        }
        draw_caption(foot, &lines, 5)
    })
}

/// Draws marks with their names, the first library at the top, in room for the most rows.
fn draw_panel(area: &Area<'_>, rows: &[&Measurement], most: usize) -> Drawn {
    let Some(first) = rows.first() else { return Ok(()) };
    let title = format!("{} ({} pairs)", first.question, first.pairs);
    let x = Axis { range: TIMES, ..Axis::powers("time per pair [µs]", TIMES) };
    let lowest = as_f64(rows.len()) - as_f64(most) - 0.6;
    let y =
        Axis { ticks: Vec::new(), ..Axis::new("", [lowest, as_f64(rows.len()) - 0.4], 1.0, power) };
    let mut plot = Axis::draw(area, &title, [x, y])?;

    for (row, place) in rows.iter().rev().zip(0_u8..) {
        let color = color(&row.library);
        let time = row.time.log10().clamp(TIMES[0], TIMES[1]);
        let at = (time, f64::from(place));
        let is_right = row.wrong + row.refused == 0;
        let fill = if is_right { color } else { WHITE };
        plot.draw_series([Circle::new(at, 6, fill.filled())])?;
        plot.draw_series([Circle::new(at, 6, color.stroke_width(2))])?;

        // The name stands on the side with room.
        let is_left = 2.0 * time < TIMES[0] + TIMES[1];
        let (side, shift) = if is_left { (HPos::Left, 12) } else { (HPos::Right, -12) };
        let style = ("sans-serif", 15).into_font().color(&color).pos(Pos::new(side, VPos::Center));
        let text = EmptyElement::at(at) + Text::new(label(row), (shift, 0), style);
        plot.draw_series([text])?;
    }
    Ok(())
}

fn color(library: &str) -> RGBColor {
    match LIBRARIES.into_iter().find(|known| known.name() == library) {
        Some(Library::Own) => OWN,
        Some(Library::Parry | Library::Boolmesh) => RUST,
        None => PYTHON,
    }
}

/// Formats the name of a library, its time, and how many of its answers are not right.
fn label(row: &Measurement) -> String {
    let mark = if row.time.log10() > TIMES[1] { "≥ " } else { "" };
    let mut text = format!("{}: {mark}{:.0} µs", row.library, row.time.min(1e6));
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
