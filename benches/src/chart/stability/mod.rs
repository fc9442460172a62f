//! Where each response and each integrator holds, over stiffness and step.
//!
//! A column an integrator, a row a response. The maps are found by taking
//! steps with the crate `response` itself; the lines on top of them are closed
//! forms ([`limits`]), so that a line off a border is a fault of one of both.
//! Mass, length and time are scaled out: only ω h and ζ matter to one spring.

pub mod bounce;
mod draw;
pub mod limits;
pub mod map;
pub mod reaction;

use std::error::Error;
use std::path::{Path, PathBuf};

use response::ResponseError;
use response::stability::{HardRow, Holding, Scheme, StabilityCase};

use self::map::{Axis, Map, Scale};
use super::sheet::{Cell, Sheet};

/// Damping ratio of the maps over stiffness and step.
const ZETA: f64 = 0.1;

/// Times of first touch within a step, of which the worst counts.
const PHASES: u32 = 16;

/// Masses of the stack whose limit is drawn beside that of one.
const STACK: u32 = 10;

const STIFFNESS: Axis =
    Axis { label: "k / m [1/s²]", scale: Scale::Logarithmic, low: 2.0, high: 8.0, cells: 30 };
const STEP: Axis =
    Axis { label: "step h [s]", scale: Scale::Logarithmic, low: -5.0, high: -1.0, cells: 20 };
const OMEGA_H: Axis =
    Axis { label: "ω h", scale: Scale::Logarithmic, low: -2.0, high: 1.0, cells: 30 };
const DAMPING: Axis =
    Axis { label: "damping ratio ζ", scale: Scale::Linear, low: 0.0, high: 2.5, cells: 20 };
const GAIN: Axis =
    Axis { label: "copies added up", scale: Scale::Linear, low: 0.0, high: 5.0, cells: 50 };
const APPROACH: Axis =
    Axis { label: "v h / d_max", scale: Scale::Linear, low: 0.0, high: 2.0, cells: 40 };
const GRAVITY: Axis =
    Axis { label: "g h² / d_max", scale: Scale::Linear, low: 0.0, high: 0.5, cells: 20 };

/// A response whose copies are added up.
#[derive(Clone, Copy, Debug)]
struct Copies {
    name: &'static str,
    holding: fn(f64) -> Holding,
    /// How many hold under an explicit integrator; `None` where as many as one likes, or none.
    most: Option<f64>,
}

impl Copies {
    const fn new(name: &'static str, holding: fn(f64) -> Holding, most: Option<f64>) -> Self {
        Self { name, holding, most }
    }
}

/// Springs as accelerations.
const ACCELERATIONS: [Copies; 2] = [
    Copies::new("first order", |gain| Holding::FirstOrder { gain }, None),
    Copies::new(
        "second order",
        |gain| Holding::SecondOrder { gain },
        Some(limits::SECOND_ORDER_GAIN),
    ),
];

/// Rows that alter positions and velocities, the same under every integrator.
const ALTERATIONS: [Copies; 4] = [
    Copies::new("spring ΔV", |gain| hard(HardRow::Spring, gain), Some(limits::SPRING_GAIN)),
    Copies::new(
        "spring ΔV that stops",
        |gain| hard(HardRow::SpringToTarget, gain),
        Some(limits::SECOND_ORDER_GAIN),
    ),
    Copies::new("reaction ΔV", |gain| hard(HardRow::Reaction, gain), Some(limits::STOPPING_GAIN)),
    Copies::new(
        "reference ΔP, ΔV",
        |gain| hard(HardRow::Reference, gain),
        Some(limits::STOPPING_GAIN),
    ),
];

const fn hard(row: HardRow, gain: f64) -> Holding {
    Holding::Hard { row, gain }
}

