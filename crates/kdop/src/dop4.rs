//! Four k-DOPs side by side, one per SIMD lane, and their overlap tests.

use glam::DVec3;
use wide::f32x4;

use crate::directions::norm;
use crate::dop::Dop;
use crate::packed::{PackedDop, group_start, groups};
use crate::projections::to_nearest;

/// The bounds of up to four children or leaves: lane `i` of every vector is child `i`.
///
/// A lane without a child holds [`Dop::EMPTY`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dop4<const S: usize> {
    lo: [f32x4; S],
    hi: [f32x4; S],
}

/// One bound in all four lanes, to be tested against a [`Dop4`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplatDop<const S: usize> {
    lo: [f32x4; S],
    hi: [f32x4; S],
}

impl<const S: usize> SplatDop<S> {
    /// Copies a bound to all lanes.
    pub(crate) fn new(bound: &Dop<S>) -> Self {
        Self { lo: bound.lo.map(f32x4::splat), hi: bound.hi.map(f32x4::splat) }
    }
}

impl<const S: usize> Dop4<S> {
    pub(crate) const EMPTY: Self = Self {
        lo: [f32x4::new([f32::INFINITY; 4]); S],
        hi: [f32x4::new([f32::NEG_INFINITY; 4]); S],
    };

    /// Returns four bounds by their rows, one per direction.
    #[inline(always)]
    pub(crate) const fn from_rows(lo: [f32x4; S], hi: [f32x4; S]) -> Self {
        Self { lo, hi }
    }

    /// Sets the bounds of all lanes.
    #[inline(always)]
    pub(crate) fn set(&mut self, [a, b, c, d]: &[PackedDop; 4]) {
        for g in 0..groups::<S>() {
            let start = group_start::<S>(g);
            let lo = f32x4::transpose([a.lo[g], b.lo[g], c.lo[g], d.lo[g]]);
            let hi = f32x4::transpose([a.hi[g], b.hi[g], c.hi[g], d.hi[g]]);
            for lane in 0..4 {
                // The last group overlaps the one before; with three directions a lane is spare.
                let k = start + lane;
                if 4 * g <= k && k < S {
                    self.lo[k] = lo[lane];
                    self.hi[k] = hi[lane];
                }
            }
        }
    }

    /// Returns the union of the four bounds.
    #[inline(always)]
    pub(crate) fn union(&self) -> PackedDop {
        let mut all = PackedDop::EMPTY;
        for g in 0..groups::<S>() {
            let start = group_start::<S>(g);
            // Transposed, registers hold one child each, and their minimum is the union.
            let [i, j, k, l] = [start, start + 1, start + 2, (start + 3).min(S - 1)];
            let lo = f32x4::transpose([self.lo[i], self.lo[j], self.lo[k], self.lo[l]]);
            let hi = f32x4::transpose([self.hi[i], self.hi[j], self.hi[k], self.hi[l]]);
            all.lo[g] = lo[0].fast_min(lo[1]).fast_min(lo[2].fast_min(lo[3]));
            all.hi[g] = hi[0].fast_max(hi[1]).fast_max(hi[2].fast_max(hi[3]));
        }
        all
    }

    /// Returns the bound in one lane.
    pub(crate) fn lane(&self, lane: usize) -> Dop<S> {
        Dop {
            lo: self.lo.map(|row| row.as_array()[lane]),
            hi: self.hi.map(|row| row.as_array()[lane]),
        }
    }

    /// Returns the lower and upper corner of the axis-aligned box in one lane.
    #[inline(always)]
    pub(crate) fn lane_box(&self, lane: usize) -> [DVec3; 2] {
        let corner = |rows: &[f32x4; S]| {
            let [x, y, z] = [0, 1, 2].map(|k| f64::from(rows[k].as_array()[lane]));
            DVec3::new(x, y, z)
        };
        [corner(&self.lo), corner(&self.hi)]
    }

    /// Copies the bound in one lane to all lanes.
    #[inline(always)]
    pub(crate) fn splat(&self, lane: usize) -> SplatDop<S> {
        let spread = |row: f32x4| f32x4::splat(row.as_array()[lane]);
        SplatDop { lo: self.lo.map(spread), hi: self.hi.map(spread) }
    }

    /// Returns the lower bounds along direction `k`, one per lane.
    #[inline(always)]
    pub(crate) fn lower(&self, k: usize) -> f32x4 {
        self.lo[k]
    }

    /// Returns the upper bounds along direction `k`, one per lane.
    #[inline(always)]
    pub(crate) fn upper(&self, k: usize) -> f32x4 {
        self.hi[k]
    }

