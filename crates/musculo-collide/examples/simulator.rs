//! A simulator of one's own, with its collision step given to this crate.
//!
//! ```text
//! cargo run --release -p musculo-collide --example simulator
//! ```
//!
//! The simulator knows two muscles as masses on springs. What it had to do for
//! collision: add its surfaces to a [`Scene`] once, and in each step hand over its states between
//! velocities and positions.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::ops::Range;

use fixtures::thigh::thigh;
use musculo_collide::distance_field::Pose;
use musculo_collide::glam::{DQuat, DVec3};
use musculo_collide::scene::{DetectorParams, StepDetectors};
use musculo_collide::{
    BodyKind, CheckParams, Friction, Margins, Material, ParticleLoads, Progress, RigidMotion,
    Scene, SceneStates, SceneStep, StepLength, StepParams,
};

/// Depth of an overlap that may go undetected, and the gap up to which contacts are detected \[mm\].
const TOLERANCE: f64 = 0.2;
const MARGIN: f64 = 0.5;

/// Steps, and their length \[s\].
const STEPS: u32 = 100;
const STEP: f64 = 0.005;

/// Muscles as the simulator has them: equal masses, on springs along the edges of their surfaces
/// and to where they were at rest.
struct Muscles {
    particles: Range<usize>,
    rest: Vec<DVec3>,
    edges: Vec<[usize; 2]>,
}

impl Muscles {
    /// Stiffness over mass of springs along edges and to the place at rest
    /// \[1/s²\], and damping over mass \[1/s\].
    const ALONG: f64 = 2000.0;
    const TO_REST: f64 = 200.0;
    const DAMPING: f64 = 10.0;

    /// Takes over all soft bodies, which follow the bone in the scene.
    fn new(scene: &Scene) -> Self {
        let rest = scene.particle_positions();
        let mut edges = Vec::new();
        for body in scene.bodies().iter().filter(|body| !body.is_rigid()) {
            let first = body.particles().start;
            let own = body.surface().edges().iter();
            edges.extend(own.map(|edge| edge.map(|vertex| (first + vertex) as usize)));
        }
        Self { particles: scene.bodies()[0].positions().len()..rest.len(), rest, edges }
    }

    /// Adds what forces do to velocities in a step.
    fn accelerate(&self, x: &[DVec3], v: &mut [DVec3]) {
        for k in self.particles.clone() {
            v[k] += STEP * (Self::TO_REST * (self.rest[k] - x[k]) - Self::DAMPING * v[k]);
        }
        for &[i, j] in &self.edges {
            let along = x[j] - x[i];
            let longer = along.length() - self.rest[j].distance(self.rest[i]);
            let pull = STEP * Self::ALONG * longer * along.normalize_or_zero();
            v[i] += pull;
            v[j] -= pull;
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // Once: surfaces into a scene. Yours come from your own meshes.
    let mut scene = Scene::new();
    let source = thigh();
    for name in ["femur", "vastus_lateralis", "rectus_femoris"] {
        let mesh = &source.body(name).mesh;
        let kind = if name == "femur" { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(name, kind, mesh.surface(), mesh.positions.clone())?;
    }
    let femur = scene.find("femur").ok_or("it was added")?;
    let muscles = Muscles::new(&scene);
    let mut x = scene.particle_positions();
    let (mut v, inverse_mass) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);

    // Once: what contacts are made of, and how they are detected.
    let friction = Friction::coulomb(0.1)?;
    let material = Material { friction, ..Material::hard(Margins::new(0.0, MARGIN)?) };
    let mut collision = SceneStep::new(material);
    let mut detectors =
        StepDetectors::new(DetectorParams { margin: MARGIN, tolerance: TOLERANCE })?;
    let params = StepParams::new(StepLength::new(STEP)?);

    println!("step  contacts  deepest before  exact after [mm]  work of the bone [g mm²/s²]");
    for step in 0..=STEPS {
        // The simulator's own part: the bone goes to the muscles and back, forces act.
        let rate = std::f64::consts::TAU / (STEP * f64::from(STEPS));
        let (sin, cos) = (rate * STEP * f64::from(step)).sin_cos();
        let way = DVec3::new(2.0, 2.0, 0.0);
        let motion = RigidMotion { velocity: way * rate * cos, ..RigidMotion::default() };
        collision.move_bone(&mut scene, femur, &Pose::new(DQuat::IDENTITY, way * sin), motion)?;
        muscles.accelerate(&x, &mut v);

        // The collision step, in place of one's own, before the move.
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
        let report = collision.correct(&mut scene, states, &params, |scene, contacts| {
            detectors.detect(scene, contacts)
        })?;

        if step % 10 == 0 {
            let (contacts, before, work) =
                (report.contacts, report.depth_before, report.rigid_work);
            let after = exact_depth(&mut scene)?;
            println!("{step:>4}{contacts:>10}{before:>16.2}{after:>18.2}{work:>29.0}");
        }
        for k in muscles.particles.clone() {
            x[k] += STEP * v[k];
        }
    }
    Ok(())
}

/// Computes the overlap that is left, exactly; no simulator needs this in every step.
fn exact_depth(scene: &mut Scene) -> Result<f64, Box<dyn Error>> {
    let reports = scene.check(&CheckParams::new(0.0), Progress::none())?;
    Ok(reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max))
}
