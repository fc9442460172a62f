//! Picture of stability: a column per integrator, a row per response.

use std::error::Error;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use response::stability::{Holding, Scheme};

use super::map::{CellMap, GridAxis, Scale};
use super::{
    ACCELERATIONS, ALTERATIONS, GAIN, GAIN_ROWS, Gain, GainRow, Limit, MAP_ROWS, MapRow, Stability,
    ZETA, limits,
};
use crate::chart::curves::{Area, Drawn, svg};
use crate::chart::sheet::Settings;

const SIZE: (u32, u32) = (1500, 1790);
const HEAD: u32 = 60;
const FOOT: u32 = 190;

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
const UNSTABLE: RGBColor = RGBColor(0xb0, 0x2f, 0x3a);
const LINE: RGBColor = BLACK;

/// Colors of responses whose copies are added up, in their order.
const COLORS: [RGBColor; 4] = [
    RGBColor(0xb0, 0x2f, 0x3a),
    RGBColor(0x1f, 0x5f, 0x8b),
    RGBColor(0xd9, 0x8a, 0x1f),
    RGBColor(0x3c, 0x8d, 0x4f),
];

/// Largest spectral radius shown over gains.
const MAX_RADIUS: f64 = 3.0;
const RADIUS: GridAxis = GridAxis {
    label: "spectral radius",
    scale: Scale::Linear,
    low: 0.0,
    high: MAX_RADIUS,
    cells: 1,
};

/// Draws the picture as SVG.
pub(super) fn draw(numbers: &Stability, settings: &Settings) -> Result<String, Box<dyn Error>> {
    svg(SIZE, |area| {
        let (head, rest) = area.split_vertically(HEAD);
        let (body, foot) = rest.split_vertically(SIZE.1 - HEAD - FOOT);
        heading(&head)?;
        legend(&foot, settings)?;

        // Maps of springs and bounces, then gains, then the map of reactions.
        let panels = body.split_evenly((MAP_ROWS.len() + GAIN_ROWS.len(), Scheme::ALL.len()));
        let mut rows = panels.chunks(Scheme::ALL.len());
        let mut maps = MAP_ROWS.iter().zip(&numbers.maps);
        for (row, maps) in maps.by_ref().take(3) {
            map_row(rows.next().unwrap_or_default(), row, maps)?;
        }
        for (row, gains) in GAIN_ROWS.iter().zip(&numbers.gains) {
            for (area, gain) in rows.next().unwrap_or_default().iter().zip(gains) {
                gain_panel(area, row, gain)?;
            }
        }
        for (row, maps) in maps {
            map_row(rows.next().unwrap_or_default(), row, maps)?;
        }
        Ok(())
    })
}

fn heading(area: &Area<'_>) -> Drawn {
    let centered = Pos::new(HPos::Center, VPos::Center);
    let title = ("sans-serif", 22).into_font().into_text_style(area).pos(centered);
    let middle = i32::try_from(SIZE.0 / 2)?;
    area.draw_text("Stability of contact responses, by integrator", &title, (middle, 18))?;

    let name = ("sans-serif", 17).into_font().into_text_style(area).pos(centered);
    let width = SIZE.0 / u32::try_from(Scheme::ALL.len())?;
    for (column, scheme) in (0..).zip(Scheme::ALL) {
        let x = i32::try_from(width * column + width / 2 + 20)?;
        area.draw_text(scheme.name(), &name, (x, 46))?;
    }
    Ok(())
}

