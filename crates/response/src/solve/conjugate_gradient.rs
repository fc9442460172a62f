//! Conjugate gradients on the equality Q_c · n = 0.
//!
//! It holds for the rows in violation, and for those that solving these brings
//! into violation, until there are no more. With N the rows' normals and W the
//! inverse masses, H = N W Nᵀ is symmetric and positive semidefinite, and H p = Q_c · n
//! has the impulses as its solution. Rows that repeat each other make H
//! singular, which does no harm; rows that contradict each other have no
//! solution, and the steps would diverge: the best impulses found are kept.

use glam::DVec3;

use super::packed::{PackedRow, PackedSystem, SolverState};
use super::slots::{Slot, cells};
use super::{Impulse, SolverParams};

/// Growth of the residual, over the smallest found, at which steps are given
/// up. A solvable system wavers by less; a contradictory one soon exceeds it.
const DIVERGENCE: f64 = 1e4;

/// Adds rows and solves for them until none is in violation by more than the
/// tolerance; returns the steps.
pub(super) fn solve(system: &PackedSystem, state: &mut SolverState, params: &SolverParams) -> u32 {
    clear_impulses(system, state);
    let mut active = vec![false; system.rows.len()];
    let mut iterations = 0;
    while iterations < params.max_iterations && activate(system, state, params, &mut active) {
        let rows: Vec<usize> = (0..active.len()).filter(|&row| active[row]).collect();
        iterations += solve_rows(system, state, params, &rows, params.max_iterations - iterations);
    }
    iterations
}

/// Steps until the largest |Q_c · n| of `rows` is within the tolerance; returns the
/// steps.
fn solve_rows(
    system: &PackedSystem,
    state: &mut SolverState,
    params: &SolverParams,
    rows: &[usize],
    max_iterations: u32,
) -> u32 {
    let approaches = approaches(system, state);
    let mut residual: Vec<f64> = rows.iter().map(|&row| approaches[row]).collect();
    let mut impulses = vec![0.0; rows.len()];
    let (mut least, mut best) = (norm(&residual), impulses.clone());
    let mut direction = residual.clone();
    let mut scratch = vec![DVec3::ZERO; system.particle_count];
    let mut iterations = 0;

    // The residual is Q_c · n of the rows: what their impulses still have to cancel.
    while iterations < max_iterations && largest(&residual) > params.tolerance {
        let product = product(system, rows, &direction, &mut scratch);
        let curvature = dot(&direction, &product);
        let square = dot(&residual, &residual);
        iterations += 1;
        if curvature <= 0.0 {
            break;
        }

        // Step to the minimum along the direction, and keep the best impulses.
        let step = square / curvature;
        add(&mut impulses, step, &direction);
        add(&mut residual, -step, &product);
        let present = norm(&residual);
        if present < least {
            (least, best) = (present, impulses.clone());
        } else if present > DIVERGENCE * least {
            break;
        }

        // The next direction is conjugate to all earlier ones.
        let turn = present * present / square;
        for (d, r) in direction.iter_mut().zip(&residual) {
            *d = r + turn * *d;
        }
    }
    apply(system, state, rows, &best);
    iterations
}

/// Takes back the impulses to start from: the equality keeps none.
fn clear_impulses(system: &PackedSystem, state: &mut SolverState) {
    let slots = cells(&mut state.q);
    for (row, impulse) in system.rows.iter().zip(&mut state.impulses) {
        system.apply(row, -impulse.normal * row.normal, -impulse.tangent, slots);
        *impulse = Impulse::default();
    }
}

/// Activates the rows with Q_c · n above the tolerance; returns true if one is new.
fn activate(
    system: &PackedSystem,
    state: &mut SolverState,
    params: &SolverParams,
    active: &mut [bool],
) -> bool {
    let mut grew = false;
    for (active, approach) in active.iter_mut().zip(approaches(system, state)) {
        if !*active && approach > params.tolerance {
            *active = true;
            grew = true;
        }
    }
    grew
}

/// Computes Q_c · n of all rows.
fn approaches(system: &PackedSystem, state: &mut SolverState) -> Vec<f64> {
    let slots = cells(&mut state.q);
    let rows = system.rows.iter().zip(&state.bias);
    rows.map(|(row, bias)| system.relative(row, *bias, slots).dot(row.normal)).collect()
}

/// Computes H p.
fn product(system: &PackedSystem, rows: &[usize], p: &[f64], q: &mut [DVec3]) -> Vec<f64> {
    q.fill(DVec3::ZERO);
    let slots = cells(q);
    for (&row, p) in rows.iter().zip(p) {
        let row = &system.rows[row];
        system.apply(row, -p * row.normal, DVec3::ZERO, slots);
    }
    rows.iter().map(|&row| approach(system, &system.rows[row], slots)).collect()
}

/// Computes Σ β q · n of a row, without its bias.
fn approach<S: Slot>(system: &PackedSystem, row: &PackedRow, q: &[S]) -> f64 {
    let terms = system.terms_of(row).iter();
    let at: DVec3 = terms.map(|t| t.weight * q[t.particle as usize].load()).sum();
    at.dot(row.normal)
}

/// Applies normal impulses and adds them to those of the rows.
fn apply(system: &PackedSystem, state: &mut SolverState, rows: &[usize], impulses: &[f64]) {
    let slots = cells(&mut state.q);
    for (&number, &normal) in rows.iter().zip(impulses) {
        let row = &system.rows[number];
        system.apply(row, normal * row.normal, DVec3::ZERO, slots);
        state.impulses[number].normal += normal;
    }
}

fn add(to: &mut [f64], factor: f64, of: &[f64]) {
    for (to, of) in to.iter_mut().zip(of) {
        *to += factor * of;
    }
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
