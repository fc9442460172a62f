//! The picture: a column an integrator, a row a response.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use response::stability::{Holding, Scheme};

use super::map::{Axis, Map, Scale};
use super::{ACCELERATIONS, ALTERATIONS, Copies, GAIN, Gain, STACK, Stability, ZETA, limits};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

const SIZE: (u32, u32) = (1500, 1790);
const HEAD: u32 = 60;
const FOOT: u32 = 190;

/// Upper ends of bands of growth in a step or a bounce, with what they mean.
const BANDS: [(f64, RGBColor, &str); 5] = [
    (0.5, RGBColor(0x1f, 0x5f, 0x8b), "up to 0.5"),
    (0.9, RGBColor(0x6a, 0xa9, 0xcf), "0.9"),
    (1.0 + limits::ROUNDING, RGBColor(0xcf, 0xe3, 0xef), "1: it holds"),
    (1.1, RGBColor(0xf6, 0xcf, 0xa6), "1.1"),
    (2.0, RGBColor(0xe6, 0x86, 0x5c), "2"),
];
const BEYOND: RGBColor = RGBColor(0xb0, 0x2f, 0x3a);
const LINE: RGBColor = BLACK;
/// Of responses whose copies are added up, in their order.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0xb0, 0x2f, 0x3a),
    RGBColor(0x1f, 0x5f, 0x8b),
    RGBColor(0xd9, 0x8a, 0x1f),
    RGBColor(0x3c, 0x8d, 0x4f),
];

/// Draws the picture as SVG.
pub(super) fn draw(
    numbers: &Stability,
    settings: &[(&'static str, String)],
) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, rest) = area.split_vertically(HEAD);
    let (body, foot) = rest.split_vertically(SIZE.1 - HEAD - FOOT);
    heading(&head)?;
    let panels = body.split_evenly((6, Scheme::ALL.len()));
    for (number, panel) in panels.iter().enumerate() {
        let column = number % Scheme::ALL.len();
        let (bounce, growth) = ("bounce: speed after / before", "contact spring: growth a step");
        match number / Scheme::ALL.len() {
            0 => springs(panel, &numbers.springs[column])?,
            1 => over_damping(panel, &numbers.damped_springs[column], growth)?,
            2 => over_damping(panel, &numbers.bounces[column], bounce)?,
            3 => {
                let title = "springs as accelerations: growth a step";
                gains(panel, &numbers.gains[column], title, &ACCELERATIONS)?;
            }
            4 => {
                let title = "altered before the move: growth a step";
                gains(panel, &numbers.alterations[column], title, &ALTERATIONS)?;
            }
            _ => reactions(panel, &numbers.reactions[column])?,
        }
    }
    legend(&foot, settings)?;
    area.present()?;
    drop((head, foot, body, rest, panels));
    drop(area);
    Ok(svg)
}

fn heading(area: &Area<'_>) -> Drawn {
    let centred = Pos::new(HPos::Center, VPos::Center);
    let title = ("sans-serif", 22).into_font().into_text_style(area).pos(centred);
    let middle = i32::try_from(SIZE.0 / 2)?;
    area.draw_text("Where contact responses hold, by integrator", &title, (middle, 18))?;
    let name = ("sans-serif", 17).into_font().into_text_style(area).pos(centred);
    let width = SIZE.0 / u32::try_from(Scheme::ALL.len())?;
    for (column, scheme) in (0..).zip(Scheme::ALL) {
        let x = i32::try_from(width * column + width / 2 + 20)?;
        area.draw_text(scheme.name(), &name, (x, 46))?;
    }
    Ok(())
}

/// A map over stiffness and step, with the limits of one spring and of a stack.
fn springs(area: &Area<'_>, map: &Map) -> Drawn {
    let of = |limit: Option<f64>| limit.map(|omega_h| move |h: f64| (h, (omega_h / h).powi(2)));
    let lines = [
        (of(limits::spring(map.scheme, ZETA)), 1.0),
        (of(limits::stack(map.scheme, ZETA, STACK)), 0.5),
    ];
    let lines = lines.into_iter().filter_map(|(line, width)| Some((line?, width)));
    let lines: Vec<(Vec<(f64, f64)>, bool)> = lines
        .map(|(line, width)| (samples(map.axes[1]).map(line).collect(), width < 1.0))
        .collect();
    panel(area, map, &format!("contact spring, ζ = {ZETA}"), &lines)
}

/// A map over ω h and ζ, with the limit of one spring.
fn over_damping(area: &Area<'_>, map: &Map, title: &str) -> Drawn {
    let line = |zeta: f64| limits::spring(map.scheme, zeta).map(|omega_h| (zeta, omega_h));
    let line: Vec<(f64, f64)> = samples(map.axes[1]).filter_map(line).collect();
    panel(area, map, title, &[(line, false)])
}

/// Many values along an axis.
fn samples(axis: Axis) -> impl Iterator<Item = f64> {
    let at = move |k: u32| axis.low + (axis.high - axis.low) * f64::from(k) / 200.0;
    (1..=200).map(move |k| axis.value(at(k)))
}

