//! Distribution of a correction over particles of any masses.

use glam::DVec3;
use response::{ResponseError, distribute};
use surface::{Stencil, Term};

use crate::common::{momentum_residual, number, term, vector};

/// Weights of a vertex and a face, or of two edges, and inverse masses of which
/// some are 0 or far apart.
fn planted(u: &mut arbitrary::Unstructured<'_>) -> arbitrary::Result<(Vec<Term>, Vec<f64>)> {
    let (s, t) = (number(u, 0.0, 1.0)?, number(u, 0.0, 1.0)?);
    let stencil = if u.arbitrary()? {
        Stencil::edge_edge([0, 1], s, [2, 3], t)
    } else {
        let weights = [1.0 - s, s * (1.0 - t), s * t];
        Stencil::vertex_face(0, [1, 2, 3], weights)
    };
    let mut w = Vec::new();
    for _ in 0..4 {
        let kinds = [0.0, 1.0, number(u, 0.1, 3.0)?, 1e-6, 1e6];
        w.push(kinds[u.choose_index(kinds.len())?]);
    }
    Ok((stencil.terms().to_vec(), w))
}

#[test]
fn reaches_the_correction_and_keeps_the_momentum() {
    fixtures::generate::cases(21, 1000, |u| {
        let (terms, w) = planted(u)?;
        let correction = vector(u, 1.0)?;
        let before = vec![vector(u, 1.0)?, vector(u, 1.0)?, vector(u, 1.0)?, vector(u, 1.0)?];
        let mut after = before.clone();
        let compliance: f64 =
            terms.iter().map(|t| t.weight * t.weight * w[t.particle as usize]).sum();
        if compliance < 1e-9 {
            return Ok(());
        }
        let impulse = distribute(&terms, &w, correction, &mut after).expect("one can move");
        let reached: DVec3 = terms
            .iter()
            .map(|t| t.weight * (after[t.particle as usize] - before[t.particle as usize]))
            .sum();
        // Rounding of positions of size 1 under weights of size 1.
        assert!(
            (reached - correction).length()
                < 1e-14 * (1.0 + correction.length()) + 1e-14 * largest(&after),
            "{reached}"
        );
        for k in 0..4 {
            if w[k] == 0.0 {
                assert_eq!(before[k], after[k], "a fixed particle stays");
            }
        }
        assert!((impulse * compliance - correction).length() < 1e-12);
        if w.iter().all(|w| (0.1..=3.0).contains(w)) {
            assert!(momentum_residual(&w, &before, &after) < 1e-12);
        }
        Ok(())
    });
}

fn largest(q: &[DVec3]) -> f64 {
    q.iter().map(|q| q.length()).fold(0.0, f64::max)
}

/// The least change by the equations of a minimum with a multiplier, solved
/// densely by elimination: the reference implementation.
fn least_change(terms: &[Term], w: &[f64], correction: f64) -> Vec<f64> {
    let n = terms.len();
    let mut a = vec![vec![0.0; n + 2]; n + 1];
    for (k, term) in terms.iter().enumerate() {
        a[k][k] = 1.0 / w[term.particle as usize];
        a[k][n] = term.weight;
        a[n][k] = term.weight;
    }
    a[n][n + 1] = correction;
    for pivot in 0..=n {
        let best = (pivot..=n)
            .max_by(|&i, &j| a[i][pivot].abs().total_cmp(&a[j][pivot].abs()))
            .expect("valid");
        a.swap(pivot, best);
        let top = a[pivot].clone();
        for (i, row) in a.iter_mut().enumerate() {
            if i != pivot {
                let factor = row[pivot] / top[pivot];
                row.iter_mut().zip(&top).for_each(|(r, t)| *r -= factor * t);
            }
        }
    }
    (0..n).map(|k| a[k][n + 1] / a[k][k]).collect()
}

