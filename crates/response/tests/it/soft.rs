//! Soft forces: derivatives against differences of the forces, products
//! against blocks, implicit steps against a dense solution.

use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ImplicitEuler, ImplicitMidpoint, LinearForces, LinearParams, Margins,
    NormalForce, ResponseError, SoftContacts, SoftLaw, TimeStep,
};
use surface::{Contact, Stencil};

use crate::common::{contact, number, term, unit, vector};

struct Scene {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    contacts: Vec<Contact>,
    friction: f64,
    law: SoftLaw,
    damped: bool,
}

fn scene(u: &mut arbitrary::Unstructured<'_>) -> arbitrary::Result<Scene> {
    let mut x = Vec::new();
    let mut v = Vec::new();
    for _ in 0..7 {
        x.push(vector(u, 1.0)?);
        v.push(vector(u, 0.5)?);
    }
    let stiffness = number(u, 0.5, 5.0)?;
    let damping = if u.arbitrary()? { number(u, 0.1, 0.3)? } else { 0.0 };
    let (normal_force, sign) = match u.choose_index(3)? {
        0 => (NormalForce::Penalty { stiffness, damping }, 1.0),
        1 => (NormalForce::TwoSided { stiffness, damping }, 1.0),
        _ => (NormalForce::Barrier { stiffness, range: 2.0 }, -1.0),
    };
    let stencils = [
        Stencil::vertex_face(0, [1, 2, 3], [0.2, 0.3, 0.5]),
        Stencil::edge_edge([1, 4], 0.3, [5, 6], 0.6),
        Stencil::new(&[term(2, -1.0), term(6, 1.0)]).expect("two terms"),
    ];
    let mut contacts = Vec::new();
    for stencil in stencils {
        contacts.push(contact(stencil, unit(u)?, -sign * number(u, 0.3, 1.5)?));
    }
    let slip_speed = if u.arbitrary()? { 0.05 } else { 4.0 };
    let law = SoftLaw::new(normal_force, slip_speed).expect("in range");
    Ok(Scene { x, v, contacts, friction: number(u, 0.0, 1.0)?, law, damped: damping > 0.0 })
}

impl Scene {
    /// Rows with the gaps that the contacts would have after `dx`.
    fn rows(&self, dx: &[DVec3]) -> ContactRows {
        let margins = Margins::new(0.0, 1.0).expect("in range");
        let law = ContactLaw::new(margins, self.friction).expect("in range");
        let mut rows = ContactRows::new(self.x.len());
        for contact in &self.contacts {
            let moved = contact.stencil.combine(|k| dx[k as usize]).dot(contact.normal);
            rows.push(&Contact { gap: contact.gap - moved, ..*contact }, law).expect("valid");
        }
        rows
    }

    fn forces(&self, dx: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let rows = self.rows(dx);
        let mut forces = vec![DVec3::ZERO; self.x.len()];
        let soft = SoftContacts::new(&rows, v, self.law).expect("no overlap");
        soft.add_forces(&mut forces).expect("one a particle");
        forces
    }
}

fn sized(q: &[DVec3]) -> f64 {
    q.iter().map(|q| q.length()).fold(0.0, f64::max)
}

#[test]
fn products_are_derivatives_and_blocks_are_products() {
    fixtures::generate::cases(21, 1000, |u| {
        let mut scene = scene(u)?;
        let direction: Vec<DVec3> =
            (0..7).map(|_| vector(u, 1.0)).collect::<arbitrary::Result<_>>()?;
        let still = [DVec3::ZERO; 7];
        let epsilon = 1e-6;
        let shifted = |base: &[DVec3], by: f64| -> Vec<DVec3> {
            base.iter().zip(&direction).map(|(q, d)| *q + by * *d).collect()
        };
        // By velocity: friction's slip too, with N as it is. Damping changes N,
        // and with it friction: left out where both are there.
        let damped = scene.damped && scene.friction > 0.0;
        let rows = scene.rows(&still);
        let soft = SoftContacts::new(&rows, &scene.v, scene.law).expect("no overlap");
        if !damped {
            let (up, down) = (
                scene.forces(&still, &shifted(&scene.v, epsilon)),
                scene.forces(&still, &shifted(&scene.v, -epsilon)),
            );
            let mut product = vec![DVec3::ZERO; 7];
            soft.add_damping(&direction, &mut product);
            check_difference(&up, &down, &product, epsilon);
        }
        for (blocks, by_position) in
            [(soft.stiffness_blocks(), true), (soft.damping_blocks(), false)]
        {
            let mut product = vec![DVec3::ZERO; 7];
            if by_position {
                soft.add_stiffness(&direction, &mut product);
            } else {
                soft.add_damping(&direction, &mut product);
            }
            let mut sum = [DVec3::ZERO; 7];
            for block in blocks {
                sum[block.row as usize] += block.value * direction[block.column as usize];
            }
            let error =
                sum.iter().zip(&product).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(error < 1e-12 * (1.0 + sized(&product)), "{error}");
        }
        // By position, without friction: its N is taken as it is.
        drop(soft);
        scene.friction = 0.0;
        let rows = scene.rows(&still);
        let soft = SoftContacts::new(&rows, &scene.v, scene.law).expect("no overlap");
        let (up, down) = (
            scene.forces(&shifted(&still, epsilon), &scene.v),
            scene.forces(&shifted(&still, -epsilon), &scene.v),
        );
        let mut product = vec![DVec3::ZERO; 7];
        soft.add_stiffness(&direction, &mut product);
        check_difference(&up, &down, &product, epsilon);
        Ok(())
    });
}