fn map_row(areas: &[Area<'_>], row: &MapRow, maps: &[CellMap]) -> Drawn {
    for (area, map) in areas.iter().zip(maps) {
        map_panel(area, row, map)?;
    }
    Ok(())
}

/// A panel over two axes.
type Panel<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws title and axes of a panel, with about these numbers of labels.
fn panel<'a>(
    area: &Area<'a>,
    title: &str,
    [horizontal, vertical]: [GridAxis; 2],
    labels: [usize; 2],
) -> Result<Panel<'a>, Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 13))
        .margin(6)
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d(horizontal.low..horizontal.high, vertical.low..vertical.high)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(labels[0])
        .y_labels(labels[1])
        .x_desc(horizontal.label)
        .y_desc(vertical.label)
        .x_label_formatter(&|place| label(horizontal, *place))
        .y_label_formatter(&|place| label(vertical, *place))
        .draw()?;
    Ok(chart)
}

/// Draws a map in colors, with its known limits.
fn map_panel(area: &Area<'_>, row: &MapRow, map: &CellMap) -> Drawn {
    // Cells in colors, with the known limits on top.
    let mut chart = panel(area, row.title, map.axes, [7, 6])?;
    chart.draw_series(bars(map))?;
    let style = LINE.stroke_width(2);
    chart.draw_series(LineSeries::new(limit_line(map, row.limit), style))?;
    if let Some(other) = row.other_limit {
        chart.draw_series(DashedLineSeries::new(limit_line(map, other), 6, 4, style))?;
    }
    Ok(())
}

/// Returns the places of a limit within a map.
fn limit_line(map: &CellMap, limit: Limit) -> impl Iterator<Item = (f64, f64)> + Clone {
    let [horizontal, vertical] = map.axes;
    let scheme = map.scheme;
    let places = (1..=200)
        .map(move |k| vertical.low + (vertical.high - vertical.low) * f64::from(k) / 200.0);
    let line =
        places.filter_map(move |y| Some((horizontal.place(limit(scheme, vertical.value(y))?), y)));
    line.filter(move |(x, _)| (horizontal.low..=horizontal.high).contains(x))
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

fn label(axis: GridAxis, place: f64) -> String {
    match axis.scale {
        Scale::Linear => format!("{place:.1}"),
        Scale::Logarithmic if (place - place.round()).abs() > 1e-9 => String::new(),
        Scale::Logarithmic => format!("1e{place:.0}"),
    }
}

/// Draws growth over the number of copies, with the largest stable numbers.
fn gain_panel(area: &Area<'_>, row: &GainRow, gain: &Gain) -> Drawn {
    let mut chart = panel(area, row.title, [GAIN, RADIUS], [5, 4])?;

    // Stable below a radius of 1.
    let stable = Rectangle::new([(GAIN.low, 0.0), (GAIN.high, 1.0)], STABLE.filled());
    chart.draw_series([stable])?;
    let border = [(GAIN.low, 1.0), (GAIN.high, 1.0)];
    chart.draw_series(LineSeries::new(border, LINE.stroke_width(2)))?;

    for (number, (response, color)) in row.responses.iter().zip(COLORS).enumerate() {
        let points = gain.radii.iter().map(|(copies, radii)| (*copies, radii[number]));
        let shown = points.take_while(|&(_, radius)| radius <= MAX_RADIUS);
        chart.draw_series(LineSeries::new(shown, color.stroke_width(3)))?;

        // Implicit integrators have no limit for soft responses.
        let is_soft = !matches!((response.holding)(1.0), Holding::Hard { .. });
        let is_limited = !is_soft || limits::spring(gain.scheme, ZETA).is_some();
        if let Some(max) = response.max.filter(|_| is_limited) {
            let limit = [(max, 0.0), (max, MAX_RADIUS)];
            chart.draw_series(DashedLineSeries::new(limit, 6, 4, LINE.stroke_width(2)))?;
        }
    }
    Ok(())
}

/// Draws the keys of colors and lines, and the settings.
fn legend(area: &Area<'_>, settings: &Settings) -> Drawn {
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
            x += 200;
        }
    }
    for (line, (name, value)) in (0..).zip(settings) {
        area.draw_text(&format!("{name}: {value}"), &text, (40, 62 + 20 * line))?;
    }
    Ok(())
}
