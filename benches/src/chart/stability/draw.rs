//! Picture of stability: a column per integrator, a row per response.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use response::stability::{Holding, Scheme};

use super::map::{CellMap, GridAxis, Scale};
use super::{ACCELERATIONS, ALTERATIONS, Copies, Drawing, Limit, Maps, RESPONSES, ZETA, limits};
use crate::chart::axes::{Area, Axis, Drawn};
use crate::chart::curves::picture;
use crate::chart::sheet::Settings;

const WIDTH: u32 = 1000;
const BODY: u32 = 1140;
const FOOT: u32 = 190;

/// Height of the names of the integrators, and of the name of a response over its row.
const NAMES: u32 = 20;

/// Band of growth in a step or a bounce, up to a value.
struct Band {
    end: f64,
    color: RGBColor,
    name: &'static str,
}

const BANDS: [Band; 6] = [
    Band { end: 0.5, color: RGBColor(0x1f, 0x5f, 0x8b), name: "up to 0.5" },
    Band { end: 0.9, color: RGBColor(0x6a, 0xa9, 0xcf), name: "0.9" },
    Band { end: 1.0 + limits::ROUNDING, color: STABLE, name: "1: stable" },
    Band { end: 1.1, color: RGBColor(0xf6, 0xcf, 0xa6), name: "1.1" },
    Band { end: 2.0, color: RGBColor(0xe6, 0x86, 0x5c), name: "2" },
    Band { end: f64::INFINITY, color: UNSTABLE, name: "more" },
];
const STABLE: RGBColor = RGBColor(0xcf, 0xe3, 0xef);
const UNSTABLE: RGBColor = RGBColor(0xa3, 0x45, 0x00);
const LINE: RGBColor = BLACK;

/// Colors of responses whose copies are added up, in their order.
const COLORS: [RGBColor; 4] = [
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
];

/// Spectral radii shown over gains.
const RADIUS: GridAxis =
    GridAxis { label: "spectral radius", scale: Scale::Linear, low: 0.0, high: 3.0, cells: 1 };

/// Draws the picture as SVG.
pub(super) fn draw(all: &[Maps], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let heading = "Stability of contact responses, by integrator";
    picture(heading, WIDTH, [BODY, FOOT], |body, foot| {
        let (head, body) = body.split_vertically(NAMES);
        draw_names(&head)?;
        draw_legend(foot, settings)?;

        // One row per response under its name, one column per integrator.
        let rows = body.split_evenly((RESPONSES.len(), 1));
        for ((response, maps), row) in RESPONSES.iter().zip(all).zip(&rows) {
            let (head, panels) = row.split_vertically(NAMES);
            let title = ("sans-serif", 15).into_font().into_text_style(&head);
            head.draw_text(response.title, &title, (40, 4))?;
            for (map, area) in maps.iter().zip(&panels.split_evenly((1, Scheme::ALL.len()))) {
                match response.drawing {
                    Drawing::Cells { limit, other_limit } => {
                        draw_cells(area, map, [Some(limit), other_limit])?;
                    }
                    Drawing::Curves(copies) => draw_curves(area, map, copies)?,
                }
            }
        }
        Ok(())
    })
}

/// Draws the names of the integrators over their columns.
fn draw_names(area: &Area<'_>) -> Drawn {
    let centered = Pos::new(HPos::Center, VPos::Center);
    let name = ("sans-serif", 17).into_font().into_text_style(area).pos(centered);
    for (column, scheme) in area.split_evenly((1, Scheme::ALL.len())).iter().zip(Scheme::ALL) {
        let middle = i32::try_from(column.dim_in_pixel().0 / 2)?;
        column.draw_text(scheme.name(), &name, (middle + 16, 10))?;
    }
    Ok(())
}

/// Draws a map in colors, with its limits in closed form on top.
fn draw_cells(area: &Area<'_>, map: &CellMap, [limit, dashed]: [Option<Limit>; 2]) -> Drawn {
    let [horizontal, vertical] = map.axes;
    let mut plot = Axis::draw(area, "", [horizontal.axis(), vertical.axis()])?;
    plot.draw_series(bars(map))?;

    // Limits lie on top of the cells.
    let style = LINE.stroke_width(2);
    if let Some(limit) = limit {
        plot.draw_series(LineSeries::new(limit_line(map, limit), style))?;
    }
    if let Some(limit) = dashed {
        plot.draw_series(DashedLineSeries::new(limit_line(map, limit), 6, 4, style))?;
    }
    Ok(())
}

