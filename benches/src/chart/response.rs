//! Overlap that is left over the time of a response: by hard contacts, by soft ones, and by overlap
//! removal.
//!
//! Hard and soft contacts answer the same thousand contacts of bodies that touch and approach each
//! other, in one step of unit length. Hard ones are solved with ever more iterations. Soft ones are
//! penalties in an implicit step, ever stiffer, whose linear system takes ever more iterations.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use fixtures::{data, thigh};
use glam::DVec3;
use musculo_collide::{BodyKind, Progress, Round, Scene, resolve};
use response::{
    ContactLaw, ContactRows, ContactSystem, ImplicitEuler, LinearParams, Margins, NormalForce,
    ResponseError, SoftContacts, SoftLaw, SolveLevel, SolverMethod, SolverParams, SweepOrder,
    TimeStep,
};
use serde::Serialize;

use super::axes::Axis;
use super::convergence::{Contacts, MASS_RATIOS, SIDE};
use super::curves::{
    CAPTION_LINE, Curve, CurveStyle, Panel, caption, draw_caption, machine, picture,
};
use super::palette;
use super::sheet::{Settings, Sheet};
use crate::gait::{resolve_params, thigh as real_thigh};
use crate::measure::interleave;

/// Iterations of hard contacts: powers of four up to 4,096.
const POWERS: u32 = 7;

/// Stiffness of soft contacts, in masses over the square of the step: powers of ten.
const STIFFNESSES: [i32; 6] = [0, 2, 4, 6, 8, 10];

/// Depth that each contact has at the start, which makes penalties act.
const ACTIVE: f64 = 1e-9;

/// Overlap \[share of that without a response\], and depth \[mm\], below which nothing is shown.
const LEAST_SHARE: f64 = 1e-12;
const LEAST_DEPTH: f64 = 1e-3;
const LEAST_CHANGE: f64 = 1e-4;

/// Residual at which hard contacts are solved.
const TOLERANCE: f64 = 1e-12;

/// Time in which each response is repeated \[ms\].
const BUDGET: u64 = 20;

const WIDTH: u32 = 1000;
const PANEL: u32 = 270;

/// Names and colors, of Okabe and Ito's palette.
const HARD: [(SolverMethod, &str, CurveStyle); 2] = [
    (SolverMethod::GaussSeidel, "Gauss–Seidel", CurveStyle::new(palette::BLUE)),
    (SolverMethod::ConjugateGradient, "conjugate gradients", CurveStyle::new(palette::BLACK)),
];
const SOFT: (&str, CurveStyle) = ("penalty", CurveStyle::new(palette::VERMILION));
const SCENES: [CurveStyle; 2] =
    [CurveStyle::new(palette::BLUE), CurveStyle::new(palette::VERMILION)];

/// State after a response: a row of the table.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    scene: String,
    #[serde(rename = "mass ratio")]
    mass_ratio: Option<f64>,
    response: &'static str,
    /// Iterations at most, stiffness, or rounds of overlap removal.
    amount: f64,
    #[serde(rename = "time [us]")]
    time: f64,
    /// Of contacts as a share of that without a response, of overlap removal the depth in mm.
    #[serde(rename = "overlap left [share, mm]")]
    left: f64,
    /// Largest of a soft body.
    #[serde(rename = "volume change [%]")]
    volume_change: Option<f64>,
}

