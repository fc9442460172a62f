//! Stability of contact responses under each integrator, over stiffness and step.
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

use std::error::Error;
use std::path::{Path, PathBuf};

use response::ResponseError;
use response::stability::{HardRow, Holding, Scheme, StabilityCase};
use serde_json::{Value, json};

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

/// Known limit of stability: the horizontal value at a vertical one.
type Limit = fn(Scheme, f64) -> Option<f64>;

/// A response as maps, one per integrator.
struct MapRow {
    /// Name in the table.
    name: &'static str,
    title: &'static str,
    axes: [GridAxis; 2],
    value: fn(Scheme, f64, f64) -> Result<f64, ResponseError>,
    limit: Limit,
    /// Limit that is drawn dashed.
    other_limit: Option<Limit>,
}

const MAP_ROWS: [MapRow; 4] = [
    MapRow {
        name: "spring over k h",
        title: "contact spring, ζ = 0.1",
        axes: [STIFFNESS, STEP],
        value: |scheme, k, h| spring_radius(scheme, k.sqrt() * h, ZETA),
        limit: |scheme, h| Some((limits::spring(scheme, ZETA)? / h).powi(2)),
        other_limit: Some(|scheme, h| Some((limits::stack(scheme, ZETA, STACK)? / h).powi(2))),
    },
    MapRow {
        name: "spring over ωh ζ",
        title: "contact spring: growth per step",
        axes: [OMEGA_H, DAMPING],
        value: spring_radius,
        limit: limits::spring,
        other_limit: None,
    },
    MapRow {
        name: "bounce over ωh ζ",
        title: "bounce: speed after / before",
        axes: [OMEGA_H, DAMPING],
        value: |scheme, omega_h, zeta| bounce::max_restitution(scheme, omega_h, zeta, PHASES),
        limit: limits::spring,
        other_limit: None,
    },
    MapRow {
        name: "reaction over vh/d gh²/d",
        title: "reaction: deepest point / d_max",
        axes: [APPROACH, GRAVITY],
        value: reaction::max_depth,
        limit: limits::reaction,
        other_limit: None,
    },
];

fn spring_radius(scheme: Scheme, omega_h: f64, zeta: f64) -> Result<f64, ResponseError> {
    StabilityCase { scheme, holding: Holding::Penalty { omega_h, zeta } }.radius()
}

/// Responses whose copies are added up, drawn in one panel per integrator.
struct GainRow {
    /// Name in the table.
    name: &'static str,
    title: &'static str,
    responses: &'static [Copies],
}

/// A response whose copies are added up.
#[derive(Clone, Copy, Debug)]
struct Copies {
    name: &'static str,
    holding: fn(f64) -> Holding,
    /// Largest stable number under an explicit integrator; `None` without a limit.
    max: Option<f64>,
}

const GAIN_ROWS: [GainRow; 2] = [
    GainRow {
        name: "acceleration over copies order",
        title: "springs as accelerations: growth per step",
        responses: &ACCELERATIONS,
    },
    GainRow {
        name: "alteration over copies row",
        title: "altered before the move: growth per step",
        responses: &ALTERATIONS,
    },
];

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

/// All numbers of the picture.
#[derive(Clone, Debug)]
pub struct Stability {
    /// Spectral radius of a contact spring over k / m and h; the same over ω h and ζ; speed after
    /// a bounce over that before; largest depth against a reaction. One map per integrator.
    pub maps: Vec<Vec<CellMap>>,
    /// Spectral radius over gain, of accelerations and of alterations. One per integrator.
    pub gains: Vec<Vec<Gain>>,
}

/// Spectral radii of copies of responses under one integrator.
#[derive(Clone, Debug)]
pub struct Gain {
    /// The integrator.
    pub scheme: Scheme,
    /// Number of copies, with the spectral radius of each response.
    pub radii: Vec<(f64, Vec<f64>)>,
}

/// Draws the picture and writes its numbers.
///
/// # Errors
///
/// When a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let numbers = Stability::compute()?;
    let settings = settings();
    let svg = Some(draw::draw(&numbers, &settings)?);
    let columns = &["response", "integrator", "x", "y", "value"];
    Ok(Sheet { name: "stability", svg, settings, columns, rows: numbers.rows() }.write(folder)?)
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