/// Returns the places of a limit within a map.
fn limit_line(map: &CellMap, limit: Limit) -> Vec<(f64, f64)> {
    const PLACES: u32 = 200;

    let [horizontal, vertical] = map.axes;
    let mut line = Vec::new();
    for k in 1..=PLACES {
        let y = vertical.low + (vertical.high - vertical.low) * f64::from(k) / f64::from(PLACES);
        let Some(value) = limit(map.scheme, vertical.value(y)) else { continue };
        let x = horizontal.place(value);
        if (horizontal.low..=horizontal.high).contains(&x) {
            line.push((x, y));
        }
    }
    line
}

/// Joins cells of one row and one band to bars.
fn bars(map: &CellMap) -> Vec<Rectangle<(f64, f64)>> {
    let [horizontal, vertical] = map.axes;
    let mut bars = Vec::new();
    for j in 0..vertical.cells {
        // A bar ends where the color changes, or at the end of the row.
        let mut start = 0;
        for end in 1..=horizontal.cells {
            let color = band_color(map.value(start, j));
            if end == horizontal.cells || band_color(map.value(end, j)) != color {
                let lower = (horizontal.edge(start), vertical.edge(j));
                let upper = (horizontal.edge(end), vertical.edge(j + 1));
                bars.push(Rectangle::new([lower, upper], color.filled()));
                start = end;
            }
        }
    }
    bars
}

fn band_color(value: f64) -> RGBColor {
    BANDS.iter().find(|band| value <= band.end).map_or(UNSTABLE, |band| band.color)
}

/// Draws growth over the number of copies, with the largest stable numbers.
fn draw_curves(area: &Area<'_>, map: &CellMap, responses: &[Copies]) -> Drawn {
    let gain = map.axes[0];
    let mut plot = Axis::draw(area, "", [gain.axis(), RADIUS.axis()])?;

    // Stable below a radius of 1.
    let stable = Rectangle::new([(gain.low, 0.0), (gain.high, 1.0)], STABLE.filled());
    plot.draw_series([stable])?;
    let border = [(gain.low, 1.0), (gain.high, 1.0)];
    plot.draw_series(LineSeries::new(border, LINE.stroke_width(2)))?;

    for (number, (response, color)) in (0..).zip(responses.iter().zip(COLORS)) {
        // Up to where the curve leaves the panel.
        let mut curve = Vec::new();
        for cell in 0..gain.cells {
            let radius = map.value(cell, number);
            if radius > RADIUS.high {
                break;
            }
            curve.push((gain.center(cell), radius));
        }
        plot.draw_series(LineSeries::new(curve, color.stroke_width(3)))?;

        // Implicit integrators have no limit for soft responses.
        let is_soft = !matches!((response.holding)(1.0), Holding::Hard { .. });
        let is_limited = !is_soft || limits::spring(map.scheme, ZETA).is_some();
        if let Some(max) = response.max.filter(|_| is_limited) {
            let limit = [(max, 0.0), (max, RADIUS.high)];
            plot.draw_series(DashedLineSeries::new(limit, 6, 4, LINE.stroke_width(2)))?;
        }
    }
    Ok(())
}

/// Draws the keys of colors and lines, and the settings.
fn draw_legend(area: &Area<'_>, settings: &Settings) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    // Bands and the line of known limits.
    let mut x = 40;
    area.draw_text("growth", &text, (x, 10))?;
    x += 70;
    for Band { color, name, .. } in BANDS {
        area.draw(&Rectangle::new([(x, 8), (x + 26, 24)], color.filled()))?;
        area.draw_text(name, &text, (x + 32, 10))?;
        x += 120;
    }
    area.draw(&PathElement::new([(x, 16), (x + 26, 16)], LINE.stroke_width(2)))?;
    area.draw_text("known limit", &text, (x + 32, 10))?;

    // Responses whose copies are added up.
    x = 40;
    for responses in [&ACCELERATIONS[..], &ALTERATIONS] {
        for (response, color) in responses.iter().zip(COLORS) {
            area.draw(&PathElement::new([(x, 40), (x + 26, 40)], color.stroke_width(3)))?;
            area.draw_text(response.name, &text, (x + 32, 34))?;
            x += 158;
        }
    }

    // One line per setting, below the keys.
    for (line, (name, value)) in (0..).zip(settings) {
        area.draw_text(&format!("{name}: {value}"), &text, (40, 62 + 20 * line))?;
    }
    Ok(())
}
