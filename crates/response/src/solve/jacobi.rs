//! Averaged Jacobi: all rows from the same state, each with its share of the
//! masses that several rows use.

use super::packed::{Packed, PackedRow, Work, change};
use super::slots::cells;
use super::{Impulse, SolverParams};

/// Repeats until no row changes by more than the tolerance.
pub(super) fn solve(packed: &Packed, work: &mut Work, params: &SolverParams) -> u32 {
    let shares = shares(packed);
    for iteration in 0..params.max_iterations {
        let largest = pass(packed, work, &shares);
        if largest <= 0.0
            || (largest <= params.tolerance && asked(packed, work) <= params.tolerance)
        {
            return iteration + 1;
        }
    }
    params.max_iterations
}

fn asked(packed: &Packed, work: &mut Work) -> f64 {
    packed.residual(&work.bias, &work.impulses, work.has_friction, cells(&mut work.q))
}

fn pass(packed: &Packed, work: &mut Work, shares: &[f64]) -> f64 {
    let Work { q, bias, impulses, has_friction } = work;
    let slots = cells(q);
    let rows = packed.rows.iter().zip(&*bias).zip(&*impulses).zip(shares);
    let asked: Vec<Impulse> = rows
        .map(|(((row, bias), impulse), share)| {
            packed.relax(row, *bias, *impulse, *has_friction, *share, slots)
        })
        .collect();
    let mut largest = 0.0_f64;
    let each = packed.rows.iter().zip(impulses).zip(asked).zip(shares);
    for (((row, impulse), asked), share) in each {
        let from = std::mem::replace(impulse, asked);
        let tangent = asked.tangent - from.tangent;
        packed.give(row, (asked.normal - from.normal) * row.normal, tangent, slots);
        // At least what the row alone would ask for.
        largest = largest.max(change(row, from, asked) / share);
    }
    largest
}

/// By how much a row's steps shrink when each of its particles counts 1/n of
/// its mass, n being the rows that use it.
fn shares(packed: &Packed) -> Vec<f64> {
    let mut users = vec![0.0_f64; packed.particle_count];
    for row in &packed.rows {
        for term in packed.terms_of(row) {
            users[term.particle as usize] += 1.0;
        }
        for particle in packed.lever_particles(row) {
            users[particle as usize] += 1.0;
        }
    }
    packed.rows.iter().map(|row| share(packed, row, &users)).collect()
}

fn share(packed: &Packed, row: &PackedRow, users: &[f64]) -> f64 {
    let mut levers = packed.lever_particles(row).peekable();
    if levers.peek().is_some() {
        let own = packed.terms_of(row).iter().map(|term| term.particle);
        return own.chain(levers).map(|k| users[k as usize]).fold(1.0, f64::max).recip();
    }
    let split: f64 = packed
        .terms_of(row)
        .iter()
        .map(|term| term.weight * term.step * users[term.particle as usize])
        .sum();
    (split * row.normal_step).recip()
}