#[test]
fn is_the_least_change_by_kinetic_norm() {
    fixtures::generate::cases(22, 1000, |u| {
        let (terms, _) = planted(u)?;
        let w = vec![number(u, 0.1, 3.0)?, number(u, 0.1, 3.0)?, number(u, 0.1, 3.0)?, 0.7];
        let mut q = vec![DVec3::ZERO; 4];
        distribute(&terms, &w, DVec3::X * 0.8, &mut q).expect("all can move");
        for (term, least) in terms.iter().zip(least_change(&terms, &w, 0.8)) {
            assert!((q[term.particle as usize].x - least).abs() < 1e-12);
        }
        Ok(())
    });
}

#[test]
fn a_particle_on_both_sides_counts_once() {
    // Self-contact: particle 1 is P's neighbor and a corner of the face.
    let twice = [term(0, -1.0), term(1, 0.5), term(2, 0.3), term(1, 0.2)];
    let merged = [term(0, -1.0), term(1, 0.7), term(2, 0.3)];
    let w = [1.0, 2.0, 3.0];
    let (mut a, mut b) = ([DVec3::ZERO; 3], [DVec3::ZERO; 3]);
    distribute(&twice, &w, DVec3::ONE, &mut a).unwrap();
    distribute(&merged, &w, DVec3::ONE, &mut b).unwrap();
    assert_eq!(a, b);
    let reached: DVec3 = twice.iter().map(|t| t.weight * a[t.particle as usize]).sum();
    assert!((reached - DVec3::ONE).length() < 1e-15);
}

/// In units of any size the answer is the same, to the bit: these are powers of two.
#[test]
fn is_the_same_in_any_unit() {
    fixtures::generate::cases(23, 200, |u| {
        let (terms, w) = planted(u)?;
        let correction = vector(u, 1.0)?;
        let before = [vector(u, 1.0)?, vector(u, 1.0)?, vector(u, 1.0)?, vector(u, 1.0)?];
        let mut after = before;
        let impulse = distribute(&terms, &w, correction, &mut after);
        for unit in [-700, 700].map(|power| 2.0_f64.powi(power)) {
            let mut scaled = before.map(|q| unit * q);
            let of_scaled = distribute(&terms, &w, unit * correction, &mut scaled);
            assert_eq!(of_scaled, impulse.map(|impulse| unit * impulse), "{w:?}");
            assert_eq!(scaled, after.map(|q| unit * q), "{w:?}");
        }
        Ok(())
    });
}

#[test]
fn refuses_what_cannot_be_and_changes_nothing() {
    let pair = [term(0, -1.0), term(1, 1.0)];
    let mut q = [DVec3::ONE; 2];
    let cases = [
        (
            distribute(&pair, &[0.0, 0.0], DVec3::X, &mut q),
            ResponseError::NoFreeParticle { contact: 0 },
        ),
        (
            distribute(&[], &[1.0, 1.0], DVec3::X, &mut q),
            ResponseError::NoFreeParticle { contact: 0 },
        ),
        (
            distribute(&pair, &[1.0], DVec3::X, &mut q),
            ResponseError::Count { what: "inverse masses", expected: 2, got: 1 },
        ),
        (
            distribute(&pair, &[1.0, -2.0], DVec3::X, &mut q),
            ResponseError::InverseMass { particle: 1, value: -2.0 },
        ),
        (
            distribute(&[term(5, -1.0)], &[1.0, 1.0], DVec3::X, &mut q),
            ResponseError::ParticleOutOfRange { contact: 0, particle: 5, particle_count: 2 },
        ),
        (
            distribute(&pair, &[1.0, 1.0], DVec3::X * f64::INFINITY, &mut q),
            ResponseError::ContactNotFinite {
                contact: 0,
                what: "correction",
                value: f64::INFINITY,
            },
        ),
    ];
    for (found, expected) in cases {
        assert_eq!(found, Err(expected));
    }
    let huge = distribute(&[term(0, -1e-300)], &[1.0, 1.0], DVec3::X * 1e300, &mut q);
    assert!(huge.is_err(), "{huge:?}");
    assert_eq!(q, [DVec3::ONE; 2]);
}