/// All numbers of the picture.
#[derive(Clone, Debug)]
pub struct Stability {
    /// Spectral radius of a contact spring, over k / m and h.
    pub springs: Vec<Map>,
    /// The same over ω h and ζ.
    pub damped_springs: Vec<Map>,
    /// Speed after a bounce over that before, over ω h and ζ.
    pub bounces: Vec<Map>,
    /// Spectral radius over gain, of first- and of second-order springs.
    pub gains: Vec<Gain>,
    /// The same of rows that alter positions and velocities.
    pub alterations: Vec<Gain>,
    /// Way into the proximity region over its width, against a reaction, over
    /// speed and gravity.
    pub reactions: Vec<Map>,
}

/// Copies of responses under one integrator.
#[derive(Clone, Debug)]
pub struct Gain {
    /// The integrator.
    pub scheme: Scheme,
    /// How many copies, with the spectral radius of each response.
    pub radii: Vec<(f64, Vec<f64>)>,
}

/// Draws the picture and writes the numbers behind it.
///
/// # Errors
///
/// When a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let numbers = Stability::compute()?;
    let settings = settings();
    let svg = draw::draw(&numbers, &settings)?;
    let (columns, rows) = numbers.table();
    Ok(Sheet { name: "stability", svg: Some(svg), settings, columns, rows }.write(folder)?)
}

fn settings() -> Vec<(&'static str, String)> {
    vec![
        (
            "spring over k / m and h",
            format!(
                "two-sided, damping ratio {ZETA}; spectral radius of a step; dashed: a stack of {STACK} masses on equal springs"
            ),
        ),
        ("spring over ω h and ζ", "two-sided; spectral radius of a step".to_owned()),
        (
            "bounce over ω h and ζ",
            format!(
                "one-sided; speed after / before, worst of {PHASES} times of first touch within a step; line: limit of the two-sided spring"
            ),
        ),
        (
            "springs as accelerations",
            "copies of one contact that are added up, of first and second order; dashed: 4 / 3"
                .to_owned(),
        ),
        (
            "altered before the move",
            "copies of one contact that are added up; the integrator makes no difference; dashed: as many as hold"
                .to_owned(),
        ),
        (
            "reaction",
            "of velocity and acceleration, shot at a wall from the rim of the region, gravity behind it; deepest point over d_max: beyond 1 it crosses"
                .to_owned(),
        ),
    ]
}

impl Stability {
    /// Takes all the steps.
    ///
    /// # Errors
    ///
    /// None for the parameters of this picture.
    pub fn compute() -> Result<Self, ResponseError> {
        let radius = |scheme, omega_h, zeta| {
            StabilityCase { scheme, holding: Holding::Penalty { omega_h, zeta } }.radius()
        };
        let mut numbers = Self {
            springs: Vec::new(),
            damped_springs: Vec::new(),
            bounces: Vec::new(),
            gains: Vec::new(),
            alterations: Vec::new(),
            reactions: Vec::new(),
        };
        for scheme in Scheme::ALL {
            numbers.springs.push(Map::new(scheme, [STIFFNESS, STEP], |k, h| {
                radius(scheme, k.sqrt() * h, ZETA)
            })?);
            numbers.damped_springs.push(Map::new(scheme, [OMEGA_H, DAMPING], |omega_h, zeta| {
                radius(scheme, omega_h, zeta)
            })?);
            numbers.bounces.push(Map::new(scheme, [OMEGA_H, DAMPING], |omega_h, zeta| {
                bounce::worst_restitution(scheme, omega_h, zeta, PHASES)
            })?);
            numbers.gains.push(Gain::new(scheme, &ACCELERATIONS)?);
            numbers.alterations.push(Gain::new(scheme, &ALTERATIONS)?);
            numbers.reactions.push(Map::new(scheme, [APPROACH, GRAVITY], |approach, gravity| {
                reaction::deepest(scheme, approach, gravity)
            })?);
        }
        Ok(numbers)
    }

