//! The same steps in other units of length and of time: powers of two, so that all digits are the
//! same.

use glam::DVec3;
use response::{
    ContactSet, ContactStep, Friction, Margins, Material, ParticleLoads, ParticleStates,
    ResponseError, RigidMotion, SolverMethod, SolverParams, SpringDamper, StepLength, StepParams,
    StepReport,
};
use surface::{Contact, ContactSide, Term};

use crate::common::{METHODS, Stream};

/// Sizes of the units of length and of time.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: f64,
    time: f64,
}

/// States after some steps, in the first units.
#[derive(Debug, PartialEq)]
struct Outcome {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    a: Vec<DVec3>,
    depth: f64,
    approach: f64,
    impulse: DVec3,
    kinetic_energy: f64,
    contact_energy: f64,
    rigid_work: f64,
    force: DVec3,
    rounds: u32,
}

const PARTICLES: u32 = 12;

fn particle(particle: u32) -> [Term; 1] {
    [Term { particle, weight: 1.0 }]
}

/// Balls of diameter 1 on a floor that rises and turns, soft below and hard between each other.
fn detect(units: Units, x: &[DVec3], contacts: &mut ContactSet) -> Result<(), ResponseError> {
    let Units { length, time } = units;
    let speed = length / time;
    let margins = Margins::new(0.02 * length, 0.2 * length)?;
    let friction = Friction::coulomb(0.4)?;
    let spring = SpringDamper::new(300.0 / (time * time), 2.0 / time)?;
    let soft = Material { friction, spring: Some(spring), ..Material::hard(margins) };
    let hard = Material { friction, ..Material::hard(margins) };
    let floor = RigidMotion {
        velocity: DVec3::new(0.1, 0.0, 0.3) * speed,
        spin: DVec3::Z * 0.5 / time,
        acceleration: DVec3::Z * speed / time,
        ..RigidMotion::default()
    };

    let mut on_floor = Vec::new();
    let mut between = Vec::new();
    for k in 0..PARTICLES {
        let p = x[k as usize];
        if p.z < 0.3 * length {
            let (on, below) = (particle(k), ContactSide::at_rest(p.with_z(0.0)));
            on_floor.push(Contact::between(ContactSide::Particles(&on), below, DVec3::Z, p.z));
        }
        for other in k + 1..PARTICLES {
            let away = p - x[other as usize];
            let gap = away.length() - length;
            if gap < 0.2 * length {
                let [of_p, on] = [k, other].map(particle);
                let (of_p, on) = (ContactSide::Particles(&of_p), ContactSide::Particles(&on));
                let contact = Contact::between(of_p, on, away.normalize(), gap + length);
                between.push(Contact { gap, offset: length, ..contact });
            }
        }
    }
    contacts.add(0, &soft, &floor, &on_floor);
    contacts.add(1, &hard, &RigidMotion::default(), &between);
    Ok(())
}

fn run(units: Units, method: SolverMethod) -> Outcome {
    let Units { length, time } = units;
    let speed = length / time;
    let mut stream = Stream(9);
    let mut any = |size: DVec3| size * DVec3::new(stream.next(), stream.next(), stream.next());
    let mut x: Vec<DVec3> =
        (0..PARTICLES).map(|_| length * any(DVec3::new(2.0, 2.0, 1.5))).collect();
    let mut v: Vec<DVec3> = (0..PARTICLES).map(|_| speed * (any(DVec3::ONE) - 0.5)).collect();
    let mut a = vec![DVec3::Z * -9.0 * speed / time; x.len()];
    let w: Vec<f64> = (0..PARTICLES).map(|k| [1.0, 0.5, 3.0, 0.0][k as usize % 4]).collect();
    let h = StepLength::new(0.01 * time).expect("in range");
    let params = StepParams {
        depth_tolerance: Some(1e-3 * length),
        approach_tolerance: Some(1e-3 * speed),
        push_tolerance: Some(1e-3 * speed / time),
        solver: SolverParams { method, max_iterations: 20, tolerance: 0.0 },
        ..StepParams::new(h)
    };

    let mut step = ContactStep::default();
    let mut report = StepReport::default();
    for _ in 0..5 {
        let loads = ParticleLoads::Accelerations(&mut a);
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let corrected = step.correct(particles, &params, |x, contacts| detect(units, x, contacts));
        report = corrected.expect("valid");
        for ((x, v), a) in x.iter_mut().zip(&mut v).zip(&mut a) {
            *v += h.get() * *a;
            *x += h.get() * *v;
            *a = DVec3::Z * -9.0 * speed / time;
        }
    }
    assert!(report.contacts > 10, "{report:?}");

    let back = |q: Vec<DVec3>, unit: f64| q.into_iter().map(|q| q / unit).collect();
    Outcome {
        x: back(x, length),
        v: back(v, speed),
        a: back(a, speed / time),
        depth: report.depth / length,
        approach: report.approach / speed,
        impulse: report.impulse / speed,
        kinetic_energy: report.kinetic_energy / (speed * speed),
        contact_energy: report.contact_energy / (speed * speed),
        rigid_work: report.rigid_work / (speed * speed),
        force: report.force / (speed / time),
        rounds: report.rounds,
    }
}

#[test]
fn steps_are_the_same_in_any_unit() {
    for method in METHODS {
        let expected = run(Units { length: 1.0, time: 1.0 }, method);
        for (length, time) in [(-90, 0), (90, 0), (0, -60), (0, 60), (-10, -10), (-40, 40)] {
            let units = Units { length: 2.0_f64.powi(length), time: 2.0_f64.powi(time) };
            assert_eq!(run(units, method), expected, "{units:?} by {method:?}");
        }
    }
}
