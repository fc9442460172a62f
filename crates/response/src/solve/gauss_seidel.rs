//! Projected Gauss–Seidel: one row after the other, batch by batch.

use super::coloring::Batch;
use super::packed::{Packed, PackedRow, Work, change};
use super::slots::{Slot, cells};
use super::{Impulse, SolverParams};
use glam::DVec3;

/// Rows of a batch below which one thread is faster: handing work to another
/// takes some microseconds, a row 20 to 40 ns.
#[cfg(feature = "rayon")]
const PARALLEL_ROWS: usize = 1024;

/// Sweeps until no row asks for more than the tolerance; returns the sweeps.
pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
    #[cfg(feature = "rayon")]
    if packed.batches.iter().any(is_parallel) {
        return parallel::solve(packed, work, params);
    }
    let Work { q, bias, impulses, has_friction } = work;
    let slots = cells(q);
    repeat(packed, impulses, bias, *has_friction, slots, params, |batch, impulses| {
        sweep_batch(packed, batch, impulses, bias, *has_friction, slots)
    })
}

/// A sweep that changes little is checked, since a row may have been changed
/// after it was visited; one that changes nothing is the last in any case.
fn repeat<S: Slot>(
    packed: &Packed,
    impulses: &mut [Impulse],
    bias: &[DVec3],
    has_friction: bool,
    slots: &[S],
    params: &SolverParams,
    sweep: impl Fn(&Batch, &mut [Impulse]) -> f64,
) -> u32 {
    for iteration in 1..=params.max_iterations {
        let mut largest = 0.0_f64;
        for batch in &packed.batches {
            largest = largest.max(sweep(batch, &mut impulses[batch.start..batch.end]));
        }
        let asked = || packed.residual(bias, impulses, has_friction, slots);
        if largest <= 0.0 || (largest <= params.tolerance && asked() <= params.tolerance) {
            return iteration;
        }
    }
    params.max_iterations
}

/// Sweeps one row of a batch after the other; returns the largest change.
fn sweep_batch<S: Slot>(
    packed: &Packed,
    batch: &Batch,
    impulses: &mut [Impulse],
    bias: &[DVec3],
    has_friction: bool,
    slots: &[S],
) -> f64 {
    let range = batch.start..batch.end;
    let rows = packed.rows[range.clone()].iter().zip(&bias[range]).zip(impulses);
    rows.map(|((row, bias), impulse)| sweep(packed, row, *bias, impulse, has_friction, slots))
        .fold(0.0, f64::max)
}

/// Brings one row to what it asks for; returns the change of its Q_c.
#[inline]
fn sweep<S: Slot>(
    packed: &Packed,
    row: &PackedRow,
    bias: DVec3,
    impulse: &mut Impulse,
    has_friction: bool,
    q: &[S],
) -> f64 {
    let asked = packed.relax(row, bias, *impulse, has_friction, 1.0, q);
    let from = std::mem::replace(impulse, asked);
    let tangent = asked.tangent - from.tangent;
    packed.give(row, (asked.normal - from.normal) * row.normal, tangent, q);
    change(row, from, asked)
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
        PARALLEL_ROWS, Packed, Slot, SolverParams, Work, is_parallel, repeat, sweep, sweep_batch,
    };

    pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
        let Work { q, bias, impulses, has_friction } = work;
        let slots: Vec<AtomicSlot> = q.iter().map(|&q| AtomicSlot::new(q)).collect();
        let iterations =
            repeat(packed, impulses, bias, *has_friction, &slots, params, |batch, impulses| {
                if !is_parallel(batch) {
                    return sweep_batch(packed, batch, impulses, bias, *has_friction, &slots);
                }
                let range = batch.start..batch.end;
                let rows = packed.rows[range.clone()].par_iter().zip(&bias[range]).zip(impulses);
                rows.with_min_len(PARALLEL_ROWS)
                    .map(|((row, bias), impulse)| {
                        sweep(packed, row, *bias, impulse, *has_friction, &slots)
                    })
                    .reduce(|| 0.0, f64::max)
            });
        for (q, slot) in q.iter_mut().zip(&slots) {
            *q = slot.load();
        }
        iterations
    }
}
