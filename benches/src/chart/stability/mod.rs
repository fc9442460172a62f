//! Stability of contact responses: under each integrator, over stiffness and step; and with each
//! detector, over planted scenes.
//!
//! A column per integrator, a row per response. The maps are computed by steps with the crate
//! `response` itself. The lines on top of them are closed forms ([`limits`]), so that a line off a
//! border shows a fault in one of both. Mass, length and time are scaled out: only ω h and ζ
//! matter to one spring.

pub mod bounce;
mod draw;
pub mod limits;
pub mod map;
pub mod reaction;
mod scene_map;

use std::error::Error;
use std::path::{Path, PathBuf};

use response::ResponseError;
use response::stability::{HardRow, Holding, Scheme, StabilityCase};
use serde::Serialize;

use self::map::{CellMap, GridAxis, Scale};
use super::sheet::{Settings, Sheet};

/// Damping ratio of the maps over stiffness and step.
const ZETA: f64 = 0.1;

/// Times of first touch within a step, of which the worst counts.
const PHASES: u32 = 16;

/// Masses of the stack whose limit is drawn beside that of one.
const STACK: u32 = 10;

const STIFFNESS: GridAxis =
    GridAxis { label: "k / m [1/s²]", scale: Scale::Logarithmic, low: 2.0, high: 8.0, cells: 30 };
const STEP: GridAxis =
    GridAxis { label: "step h [s]", scale: Scale::Logarithmic, low: -5.0, high: -1.0, cells: 20 };
const OMEGA_H: GridAxis =
    GridAxis { label: "ω h", scale: Scale::Logarithmic, low: -2.0, high: 1.0, cells: 30 };
const DAMPING: GridAxis =
    GridAxis { label: "damping ratio ζ", scale: Scale::Linear, low: 0.0, high: 2.5, cells: 20 };
const GAIN: GridAxis =
    GridAxis { label: "copies added up", scale: Scale::Linear, low: 0.0, high: 5.0, cells: 50 };
const APPROACH: GridAxis =
    GridAxis { label: "v h / d_max", scale: Scale::Linear, low: 0.0, high: 2.0, cells: 40 };
const GRAVITY: GridAxis =
    GridAxis { label: "g h² / d_max", scale: Scale::Linear, low: 0.0, high: 0.5, cells: 20 };

const ACCELERATION: GridAxis =
    GridAxis { label: "acceleration", scale: Scale::Linear, low: 0.5, high: 2.5, cells: 2 };
const ALTERATION: GridAxis =
    GridAxis { label: "alteration", scale: Scale::Linear, low: 0.5, high: 4.5, cells: 4 };

/// Limit of stability in closed form: the horizontal value at a vertical one.
type Limit = fn(Scheme, f64) -> Option<f64>;

/// A response as maps, one per integrator: a row of panels.
struct Response {
    /// Name in the table.
    name: &'static str,
    title: &'static str,
    axes: [GridAxis; 2],
    value: fn(Scheme, f64, f64) -> Result<f64, ResponseError>,
    drawing: Drawing,
}

