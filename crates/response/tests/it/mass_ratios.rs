//! A thousand coupled contacts of unequal masses, by every solver, cold and warm.

#![expect(clippy::print_stdout, reason = "iterations of the solvers beside each other")]

use glam::DVec3;
use response::{
    Constraint, ContactRows, ContactSystem, Impulse, SolveLevel, SolverMethod, SolverParams,
    SweepOrder,
};
use surface::{Contact, Stencil};

use crate::common::{self, Stream, law, momentum_residual};

/// Two sheets of `side`² particles, one at rest on the other: a thousand vertex-face contacts
/// with masses of a ratio of 1e4.
fn sheets(side: u32, turn: f64) -> (Vec<DVec3>, Vec<f64>, Vec<Contact>) {
    let mut s = Stream(3);
    let count = side * side;
    let mut v = Vec::new();
    let mut w = Vec::new();
    for k in 0..2 * count {
        let down = if k < count { -1.0 } else { 0.0 };
        v.push(DVec3::new(0.1 * s.next(), 0.1 * s.next(), down + 0.3 * s.next()));
        w.push(10.0_f64.powf(-4.0 * s.next()));
    }
    // Both ends of the range occur.
    (w[0], w[1]) = (1.0, 1e-4);
    let mut contacts = Vec::new();
    for row in 0..side - 1 {
        for column in 0..side - 1 {
            let below = count + row * side + column;
            let face = [below, below + 1, below + side];
            let (a, b) = (0.2 + 0.3 * s.next(), 0.2 + 0.3 * s.next());
            let stencil = Stencil::vertex_face(row * side + column, face, [a, b, 1.0 - a - b]);
            let tilt = DVec3::new(s.next() - 0.5 + turn, s.next() - 0.5, 2.0).normalize();
            contacts.push(common::contact(stencil, tilt, 0.0));
        }
    }
    (v, w, contacts)
}

fn two_sided(count: usize, contacts: &[Contact]) -> ContactRows {
    let mut rows = ContactRows::new(count);
    for contact in contacts {
        rows.push_constraint(contact, law(0.0), Constraint::TwoSided(0.0)).expect("valid");
    }
    rows
}

#[test]
fn a_thousand_coupled_contacts_of_unequal_masses() {
    let (v, w, contacts) = sheets(33, 0.0);
    assert_eq!(contacts.len(), 1024);
    let rows = two_sided(v.len(), &contacts);
    let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).expect("valid");
    let params = |method, max_iterations| SolverParams { method, max_iterations, tolerance: 1e-9 };
    let mut impulses = system.no_impulses();
    let run = |method, max_iterations, impulses: &mut [Impulse]| {
        let mut q = v.clone();
        let params = params(method, max_iterations);
        let report = system.solve(SolveLevel::Velocity, &mut q, impulses, &params).expect("valid");
        assert!(momentum_residual(&w, &v, &q) < 1e-12);
        println!("{method:?}: {} iterations, residual {:.1e}", report.iterations, report.residual);
        report
    };
    run(SolverMethod::GaussSeidel, 2000, &mut system.no_impulses());
    run(SolverMethod::AveragedJacobi, 2000, &mut system.no_impulses());
    let cold = run(SolverMethod::ConjugateGradient, 1000, &mut impulses);
    assert!(cold.converged && cold.iterations <= 100, "{cold:?}");

    // The next step: other normals, and velocities that have changed a little.
    let (_, _, turned) = sheets(33, 1e-3);
    let rows = two_sided(v.len(), &turned);
    let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).expect("valid");
    let mut q = v.clone();
    let params = params(SolverMethod::ConjugateGradient, 100);
    let warm = system.solve(SolveLevel::Velocity, &mut q, &mut impulses, &params).expect("valid");
    println!("warm: {} iterations, residual {:.1e}", warm.iterations, warm.residual);
    assert!(warm.converged, "{warm:?}");
}

/// A stack couples each row to those beside it: conjugate gradients end after a step or two,
/// whatever the masses are, also where the order of elimination has to be found.
#[test]
fn a_tower_of_a_thousand_of_unequal_masses() {
    let count = 1000_u32;
    let mut s = Stream(8);
    let w: Vec<f64> = (0..count).map(|_| 10.0_f64.powf(-4.0 * s.next())).collect();
    let x: Vec<DVec3> = (0..count).map(|k| DVec3::Z * f64::from(k)).collect();
    let mut contacts = common::tower(&x);

    // Rows in another order: by steps of 377, which has no divisor in common with 1000.
    contacts = (0..1000).map(|k| contacts[k * 377 % 1000]).collect();
    let floor = contacts.iter().position(|contact| contact.anchor.is_some()).expect("a floor");
    let rows = two_sided(x.len(), &contacts);
    for order in [SweepOrder::Given, SweepOrder::Colored] {
        let system = ContactSystem::new(&rows, &w, order).expect("valid");
        let mut impulses = system.no_impulses();
        let step = |h: f64, impulses: &mut [Impulse]| {
            let before = vec![DVec3::Z * -9.81 * h; x.len()];
            let mut v = before.clone();
            let params = SolverParams {
                method: SolverMethod::ConjugateGradient,
                max_iterations: 1000,
                tolerance: 1e-9,
            };
            let report =
                system.solve(SolveLevel::Velocity, &mut v, impulses, &params).expect("valid");
            println!("tower, h = {h}: {} iterations, {:.1e}", report.iterations, report.residual);
            assert!(report.converged, "{report:?}");

            // All momentum that is gained comes from the floor.
            let momentum = |v: &[DVec3]| v.iter().zip(&w).map(|(v, w)| *v / *w).sum::<DVec3>();
            let gained = momentum(&v) - momentum(&before);
            let given = impulses[floor].normal * DVec3::Z;
            assert!(gained.distance(given) <= 1e-12 * given.length(), "{gained} {given}");
            report.iterations
        };
        assert!(step(1e-3, &mut impulses) <= 10, "cold");

        // A step of another length: impulses are scaled as forces that persist.
        for impulse in &mut impulses {
            impulse.normal *= SolveLevel::Velocity.impulse_scale(0.5);
        }
        assert!(step(0.5e-3, &mut impulses) <= 10, "warm");
    }
}

/// Rows that repeat each other make the matrix singular: its factors are shifted.
#[test]
fn a_tower_of_repeated_rows_is_solved() {
    let count = 300_u32;
    let mut s = Stream(9);
    let w: Vec<f64> = (0..count).map(|_| 10.0_f64.powf(-2.0 * s.next())).collect();
    let x: Vec<DVec3> = (0..count).map(|k| DVec3::Z * f64::from(k)).collect();
    let mut contacts = common::tower(&x);
    contacts.extend_from_within(..);
    let rows = two_sided(x.len(), &contacts);
    let system = ContactSystem::new(&rows, &w, SweepOrder::Given).expect("valid");
    let mut v = vec![DVec3::Z * -9.81; x.len()];
    let method = SolverMethod::ConjugateGradient;
    let params = SolverParams { method, max_iterations: 1000, tolerance: 1e-9 };
    let mut impulses = system.no_impulses();
    let report = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params).expect("valid");
    println!("repeated rows: {} iterations, {:.1e}", report.iterations, report.residual);
    assert!(report.converged, "{report:?}");
}
