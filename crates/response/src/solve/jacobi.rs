//! Averaged Jacobi (mass splitting): all rows from the same state, each with its part of
//! the masses that several rows use.

use super::packed::{PackedRow, PackedSystem, SolverState, change};
use super::slots::cells;
use super::{Impulse, SolverParams};

/// Repeats until no row changes by more than the tolerance; returns the iterations.
pub(super) fn solve(system: &PackedSystem, state: &mut SolverState, params: &SolverParams) -> u32 {
    let factors = step_factors(system);
    for iteration in 1..=params.max_iterations {
        let largest = iterate(system, state, &factors);
        let converged = largest <= 0.0
            || (largest <= params.tolerance && system.residual(state) <= params.tolerance);
        if converged {
            return iteration;
        }
    }
    params.max_iterations
}

/// Relaxes all rows from the same state; returns the largest change.
fn iterate(system: &PackedSystem, state: &mut SolverState, factors: &[f64]) -> f64 {
    let SolverState { q, bias, impulses } = state;
    let slots = cells(q);

    // All rows read the same state before the first one writes.
    let mut relaxed: Vec<Impulse> = Vec::with_capacity(system.rows.len());
    for (number, row) in system.rows.iter().enumerate() {
        let (bias, impulse, factor) = (bias[number], impulses[number], factors[number]);
        relaxed.push(system.relax(row, bias, impulse, factor, slots));
    }

    let mut largest = 0.0_f64;
    for (number, (row, to)) in system.rows.iter().zip(relaxed).enumerate() {
        let from = std::mem::replace(&mut impulses[number], to);
        let tangent = to.tangent - from.tangent;
        system.apply(row, (to.normal - from.normal) * row.normal, tangent, slots);
        // At least the change that the row alone requires.
        largest = largest.max(change(row, from, to) / factors[number]);
    }
    largest
}

/// Computes the factor of each row's steps when each of its particles counts 1/n of its
/// mass, n being the number of rows that use it.
fn step_factors(system: &PackedSystem) -> Vec<f64> {
    let mut users = vec![0.0_f64; system.particle_count];
    for row in &system.rows {
        for term in system.terms_of(row) {
            users[term.particle as usize] += 1.0;
        }
    }
    system.rows.iter().map(|row| step_factor(system, row, &users)).collect()
}

fn step_factor(system: &PackedSystem, row: &PackedRow, users: &[f64]) -> f64 {
    let mut split = 0.0;
    for term in system.terms_of(row) {
        split += term.weight * term.step * users[term.particle as usize];
    }
    (split * row.step).recip()
}
