//! Outline of a moving polygon: what the filters need, scaled against underflow and overflow.

use glam::DVec3;

use crate::ends::{Ends, sum};
use crate::error::{CcdError, StepEnd};
use crate::rounding::{LARGE, LENGTH_UP, SMALL, UNIT, exponent, power_of_two};
use crate::scalar::{fast_max, max_each};
use crate::shape::{Corners, PointDifferences, PolygonShape};

/// One corner of a moving polygon, the two edges that meet there, and the extent of all corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// Corner 0.
    pub(crate) corner: Ends,
    /// The edge from corner 0 to corner 1.
    pub(crate) first_edge: Ends,
    /// The edge from corner 0 to corner `N - 1`.
    pub(crate) last_edge: Ends,
    /// Smallest coordinates over all corners and both times.
    lower: DVec3,
    /// Largest coordinates.
    upper: DVec3,
    /// Powers of two by which everything was multiplied.
    pub(crate) scaling: Scaling,
}

/// Powers of two by which points and their differences are multiplied.
///
/// Points are multiplied only by a quarter, and only where differences would overflow. The digits
/// that this costs are below 2^-1000 of the largest difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling {
    points: f64,
    /// Two factors, since their product may not be a normal number.
    differences: [f64; 2],
}

impl Scaling {
    pub(crate) const NONE: Self = Self { points: 1.0, differences: [1.0, 1.0] };

    /// Returns the scaling that brings differences of size `size` to about 1.
    fn of_size(size: f64, points: f64) -> Self {
        let shift = -exponent(size);
        let differences = [shift / 2, shift - shift / 2].map(power_of_two);
        Self { points, differences }
    }

    /// Multiplies a length by all factors.
    #[inline]
    pub(crate) fn length(self, x: f64) -> f64 {
        x * self.points * self.differences[0] * self.differences[1]
    }

    /// Scales a point of the input.
    pub(crate) fn point(self, x: DVec3) -> DVec3 {
        x * self.points
    }

    /// Scales a difference of scaled points.
    pub(crate) fn difference(self, x: DVec3) -> DVec3 {
        x * self.differences[0] * self.differences[1]
    }
}

impl Outline {
    /// Computes the outline of a query, scaled by a power of two where its size could underflow or
    /// overflow.
    #[inline]
    pub(crate) fn new<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError>
    where
        PolygonShape<N>: Corners<N>,
    {
        let (mut outline, finite) = Self::unscaled::<N>(x0, x1);
        if !(finite && (SMALL..=LARGE).contains(&outline.size())) {
            outline = Self::rescaled::<N>(x0, x1)?;
        }
        Ok(outline)
    }

    /// Computes the outline without scaling; the flag is true if all coordinates are finite.
    #[inline]
    fn unscaled<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> (Self, bool)
    where
        PolygonShape<N>: Corners<N>,
    {
        // Coordinates are loaded one by one: wider loads would wait for the stores of a caller that
        // has just copied the points.
        let [x0, x1] = [std::hint::black_box(x0), std::hint::black_box(x1)];
        let x = std::array::from_fn(|i| Ends::new(x0[i], x1[i]));
        let at_ends = PolygonShape::<N>::differences(&x);
        let outline = Self {
            corner: at_ends.corner,
            first_edge: at_ends.first_edge,
            last_edge: at_ends.last_edge,
            lower: at_ends.lower.lower(),
            upper: at_ends.upper.upper(),
            scaling: Scaling::NONE,
        };

        // An infinity or a NaN in any point survives the sum.
        let Ends { x, y, z } = at_ends.corner.plus(at_ends.first_edge).plus(at_ends.last_edge);
        (outline, sum(x + y + z).is_finite())
    }

    /// Scales an outline of rare size to about 1, after a check that all coordinates are finite.
    #[cold]
    #[inline(never)]
    fn rescaled<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError>
    where
        PolygonShape<N>: Corners<N>,
    {
        check_finite(x0, StepEnd::Start)?;
        check_finite(x1, StepEnd::Finish)?;

        // Finite points may have infinite differences; those of a quarter of them are finite.
        let overflows = !Self::unscaled::<N>(x0, x1).1;
        let quarter = Scaling { points: if overflows { 0.25 } else { 1.0 }, ..Scaling::NONE };
        let [x0, x1] = [x0, x1].map(|x| x.map(|x| quarter.point(x)));
        let (outline, _) = Self::unscaled::<N>(&x0, &x1);

        let size = outline.size();
        if size > 0.0 {
            Ok(outline.scaled_by(Scaling::of_size(size, quarter.points)))
        } else {
            Ok(outline)
        }
    }

    fn scaled_by(self, scaling: Scaling) -> Self {
        let by = |x: DVec3| scaling.difference(x);
        let ends_by = |x: Ends| {
            let [start, end] = x.to_array().map(by);
            Ends::new(start, end)
        };
        Self {
            corner: ends_by(self.corner),
            first_edge: ends_by(self.first_edge),
            last_edge: ends_by(self.last_edge),
            lower: by(self.lower),
            upper: by(self.upper),
            scaling,
        }
    }

    /// Returns `Q`: the largest absolute value of each coordinate, over all corners and both times.
    #[inline]
    pub(crate) fn max_abs(&self) -> DVec3 {
        max_each(-self.lower, self.upper)
    }

    /// Bounds the rounding of a point of the polygon: the mean of its corners with convex weights.
    ///
    /// Section 7 of the error analysis: 4 u for a corner, below 8 u for the weights and their sum.
    pub(crate) fn rounding(&self) -> f64 {
        16.0 * UNIT * self.max_abs().element_sum()
    }

    #[inline]
    fn size(&self) -> f64 {
        let q = self.max_abs();
        fast_max(fast_max(q.x, q.y), q.z)
    }

    /// Returns true if an axis keeps the polygon farther than `separation` from the origin during
    /// the whole step.
    ///
    /// Differences have the right sign, so without a separation this needs no bound.
    #[inline]
    pub(crate) fn axis_separates(&self, separation: f64) -> bool {
        let d = separation * LENGTH_UP;
        let (lower, upper) = (self.lower, self.upper);
        lower.x > d || lower.y > d || lower.z > d || upper.x < -d || upper.y < -d || upper.z < -d
    }

    /// Returns corner 0 at time `t`.
    #[inline]
    pub(crate) fn corner_at(&self, t: f64) -> DVec3 {
        self.corner.at(t)
    }

    /// Returns the edges of corner 0 at time `t`.
    #[inline]
    pub(crate) fn edges(&self, t: f64) -> [DVec3; 2] {
        [self.first_edge.at(t), self.last_edge.at(t)]
    }

    /// Computes the area vector at time `t`, along the normal of the order of the corners.
    ///
    /// Its length is twice the area for a triangle, the area for a parallelogram.
    #[inline]
    pub(crate) fn area_vector(&self, t: f64) -> DVec3 {
        let [first, last] = self.edges(t);
        first.cross(last)
    }
}

/// Checks that all points are finite.
pub(crate) fn check_finite(points: &[DVec3], end: StepEnd) -> Result<(), CcdError> {
    match points.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        None => Ok(()),
        Some((point, x)) => {
            let value = x.to_array().into_iter().find(|c| !c.is_finite()).unwrap_or(f64::NAN);
            Err(CcdError::NotFinite { point, end, value })
        }
    }
}
