//! Solvers against a dense reference implementation, orders and threads against each other, spread
//! rows against contacts, and warm starts.

use glam::DVec3;
use response::{
    ContactRows, ContactSet, ContactSystem, Impulse, ImpulseCache, RigidMotion, SolveLevel,
    SolverMethod, SolverParams, SweepOrder,
};
use surface::{Contact, Stencil};

use crate::common::{
    self, law, material, momentum_residual, on_plane, patch, rows, term, tower, unit, vector,
};

/// Projected Gauss–Seidel over a dense matrix of all rows against all: the reference
/// implementation. Normals and tangents of a row in turn, as the solver does.
fn dense_sweeps(
    v: &[DVec3],
    w: &[f64],
    contacts: &[Contact],
    friction: f64,
    sweeps: usize,
) -> Vec<DVec3> {
    let weight = |c: &Contact, k: usize| -> f64 {
        c.stencil.terms().iter().filter(|t| t.particle as usize == k).map(|t| t.weight).sum()
    };
    let n = contacts.len();
    // How much an impulse on row j changes the relative motion of row i.
    let coupling: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let of = |j: usize| {
                (0..v.len()).map(|k| weight(&contacts[i], k) * weight(&contacts[j], k) * w[k]).sum()
            };
            (0..n).map(of).collect()
        })
        .collect();
    let start: Vec<DVec3> = contacts.iter().map(|c| c.stencil.combine(|k| v[k as usize])).collect();
    let mut normal = vec![0.0; n];
    let mut tangent = vec![DVec3::ZERO; n];
    for _ in 0..sweeps {
        for i in 0..n {
            let axis = contacts[i].normal;
            let pushed: DVec3 = (0..n)
                .map(|j| coupling[i][j] * (normal[j] * contacts[j].normal + tangent[j]))
                .sum();
            let u = start[i] - pushed;
            normal[i] = (normal[i] + u.dot(axis) / coupling[i][i]).max(0.0);
            let slip = u - u.dot(axis) * axis;
            let wanted = tangent[i] + slip / coupling[i][i];
            let limit = friction * normal[i];
            tangent[i] =
                if wanted.length() > limit { wanted * (limit / wanted.length()) } else { wanted };
        }
    }
    let given = |k: usize| -> DVec3 {
        (0..n)
            .map(|i| weight(&contacts[i], k) * (normal[i] * contacts[i].normal + tangent[i]))
            .sum()
    };
    (0..v.len()).map(|k| v[k] - w[k] * given(k)).collect()
}

#[test]
fn sweeps_are_those_of_the_dense_matrix() {
    for (seed, count) in [(1, 6), (2, 20), (3, 40)] {
        let (v, mut w, contacts) = patch(count, seed);
        w[3] = 0.0;
        w[15] = 0.0;
        let mut fast = v.clone();
        let params = SolverParams { max_iterations: 7, ..SolverParams::default() };
        common::solve(SolveLevel::Velocity, &mut fast, &w, &contacts, law(0.6), &params);
        let slow = dense_sweeps(&v, &w, &contacts, 0.6, 7);
        for (fast, slow) in fast.iter().zip(&slow) {
            assert!((*fast - *slow).length() < 1e-12, "{count} contacts: {fast} {slow}");
        }
    }
}

#[test]
fn a_hundred_contacts_on_24_particles_are_solved_in_any_order() {
    let (v, w, contacts) = patch(100, 5);
    let solved = |order: SweepOrder| {
        let rows = rows(24, &contacts, law(0.0));
        let system = ContactSystem::new(&rows, &w, order).unwrap();
        let mut after = v.clone();
        let params = SolverParams { max_iterations: 50_000, tolerance: 1e-9, ..Default::default() };
        let mut impulses = system.no_impulses();
        let report =
            system.solve(SolveLevel::Velocity, &mut after, &mut impulses, &params).unwrap();
        assert!(report.converged, "{order:?}: {report:?}");
        assert!(momentum_residual(&w, &v, &after) < 1e-12);
        (after, system.batch_count())
    };
    let ((given, one), (colored, many)) = (solved(SweepOrder::Given), solved(SweepOrder::Colored));
    assert!(one == 1 && many > 20, "{many} colors");
    // The motion is unique even where the impulses are not.
    for (a, b) in given.iter().zip(&colored) {
        assert!((*a - *b).length() < 1e-6, "{a} {b}");
    }
}

