//! Friction by a share of the slip, in contacts that share particles: it only opposes the slip, ends
//! with the push, and adds no energy.

use glam::{DVec3, dvec3};
use response::{
    ContactLaw, ContactRows, ContactStep, ContactSystem, Friction, Impulse, Material,
    ParticleLoads, ParticleStates, ResponseError, RigidMotion, SolveLevel, SolverMethod,
    SolverParams, StepLength, StepParams, SweepOrder,
};
use surface::Contact;

use crate::common::{METHODS, Stream, kinetic_energy, law, material, on_plane};

/// A contact of particle 0 with a plane through it.
fn plane(normal: DVec3) -> Contact {
    on_plane(0, DVec3::ZERO, normal.normalize())
}

fn share(mu: f64) -> ContactLaw {
    law(0.0).with_friction(Friction::share(mu).expect("in range"))
}

fn solve(
    v: DVec3,
    contacts: &[(Contact, ContactLaw)],
    method: SolverMethod,
) -> (DVec3, Vec<Impulse>, bool) {
    let mut rows = ContactRows::new(1);
    for (contact, law) in contacts {
        rows.push(contact, *law).expect("contacts of a test are valid");
    }
    let system = ContactSystem::new(&rows, &[1.0], SweepOrder::Given).expect("valid");
    let params = SolverParams { method, max_iterations: 100_000, tolerance: 1e-11 };
    let (mut v, mut impulses) = ([v], system.no_impulses());
    let report = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params).expect("valid");
    (v[0], impulses, report.converged)
}

#[test]
fn a_share_in_a_corner_adds_no_energy() {
    // The wall stops the slip on the floor by itself: nothing is left to rub.
    for degrees in [90.0_f64, 85.0, 60.0, 45.0, 100.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (wall, floor) = (plane(dvec3(sin, 0.0, cos)), plane(DVec3::Z));
        for method in METHODS {
            let contacts = [(wall, law(0.0)), (floor, share(0.4))];
            let (v, impulses, converged) = solve(dvec3(-1.0, 0.0, -1.0), &contacts, method);
            assert!(converged, "{method:?} {degrees}: {v} {impulses:?}");
            assert!(v.length() < 1e-9, "{method:?} {degrees}: {v}");
        }
    }
}

#[test]
fn a_step_in_a_corner_adds_no_energy() {
    let hard = material(0.0);
    let rubs = Material { friction: Friction::share(0.4).expect("in range"), ..hard };
    for degrees in [90.0_f64, 85.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (mut x, mut v) = ([DVec3::ZERO], [dvec3(-1.0, 0.0, -1.0)]);
        let mut params = StepParams::new(StepLength::new(0.01).expect("in range"));
        params.solver = SolverParams { max_iterations: 1000, tolerance: 1e-9, ..params.solver };
        let (loads, inverse_mass) = (ParticleLoads::None, &[1.0][..]);
        let states = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass };
        let report = ContactStep::default()
            .correct::<ResponseError>(states, &params, |_, set| {
                set.add(0, &hard, &RigidMotion::default(), &[plane(dvec3(sin, 0.0, cos))]);
                set.add(1, &rubs, &RigidMotion::default(), &[plane(DVec3::Z)]);
                Ok(())
            })
            .expect("valid");
        let velocities = report.velocities.expect("an approach is corrected");
        assert!(velocities.converged, "{degrees}: {velocities:?}");
        assert!(report.kinetic_energy <= report.rigid_work, "{degrees}: {report:?}");
    }
}

#[test]
fn a_share_ends_with_the_push() {
    // A steeper slope throws the particle off the floor, whose slip stays as it is.
    let slope = plane(dvec3(0.1, 0.0, 1.0));
    for method in METHODS {
        let start = dvec3(-1.0, 0.3, -0.05);
        let contacts = [(slope, law(0.0)), (plane(DVec3::Z), share(0.4))];
        let (v, impulses, converged) = solve(start, &contacts, method);
        let (frictionless, _, _) = solve(start, &contacts[..1], method);
        assert!(converged && v.z > 0.0, "{method:?}: {v}");
        assert!((v - frictionless).length() < 1e-9, "{method:?}: {v}, not {frictionless}");
        assert!(impulses[1].normal < 1e-12 && impulses[1].tangent.length() < 1e-12);
    }
}

#[test]
fn a_share_alone_is_that_of_the_source() {
    let mut s = Stream(7);
    for _ in 0..100 {
        let v = dvec3(s.next() - 0.5, s.next() - 0.5, -s.next());
        for method in METHODS {
            let (after, _, converged) = solve(v, &[(plane(DVec3::Z), share(0.4))], method);
            let expected = dvec3(0.6 * v.x, 0.6 * v.y, 0.0);
            assert!(converged && (after - expected).length() < 1e-12, "{after}, not {expected}");
        }
    }
}

#[test]
fn shares_that_are_solved_only_dissipate() {
    let (mut solved, mut s) = ([0; 3], Stream(11));
    for case in 0..300 {
        let mut any = || 2.0 * dvec3(s.next(), s.next(), s.next()) - 1.0;
        let start = any() - DVec3::Z;
        let contacts: Vec<_> = (0..2 + case % 3)
            .map(|k| {
                let contact = plane(any() + 1.2 * DVec3::Z);
                let mu = [0.4, 1.0, 0.1][k % 3];
                (Contact { gap: [0.0, 0.5][(case + k) % 2], ..contact }, share(mu))
            })
            .collect();
        for (count, method) in solved.iter_mut().zip(METHODS) {
            let (v, impulses, converged) = solve(start, &contacts, method);
            if !converged {
                continue;
            }
            *count += 1;
            let (before, after) = (kinetic_energy(&[1.0], &[start]), kinetic_energy(&[1.0], &[v]));
            assert!(after <= before + 1e-9, "{method:?} {case}: {before} to {after}");
            for ((contact, _), impulse) in contacts.iter().zip(&impulses) {
                let slip = -start + start.dot(contact.normal) * contact.normal;
                assert!(impulse.tangent.dot(slip) >= 0.0, "{method:?} {case}: {impulse:?}");
                let rubs = impulse.tangent != DVec3::ZERO;
                assert!(!rubs || impulse.normal > 0.0, "{method:?} {case}: {impulse:?}");
            }
        }
    }
    assert!(solved.iter().all(|count| *count > 290), "{solved:?} of 300 are solved");
}
