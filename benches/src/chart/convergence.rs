//! Residual of coupled contacts over the time of a solution, by method, start and masses.
//!
//! Two sheets pressed together: a thousand contacts that share particles, without friction, which
//! all three methods solve. A solution is cut off after 1, 2, 4, … iterations, and timed to there.

use std::error::Error;
use std::path::{Path, PathBuf};

use glam::DVec3;
use plotters::prelude::{IntoFont, IntoTextStyle};
use response::{
    ContactLaw, ContactRows, ContactSystem, Impulse, Margins, ResponseError, SolveLevel,
    SolverMethod, SolverParams, SweepOrder,
};
use serde::Serialize;

use super::curves::{
    Area, Axis, CAPTION_LINE, Curve, CurveStyle, Drawn, Panel, caption, draw_caption, machine,
    picture,
};
use super::sheet::{Settings, Sheet};
use crate::measure::interleave;
use crate::sheets::Sheets;

/// Vertices along a side of the sheets: about 1,000 contacts.
const SIDE: u32 = 32;

/// Greatest mass over the least.
const MASS_RATIOS: [f64; 2] = [1.0, 1e4];

/// Doublings of the number of iterations: up to 16,384.
const DOUBLINGS: u32 = 15;

/// Residual at which a solution ends.
const TOLERANCE: f64 = 1e-12;

/// Time in which each cut-off solution is repeated \[ms\].
const BUDGET: u64 = 20;

const WIDTH: u32 = 1500;
const PANEL: u32 = 330;
const LEGEND: u32 = 30;

/// Methods with their names and colors.
const METHODS: [(SolverMethod, &str, CurveStyle); 3] = [
    (SolverMethod::GaussSeidel, "Gauss–Seidel", CurveStyle::new(0x1f_6f_b4)),
    (SolverMethod::AveragedJacobi, "averaged Jacobi", CurveStyle::new(0xe0_7b_00)),
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
    for mass_ratio in MASS_RATIOS {
        let pressed = Pressed::new(SIDE, mass_ratio)?;
        for (start, _) in STARTS {
            for (method, ..) in METHODS {
                rows.extend(pressed.measure(start, method)?);
            }
        }
    }
    let sheet = Sheet::new("convergence", settings(), &rows)?;
    let svg = draw(&rows, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings() -> Settings {
    vec![
        ("contacts", "1,024 vertices of a sheet on the faces of another, one-sided, without friction; at a mass ratio of 1e4 every third particle is heavy".to_owned()),
        ("residual", "greatest violation of equality and complementarity, of relative velocities of about 1".to_owned()),
        ("time", "of a solution that is cut off after 1, 2, 4, … iterations, preparation included where the method needs one; the least of several".to_owned()),
        ("warm", "from the impulses of a step with velocities that were 1 % less".to_owned()),
        ("to take from it", "with equal masses all methods do; with unlike ones conjugate gradients take a few iterations, where the others take thousands".to_owned()),
        ("machine", machine()),
    ]
}

/// Sheets pressed together, and the impulses of the step before.
struct Pressed {
    sheets: Sheets,
    mass_ratio: f64,
    system: ContactSystem,
    impulses: Vec<Impulse>,
}

impl Pressed {
    fn new(side: u32, mass_ratio: f64) -> Result<Self, Box<dyn Error>> {
        let mut sheets = Sheets::new(side)?;
        for w in sheets.inverse_mass.iter_mut().step_by(3) {
            *w = mass_ratio.recip();
        }
        let mut rows = ContactRows::new(sheets.x.len());
        rows.extend(&sheets.contacts, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?)?;
        let system = ContactSystem::new(&rows, &sheets.inverse_mass, SweepOrder::Colored)?;

        // The step before, to the end.
        let mut v: Vec<DVec3> = sheets.v.iter().map(|v| *v / 1.01).collect();
        let mut impulses = system.no_impulses();
        let params = SolverParams {
            method: SolverMethod::ConjugateGradient,
            max_iterations: 1000,
            tolerance: TOLERANCE,
        };
        system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params)?;
        Ok(Self { sheets, mass_ratio, system, impulses })
    }

    /// Solves with ever more iterations, until the residual is reached.
    fn measure(
        &self,
        start: Start,
        method: SolverMethod,
    ) -> Result<Vec<Measurement>, ResponseError> {
        let mut rows = Vec::new();
        for doubling in 0..DOUBLINGS {
            let params =
                SolverParams { method, max_iterations: 1 << doubling, tolerance: TOLERANCE };
            let (iterations, residual) = self.solve(start, &params)?;
            let mut work = || self.solve(start, &params).map_or(0, |(count, _)| count as usize);
            let [time] = interleave(BUDGET, [("solve", &mut work)]);
            rows.push(Measurement {
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
        let mut v = self.sheets.v.clone();
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
    let lines = caption(settings);
    let foot = LEGEND + CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "A thousand coupled contacts: residual over time";
    picture(heading, WIDTH, [2 * PANEL, foot], |body, foot| {
        let areas = body.split_evenly((MASS_RATIOS.len(), STARTS.len()));
        let mut places = areas.iter();
        for mass_ratio in MASS_RATIOS {
            for (_, start) in STARTS {
                let of_panel = |row: &&Measurement| {
                    row.start == start && row.mass_ratio.total_cmp(&mass_ratio).is_eq()
                };
                let chosen: Vec<&Measurement> = rows.iter().filter(of_panel).collect();
                if let Some(area) = places.next() {
                    panel(&format!("mass ratio {mass_ratio:e}, {start} start"), &chosen)
                        .draw(area)?;
                }
            }
        }
        legend(foot)?;
        draw_caption(foot, &lines, LEGEND + 5)
    })
}

fn panel(title: &str, rows: &[&Measurement]) -> Panel {
    let mut curves = Vec::new();
    for (_, name, style) in METHODS {
        let mut curve = Curve { style, points: Vec::new() };
        for row in rows.iter().filter(|row| row.method == name) {
            // Exact zeros are drawn where the solution ends.
            curve.points.push([row.time, row.residual.max(TOLERANCE)]);
        }
        curves.push(curve);
    }
    Panel {
        title: title.to_owned(),
        x: Axis::powers("time [µs]", [1.0, 6.0]),
        y_label: "residual".to_owned(),
        curves,
        has_front: false,
    }
}

fn legend(area: &Area<'_>) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    for (number, (_, name, style)) in (0..).zip(METHODS) {
        let left = 60 + 260 * number;
        style.sample(area, [left, 15])?;
        area.draw_text(name, &text, (left + 40, 7))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More iterations leave less, and a warm start begins with less.
    #[test]
    fn residuals_fall() {
        let pressed = Pressed::new(8, 1e4).unwrap();
        for (method, name, _) in METHODS {
            let params =
                |max_iterations| SolverParams { method, max_iterations, tolerance: TOLERANCE };
            let residual = |start, count| pressed.solve(start, &params(count)).unwrap().1;
            let [few, many] = [1, 64].map(|count| residual(Start::Cold, count));
            assert!(many < few, "{name}: {many} after {few}");
            assert!(residual(Start::Warm, 1) < few, "{name}");
        }
    }
}
