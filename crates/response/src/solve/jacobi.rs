//! Averaged Jacobi (mass splitting): all rows from the same state, each with its part of
//! the masses that several rows use.

use super::packed::{PackedRow, PackedSystem, SolverState, change};
use super::slots::cells;
use super::{Impulse, SolverParams};

/// Memory of a solution.
#[derive(Clone, Debug, Default)]
pub(super) struct JacobiMemory {
    /// Number of rows that use each particle.
    users: Vec<f64>,
    factors: Vec<f64>,
    relaxed: Vec<Impulse>,
}

/// Repeats until no row changes by more than the tolerance; returns the iterations.
pub(super) fn solve(
    system: &PackedSystem,
    state: &mut SolverState,
    params: &SolverParams,
    memory: &mut JacobiMemory,
) -> u32 {
    memory.set_factors(system);
    for iteration in 1..=params.max_iterations {
        let largest = iterate(system, state, memory);
        let converged = largest <= 0.0
            || (largest <= params.tolerance && state.residual(system).max() <= params.tolerance);
        if converged {
            return iteration;
        }
    }
    params.max_iterations
}

/// Relaxes all rows from the same state; returns the largest change.
fn iterate(system: &PackedSystem, state: &mut SolverState, memory: &mut JacobiMemory) -> f64 {
    let JacobiMemory { factors, relaxed, .. } = memory;
    let SolverState { q, goals, impulses } = state;
    let slots = cells(q);

    // All rows read the same state before the first one writes.
    relaxed.clear();
    for (number, row) in system.rows.iter().enumerate() {
        let (goal, impulse, factor) = (&goals[number], impulses[number], factors[number]);
        relaxed.push(system.relax(row, goal, impulse, factor, slots));
    }

    let mut largest = 0.0_f64;
    for (number, (row, &to)) in system.rows.iter().zip(&*relaxed).enumerate() {
        let from = std::mem::replace(&mut impulses[number], to);
        let tangent = to.tangent - from.tangent;
        system.apply(row, (to.normal - from.normal) * row.normal, tangent, slots);
        // At least the change that the row alone requires.
        largest = largest.max(change(row, from, to) / factors[number]);
    }
    largest
}

impl JacobiMemory {
    /// Computes the factor of each row's steps when each of its particles counts 1/n of its
    /// mass, n being the number of rows that use it.
    pub(super) fn set_factors(&mut self, system: &PackedSystem) {
        self.users.clear();
        self.users.resize(system.particle_count, 0.0);
        for row in &system.rows {
            for term in system.terms_of(row) {
                self.users[term.particle as usize] += 1.0;
            }
        }
        self.factors.clear();
        for row in &system.rows {
            self.factors.push(step_factor(system, row, &self.users));
        }
    }

    /// Returns the smallest factor. Its inverse bounds the eigenvalues of the system scaled
    /// by its diagonal.
    pub(super) fn smallest_factor(&self) -> f64 {
        self.factors.iter().copied().fold(1.0, f64::min)
    }
}

fn step_factor(system: &PackedSystem, row: &PackedRow, users: &[f64]) -> f64 {
    let mut split = 0.0;
    for term in system.terms_of(row) {
        split += term.weight * term.step * users[term.particle as usize];
    }
    (split * row.step).recip()
}
