//! Drops a soft ellipsoid on a bone, where it slides off with friction: in short explicit
//! steps, and in implicit steps sixteen times as long.
//!
//! ```text
//! cargo run --release -p response --example muscle_on_bone -- frames.svg
//! ```
//!
//! Springs hold the muscle's shape; a contact step corrects positions, velocities and
//! accelerations before each move. Millimeters, grams and seconds.

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod muscle;
mod picture;

use std::error::Error;
use std::fs;

use glam::DVec3;
use response::{
    Accelerations, ContactStep, Friction, ImplicitEuler, LinearForces, LinearParams, Margins,
    Material, ParticleLoads, ParticleStates, ResponseError, RigidMotion, SolverParams, StepLength,
    StepParams, SymplecticEuler, TimeStep,
};
use surface::{Anchor, Contact, Stencil, Term};

use crate::muscle::{Muscle, Springs};
use crate::picture::Picture;

/// Standard gravity \[mm/s²\].
const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9810.0);
/// Radius of the bone, a cylinder along y \[mm\].
const BONE: f64 = 14.0;
const FRICTION: f64 = 0.3;
/// Contact margin \[mm\].
const MARGIN: f64 = 1.0;
/// Frames shown, and the time between them \[s\].
const FRAMES: u32 = 7;
const FRAME: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "muscle_on_bone.svg".to_owned());
    let mut picture = Picture::new(BONE);
    for (name, h, step) in [
        ("symplectic Euler, h = 0.25 ms", 0.000_25, World::explicit as Step),
        ("implicit Euler, h = 4 ms", 0.004, World::implicit as Step),
    ] {
        let mut world = World::new()?;
        picture.begin_row(name);
        let mut depth = 0.0_f64;
        for frame in 0..FRAMES {
            picture.add(&world.muscle, f64::from(frame) * FRAME);
            let mut time = 0.0;
            while time < FRAME - 0.5 * h {
                depth = depth.max(step(&mut world, h)?);
                time += h;
            }
        }
        println!("{name}: deepest {depth:.1e} mm, center at {:.2} mm", world.muscle.middle());
    }
    fs::write(&path, picture.finish())?;
    println!("wrote {path}");
    Ok(())
}

/// Moves the muscle by a step; returns the depth of contacts before it \[mm\].
type Step = fn(&mut World, f64) -> Result<f64, ResponseError>;

struct World {
    muscle: Muscle,
    material: Material,
    contacts: ContactStep,
}

impl World {
    fn new() -> Result<Self, Box<dyn Error>> {
        let margins = Margins::new(0.0, MARGIN)?;
        let material =
            Material { friction: Friction::coulomb(FRICTION)?, ..Material::hard(margins) };
        Ok(Self { muscle: Muscle::new()?, material, contacts: ContactStep::default() })
    }

    fn explicit(&mut self, h: f64) -> Result<f64, ResponseError> {
        let Muscle { x, v, inverse_mass, springs, .. } = &self.muscle;
        let force = springs.forces(x, v);
        let a = force.iter().zip(inverse_mass).map(|(f, w)| *f * *w + GRAVITY).collect();
        let mut a = TimeStep::<SymplecticEuler>::new(h)?.accelerations(a)?;
        let depth = self.correct(h, a.values_mut())?;
        self.advance(a)?;
        Ok(depth)
    }

    fn implicit(&mut self, h: f64) -> Result<f64, ResponseError> {
        let Muscle { x, v, inverse_mass, springs, .. } = &self.muscle;
        let mut force = springs.forces(x, v);
        for (force, w) in force.iter_mut().zip(inverse_mass) {
            *force += GRAVITY / *w;
        }
        let linear = At { springs, x };
        let params = LinearParams { tolerance: 1e-6, ..LinearParams::default() };
        let step = TimeStep::<ImplicitEuler>::new(h)?;
        let (mut a, _) = step.implicit_accelerations(inverse_mass, &force, &linear, v, &params)?;
        let depth = self.correct(h, a.values_mut())?;
        self.advance(a)?;
        Ok(depth)
    }

    /// Corrects the state and the accelerations of the next move; returns the remaining
    /// depth \[mm\].
    fn correct(&mut self, h: f64, a: &mut [DVec3]) -> Result<f64, ResponseError> {
        let params = StepParams {
            depth_tolerance: Some(1e-6),
            push_tolerance: Some(0.0),
            solver: SolverParams { max_iterations: 50, tolerance: 1e-6, ..Default::default() },
            ..StepParams::new(StepLength::new(h)?)
        };
        let Muscle { x, v, inverse_mass, .. } = &mut self.muscle;
        let loads = ParticleLoads::Accelerations(a);
        let particles = ParticleStates { x, v, loads, inverse_mass };
        let material = self.material;
        let report = self.contacts.correct(particles, &params, |x, contacts| {
            contacts.add(0, &material, &RigidMotion::default(), &detect(x));
            Ok::<(), ResponseError>(())
        })?;
        Ok(report.depth)
    }

    fn advance<I: response::Integrator>(
        &mut self,
        a: Accelerations<I>,
    ) -> Result<(), ResponseError> {
        a.advance(&mut self.muscle.x, &mut self.muscle.v)
    }
}

/// Derivatives of the springs at positions.
struct At<'a> {
    springs: &'a Springs,
    x: &'a [DVec3],
}

impl LinearForces for At<'_> {
    fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]) {
        self.springs.add_stiffness(self.x, dx, out);
    }

    fn add_damping(&self, dv: &[DVec3], out: &mut [DVec3]) {
        self.springs.add_damping(self.x, dv, out);
    }
}

/// Detects the contacts of the particles with the cylinder, up to the margin.
fn detect(x: &[DVec3]) -> Vec<Contact> {
    let mut contacts = Vec::new();
    for (particle, x) in (0..).zip(x) {
        let from_axis = x.with_y(0.0);
        let gap = from_axis.length() - BONE;
        if gap > MARGIN {
            continue;
        }
        let normal = from_axis.normalize_or(DVec3::Z);
        contacts.push(Contact {
            stencil: Stencil::single(Term { particle, weight: -1.0 }),
            anchor: Some(Anchor { point: *x - gap * normal, ..Anchor::default() }),
            normal,
            offset: 0.0,
            gap,
            time: None,
        });
    }
    contacts
}
