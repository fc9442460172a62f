//! Conjugate gradients on the equality Q_c · n = 0.
//!
//! It holds for the rows in violation, and for those that solving these brings
//! into violation, until there are no more. With N the rows' normals and W the
//! inverse masses, H = N W Nᵀ is symmetric and not negative, and H p = Q_c · n
//! has the impulses as its solution. Rows that repeat each other make H
//! singular, which does no harm; rows that contradict each other have no
//! solution, and the steps would run away: the best impulses seen are kept.

use glam::DVec3;

use super::packed::{Packed, PackedRow, Work};
use super::slots::{Slot, cells};
use super::{Impulse, SolverParams};

/// Growth of the residual, over the smallest seen, at which steps are given
/// up. A solvable system wavers by less; a contradictory one passes it soon.
const RUNAWAY: f64 = 1e4;

/// Adds rows and solves for them until none is in violation by more than the
/// tolerance; returns the steps.
pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
    forget(packed, work);
    let mut held = vec![false; packed.rows.len()];
    let mut iterations = 0;
    while iterations < params.max_iterations && hold_violated(packed, work, params, &mut held) {
        let rows: Vec<usize> = (0..held.len()).filter(|&row| held[row]).collect();
        iterations += solve_held(packed, work, params, &rows, params.max_iterations - iterations);
    }
    iterations
}

/// Steps until the largest |Q_c · n| of `rows` is within the tolerance.
fn solve_held(
    packed: &Packed,
    work: &mut Work,
    params: &SolverParams,
    rows: &[usize],
    max_iterations: u32,
) -> u32 {
    let approaches = approaches(packed, work);
    let mut residual: Vec<f64> = rows.iter().map(|&row| approaches[row]).collect();
    let mut impulses = vec![0.0; rows.len()];
    let mut best = (norm(&residual), impulses.clone());
    let mut direction = residual.clone();
    let mut scratch = vec![DVec3::ZERO; packed.particle_count];
    let mut iterations = 0;
    while iterations < max_iterations && largest(&residual) > params.tolerance {
        let product = product(packed, rows, &direction, &mut scratch);
        let curvature = dot(&direction, &product);
        let square = dot(&residual, &residual);
        iterations += 1;
        if curvature <= 0.0 {
            break;
        }
        let along = square / curvature;
        add(&mut impulses, along, &direction);
        add(&mut residual, -along, &product);
        let now = norm(&residual);
        if now < best.0 {
            best = (now, impulses.clone());
        } else if now > RUNAWAY * best.0 {
            break;
        }
        let turn = now * now / square;
        direction.iter_mut().zip(&residual).for_each(|(d, r)| *d = r + turn * *d);
    }
    apply(packed, work, rows, &best.1);
    iterations
}

/// Takes the impulses to start from back: the equality has none to keep.
fn forget(packed: &Packed, work: &mut Work) {
    let slots = cells(&mut work.q);
    for (row, impulse) in packed.rows.iter().zip(&mut work.impulses) {
        packed.give(row, -impulse.normal * row.normal, -impulse.tangent, slots);
        *impulse = Impulse::default();
    }
}

/// Marks the rows with Q_c · n above the tolerance; whether there is a new one.
fn hold_violated(
    packed: &Packed,
    work: &mut Work,
    params: &SolverParams,
    held: &mut [bool],
) -> bool {
    let mut grew = false;
    for (held, approach) in held.iter_mut().zip(approaches(packed, work)) {
        if !*held && approach > params.tolerance {
            *held = true;
            grew = true;
        }
    }
    grew
}

/// Q_c · n of all rows.
fn approaches(packed: &Packed, work: &mut Work) -> Vec<f64> {
    let slots = cells(&mut work.q);
    let rows = packed.rows.iter().zip(&work.bias);
    rows.map(|(row, bias)| packed.relative(row, *bias, slots)[0].dot(row.normal)).collect()
}

/// H p.
fn product(packed: &Packed, rows: &[usize], p: &[f64], q: &mut [DVec3]) -> Vec<f64> {
    q.fill(DVec3::ZERO);
    let slots = cells(q);
    for (&row, p) in rows.iter().zip(p) {
        let row = &packed.rows[row];
        packed.give(row, -p * row.normal, DVec3::ZERO, slots);
    }
    rows.iter().map(|&row| approach(packed, &packed.rows[row], slots)).collect()
}

fn approach<S: Slot>(packed: &Packed, row: &PackedRow, q: &[S]) -> f64 {
    let terms = packed.terms_of(row).iter();
    let at: DVec3 = terms.map(|t| t.weight * q[t.particle as usize].load()).sum();
    at.dot(row.normal)
}

fn apply(packed: &Packed, work: &mut Work, rows: &[usize], impulses: &[f64]) {
    let slots = cells(&mut work.q);
    for (&number, &normal) in rows.iter().zip(impulses) {
        let row = &packed.rows[number];
        packed.give(row, normal * row.normal, DVec3::ZERO, slots);
        work.impulses[number].normal += normal;
    }
}

fn add(to: &mut [f64], factor: f64, of: &[f64]) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += factor * of);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest, a| a.abs().max(largest))
}
