//! Residual of coupled contacts over the time of a solution, by method, start and masses.
//!
//! A thousand contacts that share particles, without friction, which all three methods solve: of two
//! sheets pressed together, where each contact has few neighbors, and of stacks, where a push at the
//! top has to reach the floor. A solution is cut off after 1, 4, 16, … iterations, and timed to there.

use std::error::Error;
use std::path::{Path, PathBuf};

use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ContactSystem, Impulse, Margins, ResponseError, SolveLevel,
    SolverMethod, SolverParams, SweepOrder,
};
use serde::Serialize;
use surface::{Contact, ContactSide, Term};

use super::axes::Axis;
use super::curves::{
    CAPTION_LINE, Curve, CurveStyle, Panel, caption, draw_caption, machine, picture,
};
use super::palette;
use super::sheet::{Settings, Sheet};
use crate::measure::interleave;
use crate::sheets::Sheets;

/// Vertices along a side of the sheets, number of stacks, and particles in each: 1,024 contacts.
pub(super) const SIDE: u32 = 32;

/// Greatest mass over the least.
pub(super) const MASS_RATIOS: [f64; 2] = [1.0, 1e4];

/// Powers of four up to which iterations go: 16,384.
const POWERS: u32 = 8;

/// Residual at which a solution ends.
const TOLERANCE: f64 = 1e-12;

/// Time in which each cut-off solution is repeated \[ms\].
const BUDGET: u64 = 20;

const WIDTH: u32 = 1000;
const PANEL: u32 = 300;

/// Methods with their names and colors.
const METHODS: [(SolverMethod, &str, CurveStyle); 3] = [
    (SolverMethod::GaussSeidel, "Gauss–Seidel", CurveStyle::new(palette::BLUE)),
    (SolverMethod::AveragedJacobi, "averaged Jacobi", CurveStyle::new(palette::VERMILION)),
    (SolverMethod::ConjugateGradient, "conjugate gradients", CurveStyle::new(0)),
];

/// Impulses to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// None.
    Cold,
    /// Those of the step before, in which all velocities were 1 % less.
    Warm,
}

const STARTS: [(Start, &str); 2] = [(Start::Cold, "cold"), (Start::Warm, "warm")];

/// A solution that was cut off: a row of the table.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    #[serde(rename = "contacts of")]
    arrangement: &'static str,
    #[serde(rename = "mass ratio")]
    mass_ratio: f64,
    start: &'static str,
    method: &'static str,
    iterations: u32,
    #[serde(rename = "time [us]")]
    time: f64,
    /// Greatest violation of equality, complementarity and cone, of relative velocities of about 1.
    residual: f64,
}

