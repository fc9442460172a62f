//! A simulator of one's own, with its collision step given to this crate.
//!
//! ```text
//! cargo run --release -p musculo-collide --example simulator
//! ```
//!
//! The simulator knows two muscles as masses on springs. What it had to do for
//! collision: add its surfaces to a [`Scene`] once, make a [`Plan`] once, and in
//! each step hand over positions, detect, respond, and take positions back.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::error::Error;
use std::time::{Duration, Instant};

use fixtures::thigh::thigh;
use musculo_collide::distance_field::Pose;
use musculo_collide::glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, BodyKind, CheckParams, Detection, Plan, PlanParams, Progress, RespondParams, Scene,
};

/// How wrong the depth of a contact may be \[mm\].
const TOLERANCE: f64 = 0.2;

/// Steps, and their length \[s\].
const STEPS: u32 = 100;
const STEP: f64 = 0.005;

/// A muscle as the simulator has it: equal masses, on springs along the edges
/// of its surface and to where they were at rest.
struct Muscle {
    id: BodyId,
    rest: Vec<DVec3>,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
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
        let rest = body.positions().to_vec();
        let edges = body.surface().edges().iter();
        let edges = edges.map(|edge| edge.map(|vertex| vertex as usize)).collect();
        let velocity = vec![DVec3::ZERO; rest.len()];
        Self { id, position: rest.clone(), rest, velocity, edges }
    }

    /// Forces, velocities, positions: semi-implicit Euler.
    fn integrate(&mut self) {
        let state = self.rest.iter().zip(self.position.iter().zip(&self.velocity));
        let own = |(rest, (x, v)): (&DVec3, (&DVec3, &DVec3))| {
            Self::TO_REST * (*rest - *x) - Self::DAMPING * *v
        };
        let mut force: Vec<DVec3> = state.map(own).collect();
        for &[i, j] in &self.edges {
            let along = self.position[j] - self.position[i];
            let longer = along.length() - self.rest[j].distance(self.rest[i]);
            let pull = Self::ALONG * longer * along.normalize_or_zero();
            force[i] += pull;
            force[j] -= pull;
        }
        for ((x, v), f) in self.position.iter_mut().zip(&mut self.velocity).zip(force) {
            *v += STEP * f;
            *x += STEP * *v;
        }
    }

    /// Takes over where the response has moved it, and what that means for
    /// velocities: what was pushed out does not go on inwards.
    fn take(&mut self, corrected: &[DVec3]) {
        for ((x, v), after) in self.position.iter_mut().zip(&mut self.velocity).zip(corrected) {
            *v += (*after - *x) / STEP;
            *x = *after;
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
    let femur = ids[0];
    let mut muscles: Vec<Muscle> = ids[1..].iter().map(|&id| Muscle::new(id, &scene)).collect();

    // Once: how each pair is looked at, and what that needs.
    let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(TOLERANCE), Progress::none())?;
    println!("{plan}");
    let mut detection = Detection::default();

    println!("step  contacts  deepest before  after [mm]  detect  respond [us a step]");
    let mut spent = [Duration::ZERO; 2];
    for step in 0..=STEPS {
        // The simulator's own part: the bone goes to the muscles and back, and
        // these follow their springs.
        let share = f64::from(step) / f64::from(STEPS);
        let way = 2.0 * (std::f64::consts::TAU * share).sin();
        scene.pose_body(femur, &Pose::new(DQuat::IDENTITY, DVec3::new(way, way, 0.0)))?;
        for muscle in &mut muscles {
            muscle.integrate();
            scene.move_body(muscle.id, &muscle.position)?;
        }
        // The collision step, in place of one's own.
        let start = Instant::now();
        plan.detect(&mut scene, &mut detection)?;
        spent[0] += start.elapsed();
        let start = Instant::now();
        plan.respond(&mut scene, &detection, &RespondParams::default())?;
        spent[1] += start.elapsed();
        for muscle in &mut muscles {
            muscle.take(scene.body(muscle.id).positions());
        }
        if step % 10 == 0 {
            let (contacts, before) = (detection.contacts().len(), deepest(&detection));
            let after = exact_depth(&mut scene)?;
            let [detect, respond] = spent.map(|time| time.as_micros() / u128::from(step + 1));
            println!("{step:>4}{contacts:>10}{before:>16.2}{after:>12.2}{detect:>8}{respond:>9}");
        }
    }
    Ok(())
}

fn deepest(detection: &Detection) -> f64 {
    detection.pairs().iter().map(|pair| pair.max_depth).fold(0.0, f64::max)
}

/// What overlap is left, exactly; no simulator needs this in every step.
fn exact_depth(scene: &mut Scene) -> Result<f64, Box<dyn Error>> {
    let reports = scene.check(&CheckParams::new(0.0), Progress::none())?;
    Ok(reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max))
}