/// Patches of contacts that may open, by every method: what impulses do to the particles is the
/// change, none pulls, no row approaches, and none that pushes separates. The motion is then the
/// one with the least change by kinetic norm, whatever the method.
#[test]
fn patches_push_where_they_would_approach_and_nowhere_else() {
    for (count, seed) in [(6, 1), (12, 2), (24, 3), (48, 4), (100, 5), (48, 6), (48, 7)] {
        let (v, w, contacts) = patch(count, seed);
        let rows = rows(24, &contacts, law(0.0));
        let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).unwrap();
        for method in common::METHODS {
            let params = SolverParams { method, max_iterations: 50_000, tolerance: 1e-9 };
            let (mut after, mut impulses) = (v.clone(), system.no_impulses());
            let report = system.solve(SolveLevel::Velocity, &mut after, &mut impulses, &params);
            let report = report.unwrap();
            assert!(report.converged, "{count} rows by {method:?}: {report:?}");

            let mut moved = v.clone();
            let mut pushing = 0;
            for (contact, impulse) in contacts.iter().zip(&impulses) {
                let approach = contact.stencil.combine(|k| after[k as usize]).dot(contact.normal);
                assert!(approach < 1e-8 && impulse.normal >= 0.0, "{method:?}: {approach}");
                assert!(impulse.normal < 1e-7 || approach > -1e-8, "{method:?}: {approach}");
                pushing += usize::from(impulse.normal > 0.0);
                for term in contact.stencil.terms() {
                    let k = term.particle as usize;
                    moved[k] -= term.weight * w[k] * impulse.normal * contact.normal;
                }
            }
            assert!(count < 48 || pushing < count, "some open");
            for (moved, after) in moved.iter().zip(&after) {
                assert!(moved.distance(*after) < 1e-11, "{method:?}: {moved} {after}");
            }
        }
    }
}

/// A strip of particles pressed on a slope, enough for batches that are run in
/// parallel, and its bits after some sweeps.
fn strip_bits() -> u64 {
    let count = 9000_u32;
    let normal = DVec3::new(0.3, 0.1, 1.0).normalize();
    let mut stream = common::Stream(11);
    let mut contacts = Vec::new();
    let mut v = Vec::new();
    for k in 0..count {
        v.push(DVec3::new(stream.next(), stream.next(), -stream.next()));
        if k % 3 == 0 {
            contacts.push(on_plane(k, DVec3::ZERO, normal));
        }
        if k >= 2 {
            let stencil = Stencil::new(&[term(k, -1.0), term(k - 1, 0.4), term(k - 2, 0.6)]);
            contacts.push(common::contact(stencil.expect("valid"), DVec3::Z, 0.0));
        }
    }
    let w: Vec<f64> = (0..count).map(|k| if k % 17 == 0 { 0.0 } else { 1.0 }).collect();
    let rows = rows(v.len(), &contacts, law(0.4));
    let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).expect("valid");
    let mut impulses = system.no_impulses();
    system
        .solve(SolveLevel::Velocity, &mut v, &mut impulses, &SolverParams::default())
        .expect("valid");
    let numbers = v.iter().flat_map(|v| v.to_array());
    let of_impulses = impulses.iter().flat_map(|i| [i.normal, i.tangent.x, i.tangent.y]);
    numbers.chain(of_impulses).fold(0xcbf2_9ce4_8422_2325, |hash, number| {
        (hash ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Recorded without the feature `rayon`; the feature and threads change nothing.
const STRIP_BITS: u64 = 0x046e_7610_72c1_5cf2;

#[test]
fn bits_are_as_recorded() {
    assert_eq!(strip_bits(), STRIP_BITS, "{:#x}", strip_bits());
}

#[cfg(feature = "rayon")]
#[test]
fn bits_do_not_depend_on_threads() {
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(strip_bits), STRIP_BITS, "{threads} threads");
    }
}

#[test]
fn a_spread_row_moves_the_polygon_as_its_center_would() {
    // A hexagon of particles 1..=6 with its center, point 7, lifted by 0.1; the
    // contact is on the fan triangle of particles 2, 3 and the center.
    let center = 7;
    let stencil = Stencil::vertex_face(0, [2, 3, center], [0.2, 0.3, 0.5]);
    let contact = common::contact(stencil, DVec3::Z, -0.4);
    let mut terms = stencil.terms()[..3].to_vec();
    terms.extend((1..=6).map(|k| term(k, 0.5 / 6.0)));
    let mut rows = ContactRows::new(7);
    rows.push_terms(&contact, &terms, law(0.0), response::Constraint::Contact).unwrap();
    let row = rows.row(0);
    assert_eq!(row.terms.len(), 7, "each particle once: {:?}", row.terms);
    let weight = |k: u32| row.terms.iter().find(|t| t.particle == k).unwrap().weight;
    assert!((weight(2) - 0.2 - 0.5 / 6.0).abs() < 1e-15 && (weight(5) - 0.5 / 6.0).abs() < 1e-15);

    let w = [1.0; 7];
    let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).unwrap();
    let mut moved = [DVec3::ZERO; 7];
    let params = SolverParams::default();
    system.solve(SolveLevel::Position, &mut moved, &mut system.no_impulses(), &params).unwrap();
    let center_moved: DVec3 = moved[1..].iter().sum::<DVec3>() / 6.0;
    let at = |k: u32| if k == center { center_moved } else { moved[k as usize] };
    // The depth of 0.4 is gone, whatever the lift: only changes count.
    assert!((stencil.combine(at).z + 0.4).abs() < 1e-15);
    assert!(moved.iter().sum::<DVec3>().length() < 1e-15);
}