    fn table(&self) -> (Vec<&'static str>, Vec<Vec<Cell>>) {
        let columns = vec!["response", "integrator", "x", "y", "value"];
        let maps = [
            ("spring over k h", &self.springs),
            ("spring over ωh ζ", &self.damped_springs),
            ("bounce over ωh ζ", &self.bounces),
            ("reaction over vh/d gh²/d", &self.reactions),
        ];
        let mut rows = Vec::new();
        let mut add = |response: &str, scheme: Scheme, values: [f64; 3]| {
            let names = [response, scheme.name()].map(Cell::text);
            rows.push(names.into_iter().chain(values.map(Cell::Number)).collect());
        };
        for (response, maps) in maps {
            for map in maps {
                map.cells().for_each(|[x, y, value]| add(response, map.scheme, [x, y, value]));
            }
        }
        let gains = [
            ("acceleration over copies order", &self.gains),
            ("alteration over copies row", &self.alterations),
        ];
        for (response, gains) in gains {
            for gain in gains {
                for (copies, radii) in &gain.radii {
                    for (number, &radius) in (1_u32..).zip(radii) {
                        add(response, gain.scheme, [*copies, f64::from(number), radius]);
                    }
                }
            }
        }
        (columns, rows)
    }
}

impl Gain {
    fn new(scheme: Scheme, responses: &[Copies]) -> Result<Self, ResponseError> {
        let at = |gain: f64| {
            let radii = responses.iter().map(|response| {
                StabilityCase { scheme, holding: (response.holding)(gain) }.radius()
            });
            Ok((gain, radii.collect::<Result<_, ResponseError>>()?))
        };
        let radii = (0..GAIN.cells).map(|cell| at(GAIN.value(GAIN.centre(cell))));
        Ok(Self { scheme, radii: radii.collect::<Result<_, ResponseError>>()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells on either side of a line are on the right side of it, and those
    /// that it passes through may be either.
    fn border_is_on_the_line(map: &Map, limit: impl Fn(f64, f64) -> Option<f64>) {
        let half = 0.5 * map.axes[0].width();
        for [x, y, radius] in map.cells() {
            let at = map.axes[0].place(x);
            let line = limit(x, y).map_or(f64::INFINITY, |x| map.axes[0].place(x));
            if (at - line).abs() > half {
                let holds = radius <= 1.0 + limits::ROUNDING;
                assert_eq!(holds, at < line, "{:?} at {x}, {y}: {radius}", map.scheme);
            }
        }
    }

    #[test]
    fn borders_are_on_the_known_lines() {
        let numbers = Stability::compute().unwrap();
        for map in &numbers.damped_springs {
            border_is_on_the_line(map, |_, zeta| limits::spring(map.scheme, zeta));
        }
        for map in &numbers.springs {
            let omega_h = limits::spring(map.scheme, ZETA);
            border_is_on_the_line(map, |_, h| omega_h.map(|limit| (limit / h).powi(2)));
        }
        for map in &numbers.reactions {
            let line = |gravity| limits::reaction(map.scheme, gravity).unwrap_or(0.0);
            border_is_on_the_line(map, |_, gravity| Some(line(gravity)));
        }
        let explicit = [Scheme::ExplicitEuler, Scheme::Taylor, Scheme::SymplecticEuler];
        let gains = || numbers.gains.iter().filter(|gain| explicit.contains(&gain.scheme));
        gains().for_each(|gain| copies_hold_up_to_the_most(gain, &ACCELERATIONS));
        for gain in &numbers.alterations {
            copies_hold_up_to_the_most(gain, &ALTERATIONS);
        }
    }

    fn copies_hold_up_to_the_most(gain: &Gain, responses: &[Copies]) {
        for (number, Copies { name, most, .. }) in responses.iter().enumerate() {
            let Some(most) = most else { continue };
            for (copies, radii) in &gain.radii {
                let holds = radii[number] <= 1.0 + limits::ROUNDING;
                assert_eq!(holds, copies < most, "{name}, {:?}: {copies}", gain.scheme);
            }
        }
    }

    #[test]
    fn the_same_numbers_every_time() {
        let of = |numbers: Stability| format!("{:?}", numbers.table());
        assert_eq!(of(Stability::compute().unwrap()), of(Stability::compute().unwrap()));
    }
}
