//! Four bounds side by side, one a lane, and how they are tested.

use glam::DVec3;
use wide::f32x4;

use crate::dop::Dop;
use crate::rows::{MAX_GROUPS, Packed, group_start, groups};

/// The bounds of up to four children or leaves; lane `i` of every vector is child `i`. A lane
/// without a child is [`Dop::EMPTY`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quad<const S: usize> {
    lo: [f32x4; S],
    hi: [f32x4; S],
}

/// One bound in all four lanes, to be tested against a [`Quad`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat<const S: usize> {
    lo: [f32x4; S],
    hi: [f32x4; S],
}

impl<const S: usize> Splat<S> {
    pub(crate) fn new(bound: &Dop<S>) -> Self {
        Self { lo: bound.lo.map(f32x4::splat), hi: bound.hi.map(f32x4::splat) }
    }
}

impl<const S: usize> Quad<S> {
    pub(crate) const EMPTY: Self = Self {
        lo: [f32x4::new([f32::INFINITY; 4]); S],
        hi: [f32x4::new([f32::NEG_INFINITY; 4]); S],
    };

    /// Sets bounds side by side.
    #[inline(always)]
    pub(crate) fn set(&mut self, [a, b, c, d]: &[Packed; 4]) {
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

    /// The union of the four, packed.
    #[inline(always)]
    pub(crate) fn enclosing(&self) -> Packed {
        let mut all = Packed::EMPTY;
        for g in 0..groups::<S>() {
            let start = group_start::<S>(g);
            let [i, j, k, l] = [start, start + 1, start + 2, (start + 3).min(S - 1)];
            let lo = f32x4::transpose([self.lo[i], self.lo[j], self.lo[k], self.lo[l]]);
            let hi = f32x4::transpose([self.hi[i], self.hi[j], self.hi[k], self.hi[l]]);
            all.lo[g] = lo[0].fast_min(lo[1]).fast_min(lo[2].fast_min(lo[3]));
            all.hi[g] = hi[0].fast_max(hi[1]).fast_max(hi[2].fast_max(hi[3]));
        }
        all
    }

    /// The bound in one lane.
    pub(crate) fn lane(&self, lane: usize) -> Dop<S> {
        Dop {
            lo: self.lo.map(|row| row.as_array()[lane]),
            hi: self.hi.map(|row| row.as_array()[lane]),
        }
    }

    /// Lowest and highest corner of the axis-aligned box in one lane.
    #[inline(always)]
    pub(crate) fn lane_box(&self, lane: usize) -> [DVec3; 2] {
        [self.lo, self.hi]
            .map(|rows| DVec3::from_array([0, 1, 2].map(|k| rows[k].as_array()[lane].into())))
    }

    /// The bound in one lane, in all lanes.
    #[inline(always)]
    pub(crate) fn splat(&self, lane: usize) -> Splat<S> {
        let spread = |row: f32x4| f32x4::splat(row.as_array()[lane]);
        Splat { lo: self.lo.map(spread), hi: self.hi.map(spread) }
    }

    /// The lanes of lower and upper bounds along direction `k`.
    #[inline(always)]
    pub(crate) fn interval(&self, k: usize) -> [f32x4; 2] {
        [self.lo[k], self.hi[k]]
    }

    /// All four bounds moved outward by `margin[k]` along direction `k`. One beyond the range of
    /// f32 may stand for any larger number, so it counts as the largest.
    #[inline(always)]
    pub(crate) fn widened(&self, margin: &[f32; S]) -> Self {
        let (least, greatest) = (f32x4::splat(-f32::MAX), f32x4::splat(f32::MAX));
        let lo = |k: usize| self.lo[k].fast_min(greatest) - f32x4::splat(margin[k]);
        let hi = |k: usize| self.hi[k].fast_max(least) + f32x4::splat(margin[k]);
        Self { lo: std::array::from_fn(lo), hi: std::array::from_fn(hi) }
    }

    /// Which lanes overlap one bound: bit `i` for lane `i`.
    #[inline(always)]
    pub(crate) fn overlaps_one(&self, one: &Splat<S>) -> u32 {
        let axis = |k: usize| self.lo[k].simd_le(one.hi[k]) & one.lo[k].simd_le(self.hi[k]);
        let mut hit = axis(0) & axis(1) & axis(2);
        if S > 3 && !hit.any() {
            return 0;
        }
        for k in 3..S {
            hit &= axis(k);
        }
        hit.to_bitmask()
    }

    /// Which of the sixteen pairs overlap: bit `4 i + j` for lane `i` of this and `j` of the other.
    ///
    /// The axes are tested first: most quads that miss each other are apart along one of them.
    #[inline(always)]
    pub(crate) fn overlaps(&self, other: &Self) -> u32 {
        let mut hits = [self.row_overlap(other, 0, 0); 4];
        for (i, hit) in hits.iter_mut().enumerate() {
            *hit = self.row_overlap(other, i, 0)
                & self.row_overlap(other, i, 1)
                & self.row_overlap(other, i, 2);
        }
        if S > 3 {
            if !(hits[0] | hits[1] | hits[2] | hits[3]).any() {
                return 0;
            }
            for k in 3..S {
                for (i, hit) in hits.iter_mut().enumerate() {
                    *hit &= self.row_overlap(other, i, k);
                }
            }
        }
        let [a, b, c, d] = hits.map(|hit| hit.to_bitmask());
        a | b << 4 | c << 8 | d << 12
    }

    /// Overlap of lane `i` with the other's four lanes along direction `k`.
    #[inline(always)]
    fn row_overlap(&self, other: &Self, i: usize, k: usize) -> f32x4 {
        let lo = f32x4::splat(self.lo[k].as_array()[i]);
        let hi = f32x4::splat(self.hi[k].as_array()[i]);
        lo.simd_le(other.hi[k]) & other.lo[k].simd_le(hi)
    }
}

/// The bits of [`Quad::overlaps`] with `i < j`, and those with `i <= j`.
pub(crate) const BELOW_DIAGONAL: u32 = 0b0000_1000_1100_1110;
/// See [`BELOW_DIAGONAL`].
pub(crate) const BELOW_OR_ON_DIAGONAL: u32 = 0b1000_1100_1110_1111;

impl Packed {
    /// The packed bound as it is named outside.
    pub(crate) fn to_dop<const S: usize>(self) -> Dop<S> {
        const { assert!(S <= 4 * MAX_GROUPS, "a group for every direction") };
        let at = |rows: &[f32x4; MAX_GROUPS], k: usize| {
            let g = k / 4;
            rows[g].as_array()[k - group_start::<S>(g)]
        };
        Dop {
            lo: std::array::from_fn(|k| at(&self.lo, k)),
            hi: std::array::from_fn(|k| at(&self.hi, k)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn boxes<const S: usize>(seed: u32) -> [Dop<S>; 4] {
        std::array::from_fn(|i| {
            let hash = (seed * 4 + u32::try_from(i).unwrap()).wrapping_mul(2_654_435_761);
            let at = |shift: u32| f64::from((hash >> shift) % 64) / 16.0;
            let corner = DVec3::new(at(4), at(12), at(20));
            Dop::from_points(&[corner, corner + DVec3::new(1.0, 0.5, 1.5)])
        })
    }

    fn quad<const S: usize>(dops: &[Dop<S>; 4]) -> Quad<S> {
        let mut quad = Quad::EMPTY;
        quad.set(&dops.map(|dop| {
            let mut packed = Packed::EMPTY;
            packed.include(&dop.lo, &dop.hi);
            packed
        }));
        quad
    }

    /// The lanes against their slow twin, bound by bound.
    fn agrees<const S: usize>() {
        for seed in 0..200 {
            let (a, b) = (boxes::<S>(seed), boxes::<S>(seed + 1000));
            let (qa, qb) = (quad(&a), quad(&b));
            let mask = qa.overlaps(&qb);
            for (i, one) in a.iter().enumerate() {
                assert_eq!(qa.lane(i), *one, "lane {i}");
                let row = qb.overlaps_one(&Splat::new(one));
                assert_eq!(row, mask >> (4 * i) & 15, "row {i}");
                for (j, other) in b.iter().enumerate() {
                    assert_eq!(row >> j & 1 == 1, one.overlaps(other), "pair {i} {j}");
                }
            }
            let union = a.iter().fold(Dop::EMPTY, |all, dop| all.union(dop));
            assert_eq!(qa.enclosing().to_dop(), union, "union");
            let other = b.iter().fold(Dop::EMPTY, |all, dop| all.union(dop));
            let packed = qa.enclosing().overlaps::<S>(&qb.enclosing());
            assert_eq!(packed, union.overlaps(&other), "packed");
        }
    }

    #[test]
    fn lanes_agree_with_single_bounds() {
        agrees::<3>();
        agrees::<7>();
        agrees::<9>();
        agrees::<13>();
    }
}