/// Drawing of a map.
enum Drawing {
    /// Cells in colors, under limits in closed form; `other_limit` is dashed.
    Cells { limit: Limit, other_limit: Option<Limit> },
    /// Curves: one per row of cells.
    Curves(&'static [Copies]),
}

const RESPONSES: [Response; 6] = [
    Response {
        name: "spring over k h",
        title: "contact spring, ζ = 0.1",
        axes: [STIFFNESS, STEP],
        value: |scheme, k, h| spring_radius(scheme, k.sqrt() * h, ZETA),
        drawing: Drawing::Cells {
            limit: |scheme, h| Some((limits::spring(scheme, ZETA)? / h).powi(2)),
            other_limit: Some(|scheme, h| Some((limits::stack(scheme, ZETA, STACK)? / h).powi(2))),
        },
    },
    Response {
        name: "spring over ωh ζ",
        title: "contact spring: growth per step",
        axes: [OMEGA_H, DAMPING],
        value: spring_radius,
        drawing: Drawing::Cells { limit: limits::spring, other_limit: None },
    },
    Response {
        name: "bounce over ωh ζ",
        title: "bounce: speed after / before",
        axes: [OMEGA_H, DAMPING],
        value: |scheme, omega_h, zeta| bounce::max_restitution(scheme, omega_h, zeta, PHASES),
        drawing: Drawing::Cells { limit: limits::spring, other_limit: None },
    },
    Response {
        name: "acceleration over copies order",
        title: "springs as accelerations: growth per step",
        axes: [GAIN, ACCELERATION],
        value: |scheme, gain, number| copies_radius(&ACCELERATIONS, scheme, gain, number),
        drawing: Drawing::Curves(&ACCELERATIONS),
    },
    Response {
        name: "alteration over copies row",
        title: "altered before the move: growth per step",
        axes: [GAIN, ALTERATION],
        value: |scheme, gain, number| copies_radius(&ALTERATIONS, scheme, gain, number),
        drawing: Drawing::Curves(&ALTERATIONS),
    },
    Response {
        name: "reaction over vh/d gh²/d",
        title: "reaction: deepest point / d_max",
        axes: [APPROACH, GRAVITY],
        value: reaction::max_depth,
        drawing: Drawing::Cells { limit: limits::reaction, other_limit: None },
    },
];

fn spring_radius(scheme: Scheme, omega_h: f64, zeta: f64) -> Result<f64, ResponseError> {
    StabilityCase { scheme, holding: Holding::Penalty { omega_h, zeta } }.radius()
}

/// Computes the spectral radius of copies of the response with a number, from 1 on.
fn copies_radius(
    responses: &[Copies],
    scheme: Scheme,
    gain: f64,
    number: f64,
) -> Result<f64, ResponseError> {
    // Cells of the vertical axis stand for responses, numbered from 1.
    let mut radius = f64::NAN;
    for (other, response) in (1..).zip(responses) {
        if (f64::from(other) - number).abs() < 0.5 {
            radius = StabilityCase { scheme, holding: (response.holding)(gain) }.radius()?;
        }
    }
    Ok(radius)
}

/// A response whose copies are added up.
#[derive(Clone, Copy, Debug)]
struct Copies {
    name: &'static str,
    holding: fn(f64) -> Holding,
    /// Largest stable number under an explicit integrator; `None` without a limit.
    max: Option<f64>,
}

/// Springs as accelerations.
const ACCELERATIONS: [Copies; 2] = [
    Copies { name: "first order", holding: |gain| Holding::FirstOrder { gain }, max: None },
    Copies {
        name: "second order",
        holding: |gain| Holding::SecondOrder { gain },
        max: Some(limits::SECOND_ORDER_GAIN),
    },
];

/// Alterations of positions and velocities, the same under every integrator.
const ALTERATIONS: [Copies; 4] = [
    Copies {
        name: "spring ΔV",
        holding: |gain| hard(HardRow::Spring, gain),
        max: Some(limits::SPRING_GAIN),
    },
    Copies {
        name: "spring ΔV that stops",
        holding: |gain| hard(HardRow::SpringToTarget, gain),
        max: Some(limits::SECOND_ORDER_GAIN),
    },
    Copies {
        name: "reaction ΔV",
        holding: |gain| hard(HardRow::Reaction, gain),
        max: Some(limits::STOPPING_GAIN),
    },
    Copies {
        name: "reference ΔP, ΔV",
        holding: |gain| hard(HardRow::Reference, gain),
        max: Some(limits::STOPPING_GAIN),
    },
];

const fn hard(row: HardRow, gain: f64) -> Holding {
    Holding::Hard { row, gain }
}

/// Border of a map at one height: a row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct BorderRow {
    response: &'static str,
    integrator: &'static str,
    y: f64,
    /// Value at which the cells stop to be stable, from the left; none where all are.
    stable_up_to: Option<f64>,
    /// Largest value of all cells.
    worst: f64,
}

/// Maps of a response, one per integrator.
type Maps = Vec<CellMap>;

/// Draws the picture and writes its numbers.
///
/// # Errors
///
/// When a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let all = compute()?;
    let sheet = Sheet::new("stability", settings(), &rows(&all))?;
    let mut written = sheet.write(folder, Some(draw::draw(&all, &sheet.settings)?))?;
    written.extend(scene_map::run(folder)?);
    Ok(written)
}

/// Computes the maps of all responses.
fn compute() -> Result<[Maps; RESPONSES.len()], ResponseError> {
    let mut all = [const { Vec::new() }; RESPONSES.len()];
    for (response, maps) in RESPONSES.iter().zip(&mut all) {
        for scheme in Scheme::ALL {
            maps.push(CellMap::new(scheme, response.axes, response.value)?);
        }
    }
    Ok(all)
}

