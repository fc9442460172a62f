//! One discrete oriented polytope: an interval along each of `S` directions.

use glam::DVec3;

use crate::directions::norm;
use crate::extents::Extents;
use crate::rows::to_nearest;

/// A k-DOP of `k = 2 S` planes: the intervals of a set along the directions
/// [`direction::<S>`](crate::direction), in f32, rounded so that sets which meet have bounds which
/// overlap (the crate's documentation has the proof).
///
/// ```
/// use glam::DVec3;
/// use kdop::Dop18;
///
/// // A needle along the diagonal, and a point beside it that a box would keep.
/// let needle = Dop18::from_points(&[DVec3::ZERO, DVec3::ONE]);
/// let beside = Dop18::from_points(&[DVec3::new(0.9, 0.1, 0.5)]);
/// assert!(!needle.overlaps(&beside));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dop<const S: usize> {
    pub(crate) lo: [f32; S],
    pub(crate) hi: [f32; S],
}

/// A box along the axes.
pub type Dop6 = Dop<3>;
/// A box with its corners cut.
pub type Dop14 = Dop<7>;
/// A box with its edges cut: what [`Tree`](crate::Tree) is made of.
pub type Dop18 = Dop<9>;
/// A box with its edges and corners cut.
pub type Dop26 = Dop<13>;

impl<const S: usize> Dop<S> {
    /// The bound of nothing: overlaps nothing, neutral in a union.
    pub const EMPTY: Self = Self { lo: [f32::INFINITY; S], hi: [f32::NEG_INFINITY; S] };

    /// Bounds the hull of points; a coordinate that is not finite makes the bound meaningless.
    #[must_use]
    pub fn from_points(points: &[DVec3]) -> Self {
        Self::from_extents(&Extents::points(points))
    }

    /// Bounds the hull of all that is given.
    #[must_use]
    pub fn from_extents(extents: &Extents<'_>) -> Self {
        let mut all = Self::EMPTY;
        extents.for_each::<S>(|lo, hi| {
            all = all.union(&Self { lo: lo.map(to_nearest), hi: hi.map(to_nearest) });
        });
        all
    }

    /// Bounds the half-infinite ray from `origin` along `axis`: unbounded where the ray goes.
    ///
    /// Of the 18 comparisons with an 18-DOP, five can then not fail.
    #[must_use]
    pub fn from_ray(origin: DVec3, axis: crate::Axis) -> Self {
        let mut ray = Self::from_points(&[origin]);
        for k in 0..S {
            let along = crate::direction::<S>(k)[axis as usize];
            if along > 0.0 {
                ray.hi[k] = f32::INFINITY;
            } else if along < 0.0 {
                ray.lo[k] = f32::NEG_INFINITY;
            }
        }
        ray
    }

    /// Lower and upper bound of `n · P` along direction `k` (`k < S`).
    ///
    /// # Panics
    ///
    /// When `k >= S`.
    #[must_use]
    pub const fn interval(&self, k: usize) -> [f32; 2] {
        [self.lo[k], self.hi[k]]
    }

    /// Whether it bounds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lo[0] > self.hi[0]
    }

    /// Whether no direction separates the two; bounds that touch overlap.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..S).all(|k| self.lo[k] <= other.hi[k] && other.lo[k] <= self.hi[k])
    }

    /// The least bound that holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lo: std::array::from_fn(|k| self.lo[k].min(other.lo[k])),
            hi: std::array::from_fn(|k| self.hi[k].max(other.hi[k])),
        }
    }

    /// Moves every plane outward by `by · ‖n_k‖` (`by >= 0`) and by what rounding may take, so that
    /// a set within `by` of this one's overlaps the result.
    #[must_use]
    pub fn inflated(&self, by: f64) -> Self {
        if self.is_empty() || by == 0.0 {
            return *self;
        }
        Self {
            lo: std::array::from_fn(|k| -outward(-self.lo[k], by * norm::<S>(k))),
            hi: std::array::from_fn(|k| outward(self.hi[k], by * norm::<S>(k))),
        }
    }
}

/// An upper bound moved up by `by`, and by the half ulp that it may have lost when it was rounded.
/// One beyond the range of f32 may stand for any larger number, so it counts as the largest.
fn outward(bound: f32, by: f64) -> f32 {
    let bound = f64::from(bound.max(-f32::MAX));
    to_nearest(bound + by * (1.0 + 4.0 * f64::EPSILON) + rounding_loss(bound.abs()))
}

/// More than what rounding to f32 changes a number of this magnitude by.
pub(crate) fn rounding_loss(magnitude: f64) -> f64 {
    magnitude.min(f64::from(f32::MAX)) * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Axis;

    #[test]
    fn touching_overlaps_and_a_gap_does_not() {
        let unit = Dop18::from_points(&[DVec3::ZERO, DVec3::ONE]);
        assert!(unit.overlaps(&Dop18::from_points(&[DVec3::ONE])), "a shared corner");
        assert!(!unit.overlaps(&Dop18::from_points(&[DVec3::splat(1.001)])), "beyond it");
        assert!(!unit.overlaps(&Dop18::EMPTY) && Dop18::EMPTY.is_empty(), "nothing");
    }

    #[test]
    fn a_ball_reaches_its_radius_times_the_norm() {
        let ball = Dop26::from_extents(&Extents::balls(&[DVec3::ZERO], &[1.0]));
        for k in 0..13 {
            let [lo, hi] = ball.interval(k).map(f64::from);
            let exact = crate::direction::<13>(k).length();
            assert!((hi - exact).abs() < 1e-6 && (lo + exact).abs() < 1e-6, "{k}: {lo}..{hi}");
        }
    }

    #[test]
    fn inflation_reaches_what_lies_within() {
        for offset in [0.0, 1.0, 1e3, 1e6] {
            let at = |x: f64| Dop18::from_points(&[DVec3::new(offset + x, offset, -offset)]);
            for by in [1e-9, 0.1, 1.0, 1e30, 1e300] {
                assert!(at(0.0).inflated(by).overlaps(&at(by.min(1e12))), "{by} at {offset}");
            }
            assert!(!at(0.0).inflated(0.5).overlaps(&at(1.5)), "too far at {offset}");
        }
    }

    #[test]
    fn a_ray_leaves_thirteen_comparisons() {
        let ray = Dop18::from_ray(DVec3::ZERO, Axis::X);
        let bounds = ray.lo.iter().chain(&ray.hi);
        assert_eq!(bounds.filter(|bound| bound.is_finite()).count(), 13);
        assert!(ray.overlaps(&Dop18::from_points(&[DVec3::X * 1e9])), "ahead");
        assert!(!ray.overlaps(&Dop18::from_points(&[DVec3::X * -1e-9])), "behind");
    }
}