impl Stability {
    /// Computes all maps and gains.
    ///
    /// # Errors
    ///
    /// Never for the parameters of this picture.
    pub fn compute() -> Result<Self, ResponseError> {
        let mut numbers = Self {
            maps: vec![Vec::new(); MAP_ROWS.len()],
            gains: vec![Vec::new(); GAIN_ROWS.len()],
        };
        for scheme in Scheme::ALL {
            for (row, maps) in MAP_ROWS.iter().zip(&mut numbers.maps) {
                maps.push(CellMap::new(scheme, row.axes, row.value)?);
            }
            for (row, gains) in GAIN_ROWS.iter().zip(&mut numbers.gains) {
                gains.push(Gain::new(scheme, row.responses)?);
            }
        }
        Ok(numbers)
    }

    /// Returns the rows of the table.
    fn rows(&self) -> Vec<Value> {
        // Maps cell by cell, then gains by the number of the response.
        let mut rows = Vec::new();
        for (MapRow { name, .. }, maps) in MAP_ROWS.iter().zip(&self.maps) {
            for map in maps {
                for [x, y, value] in map.cells() {
                    rows.push(json!([name, map.scheme.name(), x, y, value]));
                }
            }
        }
        for (GainRow { name, .. }, gains) in GAIN_ROWS.iter().zip(&self.gains) {
            for gain in gains {
                for (copies, radii) in &gain.radii {
                    for (number, radius) in (1..).zip(radii) {
                        rows.push(json!([name, gain.scheme.name(), copies, number, radius]));
                    }
                }
            }
        }
        rows
    }
}

impl Gain {
    fn new(scheme: Scheme, responses: &[Copies]) -> Result<Self, ResponseError> {
        let mut all = Vec::new();
        for cell in 0..GAIN.cells {
            let gain = GAIN.center(cell);
            let mut radii = Vec::new();
            for response in responses {
                let holding = (response.holding)(gain);
                radii.push(StabilityCase { scheme, holding }.radius()?);
            }
            all.push((gain, radii));
        }
        Ok(Self { scheme, radii: all })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells on either side of a line are on the right side of it; those that it passes through
    /// may be either.
    fn border_is_on_the_line(row: &MapRow, map: &CellMap) {
        let half = 0.5 * map.axes[0].width();
        for [x, y, radius] in map.cells() {
            let place = map.axes[0].place(x);
            let limit = (row.limit)(map.scheme, y);
            let line = limit.map_or(f64::INFINITY, |x| map.axes[0].place(x));
            if (place - line).abs() > half {
                let is_stable = radius <= 1.0 + limits::ROUNDING;
                assert_eq!(is_stable, place < line, "{:?} at {x}, {y}: {radius}", map.scheme);
            }
        }
    }

    #[test]
    fn borders_are_on_the_known_lines() {
        let numbers = Stability::compute().unwrap();
        for (row, maps) in MAP_ROWS.iter().zip(&numbers.maps) {
            // A bounce is one-sided: it may gain within the limit.
            if !row.name.starts_with("bounce") {
                maps.iter().for_each(|map| border_is_on_the_line(row, map));
            }
        }

        let explicit = [Scheme::ExplicitEuler, Scheme::Taylor, Scheme::SymplecticEuler];
        let [accelerations, alterations] = &numbers.gains[..] else { panic!("two rows") };
        for gain in accelerations.iter().filter(|gain| explicit.contains(&gain.scheme)) {
            copies_are_stable_up_to_the_max(gain, &ACCELERATIONS);
        }
        for gain in alterations {
            copies_are_stable_up_to_the_max(gain, &ALTERATIONS);
        }
    }

    fn copies_are_stable_up_to_the_max(gain: &Gain, responses: &[Copies]) {
        for (number, Copies { name, max, .. }) in responses.iter().enumerate() {
            let Some(max) = max else { continue };
            for (copies, radii) in &gain.radii {
                let is_stable = radii[number] <= 1.0 + limits::ROUNDING;
                assert_eq!(is_stable, copies < max, "{name}, {:?}: {copies}", gain.scheme);
            }
        }
    }

    #[test]
    fn the_same_numbers_every_time() {
        let rows = || Stability::compute().unwrap().rows();
        assert_eq!(format!("{:?}", rows()), format!("{:?}", rows()));
    }
}