/// Returns the rows of the table, map by map: where each border is. The cells are in the picture.
fn rows(all: &[Maps]) -> Vec<BorderRow> {
    let mut rows = Vec::new();
    for (Response { name, .. }, maps) in RESPONSES.iter().zip(all) {
        for map in maps {
            let [horizontal, vertical] = map.axes;
            for j in 0..vertical.cells {
                let row = (0..horizontal.cells).map(|i| map.value(i, j));
                // The border is at the start of the first unstable cell.
                let border =
                    row.clone().zip(0..).find(|(value, _)| *value > 1.0 + limits::ROUNDING);
                rows.push(BorderRow {
                    response: name,
                    integrator: map.scheme.name(),
                    y: vertical.center(j),
                    stable_up_to: border.map(|(_, i)| horizontal.value(horizontal.edge(i))),
                    worst: row.fold(0.0, f64::max),
                });
            }
        }
    }
    rows
}

fn settings() -> Settings {
    let springs = format!(
        "two-sided, damping ratio {ZETA}; spectral radius of a step; dashed: a stack of {STACK} masses on equal springs"
    );
    let bounce = format!(
        "one-sided; speed after / before, worst of {PHASES} times of first touch within a step; line: limit of the two-sided spring"
    );
    let damped = "two-sided; spectral radius of a step";
    let accelerations =
        "copies of one contact that are added up, of first and second order; dashed: 4 / 3";
    let alterations = "copies of one contact that are added up; the integrator makes no difference; dashed: largest stable number";
    let reaction = "of velocity and acceleration, shot at a wall from the rim of the region, with gravity; deepest point over d_max: beyond 1 it crosses";
    vec![
        ("spring over k / m and h", springs),
        ("spring over ω h and ζ", damped.to_owned()),
        ("bounce over ω h and ζ", bounce),
        ("springs as accelerations", accelerations.to_owned()),
        ("altered before the move", alterations.to_owned()),
        ("reaction", reaction.to_owned()),
    ]
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    /// The maps of all responses, computed once for all tests.
    static MAPS: LazyLock<[Maps; RESPONSES.len()]> = LazyLock::new(|| compute().unwrap());

    /// Cells on either side of a line are on the right side of it; those that it passes through
    /// may be either.
    fn border_is_on_the_line(limit: Limit, map: &CellMap) {
        let half = 0.5 * map.axes[0].width();
        for [x, y, radius] in map.cells() {
            let place = map.axes[0].place(x);
            let limit = limit(map.scheme, y);
            let line = limit.map_or(f64::INFINITY, |x| map.axes[0].place(x));
            if (place - line).abs() > half {
                let is_stable = radius <= 1.0 + limits::ROUNDING;
                assert_eq!(is_stable, place < line, "{:?} at {x}, {y}: {radius}", map.scheme);
            }
        }
    }

    fn copies_are_stable_up_to_the_max(copies: &[Copies], map: &CellMap) {
        for ([gain, _, radius], copies) in map.cells().zip(copies.iter().flat_map(per_gain)) {
            let is_stable = radius <= 1.0 + limits::ROUNDING;
            if let Some(max) = copies.max {
                assert_eq!(is_stable, gain < max, "{}, {:?}: {gain}", copies.name, map.scheme);
            }
        }
    }

    fn per_gain(copies: &Copies) -> impl Iterator<Item = &Copies> {
        std::iter::repeat_n(copies, GAIN.cells as usize)
    }

    #[test]
    fn borders_are_on_the_known_lines() {
        let explicit = [Scheme::ExplicitEuler, Scheme::Taylor, Scheme::SymplecticEuler];
        for (response, maps) in RESPONSES.iter().zip(&*MAPS) {
            for map in maps {
                match response.drawing {
                    // A bounce is one-sided: it may gain within the limit.
                    Drawing::Cells { .. } if response.name.starts_with("bounce") => {}
                    Drawing::Cells { limit, .. } => border_is_on_the_line(limit, map),
                    // Implicit integrators have no limit for soft responses.
                    Drawing::Curves(copies)
                        if explicit.contains(&map.scheme) || copies.len() > 2 =>
                    {
                        copies_are_stable_up_to_the_max(copies, map);
                    }
                    Drawing::Curves(_) => {}
                }
            }
        }
    }

    #[test]
    fn the_same_numbers_every_time() {
        let again = compute().unwrap();
        assert_eq!(format!("{:?}", rows(&again)), format!("{:?}", rows(&*MAPS)));
    }
}
