//! Projected Gauss–Seidel: one row after the other, batch by batch.

use super::colouring::Batch;
use super::packed::{Packed, PackedRow, Work, change};
use super::slots::{Slot, cells};
use super::{Impulse, SolverParams};
use glam::DVec3;

/// Rows of a batch below which one thread is faster: handing work to another
/// takes some microseconds, a row 20 to 40 ns.
#[cfg(feature = "rayon")]
const PARALLEL_ROWS: usize = 1024;

/// Sweeps until no row changes by more than the tolerance; returns the sweeps.
pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
    #[cfg(feature = "rayon")]
    if packed.batches.iter().any(is_parallel) {
        return parallel::solve(packed, work, params);
    }
    let Work { q, bias, impulses, rubs } = work;
    let slots = cells(q);
    repeat(packed, params, |batch| {
        let range = batch.start..batch.end;
        let rows = packed.rows[range.clone()].iter().zip(&bias[range.clone()]);
        let each = rows.zip(&mut impulses[range]);
        each.map(|((row, bias), impulse)| sweep(packed, row, *bias, impulse, *rubs, slots))
            .fold(0.0, f64::max)
    })
}

fn repeat(packed: &Packed, params: &SolverParams, mut sweep: impl FnMut(&Batch) -> f64) -> u32 {
    for iteration in 0..params.max_iterations {
        let largest = packed.batches.iter().map(&mut sweep).fold(0.0, f64::max);
        if largest <= params.tolerance {
            return iteration + 1;
        }
    }
    params.max_iterations
}

/// Brings one row to what it asks for; returns the change of its Q_c.
#[inline]
fn sweep<S: Slot>(
    packed: &Packed,
    row: &PackedRow,
    bias: DVec3,
    impulse: &mut Impulse,
    rubs: bool,
    q: &[S],
) -> f64 {
    let asked = packed.relax(row, bias, *impulse, rubs, 1.0, q);
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
    use super::{PARALLEL_ROWS, Packed, Slot, SolverParams, Work, is_parallel, repeat, sweep};

    pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
        let Work { q, bias, impulses, rubs } = work;
        let slots: Vec<AtomicSlot> = q.iter().map(|&q| AtomicSlot::new(q)).collect();
        let iterations = repeat(packed, params, |batch| {
            let range = batch.start..batch.end;
            let (rows, bias) = (&packed.rows[range.clone()], &bias[range.clone()]);
            let impulses = &mut impulses[range];
            if is_parallel(batch) {
                let each = rows.par_iter().zip(bias).zip(impulses).with_min_len(PARALLEL_ROWS);
                each.map(|((row, bias), impulse)| sweep(packed, row, *bias, impulse, *rubs, &slots))
                    .reduce(|| 0.0, f64::max)
            } else {
                let each = rows.iter().zip(bias).zip(impulses);
                each.map(|((row, bias), impulse)| sweep(packed, row, *bias, impulse, *rubs, &slots))
                    .fold(0.0, f64::max)
            }
        });
        for (q, slot) in q.iter_mut().zip(&slots) {
            *q = slot.load();
        }
        iterations
    }
}