    /// Returns the greatest extents of the four bounds as lengths: 0 for an empty one, and beyond the
    /// range of f32.
    #[inline(always)]
    pub(crate) fn widths(&self) -> [f32; 4] {
        let mut widths = f32x4::ZERO;
        for k in 0..S {
            // An empty lane has an extent of −∞.
            let extent = self.hi[k] - self.lo[k];
            widths = widths.fast_max(extent * f32x4::splat(to_nearest(norm::<S>(k).recip())));
        }
        widths.to_array().map(|width| if width.is_finite() { width } else { 0.0 })
    }

    /// Returns all four bounds moved outward by `margin[k]` along direction `k`.
    ///
    /// A bound beyond the range of f32 may stand for any larger number, so it counts as the
    /// largest.
    #[inline(always)]
    pub(crate) fn widened(&self, margin: &[f32; S]) -> Self {
        let (min, max) = (f32x4::splat(-f32::MAX), f32x4::splat(f32::MAX));
        Self {
            lo: std::array::from_fn(|k| self.lo[k].fast_min(max) - f32x4::splat(margin[k])),
            hi: std::array::from_fn(|k| self.hi[k].fast_max(min) + f32x4::splat(margin[k])),
        }
    }

    /// Tests four bounds against one: bit `i` is set where lane `i` overlaps it.
    #[inline(always)]
    pub(crate) fn overlaps_one(&self, one: &SplatDop<S>) -> u32 {
        let axis = |k: usize| self.lo[k].simd_le(one.hi[k]) & one.lo[k].simd_le(self.hi[k]);
        // Most bounds that do not overlap are apart along one of the axes.
        let mut hit = axis(0) & axis(1) & axis(2);
        if S > 3 && !hit.any() {
            return 0;
        }
        for k in 3..S {
            hit &= axis(k);
        }
        hit.to_bitmask()
    }

    /// Tests four bounds against four: bit `4 i + j` is set where lane `i` of this overlaps lane
    /// `j` of the other, among the pairs whose bits are given.
    #[inline(always)]
    pub(crate) fn overlaps(&self, other: &Self, pairs: u32) -> u32 {
        let mut hits = pairs;
        for first in (0..S).step_by(DIRECTIONS_AT_ONCE) {
            let mut turns = [0, 1, 2, 3].map(|by| self.turned_overlap(other, by, first));
            for k in first + 1..S.min(first + DIRECTIONS_AT_ONCE) {
                for (by, turn) in turns.iter_mut().enumerate() {
                    *turn &= self.turned_overlap(other, by, k);
                }
            }

            // Most bounds that do not overlap are apart along one of the axes.
            hits &= pairs_of_turns(turns);
            if hits == 0 {
                break;
            }
        }
        hits
    }

    /// Compares each lane of bounds at both ends of a step with the other's lane `BY` places after it
    /// along direction `k`: neither is above the other at both ends.
    #[inline(always)]
    pub(crate) fn turned_meet<const BY: usize>(a: [&Self; 2], b: [&Self; 2], k: usize) -> f32x4 {
        let ([a0, a1], [b0, b1]) = (a, b);
        (a0.lo[k].simd_le(turned(b0.hi[k], BY)) | a1.lo[k].simd_le(turned(b1.hi[k], BY)))
            & (turned(b0.lo[k], BY).simd_le(a0.hi[k]) | turned(b1.lo[k], BY).simd_le(a1.hi[k]))
    }

    /// Compares bounds at both ends of a step with one along direction `k`, as
    /// [`turned_meet`](Self::turned_meet).
    #[inline(always)]
    pub(crate) fn lanes_meet(four: [&Self; 2], one: &[SplatDop<S>; 2], k: usize) -> f32x4 {
        let [a0, a1] = four;
        let [b0, b1] = one;
        (a0.lo[k].simd_le(b0.hi[k]) | a1.lo[k].simd_le(b1.hi[k]))
            & (b0.lo[k].simd_le(a0.hi[k]) | b1.lo[k].simd_le(a1.hi[k]))
    }

    /// Compares each lane with the other's lane `by` places after it along direction `k`.
    ///
    /// Lanes are turned in a register, which takes less than to spread each over one of its own.
    #[inline(always)]
    fn turned_overlap(&self, other: &Self, by: usize, k: usize) -> f32x4 {
        let [lo, hi] = [other.lo[k], other.hi[k]].map(|row| turned(row, by));
        self.lo[k].simd_le(hi) & lo.simd_le(self.hi[k])
    }
}

/// Returns the lanes of a row, each moved by some places.
#[inline(always)]
fn turned(row: f32x4, by: usize) -> f32x4 {
    let [a, b, c, d] = row.to_array();
    f32x4::new(match by {
        0 => [a, b, c, d],
        1 => [b, c, d, a],
        2 => [c, d, a, b],
        _ => [d, a, b, c],
    })
}