/// Contacts of one pair of bodies.
fn set(pair: u64, contacts: &[Contact]) -> ContactSet {
    let mut set = ContactSet::default();
    set.add(pair, &material(0.3), &RigidMotion::default(), contacts);
    set
}

#[test]
fn a_warm_start_from_the_same_contacts_needs_one_sweep() {
    let x: Vec<DVec3> = (0..12).map(|k| DVec3::Z * f64::from(k)).collect();
    let contacts = tower(&x);
    let rows = rows(12, &contacts, law(0.3));
    let system = ContactSystem::new(&rows, &[1.0; 12], SweepOrder::Given).unwrap();
    let params = SolverParams { max_iterations: 5000, tolerance: 1e-10, ..Default::default() };
    let mut impulses = system.no_impulses();
    let fall = |impulses: &mut Vec<Impulse>| {
        let mut v = vec![DVec3::Z * -0.1; 12];
        system.solve(SolveLevel::Velocity, &mut v, impulses, &params).unwrap().iterations
    };
    let cold = fall(&mut impulses);
    let mut cache = ImpulseCache::default();
    let contacts = set(0, &contacts);
    cache.store(&contacts, &impulses).unwrap();
    let mut warm = Vec::new();
    cache.warm_start(&contacts, 1.0, &mut warm);
    let again = fall(&mut warm);
    assert!(cold > 100 && again <= 2, "{cold} sweeps cold, {again} warm");
}

#[test]
fn impulses_are_carried_by_particle_and_normal() {
    let at = |face, normal: DVec3| {
        common::contact(Stencil::vertex_face(0, face, [0.2, 0.3, 0.5]), normal, 0.0)
    };
    let push = |normal| Impulse { normal, tangent: DVec3::ZERO };
    let side = DVec3::X;
    let old = [at([1, 2, 3], DVec3::Z), at([4, 5, 6], side)];
    let impulses = vec![push(1.0), push(2.0)];
    // The two contacts of particle 0 have changed their order and their faces.
    let turned = DVec3::new(1.0, 0.0, 0.2).normalize();
    let new = [at([5, 6, 7], turned), at([2, 3, 8], DVec3::Z)];
    let mut cache = ImpulseCache::default();
    cache.store(&set(5, &old), &impulses).unwrap();
    let mut start = Vec::new();
    cache.warm_start(&set(5, &new), 1.0, &mut start);
    assert_eq!(start, [push(2.0), push(1.0)]);
    // Of another pair of bodies, or scaled to a shorter step.
    cache.warm_start(&set(6, &new), 1.0, &mut start);
    assert_eq!(start, [push(0.0), push(0.0)]);
    cache.warm_start(&set(5, &new), 0.25, &mut start);
    assert_eq!(start, [push(0.5), push(0.25)]);
    // Turned by more than 30°, or twice the same: not handed on.
    let off = DVec3::new(0.7, 0.0, 0.8).normalize();
    let new = [at([1, 2, 3], off), at([1, 2, 3], DVec3::Z), at([1, 2, 3], DVec3::Z)];
    cache.warm_start(&set(5, &new), 1.0, &mut start);
    assert_eq!(start, [push(0.0), push(1.0), push(0.0)]);
}

/// An edge persists wherever on it its contact is, ends included.
#[test]
fn impulses_of_edges_are_carried_along_them() {
    let push = Impulse { normal: 1.0, tangent: DVec3::ZERO };
    let mut start = Vec::new();
    for from in [-0.0, 0.0, 0.5, 1.0] {
        for to in [-0.0, 0.0, 0.5, 1.0] {
            let [old, new] = [from, to].map(|s| {
                let edges = Stencil::edge_edge([0, 1], s, [2, 3], s);
                set(5, &[common::contact(edges, DVec3::Z, 0.0)])
            });
            let mut cache = ImpulseCache::default();
            cache.store(&old, &[push]).unwrap();
            cache.warm_start(&new, 1.0, &mut start);
            assert_eq!(start, [push], "from {from} to {to}");
        }
    }
}