/// Draws what is left over the time.
///
/// # Errors
///
/// When a scene cannot be set up, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut rows = Vec::new();
    for make in [Contacts::sheets, Contacts::stacks] {
        for mass_ratio in MASS_RATIOS {
            let contacts = make(SIDE, mass_ratio)?;
            for (method, name, _) in HARD {
                rows.extend(hard(&contacts, method, name)?);
            }
            rows.extend(soft(&contacts)?);
        }
    }
    rows.extend(removal("generated thigh", generated_thigh()?)?);
    if let Some(anatomy) = data::anatomy("overlap removal of a real thigh") {
        let scene = real_thigh(&anatomy.join("vhf_left_thigh_lo"))?;
        rows.extend(removal("thigh of the Visible Human", scene)?);
    }
    let sheet = Sheet::new("response", settings(), &rows)?;
    let svg = draw(&rows, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings() -> Settings {
    vec![
        ("contacts", "1,024 each, without friction, in one step: sheets pressed together, and stacks of 32 particles that fall on a floor; every third particle of sheets, or the topmost of stacks, is heavy at a mass ratio of 10,000".to_owned()),
        ("overlap", "greatest of all contacts after the step, as a share of that without a response; of hard contacts (Gauss–Seidel, conjugate gradients) after at most 1, 4, 16, … iterations, of soft ones by a penalty of 1, 100, … 1e10 masses over the step squared, in one implicit step, which also pulls where sides part".to_owned()),
        ("overlap removal", "by resolve, a mark per round: depth of the deepest vertex or edge, and largest change of a muscle's volume; what is less than shown is at the lower border".to_owned()),
        ("to take from it", "an implicit penalty takes the same time at any stiffness and leaves an overlap in inverse proportion to it, a thousand times more where masses are unlike; Gauss–Seidel is soonest on sheets, and hardly gets on in stacks of unlike masses, which conjugate gradients solve. Overlap removal takes most of the depth in its first rounds, and the last of it, where edges cross, in its last ones".to_owned()),
        ("machine", machine()),
    ]
}

/// Solves hard contacts with ever more iterations.
fn hard(
    contacts: &Contacts,
    method: SolverMethod,
    name: &'static str,
) -> Result<Vec<Measurement>, ResponseError> {
    let rows = contacts.touching()?;
    let solve = |max_iterations| -> Result<(Vec<DVec3>, bool), ResponseError> {
        let system = ContactSystem::new(&rows, &contacts.inverse_mass, SweepOrder::Colored)?;
        let (mut v, mut impulses) = (contacts.v.clone(), system.no_impulses());
        let params = SolverParams { method, max_iterations, tolerance: TOLERANCE };
        let report = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params)?;
        Ok((v, report.converged))
    };

    // Ever more iterations, until they suffice.
    let mut measured = Vec::new();
    for power in 0..POWERS {
        let count = 4_u32.pow(power);
        let (v, converged) = solve(count)?;
        let mut work = || solve(count).map_or(0, |(v, _)| v.len());
        measured.push(contacts.measurement(name, f64::from(count), &v, &rows, &mut work));
        if converged {
            break;
        }
    }
    Ok(measured)
}

/// Answers by ever stiffer penalties.
fn soft(contacts: &Contacts) -> Result<Vec<Measurement>, ResponseError> {
    let rows = contacts.touching()?;
    let step = TimeStep::<ImplicitEuler>::new(1.0)?;
    let push = |stiffness| -> Result<Vec<DVec3>, ResponseError> {
        let law = SoftLaw::new(NormalForce::Penalty { stiffness, damping: 0.0 }, 1.0)?;
        let soft = SoftContacts::new(&rows, &contacts.v, law)?;
        let mut force = vec![DVec3::ZERO; contacts.v.len()];
        soft.add_forces(&mut force)?;
        let params = LinearParams::default();

        // The step takes the changes of the penalties into account.
        let (accelerations, _) = step.implicit_accelerations(
            &contacts.inverse_mass,
            &force,
            &soft,
            &contacts.v,
            &params,
        )?;
        let (mut x, mut v) = (force, contacts.v.clone());
        accelerations.advance(&mut x, &mut v)?;
        Ok(v)
    };

    let mut measured = Vec::new();
    for power in STIFFNESSES {
        let stiffness = 10.0_f64.powi(power);
        let v = push(stiffness)?;
        let mut work = || push(stiffness).map_or(0, |v| v.len());
        measured.push(contacts.measurement(SOFT.0, stiffness, &v, &rows, &mut work));
    }
    Ok(measured)
}

