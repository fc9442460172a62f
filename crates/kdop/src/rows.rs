//! A tree's points, projected: one row of `S` numbers a point, rounded once to f32.
//!
//! Rows are read four directions at a time. The last four overlap those before when `S` is no
//! multiple of four, so rows need no padding.

use wide::f32x4;

use crate::directions::project;
use crate::extents::Extents;

/// Groups of four that cover 13 directions.
pub(crate) const MAX_GROUPS: usize = 4;

/// Groups of four that cover `S` directions.
pub(crate) const fn groups<const S: usize>() -> usize {
    S.div_ceil(4)
}

/// Direction in the first lane of group `g`.
pub(crate) const fn group_start<const S: usize>(g: usize) -> usize {
    if S < 4 {
        0
    } else if 4 * g + 4 > S {
        S - 4
    } else {
        4 * g
    }
}

/// Four directions of a row; with three directions the last is doubled.
#[inline(always)]
pub(crate) fn load<const S: usize>(row: &[f32; S], g: usize) -> f32x4 {
    match row[group_start::<S>(g)..].first_chunk::<4>() {
        Some(&four) => f32x4::new(four),
        None => f32x4::new([row[0], row[1], row[2], row[2]]),
    }
}

/// A bound with its directions packed in groups of four.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packed {
    pub(crate) lo: [f32x4; MAX_GROUPS],
    pub(crate) hi: [f32x4; MAX_GROUPS],
}

impl Packed {
    pub(crate) const EMPTY: Self = Self {
        lo: [f32x4::new([f32::INFINITY; 4]); MAX_GROUPS],
        hi: [f32x4::new([f32::NEG_INFINITY; 4]); MAX_GROUPS],
    };

    #[inline(always)]
    pub(crate) fn include<const S: usize>(&mut self, lo: &[f32; S], hi: &[f32; S]) {
        for g in 0..groups::<S>() {
            self.lo[g] = self.lo[g].fast_min(load(lo, g));
            self.hi[g] = self.hi[g].fast_max(load(hi, g));
        }
    }

    /// Grows to hold another bound.
    #[inline(always)]
    pub(crate) fn merge<const S: usize>(&mut self, other: &Self) {
        for g in 0..groups::<S>() {
            self.lo[g] = self.lo[g].fast_min(other.lo[g]);
            self.hi[g] = self.hi[g].fast_max(other.hi[g]);
        }
    }

    /// Whether two bounds overlap along every direction; touching counts.
    #[inline(always)]
    pub(crate) fn overlaps<const S: usize>(&self, other: &Self) -> bool {
        let mut hit = self.lo[0].simd_le(other.hi[0]) & other.lo[0].simd_le(self.hi[0]);
        for g in 1..groups::<S>() {
            hit &= self.lo[g].simd_le(other.hi[g]) & other.lo[g].simd_le(self.hi[g]);
        }
        hit.to_bitmask() == 0b1111
    }
}

/// The projected points of a tree.
#[derive(Clone, Debug)]
pub(crate) struct Rows<const S: usize> {
    lo: Vec<[f32; S]>,
    /// Empty where upper and lower bounds are the same: points at rest.
    hi: Vec<[f32; S]>,
}

impl<const S: usize> Rows<S> {
    pub(crate) const fn new() -> Self {
        Self { lo: Vec::new(), hi: Vec::new() }
    }

    pub(crate) const fn len(&self) -> usize {
        self.lo.len()
    }

    #[inline(always)]
    pub(crate) fn lo(&self) -> &[[f32; S]] {
        &self.lo
    }

    #[inline(always)]
    pub(crate) fn hi(&self) -> &[[f32; S]] {
        if self.hi.is_empty() { &self.lo } else { &self.hi }
    }

    pub(crate) const fn bytes(&self) -> usize {
        (self.lo.capacity() + self.hi.capacity()) * size_of::<[f32; S]>()
    }

    /// Replaces all rows. Allocates only where there were fewer.
    pub(crate) fn fill(&mut self, extents: &Extents<'_>) {
        self.resize(extents);
        fill(extents, &mut self.lo, &mut self.hi);
    }

    /// As [`fill`](Self::fill), in parts on the threads of the current pool.
    #[cfg(feature = "rayon")]
    pub(crate) fn par_fill(&mut self, extents: &Extents<'_>) {
        use rayon::prelude::*;
        /// Points of a task: some ten microseconds of work.
        const PART: usize = 4096;
        self.resize(extents);
        let part = |i: usize| extents.part(i * PART..extents.len().min((i + 1) * PART));
        if self.hi.is_empty() {
            let parts = self.lo.par_chunks_mut(PART).enumerate();
            parts.for_each(|(i, lo)| fill(&part(i), lo, &mut []));
        } else {
            let parts = self.lo.par_chunks_mut(PART).zip(self.hi.par_chunks_mut(PART)).enumerate();
            parts.for_each(|(i, (lo, hi))| fill(&part(i), lo, hi));
        }
    }

    fn resize(&mut self, extents: &Extents<'_>) {
        let exact = extents.exact_points::<S>().is_some();
        self.lo.resize(extents.len(), [0.0; S]);
        self.hi.resize(if exact { 0 } else { extents.len() }, [0.0; S]);
    }
}

/// Writes the rows of some points; upper ones only where they differ.
fn fill<const S: usize>(extents: &Extents<'_>, lo: &mut [[f32; S]], hi: &mut [[f32; S]]) {
    if let Some(points) = extents.exact_points::<S>() {
        for (row, &point) in lo.iter_mut().zip(points) {
            *row = round(project(point));
        }
        return;
    }
    let mut rows = lo.iter_mut().zip(hi);
    extents.for_each::<S>(|below, above| {
        if let Some((lo, hi)) = rows.next() {
            *lo = round(below);
            *hi = round(above);
        }
    });
}

#[inline(always)]
fn round<const S: usize>(row: [f64; S]) -> [f32; S] {
    row.map(to_nearest)
}

/// The one rounding from f64: to nearest, hence monotone; beyond the range of f32 to infinity.
#[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is what is wanted")]
#[inline(always)]
pub(crate) const fn to_nearest(value: f64) -> f32 {
    value as f32
}
