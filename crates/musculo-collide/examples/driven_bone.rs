//! Drives a bone into a muscle and out again, and draws the energy over time to an SVG picture on
//! standard output.
//!
//! ```text
//! cargo run --release -p musculo-collide --example driven_bone > energy.svg
//! ```
//!
//! The work that the bone gives becomes motion and tension of the muscle, and returns as the bone
//! does. What the muscle has never exceeds the work: contact and damping only take energy away.
#![expect(clippy::print_stdout, reason = "a program that writes a picture")]

use std::error::Error;
use std::ops::Range;

use fixtures::shapes::{capsule, ellipsoid};
use musculo_collide::glam::{DQuat, DVec3};
use musculo_collide::scene::{DetectorParams, StepDetectors};
use musculo_collide::surface::Pose;
use musculo_collide::{
    BodyId, BodyKind, Margins, Material, ParticleLoads, RigidMotion, Scene, SceneStates, SceneStep,
    StepLength, StepParams,
};

/// Steps, and their length \[s\].
const STEPS: u32 = 400;
const H: f64 = 1e-3;

/// Depth to which the bone is driven \[mm\], in the first 300 steps, with the way back.
const WAY: f64 = 5.0;
const DRIVEN: f64 = 0.3;

/// Gap up to which contacts are detected \[mm\].
const MARGIN: f64 = 0.5;

/// Stiffness over mass of springs to the place at rest \[1/s²\], and damping over mass \[1/s\].
const STIFFNESS: f64 = 2e5;
const DAMPING: f64 = 100.0;

/// Energies at a time \[mJ\], for particles of 1 g.
struct Moment {
    time: f64,
    kinetic: f64,
    elastic: f64,
    work: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    // A muscle on springs to its place, and a finger of bone above it.
    let mut scene = Scene::new();
    let finger = capsule(4.0, 20.0, 16).translated(DVec3::new(0.4, 0.3, 23.0));
    let muscle = ellipsoid(DVec3::new(16.0, 11.0, 8.0), 3);
    let bone = scene.add("bone", BodyKind::Rigid, finger.surface(), finger.positions)?;
    scene.add("muscle", BodyKind::Deformable, muscle.surface(), muscle.positions)?;
    let particles = scene.body(bone).positions().len()..scene.particle_positions().len();

    // Contacts by surfaces, hard and without friction.
    let mut step = SceneStep::new(Material::hard(Margins::new(0.0, MARGIN)?));
    let mut detectors = StepDetectors::new(DetectorParams { margin: MARGIN, tolerance: 0.1 })?;
    let moments = simulate(&mut scene, bone, particles, &mut step, &mut detectors)?;
    draw(&moments);
    Ok(())
}

/// Returns the way of the bone after a time: in, out, and rest.
fn way(time: f64) -> DVec3 {
    let turn = std::f64::consts::TAU * (time / DRIVEN).min(1.0);
    DVec3::Z * (-0.5 * WAY * (1.0 - turn.cos()))
}

fn simulate(
    scene: &mut Scene,
    bone: BodyId,
    particles: Range<usize>,
    step: &mut SceneStep,
    detectors: &mut StepDetectors,
) -> Result<Vec<Moment>, Box<dyn Error>> {
    let rest = scene.particle_positions();
    let (mut x, mut v) = (rest.clone(), vec![DVec3::ZERO; rest.len()]);
    let inverse_mass = vec![1.0; rest.len()];
    let params = StepParams::new(StepLength::new(H)?);
    let (mut moments, mut work) = (Vec::new(), 0.0);
    for number in 0..STEPS {
        // The bone moves; springs and dampers act.
        let time = H * f64::from(number);
        let velocity = (way(time + H) - way(time)) / H;
        let motion = RigidMotion { velocity, ..RigidMotion::default() };
        step.move_bone(scene, bone, &Pose::new(DQuat::IDENTITY, way(time)), motion)?;
        let (mut kinetic, mut elastic) = (0.0, 0.0);
        for k in particles.clone() {
            kinetic += 0.5e-6 * v[k].length_squared();
            elastic += 0.5e-6 * STIFFNESS * x[k].distance_squared(rest[k]);
            v[k] = v[k] / (1.0 + H * DAMPING) + H * STIFFNESS * (rest[k] - x[k]);
        }
        moments.push(Moment { time, kinetic, elastic, work });

        // Contacts are answered before the move.
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
        let report = step
            .correct(scene, states, &params, |scene, contacts| detectors.detect(scene, contacts))?;
        work += 1e-6 * report.rigid_work;
        for k in particles.clone() {
            x[k] += H * v[k];
        }
    }
    Ok(moments)
}

/// Prints the picture.
fn draw(moments: &[Moment]) {
    let highest = moments.iter().map(|at| at.work.max(at.kinetic + at.elastic)).fold(0.0, f64::max);
    let scale = 300.0 / highest.max(f64::MIN_POSITIVE);
    println!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 760 400" font-family="sans-serif" font-size="14">
<rect width="100%" height="100%" fill="#ffffff"/>
<text x="60" y="24" font-size="16">A bone driven into a muscle and out again: energy over time</text>
<path d="M60 40 V350 H700" fill="none" stroke="#333333"/>
<text x="64" y="54" fill="#333333">{highest:.2} mJ</text>
<text x="640" y="370" fill="#333333">{:.1} s</text>"##,
        H * f64::from(STEPS)
    );
    let curves = [
        ("work of the bone", "#333333"),
        ("motion and tension of the muscle", "#1f5f8b"),
        ("motion alone", "#d98a1f"),
    ];
    for (row, (name, color)) in curves.into_iter().enumerate() {
        let mut points = String::new();
        for at in moments {
            let energy = [at.work, at.kinetic + at.elastic, at.kinetic][row];
            let x = 60.0 + 600.0 * at.time / (H * f64::from(STEPS));
            points += &format!("{x:.1},{:.1} ", 350.0 - scale * energy);
        }
        println!(r#"<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2"/>"#);
        println!(r#"<text x="440" y="{}" fill="{color}">{name}</text>"#, 70 + 20 * row);
    }
    println!("</svg>");
}