impl Contacts {
    /// Returns rows of which each touches: penalties act from the start of the step.
    fn touching(&self) -> Result<ContactRows, ResponseError> {
        let mut rows = ContactRows::new(self.v.len());
        for contact in &self.contacts {
            let margins = Margins::new(contact.gap + ACTIVE, 1.0)?;
            rows.push(contact, ContactLaw::new(margins, 0.0)?)?;
        }
        Ok(rows)
    }

    /// Times a response, and compares the overlap that it leaves with that without it.
    fn measurement(
        &self,
        response: &'static str,
        amount: f64,
        v: &[DVec3],
        rows: &ContactRows,
        work: &mut dyn FnMut() -> usize,
    ) -> Measurement {
        let [time] = interleave(BUDGET, [("response", work)]);
        Measurement {
            scene: self.arrangement.to_owned(),
            mass_ratio: Some(self.mass_ratio),
            response,
            amount,
            time: 1e-3 * time,
            left: greatest_approach(rows, v) / greatest_approach(rows, &self.v),
            volume_change: None,
        }
    }
}

/// Returns the greatest way that two sides of a contact approach in the step.
fn greatest_approach(rows: &ContactRows, v: &[DVec3]) -> f64 {
    let mut greatest = 0.0_f64;
    for row in rows.iter() {
        let relative: DVec3 =
            row.terms.iter().map(|term| term.weight * v[term.particle as usize]).sum();
        greatest = greatest.max(relative.dot(row.normal));
    }
    greatest
}

/// Builds the scene of the generated thigh.
fn generated_thigh() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    for body in thigh::thigh().bodies {
        let kind = if body.kind == "rigid" { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(body.name, kind, body.mesh.surface(), body.mesh.positions)?;
    }
    Ok(scene)
}

/// Removes the overlaps of a scene; returns a row per round.
fn removal(name: &str, mut scene: Scene) -> Result<Vec<Measurement>, Box<dyn Error>> {
    let params = resolve_params(&mut scene)?;

    // The completed fraction is that of rounds: the first report of each has its time.
    let (start, reports) = (Instant::now(), Mutex::new(Vec::<[f64; 2]>::new()));
    let note = |fraction: f64| {
        if let Ok(mut reports) = reports.lock()
            && reports.last().is_none_or(|[last, _]| *last < fraction)
        {
            reports.push([fraction, 1e6 * start.elapsed().as_secs_f64()]);
        }
        ControlFlow::Continue(())
    };
    let rounds = resolve(&mut scene, &params, Progress::new(&note))?.rounds;
    let end = 1e6 * start.elapsed().as_secs_f64();

    let reports = reports.into_inner()?;
    let mut measured = Vec::new();
    for (number, round) in (0_u32..).zip(&rounds) {
        let share = (f64::from(number) + 1.0) / (f64::from(params.max_rounds) + 1.0);
        let after = reports.iter().find(|[fraction, _]| *fraction >= share - 1e-9);
        measured.push(Measurement {
            scene: name.to_owned(),
            mass_ratio: None,
            response: "overlap removal",
            amount: f64::from(number),
            time: after.map_or(end, |[_, time]| *time),
            left: depth(round),
            volume_change: Some(100.0 * round.volume_change),
        });
    }
    Ok(measured)
}

/// Returns the depth of the deepest vertex, edge or, where that was measured, surface.
fn depth(round: &Round) -> f64 {
    round.surface_depth.map_or(round.max_depth, |depth| depth.upper.max(round.max_depth))
}