#[track_caller]
fn check_difference(up: &[DVec3], down: &[DVec3], product: &[DVec3], epsilon: f64) {
    let slope: Vec<DVec3> =
        up.iter().zip(down).map(|(up, down)| (*up - *down) / (2.0 * epsilon)).collect();
    let error = slope.iter().zip(product).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
    assert!(
        error < 1e-5 * (1.0 + sized(product) + sized(&slope)),
        "{error}: {slope:?} {product:?}"
    );
}

#[test]
fn forces_keep_momentum_and_derivatives_do_not_gain_energy() {
    fixtures::generate::cases(22, 1000, |u| {
        let scene = scene(u)?;
        let rows = scene.rows(&[DVec3::ZERO; 7]);
        let soft = SoftContacts::new(&rows, &scene.v, scene.law).expect("no overlap");
        let forces = scene.forces(&[DVec3::ZERO; 7], &scene.v);
        assert!(forces.iter().sum::<DVec3>().length() < 1e-12 * (1.0 + sized(&forces)));
        let q: Vec<DVec3> = (0..7).map(|_| vector(u, 1.0)).collect::<arbitrary::Result<_>>()?;
        for by_position in [true, false] {
            let mut product = vec![DVec3::ZERO; 7];
            if by_position {
                soft.add_stiffness(&q, &mut product);
            } else {
                soft.add_damping(&q, &mut product);
            }
            let form: f64 = q.iter().zip(&product).map(|(a, b)| a.dot(*b)).sum();
            assert!(form < 1e-10, "not positive: {form}");
        }
        Ok(())
    });
}

/// Solves (M − σ h C − σ² h² K) dv = h f + σ h² K v densely.
fn dense_step(scene: &Scene, w: &[f64], force: &[DVec3], h: f64, sigma: f64) -> Vec<DVec3> {
    let rows = scene.rows(&[DVec3::ZERO; 7]);
    let soft = SoftContacts::new(&rows, &scene.v, scene.law).expect("no overlap");
    let n = 21;
    let mut a = vec![vec![0.0; n + 1]; n];
    let mut right = [DVec3::ZERO; 7];
    for block in soft.stiffness_blocks() {
        let (i, j) = (block.row as usize, block.column as usize);
        right[i] += sigma * h * h * (block.value * scene.v[j]);
        add_block(&mut a, i, j, block.value * (-sigma * sigma * h * h));
    }
    for block in soft.damping_blocks() {
        add_block(&mut a, block.row as usize, block.column as usize, block.value * (-sigma * h));
    }
    for k in 0..7 {
        right[k] += h * force[k];
        for (c, right) in right[k].to_array().into_iter().enumerate() {
            let row = 3 * k + c;
            if w[k] > 0.0 {
                a[row][row] += 1.0 / w[k];
                a[row][n] = right;
            } else {
                a[row] = vec![0.0; n + 1];
                a[row][row] = 1.0;
            }
        }
    }
    eliminate(a).chunks(3).map(DVec3::from_slice).collect()
}

fn add_block(a: &mut [Vec<f64>], i: usize, j: usize, block: glam::DMat3) {
    for r in 0..3 {
        for c in 0..3 {
            a[3 * i + r][3 * j + c] += block.col(c)[r];
        }
    }
}

fn eliminate(mut a: Vec<Vec<f64>>) -> Vec<f64> {
    let n = a.len();
    for pivot in 0..n {
        let best = (pivot..n)
            .max_by(|&i, &j| a[i][pivot].abs().total_cmp(&a[j][pivot].abs()))
            .expect("rows");
        a.swap(pivot, best);
        let top = a[pivot].clone();
        for (i, row) in a.iter_mut().enumerate() {
            if i != pivot {
                let factor = row[pivot] / top[pivot];
                row.iter_mut().zip(&top).for_each(|(r, t)| *r -= factor * t);
            }
        }
    }
    (0..n).map(|k| a[k][n] / a[k][k]).collect()
}