/// A map in colours, with lines of (value up, value across), dashed or not.
fn panel(area: &Area<'_>, map: &Map, title: &str, lines: &[(Vec<(f64, f64)>, bool)]) -> Drawn {
    let [across, up] = map.axes;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 13))
        .margin(6)
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d(across.low..across.high, up.low..up.high)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(7)
        .y_labels(6)
        .x_desc(across.label)
        .y_desc(up.label)
        .x_label_formatter(&|place| label(across, *place))
        .y_label_formatter(&|place| label(up, *place))
        .draw()?;
    chart.draw_series(bands(map))?;
    for (line, dashed) in lines {
        let places = line.iter().map(|&(y, x)| (across.place(x), up.place(y)));
        let inside = places.filter(|&(x, y)| {
            (across.low..=across.high).contains(&x) && (up.low..=up.high).contains(&y)
        });
        let style = LINE.stroke_width(2);
        if *dashed {
            chart.draw_series(DashedLineSeries::new(inside, 6, 4, style))?;
        } else {
            chart.draw_series(LineSeries::new(inside, style))?;
        }
    }
    Ok(())
}

/// Cells of one row and one band, joined.
fn bands(map: &Map) -> Vec<Rectangle<(f64, f64)>> {
    let [across, up] = map.axes;
    let mut bars = Vec::new();
    for j in 0..up.cells {
        let mut from = 0;
        for i in 1..=across.cells {
            let colour = band(map.value(from, j));
            if i == across.cells || band(map.value(i, j)) != colour {
                let corners = [(across.edge(from), up.edge(j)), (across.edge(i), up.edge(j + 1))];
                bars.push(Rectangle::new(corners, colour.filled()));
                from = i;
            }
        }
    }
    bars
}

fn band(value: f64) -> RGBColor {
    BANDS.iter().find(|(end, ..)| value <= *end).map_or(BEYOND, |(_, colour, _)| *colour)
}

fn label(axis: Axis, place: f64) -> String {
    match axis.scale {
        Scale::Linear => format!("{place:.1}"),
        Scale::Logarithmic if (place - place.round()).abs() > 1e-9 => String::new(),
        Scale::Logarithmic => format!("1e{place:.0}"),
    }
}

/// A map over speed and gravity, with the limit of a reaction.
fn reactions(area: &Area<'_>, map: &Map) -> Drawn {
    let line = |gravity: f64| limits::reaction(map.scheme, gravity).map(|limit| (gravity, limit));
    let line: Vec<(f64, f64)> = samples(map.axes[1]).filter_map(line).collect();
    panel(area, map, "reaction: deepest point / d_max", &[(line, false)])
}

/// Growth over the number of copies, and how many hold.
fn gains(area: &Area<'_>, gain: &Gain, title: &str, responses: &[Copies]) -> Drawn {
    let highest = 3.0;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 13))
        .margin(6)
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d(GAIN.low..GAIN.high, 0.0..highest)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(5)
        .y_labels(4)
        .x_desc(GAIN.label)
        .y_desc("spectral radius")
        .draw()?;
    let holds = Rectangle::new([(GAIN.low, 0.0), (GAIN.high, 1.0)], BANDS[2].1.filled());
    chart.draw_series([holds])?;
    chart
        .draw_series(LineSeries::new([(GAIN.low, 1.0), (GAIN.high, 1.0)], LINE.stroke_width(2)))?;
    for (number, (response, colour)) in responses.iter().zip(COLOURS).enumerate() {
        let points = gain.radii.iter().map(|(copies, radii)| (*copies, radii[number]));
        let shown = points.take_while(|&(_, radius)| radius <= highest);
        chart.draw_series(LineSeries::new(shown, colour.stroke_width(3)))?;
        let is_soft = !matches!((response.holding)(1.0), Holding::Hard { .. });
        let is_limited = !is_soft || limits::spring(gain.scheme, ZETA).is_some();
        if let (Some(most), true) = (response.most, is_limited) {
            let limit = [(most, 0.0), (most, highest)];
            chart.draw_series(DashedLineSeries::new(limit, 6, 4, LINE.stroke_width(2)))?;
        }
    }
    Ok(())
}

/// What colours and lines mean, and what was held fixed.
fn legend(area: &Area<'_>, settings: &[(&'static str, String)]) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let mut x = 40;
    area.draw_text("growth", &text, (x, 10))?;
    x += 70;
    let names = BANDS.iter().map(|&(_, colour, name)| (colour, name)).chain([(BEYOND, "more")]);
    for (colour, name) in names {
        area.draw(&Rectangle::new([(x, 8), (x + 26, 24)], colour.filled()))?;
        area.draw_text(name, &text, (x + 32, 10))?;
        x += 120;
    }
    area.draw(&PathElement::new([(x, 16), (x + 26, 16)], LINE.stroke_width(2)))?;
    area.draw_text("known limit", &text, (x + 32, 10))?;
    x = 40;
    for responses in [&ACCELERATIONS[..], &ALTERATIONS] {
        for (response, colour) in responses.iter().zip(COLOURS) {
            area.draw(&PathElement::new([(x, 40), (x + 26, 40)], colour.stroke_width(3)))?;
            area.draw_text(response.name, &text, (x + 32, 34))?;
            x += 200;
        }
    }
    for (line, (what, value)) in (0..).zip(settings) {
        area.draw_text(&format!("{what}: {value}"), &text, (40, 62 + 20 * line))?;
    }
    Ok(())
}
