//! A simulator of one's own, with its collision step given to this crate.
//!
//! ```text
//! cargo run --release -p musculo-collide --example simulator
//! ```
//!
//! The simulator knows two muscles as masses on springs. What it had to do for
//! collision: add its surfaces to a [`Scene`] once, make a [`Plan`] once, and in each step hand
//! over its states between velocities and positions.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::ops::Range;
use std::time::{Duration, Instant};

use fixtures::thigh::thigh;
use musculo_collide::distance_field::Pose;
use musculo_collide::glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, BodyKind, CheckParams, Detection, Friction, Margins, Material, PairContacts,
    ParticleLoads, Plan, PlanError, PlanParams, Progress, RigidMotion, Scene, SceneStates,
    SceneStep, StepLength, StepParams,
};

/// How wrong the depth of a contact may be \[mm\].
const TOLERANCE: f64 = 0.2;

/// Gap up to which contacts are detected \[mm\].
const MARGIN: f64 = 0.5;

/// Steps, and their length \[s\].
const STEPS: u32 = 100;
const STEP: f64 = 0.005;

/// A muscle as the simulator has it: equal masses, on springs along the edges
/// of its surface and to where they were at rest.
struct Muscle {
    particles: Range<usize>,
    rest: Vec<DVec3>,
    edges: Vec<[usize; 2]>,
}

impl Muscle {
    /// Stiffness over mass of springs along edges and to the place at rest
    /// \[1/s²\], and damping over mass \[1/s\].
    const ALONG: f64 = 2000.0;
    const TO_REST: f64 = 200.0;
    const DAMPING: f64 = 10.0;

    fn new(id: BodyId, scene: &Scene) -> Self {
        let body = scene.body(id);
        let edges = body.surface().edges().iter();
        let edges = edges.map(|edge| edge.map(|vertex| vertex as usize)).collect();
        let particles = body.particles().start as usize..body.particles().end as usize;
        Self { particles, rest: body.positions().to_vec(), edges }
    }

    /// Adds what forces do to velocities in a step.
    fn accelerate(&self, x: &[DVec3], v: &mut [DVec3]) {
        let (x, v) = (&x[self.particles.clone()], &mut v[self.particles.clone()]);
        for ((rest, x), v) in self.rest.iter().zip(x).zip(&mut *v) {
            *v += STEP * (Self::TO_REST * (*rest - *x) - Self::DAMPING * *v);
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
    let ids: Vec<BodyId> = scene.ids().collect();
    let muscles: Vec<Muscle> = ids[1..].iter().map(|&id| Muscle::new(id, &scene)).collect();
    let mut x = scene.particle_positions();
    let (mut v, inverse_mass) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);

    // Once: how each pair is detected, and what its contacts are made of.
    let params = PlanParams { margin: MARGIN, ..PlanParams::with_tolerance(TOLERANCE) };
    let mut plan = Plan::new(&mut scene, &params, Progress::none())?;
    println!("{plan}");
    let mut detection = Detection::default();
    let friction = Friction::coulomb(0.1)?;
    let material = Material { friction, ..Material::hard(Margins::new(0.0, MARGIN)?) };
    let mut contact_step = SceneStep::new(material);
    contact_step.set_followers(plan.followers(&scene)?);
    let params = StepParams::new(StepLength::new(STEP)?);

    println!(
        "step  contacts  deepest before  exact after [mm]  energy given [g mm²/s²]  us a step"
    );
    let mut spent = Duration::ZERO;
    for step in 0..=STEPS {
        // The simulator's own part: the bone goes to the muscles and back, and forces change
        // velocities.
        let (pose, motion) = bone_motion(step);
        contact_step.move_bone(&mut scene, ids[0], &pose, motion)?;
        for muscle in &muscles {
            muscle.accelerate(&x, &mut v);
        }

        // The collision step, in place of one's own, before the move.
        let start = Instant::now();
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
        let report = contact_step.correct(&mut scene, states, &params, |scene, contacts| {
            detect(&mut plan, scene, &mut detection, contacts)
        })?;
        spent += start.elapsed();

        if step % 10 == 0 {
            let (contacts, before) = (report.contacts, report.depth_before);
            let after = exact_depth(&mut scene)?;
            let (energy, us) = (report.rigid_work, spent.as_micros() / u128::from(step + 1));
            println!("{step:>4}{contacts:>10}{before:>16.2}{after:>18.2}{energy:>25.0}{us:>11}");
        }
        for muscle in &muscles {
            for particle in muscle.particles.clone() {
                x[particle] += STEP * v[particle];
            }
        }
    }
    Ok(())
}

/// Returns where the bone is at a step, and how it moves there.
fn bone_motion(step: u32) -> (Pose, RigidMotion) {
    let rate = std::f64::consts::TAU / (STEP * f64::from(STEPS));
    let (sin, cos) = (rate * STEP * f64::from(step)).sin_cos();
    let way = DVec3::new(2.0, 2.0, 0.0);
    let (velocity, acceleration) = (way * rate * cos, way * rate * rate * -sin);
    let motion = RigidMotion { velocity, acceleration, ..RigidMotion::default() };
    (Pose::new(DQuat::IDENTITY, way * sin), motion)
}

/// Hands the contacts of a frame on to the response.
fn detect(
    plan: &mut Plan,
    scene: &mut Scene,
    detection: &mut Detection,
    contacts: &mut PairContacts<'_>,
) -> Result<(), PlanError> {
    plan.detect(scene, detection)?;
    for pair in detection.pairs() {
        contacts.add(pair.pair, &detection.contacts()[pair.contacts.clone()]);
    }
    Ok(())
}

/// Computes the overlap that is left, exactly; no simulator needs this in every step.
fn exact_depth(scene: &mut Scene) -> Result<f64, Box<dyn Error>> {
    let reports = scene.check(&CheckParams::new(0.0), Progress::none())?;
    Ok(reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max))
}