fn implicit_is_dense<I: response::Implicit>(scene: &Scene, w: &[f64], force: &[DVec3], h: f64) {
    let rows = scene.rows(&[DVec3::ZERO; 7]);
    let soft = SoftContacts::new(&rows, &scene.v, scene.law).expect("no overlap");
    let step = TimeStep::<I>::new(h).expect("in range");
    let params = LinearParams { max_iterations: 500, tolerance: 1e-13 };
    let (a, _) = step.implicit_accelerations(w, force, &soft, &scene.v, &params).expect("valid");
    let dense = dense_step(scene, w, force, h, I::POSITION_SHARE);
    for (a, dense) in a.values().iter().zip(&dense) {
        assert!((h * *a - *dense).length() < 1e-9 * (1.0 + dense.length()), "{a} {dense}");
    }
}

#[test]
fn implicit_steps_are_those_of_the_dense_system() {
    fixtures::generate::cases(23, 1000, |u| {
        let scene = scene(u)?;
        let mut w = Vec::new();
        let mut force = Vec::new();
        for k in 0..7 {
            w.push(if k == 3 { 0.0 } else { number(u, 0.2, 3.0)? });
            force.push(vector(u, 5.0)?);
        }
        let h = number(u, 0.01, 1.0)?;
        implicit_is_dense::<ImplicitEuler>(&scene, &w, &force, h);
        implicit_is_dense::<ImplicitMidpoint>(&scene, &w, &force, h);
        Ok(())
    });
}

#[test]
fn a_penalty_acts_on_neither_side_of_its_contact_alone() {
    // Damping alone would push before the contact, and pull behind it.
    let penalty = NormalForce::Penalty { stiffness: 2.0, damping: 3.0 };
    let law = SoftLaw::new(penalty, 1.0).expect("in range");
    let force = |gap: f64, velocity: f64| {
        let stencil = Stencil::new(&[term(0, -1.0), term(1, 1.0)]).expect("two terms");
        let contacts = vec![contact(stencil, DVec3::Z, gap)];
        let (x, v) = (vec![DVec3::ZERO; 2], vec![velocity * DVec3::Z, DVec3::ZERO]);
        let scene = Scene { x, v, contacts, friction: 0.0, law, damped: true };
        scene.forces(&[DVec3::ZERO; 2], &scene.v)[0]
    };
    let (near, deep) = (force(0.1, -1.0), force(-0.1, -1.0));
    assert!(near == DVec3::ZERO && (deep - 3.2 * DVec3::Z).length() < 1e-12, "{near} {deep}");
    assert_eq!(force(-0.1, 1.0), DVec3::ZERO, "no pull where it leaves");
}

/// Near a gap of 0 the force of a barrier is finite where its derivative overflows, and friction that
/// is full at no speed at all has a derivative that overflows.
#[test]
fn derivatives_that_overflow_are_refused() {
    let refused = |normal: NormalForce, slip_speed: f64, gap: f64| {
        let law = SoftLaw::new(normal, slip_speed).expect("in range");
        let stencil = Stencil::new(&[term(0, -1.0), term(1, 1.0)]).expect("two terms");
        let contacts = vec![contact(stencil, DVec3::Z, gap)];
        let (x, v) = (vec![DVec3::ZERO; 2], vec![DVec3::ZERO; 2]);
        let scene = Scene { x, v, contacts, friction: 0.5, law, damped: true };
        let rows = scene.rows(&[DVec3::ZERO; 2]);
        match SoftContacts::new(&rows, &scene.v, scene.law) {
            Ok(soft) => {
                for block in [soft.stiffness_blocks(), soft.damping_blocks()].concat() {
                    assert!(block.value.is_finite(), "{block:?}");
                }
                None
            }
            Err(ResponseError::ContactNotFinite { contact: 0, what, .. }) => Some(what),
            Err(other) => panic!("{other}"),
        }
    };
    let barrier = NormalForce::Barrier { stiffness: 1.0, range: 1.0 };
    assert_eq!(refused(barrier, 1.0, 1e-160), Some("stiffness"));
    assert_eq!(refused(barrier, 1.0, 1e-150), None);
    let penalty = NormalForce::Penalty { stiffness: 1e10, damping: 0.0 };
    assert_eq!(refused(penalty, 1e-300, -1.0), Some("force"));
    assert_eq!(refused(penalty, 1e-290, -1.0), None);
}