/// Draws the residuals over the times.
///
/// # Errors
///
/// When a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut rows = Vec::new();
    for make in [Contacts::sheets, Contacts::stacks] {
        for mass_ratio in MASS_RATIOS {
            let contacts = make(SIDE, mass_ratio)?;
            for (start, _) in STARTS {
                for (method, ..) in METHODS {
                    rows.extend(contacts.measure(start, method)?);
                }
            }
        }
    }
    let sheet = Sheet::new("convergence", settings(), &rows)?;
    let svg = draw(&rows, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings() -> Settings {
    vec![
        ("contacts", "1,024 each, one-sided, without friction: vertices of a sheet on the faces of another, with every third particle heavy at a mass ratio of 10,000; 32 stacks of 32 particles, the topmost heavy".to_owned()),
        ("residual", "greatest violation of equality and complementarity, of relative velocities of 1 to 2".to_owned()),
        ("time", "of a solution that is cut off after 1, 4, 16, … iterations, preparation included where the method needs one; the least of several".to_owned()),
        ("warm", "from the impulses of a step with velocities that were 1 % less; hollow".to_owned()),
        ("to take from it", "sheets are solved soonest by Gauss–Seidel, whatever the masses; stacks by conjugate gradients, whose factors are exact there".to_owned()),
        ("machine", machine()),
    ]
}

/// Coupled contacts, and the impulses of the step before.
pub(super) struct Contacts {
    pub(super) arrangement: &'static str,
    pub(super) mass_ratio: f64,
    pub(super) contacts: Vec<Contact>,
    pub(super) inverse_mass: Vec<f64>,
    pub(super) v: Vec<DVec3>,
    system: ContactSystem,
    impulses: Vec<Impulse>,
}

impl Contacts {
    /// Presses two sheets together, of which every third particle is heavy.
    pub(super) fn sheets(side: u32, mass_ratio: f64) -> Result<Self, Box<dyn Error>> {
        let mut sheets = Sheets::new(side)?;
        for w in sheets.inverse_mass.iter_mut().step_by(3) {
            *w = mass_ratio.recip();
        }
        Self::new("sheets", mass_ratio, sheets.contacts, sheets.v, sheets.inverse_mass)
    }

    /// Lets stacks fall on a floor, each with a heavy particle on top.
    pub(super) fn stacks(side: u32, mass_ratio: f64) -> Result<Self, Box<dyn Error>> {
        let (mut contacts, mut v, mut inverse_mass) = (Vec::new(), Vec::new(), Vec::new());
        for particle in 0..side * side {
            let (stack, place) = (particle / side, particle % side);
            let above = [Term { particle, weight: 1.0 }];
            let below = [Term { particle: particle.saturating_sub(1), weight: 1.0 }];
            let on = match place {
                0 => ContactSide::at_rest(DVec3::ZERO),
                _ => ContactSide::Particles(&below),
            };
            contacts.push(Contact::between(ContactSide::Particles(&above), on, DVec3::Z, 0.0));

            // Stacks fall at different speeds.
            v.push(DVec3::Z * (-1.0 - f64::from(stack) / f64::from(side)));
            inverse_mass.push(if place == side - 1 { mass_ratio.recip() } else { 1.0 });
        }
        Self::new("stacks", mass_ratio, contacts, v, inverse_mass)
    }

    fn new(
        arrangement: &'static str,
        mass_ratio: f64,
        contacts: Vec<Contact>,
        v: Vec<DVec3>,
        inverse_mass: Vec<f64>,
    ) -> Result<Self, Box<dyn Error>> {
        let mut rows = ContactRows::new(v.len());
        rows.extend(&contacts, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?)?;
        let system = ContactSystem::new(&rows, &inverse_mass, SweepOrder::Colored)?;

        // The step before, to the end.
        let mut before: Vec<DVec3> = v.iter().map(|v| *v / 1.01).collect();
        let mut impulses = system.no_impulses();
        let params = SolverParams {
            method: SolverMethod::ConjugateGradient,
            max_iterations: 1000,
            tolerance: TOLERANCE,
        };
        system.solve(SolveLevel::Velocity, &mut before, &mut impulses, &params)?;
        Ok(Self { arrangement, mass_ratio, contacts, inverse_mass, v, system, impulses })
    }

    /// Solves with ever more iterations, until the residual is reached.
    fn measure(
        &self,
        start: Start,
        method: SolverMethod,
    ) -> Result<Vec<Measurement>, ResponseError> {
        let mut rows = Vec::new();
        for power in 0..POWERS {
            let params =
                SolverParams { method, max_iterations: 4_u32.pow(power), tolerance: TOLERANCE };
            // Once for the residual, then again for the time.
            let (iterations, residual) = self.solve(start, &params)?;
            let mut work = || self.solve(start, &params).map_or(0, |(count, _)| count as usize);
            let [time] = interleave(BUDGET, [("solve", &mut work)]);
            rows.push(Measurement {
                arrangement: self.arrangement,
                mass_ratio: self.mass_ratio,
                start: name_of(&STARTS, start),
                method: METHODS.iter().find(|known| known.0 == method).map_or("", |known| known.1),
                iterations,
                time: 1e-3 * time,
                residual,
            });
            if residual <= TOLERANCE {
                break;
            }
        }
        Ok(rows)
    }

    /// Solves once; returns the number of iterations and the residual.
    fn solve(&self, start: Start, params: &SolverParams) -> Result<(u32, f64), ResponseError> {
        let mut v = self.v.clone();
        let mut impulses = match start {
            Start::Cold => self.system.no_impulses(),
            Start::Warm => self.impulses.clone(),
        };
        let report = self.system.solve(SolveLevel::Velocity, &mut v, &mut impulses, params)?;
        Ok((report.iterations, report.conditions.max()))
    }
}

fn name_of(names: &[(Start, &'static str)], start: Start) -> &'static str {
    names.iter().find(|(known, _)| *known == start).map_or("", |(_, name)| name)
}

fn draw(rows: &[Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings, WIDTH);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "A thousand coupled contacts: residual over time";
    picture(heading, WIDTH, [2 * PANEL, foot], |body, foot| {
        let areas = body.split_evenly((2, MASS_RATIOS.len()));
        let mut places = areas.iter();
        for arrangement in ["sheets", "stacks"] {
            for mass_ratio in MASS_RATIOS {
                let mut chosen = Vec::new();
                for row in rows {
                    let is_of_ratio = row.mass_ratio.total_cmp(&mass_ratio).is_eq();
                    if is_of_ratio && row.arrangement == arrangement {
                        chosen.push(row);
                    }
                }
                if let Some(area) = places.next() {
                    let title = format!("{arrangement}, mass ratio {mass_ratio}");
                    let (panel, names) = panel(&title, &chosen);
                    panel.draw_named(area, &names)?;
                }
            }
        }
        draw_caption(foot, &lines, 5)
    })
}

/// Returns a panel, and the names of its curves: those from cold starts have one.
fn panel(title: &str, rows: &[&Measurement]) -> (Panel, Vec<String>) {
    let (mut curves, mut names) = (Vec::new(), Vec::new());
    for (_, name, style) in METHODS {
        for ((_, start), style) in STARTS.into_iter().zip([style, style.hollow()]) {
            let mut curve = Curve { style, points: Vec::new() };
            for row in rows.iter().filter(|row| row.method == name && row.start == start) {
                // Exact zeros are drawn where the solution ends.
                curve.points.push([row.time, row.residual.max(TOLERANCE)]);
            }
            curves.push(curve);
            names.push(if style.is_hollow { String::new() } else { name.to_owned() });
        }
    }
    let panel = Panel {
        title: title.to_owned(),
        x: Axis::powers("time [µs]", [1.0, 6.0]),
        y_label: "residual".to_owned(),
        curves,
        has_front: false,
    };
    (panel, names)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More iterations leave less, and a warm start begins with less.
    #[test]
    fn residuals_fall() {
        let contacts = Contacts::stacks(8, 1e4).unwrap();
        for (method, name, _) in METHODS {
            let params =
                |max_iterations| SolverParams { method, max_iterations, tolerance: TOLERANCE };
            let residual = |start, count| contacts.solve(start, &params(count)).unwrap().1;
            let [few, many] = [1, 64].map(|count| residual(Start::Cold, count));
            assert!(many < few, "{name}: {many} after {few}");
            assert!(residual(Start::Warm, 1) < few, "{name}");
        }
    }
}