#[test]
fn results_are_inside_the_cone_whatever_the_start() {
    fixtures::generate::cases(21, 1000, |u| {
        let seed = u.int_in_range(0..=200)?;
        let (v, w, contacts) = patch(30, seed);
        let rows = rows(24, &contacts, law(0.7));
        let system = ContactSystem::new(&rows, &w, SweepOrder::Colored).unwrap();
        let mut impulses = system.no_impulses();
        for impulse in &mut impulses {
            // Not admissible: it may pull, and points anywhere.
            *impulse = Impulse { normal: vector(u, 2.0)?.x, tangent: unit(u)? };
        }
        for method in [SolverMethod::GaussSeidel, SolverMethod::AveragedJacobi] {
            let mut after = v.clone();
            let mut impulses = impulses.clone();
            let params = SolverParams { method, max_iterations: 3, tolerance: 0.0 };
            system.solve(SolveLevel::Velocity, &mut after, &mut impulses, &params).unwrap();
            for (impulse, contact) in impulses.iter().zip(&contacts) {
                assert!(impulse.normal >= 0.0);
                assert!(impulse.tangent.length() <= 0.7 * impulse.normal * (1.0 + 1e-12) + 1e-15);
                assert!(impulse.tangent.dot(contact.normal).abs() < 1e-13);
            }
            assert!(momentum_residual(&w, &v, &after) < 1e-12);
            // What the impulses say is what the particles got.
            let mut expected = v.clone();
            for (impulse, contact) in impulses.iter().zip(&contacts) {
                for t in contact.stencil.terms() {
                    let k = t.particle as usize;
                    let given = impulse.normal * contact.normal + impulse.tangent;
                    expected[k] -= t.weight * w[k] * given;
                }
            }
            for (a, b) in expected.iter().zip(&after) {
                assert!((*a - *b).length() < 1e-11, "{a} {b}");
            }
        }
        Ok(())
    });
}

#[test]
fn fixed_particles_and_moving_rigid_objects_give_what_they_do() {
    // A rigid floor that rises takes the particle with it; a fixed particle
    // with a velocity does the same.
    let mut on_lift = on_plane(0, DVec3::ZERO, DVec3::Z);
    on_lift.anchor.as_mut().unwrap().velocity = DVec3::new(0.2, 0.0, 1.0);
    let on_fixed =
        common::contact(Stencil::new(&[term(0, -1.0), term(1, 1.0)]).unwrap(), DVec3::Z, 0.0);
    for contact in [on_lift, on_fixed] {
        let mut v = [DVec3::ZERO, DVec3::new(0.2, 0.0, 1.0)];
        let w = [2.0, 0.0];
        common::solve(SolveLevel::Velocity, &mut v, &w, &[contact], law(1.0), &common::thorough());
        assert!((v[0] - DVec3::new(0.2, 0.0, 1.0)).length() < 1e-14, "{v:?}");
        assert_eq!(v[1], DVec3::new(0.2, 0.0, 1.0));
    }
}

/// Changes of later rows add up: three particles that press along the axes, each by less than the
/// tolerance, move the first one along the diagonal by more, where it is on a plane.
#[test]
fn solvers_end_where_no_row_is_off_by_more_than_the_tolerance() {
    let diagonal = DVec3::ONE.normalize();
    let mut contacts = vec![on_plane(0, DVec3::ZERO, -diagonal)];
    for (particle, axis) in (1..).zip(DVec3::AXES) {
        let stencil = Stencil::new(&[term(particle, -1.0), term(0, 1.0)]).expect("two terms");
        contacts.push(common::contact(stencil, -axis, 0.0));
    }
    // The three are heavy, and hardly slowed.
    let w = [1.0, 1e-3, 1e-3, 1e-3];
    for tolerance in [1e-1, 1e-4, 1e-7] {
        let [x, y, z] = DVec3::AXES.map(|axis| 0.9 * tolerance * axis);
        let mut v = [DVec3::ZERO, x, y, z];
        let params = SolverParams { max_iterations: 10_000, tolerance, ..SolverParams::default() };
        let level = SolveLevel::Velocity;
        let report = common::solve(level, &mut v, &w, &contacts, law(0.0), &params);
        assert!(report.converged && report.residual <= tolerance, "{tolerance}: {report:?}");
        assert!(v[0].dot(diagonal) <= tolerance, "{tolerance}: {}", v[0]);
    }
}

#[test]
fn a_slip_that_friction_holds_is_not_converged() {
    // Pressed enough, and none of the friction that this permits.
    let rows = rows(1, &[on_plane(0, DVec3::ZERO, DVec3::Z)], law(0.5));
    let system = ContactSystem::new(&rows, &[1.0], SweepOrder::Given).unwrap();
    let mut v = [DVec3::new(1.0, 0.0, -1.0)];
    let mut impulses = [Impulse { normal: 1.0, tangent: DVec3::ZERO }];
    let params = SolverParams { max_iterations: 0, tolerance: 0.1, ..SolverParams::default() };
    let report = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params).unwrap();
    assert!(!report.converged && (report.residual - 0.5).abs() < 1e-12, "{report:?}");
}
