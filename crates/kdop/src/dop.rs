//! Single k-DOP: an interval along each of `S` directions.

use glam::DVec3;

use crate::directions::norm;
use crate::extents::Extents;
use crate::projections::to_nearest;

/// Discrete oriented polytope (k-DOP) of `k = 2 S` planes.
///
/// Holds the interval of a set along each [`direction::<S>`](crate::direction), in f32. Bounds are
/// rounded such that those of sets with a common point overlap; the documentation of the crate has
/// the proof. `S` is 3 for a box, 7 for a box with its corners cut, 9 for one with its edges cut
/// and 13 for one with both.
///
/// ```
/// use glam::DVec3;
/// use kdop::Dop18;
///
/// // A needle along the diagonal, and a point beside it that is inside its box.
/// let needle = Dop18::from_points(&[DVec3::ZERO, DVec3::ONE]);
/// let beside = Dop18::from_points(&[DVec3::new(0.9, 0.1, 0.5)]);
/// assert!(!needle.overlaps(&beside));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dop<const S: usize> {
    pub(crate) lo: [f32; S],
    pub(crate) hi: [f32; S],
}

/// The 18-DOP: a box with its edges cut.
pub type Dop18 = Dop<9>;

impl<const S: usize> Dop<S> {
    /// The bound of the empty set: overlaps nothing, and is neutral in a union.
    pub const EMPTY: Self = Self { lo: [f32::INFINITY; S], hi: [f32::NEG_INFINITY; S] };

    /// Bounds the convex hull of points.
    ///
    /// A coordinate that is not finite makes the bound meaningless.
    #[must_use]
    pub fn from_points(points: &[DVec3]) -> Self {
        let mut all = Self::EMPTY;
        Extents::Points(points).for_each::<S>(|extent| {
            let lo = extent.lower.map(to_nearest);
            let hi = extent.upper.map(to_nearest);
            all = all.union(&Self { lo, hi });
        });
        all
    }

    /// Returns the lower and upper bound of `n · P` along direction `k < S`.
    ///
    /// # Panics
    ///
    /// When `k >= S`.
    #[must_use]
    pub const fn interval(&self, k: usize) -> [f32; 2] {
        [self.lo[k], self.hi[k]]
    }

    /// Returns true if this bounds the empty set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lo[0] > self.hi[0]
    }

    /// Returns true if no direction separates the two bounds. Bounds that touch overlap.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..S).all(|k| self.lo[k] <= other.hi[k] && other.lo[k] <= self.hi[k])
    }

    /// Returns the smallest bound that contains both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lo: std::array::from_fn(|k| self.lo[k].min(other.lo[k])),
            hi: std::array::from_fn(|k| self.hi[k].max(other.hi[k])),
        }
    }

    /// Returns the bound with every plane moved outward by `by · ‖n_k‖` (`by >= 0`) and by the
    /// rounding error.
    ///
    /// The bound of any set within `by` of this one's overlaps the result.
    #[must_use]
    pub fn inflated(&self, by: f64) -> Self {
        // Bounds at infinity mark the empty set, and must stay there.
        if self.is_empty() || by == 0.0 {
            return *self;
        }
        Self {
            lo: std::array::from_fn(|k| -moved_outward(-self.lo[k], by * norm::<S>(k))),
            hi: std::array::from_fn(|k| moved_outward(self.hi[k], by * norm::<S>(k))),
        }
    }

    /// Finds the direction of greatest extent, the first of equals, and that extent as a length.
    pub(crate) fn widest(&self) -> (usize, f64) {
        let mut best = (0, 0.0);
        for k in 0..S {
            let width = (f64::from(self.hi[k]) - f64::from(self.lo[k])) / norm::<S>(k);
            if width > best.1 {
                best = (k, width);
            }
        }
        best
    }
}

/// Moves an upper bound up by `by`, and by the half ulp that its rounding may have removed.
///
/// A bound beyond the range of f32 may stand for any larger number, so it counts as the largest.
fn moved_outward(bound: f32, by: f64) -> f32 {
    let bound = f64::from(bound.max(-f32::MAX));
    to_nearest(bound + by * (1.0 + 4.0 * f64::EPSILON) + rounding_loss(bound.abs()))
}

/// Returns more than the change of a number of this magnitude when it is rounded to f32.
pub(crate) fn rounding_loss(magnitude: f64) -> f64 {
    magnitude.min(f64::from(f32::MAX)) * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction;

    #[test]
    fn touching_overlaps_and_a_gap_does_not() {
        let unit = Dop18::from_points(&[DVec3::ZERO, DVec3::ONE]);
        assert!(unit.overlaps(&Dop18::from_points(&[DVec3::ONE])), "a shared corner");
        assert!(!unit.overlaps(&Dop18::from_points(&[DVec3::splat(1.001)])), "beyond it");
        assert!(!unit.overlaps(&Dop18::EMPTY) && Dop18::EMPTY.is_empty(), "the empty set");
    }

    /// Points along every direction of the k-DOP, to both sides.
    fn inflates_along_all_directions<const S: usize>() {
        let point = DVec3::new(3.0, -2.0, 5.0);
        let bound = Dop::<S>::from_points(&[point]).inflated(1.0);
        for k in 0..S {
            let unit = direction::<S>(k).normalize();
            for side in [-1.0, 1.0] {
                let at = |by: f64| Dop::<S>::from_points(&[point + side * by * unit]);
                assert!(bound.overlaps(&at(0.999)), "direction {k} of {S}, side {side}");
                assert!(!bound.overlaps(&at(1.001)), "direction {k} of {S}, side {side}");
            }
        }
    }

    #[test]
    fn inflation_reaches_as_far_along_all_directions() {
        inflates_along_all_directions::<3>();
        inflates_along_all_directions::<7>();
        inflates_along_all_directions::<9>();
        inflates_along_all_directions::<13>();
    }

    #[test]
    fn inflation_covers_what_lies_within() {
        for offset in [0.0, 1.0, 1e3, 1e6] {
            let at = |x: f64| Dop18::from_points(&[DVec3::new(offset + x, offset, -offset)]);
            for by in [1e-9, 0.1, 1.0, 1e30, 1e300] {
                assert!(at(0.0).inflated(by).overlaps(&at(by.min(1e12))), "{by} at {offset}");
            }
            assert!(!at(0.0).inflated(0.5).overlaps(&at(1.5)), "too far at {offset}");
        }
    }
}