/// Returns the bits of [`Dop4::overlaps`] of four comparisons, each with lanes one more place after.
#[inline(always)]
pub(crate) fn pairs_of_turns(turns: [f32x4; 4]) -> u32 {
    let mut found = 0;
    for (turn, pairs) in turns.into_iter().zip(&TURNED_PAIRS) {
        found |= pairs[turn.to_bitmask() as usize & 15];
    }
    u32::from(found)
}

/// The bits of [`Dop4::overlaps`] by those of four lanes with lanes so many places after them.
const TURNED_PAIRS: [[u16; 16]; 4] = {
    let mut pairs = [[0; 16]; 4];
    let mut bit = 0;
    while bit < 4 * 16 * 4 {
        let (by, lanes, lane) = (bit / 64, bit / 4 % 16, bit % 4);
        if lanes >> lane & 1 == 1 {
            pairs[by][lanes] |= 1 << (4 * lane + (lane + by) % 4);
        }
        bit += 1;
    }
    pairs
};

/// Directions that are tested before the first look at what is left: the axes.
const DIRECTIONS_AT_ONCE: usize = 3;

/// All bits of [`Dop4::overlaps`].
pub(crate) const ALL_PAIRS: u32 = 0xffff;

/// The bits of [`Dop4::overlaps`] with `i < j`.
pub(crate) const ABOVE_DIAGONAL: u32 = 0b0000_1000_1100_1110;

/// The bits of [`Dop4::overlaps`] with `i <= j`.
pub(crate) const ON_OR_ABOVE_DIAGONAL: u32 = 0b1000_1100_1110_1111;

/// Returns the positions of the bits that are set, ascending.
#[inline(always)]
pub(crate) fn set_bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = (mask != 0).then(|| mask.trailing_zeros() as usize)?;
        mask &= mask - 1;
        Some(lowest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes<const S: usize>(seed: u32) -> [Dop<S>; 4] {
        std::array::from_fn(|i| {
            let hash = (seed * 4 + u32::try_from(i).unwrap()).wrapping_mul(2_654_435_761);
            let at = |shift: u32| f64::from((hash >> shift) % 64) / 16.0;
            let corner = DVec3::new(at(4), at(12), at(20));
            Dop::from_points(&[corner, corner + DVec3::new(1.0, 0.5, 1.5)])
        })
    }

    fn side_by_side<const S: usize>(dops: &[Dop<S>; 4]) -> Dop4<S> {
        let mut four = Dop4::EMPTY;
        four.set(&dops.map(|dop| {
            let mut packed = PackedDop::EMPTY;
            packed.include(&dop.lo, &dop.hi);
            packed
        }));
        four
    }

    /// Compares the lanes with the reference implementation, bound by bound.
    fn lanes_agree<const S: usize>() {
        // An interpreter that looks for undefined behavior takes a thousand times longer.
        let seeds = if cfg!(miri) { 2 } else { 200 };
        for seed in 0..seeds {
            let (a, b) = (boxes::<S>(seed), boxes::<S>(seed + 1000));
            let (four_a, four_b) = (side_by_side(&a), side_by_side(&b));
            let mask = four_a.overlaps(&four_b, ALL_PAIRS);
            let some = seed.wrapping_mul(2_654_435_761) >> 16;
            assert_eq!(four_a.overlaps(&four_b, some), mask & some, "among {some:b}");
            for (i, one) in a.iter().enumerate() {
                assert_eq!(four_a.lane(i), *one, "lane {i}");
                let row = four_b.overlaps_one(&SplatDop::new(one));
                assert_eq!(row, mask >> (4 * i) & 15, "row {i}");
                for (j, other) in b.iter().enumerate() {
                    assert_eq!(row >> j & 1 == 1, one.overlaps(other), "pair {i} {j}");
                }
            }
            let union = a.iter().fold(Dop::EMPTY, |all, dop| all.union(dop));
            for (width, dop) in four_a.widths().into_iter().zip(&a) {
                assert!((f64::from(width) - dop.widest().1).abs() < 1e-6, "{width} of {dop:?}");
            }
            assert_eq!(four_a.union().to_dop(), union, "union");
            let other = b.iter().fold(Dop::EMPTY, |all, dop| all.union(dop));
            let packed = four_a.union().overlaps::<S>(&four_b.union());
            assert_eq!(packed, union.overlaps(&other), "packed");
        }
    }

    #[test]
    fn bounds_of_nothing_and_beyond_all_range_have_no_width() {
        let far = Dop::<9>::from_points(&[DVec3::ZERO, DVec3::splat(1e300)]);
        for bounds in [Dop4::<9>::EMPTY, side_by_side(&[far; 4])] {
            assert!(bounds.widths().iter().all(|&width| width <= 0.0), "{bounds:?}");
        }
    }

    #[test]
    fn lanes_agree_with_single_bounds() {
        lanes_agree::<3>();
        lanes_agree::<7>();
        lanes_agree::<9>();
        lanes_agree::<13>();
    }
}
