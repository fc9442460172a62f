//! Bounds with their directions packed into SIMD registers, four to a group.
//!
//! The last group overlaps the one before it when `S` is not a multiple of four, so that the rows
//! of projections need no padding.

use wide::f32x4;

use crate::dop::Dop;

/// Groups of four that cover 13 directions.
const MAX_GROUPS: usize = 4;

/// Returns the number of groups of four that cover `S` directions.
pub(crate) const fn groups<const S: usize>() -> usize {
    S.div_ceil(4)
}

/// Returns the direction in the first lane of group `g`.
pub(crate) const fn group_start<const S: usize>(g: usize) -> usize {
    if S < 4 {
        0
    } else if 4 * g + 4 > S {
        S - 4
    } else {
        4 * g
    }
}

/// Loads four directions of a row; with three directions the last is doubled.
#[inline(always)]
fn load<const S: usize>(row: &[f32; S], g: usize) -> f32x4 {
    match row[group_start::<S>(g)..].first_chunk::<4>() {
        Some(&four) => f32x4::new(four),
        None => f32x4::new([row[0], row[1], row[2], row[2]]),
    }
}

/// One bound, its directions in groups of four.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PackedDop {
    pub(crate) lo: [f32x4; MAX_GROUPS],
    pub(crate) hi: [f32x4; MAX_GROUPS],
}

impl PackedDop {
    pub(crate) const EMPTY: Self = Self {
        lo: [f32x4::new([f32::INFINITY; 4]); MAX_GROUPS],
        hi: [f32x4::new([f32::NEG_INFINITY; 4]); MAX_GROUPS],
    };

    /// Bounds three points, each given by its lower and its upper row.
    #[inline(always)]
    pub(crate) fn around<const S: usize>([a, b, c]: [[&[f32; S]; 2]; 3]) -> Self {
        let mut all = Self::EMPTY;
        for g in 0..groups::<S>() {
            all.lo[g] = load(a[0], g).fast_min(load(b[0], g)).fast_min(load(c[0], g));
            all.hi[g] = load(a[1], g).fast_max(load(b[1], g)).fast_max(load(c[1], g));
        }
        all
    }

    /// Grows to contain a bound given by its rows.
    #[inline(always)]
    pub(crate) fn include<const S: usize>(&mut self, lo: &[f32; S], hi: &[f32; S]) {
        for g in 0..groups::<S>() {
            self.lo[g] = self.lo[g].fast_min(load(lo, g));
            self.hi[g] = self.hi[g].fast_max(load(hi, g));
        }
    }

    /// Grows to contain a point given by its row.
    #[inline(always)]
    pub(crate) fn include_point<const S: usize>(&mut self, row: &[f32; S]) {
        for g in 0..groups::<S>() {
            let at = load(row, g);
            self.lo[g] = self.lo[g].fast_min(at);
            self.hi[g] = self.hi[g].fast_max(at);
        }
    }

    /// Grows along the axes alone to contain a bound given by its rows.
    #[inline(always)]
    pub(crate) fn include_box<const S: usize>(&mut self, lo: &[f32; S], hi: &[f32; S]) {
        self.lo[0] = self.lo[0].fast_min(load(lo, 0));
        self.hi[0] = self.hi[0].fast_max(load(hi, 0));
    }

    /// Grows to contain another bound.
    #[inline(always)]
    pub(crate) fn merge<const S: usize>(&mut self, other: &Self) {
        for g in 0..groups::<S>() {
            self.lo[g] = self.lo[g].fast_min(other.lo[g]);
            self.hi[g] = self.hi[g].fast_max(other.hi[g]);
        }
    }

    /// Returns true if the bounds overlap along every direction. Bounds that touch overlap.
    #[inline(always)]
    pub(crate) fn overlaps<const S: usize>(&self, other: &Self) -> bool {
        let mut hit = self.lo[0].simd_le(other.hi[0]) & other.lo[0].simd_le(self.hi[0]);
        for g in 1..groups::<S>() {
            hit &= self.lo[g].simd_le(other.hi[g]) & other.lo[g].simd_le(self.hi[g]);
        }
        hit.to_bitmask() == 0b1111
    }

    /// Returns true if, over a step that ends with `end` and `other_end`, neither bound is above the
    /// other at both ends along any direction.
    #[inline(always)]
    pub(crate) fn meets<const S: usize>(&self, end: &Self, other: &Self, other_end: &Self) -> bool {
        let group = |g: usize| {
            (self.lo[g].simd_le(other.hi[g]) | end.lo[g].simd_le(other_end.hi[g]))
                & (other.lo[g].simd_le(self.hi[g]) | other_end.lo[g].simd_le(end.hi[g]))
        };
        let mut hit = group(0);
        for g in 1..groups::<S>() {
            hit &= group(g);
        }
        hit.to_bitmask() == 0b1111
    }

    /// Unpacks the bound.
    pub(crate) fn to_dop<const S: usize>(self) -> Dop<S> {
        const { assert!(S <= 4 * MAX_GROUPS, "a group for every direction") };
        Dop {
            lo: std::array::from_fn(|k| self.lo[k / 4].as_array()[k - group_start::<S>(k / 4)]),
            hi: std::array::from_fn(|k| self.hi[k / 4].as_array()[k - group_start::<S>(k / 4)]),
        }
    }
}