fn draw(rows: &[Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let lines = caption(settings, WIDTH);
    let foot = CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "Overlap that is left over the time of a response";
    picture(heading, WIDTH, [3 * PANEL, foot], |body, foot| {
        // Contacts above, overlap removal below.
        let areas = body.split_evenly((3, 2));
        let mut panels = Vec::new();
        for scene in ["sheets", "stacks"] {
            for mass_ratio in MASS_RATIOS {
                panels.push(contact_panel(rows, scene, mass_ratio));
            }
        }
        panels.push(removal_panel(rows, "overlap removal: depth", "depth left [mm]", |row| {
            row.left.max(LEAST_DEPTH)
        }));
        panels.push(removal_panel(rows, "overlap removal: volume", "change [%]", |row| {
            row.volume_change.unwrap_or(0.0).max(LEAST_CHANGE)
        }));
        for (area, (panel, names)) in areas.iter().zip(&panels) {
            panel.draw_named(area, names)?;
        }
        draw_caption(foot, &lines, 5)
    })
}

/// Returns the curves of hard and soft contacts in a scene, with their names.
fn contact_panel(rows: &[Measurement], scene: &str, mass_ratio: f64) -> (Panel, Vec<String>) {
    let styles = HARD.map(|(_, name, style)| (name, style)).into_iter().chain([SOFT]);
    let (mut curves, mut names) = (Vec::new(), Vec::new());
    for (name, style) in styles {
        // Shares below the least are drawn at the border.
        let mut points = Vec::new();
        for row in rows {
            let is_of_scene = row.scene == scene && row.mass_ratio == Some(mass_ratio);
            if is_of_scene && row.response == name {
                points.push([row.time, row.left.max(LEAST_SHARE)]);
            }
        }
        curves.push(Curve { style, points });
        names.push(name.to_owned());
    }
    let panel = Panel {
        title: format!("{scene}, mass ratio {mass_ratio}"),
        x: Axis::powers("time [µs]", [1.0, 6.0]),
        y_label: "overlap left [share]".to_owned(),
        curves,
        has_front: false,
    };
    (panel, names)
}

/// Returns the curves of overlap removal, one per scene, with the names of the scenes.
fn removal_panel(
    rows: &[Measurement],
    title: &str,
    y_label: &str,
    value: fn(&Measurement) -> f64,
) -> (Panel, Vec<String>) {
    let mut names: Vec<String> = Vec::new();
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows.iter().filter(|row| row.volume_change.is_some()) {
        // Rows of a scene follow each other.
        if names.last() != Some(&row.scene) {
            curves.push(Curve { style: SCENES[names.len() % SCENES.len()], points: Vec::new() });
            names.push(row.scene.clone());
        }
        if let Some(curve) = curves.last_mut() {
            curve.points.push([1e-6 * row.time, value(row)]);
        }
    }
    let panel = Panel {
        title: title.to_owned(),
        x: Axis::powers("time [s]", [-2.0, 1.0]),
        y_label: y_label.to_owned(),
        curves,
        has_front: false,
    };
    (panel, names)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More iterations and more stiffness leave less; the floor holds a stack by half where the
    /// penalty is as stiff as a mass is heavy.
    #[test]
    fn less_is_left_by_more() {
        let contacts = Contacts::stacks(4, 1.0).unwrap();
        let hard = hard(&contacts, SolverMethod::GaussSeidel, "hard").unwrap();
        let soft = soft(&contacts).unwrap();
        for rows in [&hard, &soft] {
            assert!(rows.windows(2).all(|pair| pair[1].left < pair[0].left), "{rows:?}");
        }
        let [first, .., last] = &soft[..] else { panic!("no rows") };
        assert!(first.left > 0.1 && last.left < 1e-8 && hard[hard.len() - 1].left < 1e-8);
    }

    #[test]
    fn overlap_removal_ends_with_less() {
        let rows = removal("thigh", generated_thigh().unwrap()).unwrap();
        let [first, .., last] = &rows[..] else { panic!("no rounds") };
        assert!(first.left > 0.1 && last.left < 0.1 * first.left, "{rows:?}");
        assert!(rows.windows(2).all(|pair| pair[0].time <= pair[1].time), "{rows:?}");
    }
}
