//! Medial surfaces of generated muscles: time to generate one, certainty of its deviation, and
//! detection beside surfaces.

use std::error::Error;
use std::time::Instant;

use ::medial::{FootRule, MedialParams, generate};
use fixtures::Mesh;
use glam::DVec3;
use surface::progress::Progress;

use crate::bodies::{body, moved};
use crate::measure::Report;
use crate::medial_contact::{Balls, ContactScene, WorkLimits};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 400;

/// Reports generation and detection with a hundred balls.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    // Four times as many faces: the time is to grow with them.
    let [small, large] = [4, 5].map(belly);
    generation(&small, 1.0, report)?;
    let balls = generation(&large, 3.0, report)?;

    // The middles of both muscles overlap by 2 mm.
    let by = DVec3::new(11.0, 6.0, 23.0);
    let other = body(large);
    let first = moved(&other, by);

    // Balls against vertices and against balls, beside vertices projected on faces.
    let scene = ContactScene::new(&first, &other);
    let projection = scene.projection(BUDGET, report).counts;

    let work = scene.vertices_in_balls(&balls, FootRule::Exact, BUDGET, report);
    let limits = WorkLimits { bounds: 0.4, leaves: 1.0 / 13.0, time: 0.5 };
    work.report("vertices × balls", &projection, limits, report);
    let work = scene.balls_in_balls([&balls.moved(by), &balls], BUDGET, report);
    let limits = WorkLimits { bounds: 0.25, ..limits };
    work.report("balls × balls", &projection, limits, report);
    Ok(())
}

/// Returns a flat, bent muscle belly, 240 mm long.
fn belly(level: u32) -> Mesh {
    fixtures::shapes::ellipsoid(DVec3::new(120.0, 40.0, 12.0), level)
        .mapped(|p| p + DVec3::Z * (0.002 * p.x * p.x + 3.0 * (p.y / 20.0).sin()))
}

/// Generates a hundred balls within a time \[s\].
fn generation(mesh: &Mesh, seconds: f64, report: &mut Report) -> Result<Balls, Box<dyn Error>> {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions)?;
    let start = Instant::now();
    let generated = generate(&surface, x, &MedialParams::balls(100), Progress::none())?;
    let time = start.elapsed().as_secs_f64();

    let faces = mesh.faces.len();
    report.ratio(format!("100 balls of {faces} faces"), [time, seconds], "s", 1.0);
    // Bounds on the deviation are tight: the upper ones are close to the lower ones.
    let deviation = &generated.deviation;
    for (direction, hausdorff) in [
        ("surface to balls", deviation.surface_to_medial),
        ("balls to surface", deviation.medial_to_surface),
    ] {
        let name = format!("{faces} faces, {direction}, upper / lower bound");
        report.ratio(name, [hausdorff.upper, hausdorff.lower], "mm", 1.06);
    }
    Ok(Balls::new(generated.medial))
}
