//! Projected Gauss–Seidel: one row after the other, batch by batch.

use super::coloring::Batch;
use super::packed::{PackedRow, PackedSystem, RowGoal, SolverState, change};
use super::slots::{Slot, cells};
use super::{Impulse, SolverParams};

/// Rows of a batch below which one thread is faster: handing work to another
/// takes some microseconds, a row 20 to 40 ns.
#[cfg(feature = "rayon")]
const PARALLEL_ROWS: usize = 1024;

/// Sweeps until no row changes by more than the tolerance; returns the sweeps.
pub(super) fn solve(system: &PackedSystem, state: &mut SolverState, params: &SolverParams) -> u32 {
    #[cfg(feature = "rayon")]
    if !surface::parallel::is_alone() && system.batches().iter().any(is_parallel) {
        return parallel::solve(system, state, params);
    }
    let SolverState { q, goals, impulses } = state;
    let slots = cells(q);
    repeat(system, impulses, goals, slots, params, |batch, impulses| {
        sweep_batch(system, batch, impulses, goals, slots)
    })
}

/// Repeats sweeps over all batches until they converge.
///
/// A sweep that changes little is checked, since a row may have been changed
/// after it was visited; one that changes nothing is the last in any case.
fn repeat<S: Slot>(
    system: &PackedSystem,
    impulses: &mut [Impulse],
    goals: &[RowGoal],
    slots: &[S],
    params: &SolverParams,
    sweep: impl Fn(&Batch, &mut [Impulse]) -> f64,
) -> u32 {
    for iteration in 1..=params.max_iterations {
        // Batches in order: rows of a later one read what earlier ones wrote.
        let mut largest = 0.0_f64;
        for batch in system.batches() {
            largest = largest.max(sweep(batch, &mut impulses[batch.start..batch.end]));
        }
        let converged = largest <= 0.0
            || (largest <= params.tolerance
                && system.residual(goals, impulses, slots).max() <= params.tolerance);
        if converged {
            return iteration;
        }
    }
    params.max_iterations
}

/// Sweeps one row of a batch after the other; returns the largest change.
fn sweep_batch<S: Slot>(
    system: &PackedSystem,
    batch: &Batch,
    impulses: &mut [Impulse],
    goals: &[RowGoal],
    slots: &[S],
) -> f64 {
    let range = batch.start..batch.end;
    let mut largest = 0.0_f64;
    for ((row, goal), impulse) in system.rows[range.clone()].iter().zip(&goals[range]).zip(impulses)
    {
        largest = largest.max(sweep(system, row, goal, impulse, slots));
    }
    largest
}

/// Relaxes one row; returns the change of its Q_c.
#[inline]
fn sweep<S: Slot>(
    system: &PackedSystem,
    row: &PackedRow,
    goal: &RowGoal,
    impulse: &mut Impulse,
    q: &[S],
) -> f64 {
    let to = system.relax(row, goal, *impulse, 1.0, q);
    let from = std::mem::replace(impulse, to);
    system.apply(row, (to.normal - from.normal) * row.normal, to.tangent - from.tangent, q);
    change(row, from, to)
}

#[cfg(feature = "rayon")]
fn is_parallel(batch: &Batch) -> bool {
    batch.independent && batch.end - batch.start >= 2 * PARALLEL_ROWS
}

#[cfg(feature = "rayon")]
mod parallel {
    use rayon::prelude::*;

    use super::super::slots::AtomicSlot;
    use super::{
        Batch, Impulse, PARALLEL_ROWS, PackedSystem, RowGoal, Slot, SolverParams, SolverState,
        is_parallel, repeat, sweep, sweep_batch,
    };

    pub(super) fn solve(
        system: &PackedSystem,
        state: &mut SolverState,
        params: &SolverParams,
    ) -> u32 {
        let SolverState { q, goals, impulses } = state;
        let slots: Vec<AtomicSlot> = q.iter().map(|&q| AtomicSlot::new(q)).collect();
        let iterations = repeat(system, impulses, goals, &slots, params, |batch, impulses| {
            sweep_parallel(system, batch, impulses, goals, &slots)
        });

        for (q, slot) in q.iter_mut().zip(&slots) {
            *q = slot.load();
        }
        iterations
    }

    fn sweep_parallel(
        system: &PackedSystem,
        batch: &Batch,
        impulses: &mut [Impulse],
        goals: &[RowGoal],
        slots: &[AtomicSlot],
    ) -> f64 {
        if !is_parallel(batch) {
            return sweep_batch(system, batch, impulses, goals, slots);
        }
        let range = batch.start..batch.end;
        let rows = system.rows[range.clone()].par_iter().zip(&goals[range]).zip(impulses);
        rows.with_min_len(PARALLEL_ROWS)
            .map(|((row, goal), impulse)| sweep(system, row, goal, impulse, slots))
            .reduce(|| 0.0, f64::max)
    }
}
