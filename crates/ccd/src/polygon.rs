//! Both queries as one: a moving convex polygon against the origin.
//!
//! A vertex meets a face when the face, seen from the vertex, holds the
//! origin. Two edges meet when the parallelogram of all differences of their
//! points holds it. Corners move on straight lines, so for a fixed direction
//! `m` the projections of all of them are linear in time: if they are positive
//! at both ends of an interval there is no contact within it, whatever `m` is
//! and however badly it was computed. That is the *direction certificate*.

use glam::DVec3;

use crate::error::{CcdError, StepEnd};
use crate::rounding::{DIRECTION, LARGE, LENGTH_UP, SMALL, UNDERFLOW, exponent, power_of_two};

/// A convex polygon with `N` corners (3 or 4) that move on straight lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingPolygon<const N: usize> {
    /// Corners at time 0.
    pub(crate) start: [DVec3; N],
    /// Corners at time 1.
    pub(crate) end: [DVec3; N],
    /// The edge from corner 0 to corner 1 at both times, subtracted from the
    /// input rather than from corners.
    pub(crate) first_edge: [DVec3; 2],
    /// The edge from corner 0 to corner `N - 1`, likewise.
    pub(crate) last_edge: [DVec3; 2],
    /// Smallest coordinates over all corners and both times.
    low: DVec3,
    /// Largest coordinates.
    high: DVec3,
    /// Power of two that all coordinates were multiplied with.
    pub(crate) scale: f64,
}

/// Numbers of corners that have a meaning, with the way to build them.
pub(crate) trait Corners<const N: usize>: Sized {
    /// For each corner, the points whose difference it is: the first less the second.
    #[cfg(feature = "exact")]
    const PAIRS: [(usize, usize); N];

    /// Differences of the query's points: corners and the two edges of corner 0.
    fn differences(x: &[DVec3; 4]) -> ([DVec3; N], DVec3, DVec3);

    /// Weights of the query's points for given weights of the corners.
    fn stencil(corners: [f64; N]) -> [f64; 4];

    /// Weights of the corners for the origin, given its edge functions: the
    /// areas spanned with the edges from corner `i` to `i + 1`.
    fn corner_weights(edge_functions: [f64; N]) -> [f64; N];
}

impl Corners<3> for MovingPolygon<3> {
    #[cfg(feature = "exact")]
    const PAIRS: [(usize, usize); 3] = [(1, 0), (2, 0), (3, 0)];

    #[inline]
    fn differences(&[p, a, b, c]: &[DVec3; 4]) -> ([DVec3; 3], DVec3, DVec3) {
        ([a - p, b - p, c - p], b - a, c - a)
    }

    fn stencil([a, b, c]: [f64; 3]) -> [f64; 4] {
        [-1.0, a, b, c]
    }

    fn corner_weights([ab, bc, ca]: [f64; 3]) -> [f64; 3] {
        let area = ab + bc + ca;
        [bc / area, ca / area, ab / area]
    }
}

impl Corners<4> for MovingPolygon<4> {
    #[cfg(feature = "exact")]
    const PAIRS: [(usize, usize); 4] = [(2, 0), (3, 0), (3, 1), (2, 1)];

    #[inline]
    fn differences(&[a0, a1, b0, b1]: &[DVec3; 4]) -> ([DVec3; 4], DVec3, DVec3) {
        ([b0 - a0, b1 - a0, b1 - a1, b0 - a1], b1 - b0, a0 - a1)
    }

    fn stencil([b0a0, b1a0, b1a1, b0a1]: [f64; 4]) -> [f64; 4] {
        [-(b0a0 + b1a0), -(b1a1 + b0a1), b0a0 + b0a1, b1a0 + b1a1]
    }

    fn corner_weights([at_a0, at_b1, at_a1, at_b0]: [f64; 4]) -> [f64; 4] {
        let (a, b) = (at_a0 / (at_a0 + at_a1), at_b0 / (at_b0 + at_b1));
        [(1.0 - a) * (1.0 - b), (1.0 - a) * b, a * b, a * (1.0 - b)]
    }
}

impl<const N: usize> MovingPolygon<N>
where
    Self: Corners<N>,
{
    /// The polygon of a query, scaled by a power of two where its size could
    /// underflow or overflow.
    #[inline]
    pub(crate) fn new(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError> {
        let (mut polygon, finite) = Self::unscaled(x0, x1);
        let reach = polygon.reach();
        let size = larger(larger(reach.x, reach.y), reach.z);
        if !(finite && SMALL <= size && size <= LARGE) {
            polygon = Self::rescaled(x0, x1)?;
        }
        Ok(polygon)
    }

    /// The polygon as it is, and whether no coordinate is infinite or NaN.
    #[inline]
    fn unscaled(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> (Self, bool) {
        let (start, first_0, last_0) = Self::differences(x0);
        let (end, first_1, last_1) = Self::differences(x1);
        let (mut low, mut high, mut sum) = (start[0], start[0], DVec3::ZERO);
        for q in start.iter().chain(&end) {
            low = DVec3::new(smaller(low.x, q.x), smaller(low.y, q.y), smaller(low.z, q.z));
            high = DVec3::new(larger(high.x, q.x), larger(high.y, q.y), larger(high.z, q.z));
            sum += *q;
        }
        let first_edge = [first_0, first_1];
        let last_edge = [last_0, last_1];
        let polygon = Self { start, end, first_edge, last_edge, low, high, scale: 1.0 };
        // An infinity or a NaN in any corner survives the sum.
        (polygon, (sum.x + sum.y + sum.z).is_finite())
    }

    /// The rare sizes: refuses what is not finite, scales the rest to about 1.
    #[cold]
    #[inline(never)]
    fn rescaled(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError> {
        check_finite(x0, StepEnd::Start)?;
        check_finite(x1, StepEnd::Finish)?;
        // A quarter first: no difference of quarters overflows. What this
        // loses is 2^-2000 of the largest coordinate.
        let overflows = !Self::unscaled(x0, x1).1;
        let quarter = if overflows { 0.25 } else { 1.0 };
        let (polygon, _) = Self::unscaled(&x0.map(|x| x * quarter), &x1.map(|x| x * quarter));
        let size = polygon.reach().max_element();
        if size == 0.0 {
            return Ok(polygon);
        }
        Ok(polygon.scaled_by(-exponent(size), quarter))
    }

    /// The polygon times `2^shift`, in two steps so that each is a normal number.
    fn scaled_by(self, shift: i32, already: f64) -> Self {
        let (half, rest) = (power_of_two(shift / 2), power_of_two(shift - shift / 2));
        let by = |x: DVec3| x * half * rest;
        Self {
            start: self.start.map(by),
            end: self.end.map(by),
            first_edge: self.first_edge.map(by),
            last_edge: self.last_edge.map(by),
            low: by(self.low),
            high: by(self.high),
            scale: already * half * rest,
        }
    }
}

impl<const N: usize> MovingPolygon<N> {
    /// `Q`: largest coordinates in absolute value, over all corners and both times.
    #[inline]
    pub(crate) fn reach(&self) -> DVec3 {
        DVec3::new(
            larger(-self.low.x, self.high.x),
            larger(-self.low.y, self.high.y),
            larger(-self.low.z, self.high.z),
        )
    }

    /// Whether an axis alone keeps the polygon further than `separation` from
    /// the origin during the whole step. Differences have the right sign, so
    /// without a separation this needs no bound.
    #[inline]
    pub(crate) fn axis_separates(&self, separation: f64) -> bool {
        let d = separation * LENGTH_UP;
        let (low, high) = (self.low, self.high);
        low.x > d || low.y > d || low.z > d || high.x < -d || high.y < -d || high.z < -d
    }

    /// `E(m)`: what the projections onto `m` must exceed for the direction
    /// certificate to hold with the given separation.
    #[inline]
    pub(crate) fn direction_bound(&self, m: DVec3, separation: f64) -> f64 {
        DIRECTION * m.abs().dot(self.reach()) + UNDERFLOW + separation_bound(m, separation)
    }

    /// Direction certificate: whether `m` or `-m` keeps all corners further
    /// than `separation` from the origin during `lo..=hi`.
    #[inline]
    pub(crate) fn direction_separates(&self, m: DVec3, lo: f64, hi: f64, separation: f64) -> bool {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..N {
            let (s0, s1) = (m.dot(self.start[i]), m.dot(self.end[i]));
            let (a, b) = (mix(s0, s1, lo), mix(s0, s1, hi));
            least = smaller(least, smaller(a, b));
            most = larger(most, larger(a, b));
        }
        let bound = self.direction_bound(m, separation);
        least > bound || most < -bound
    }

    /// The last time up to which `m` keeps all corners on its positive side,
    /// from `t` on and not beyond `end`; `None` if it does not even at `t`.
    pub(crate) fn clear_until(&self, m: DVec3, t: f64, end: f64, separation: f64) -> Option<f64> {
        let bound = self.direction_bound(m, separation);
        let ends: [(f64, f64); N] =
            std::array::from_fn(|i| (m.dot(self.start[i]), m.dot(self.end[i])));
        let holds = |t: f64| ends.iter().all(|&(s0, s1)| mix(s0, s1, t) > bound);
        if !holds(t) {
            return None;
        }
        let zero = ends
            .iter()
            .filter(|(s0, s1)| s1 < s0)
            .map(|(s0, s1)| (s0 - bound) / (s0 - s1))
            .fold(f64::INFINITY, f64::min);
        // The quotient is a hint: rounded down, then checked.
        let close = smaller(end, zero - 8.0 * f64::EPSILON * zero.abs());
        let safe = smaller(end, zero - 1e-3 * (zero - t));
        [close, safe].into_iter().find(|&until| until > t && holds(until)).or(Some(t))
    }

    /// Corners at time `t`.
    #[inline]
    pub(crate) fn corners(&self, t: f64) -> [DVec3; N] {
        std::array::from_fn(|i| mix_points(self.start[i], self.end[i], t))
    }

    /// The edges of corner 0 at time `t`.
    #[inline]
    pub(crate) fn edges(&self, t: f64) -> [DVec3; 2] {
        [
            mix_points(self.first_edge[0], self.first_edge[1], t),
            mix_points(self.last_edge[0], self.last_edge[1], t),
        ]
    }

    /// Area vector at time `t`: twice the area for a triangle, the area for a
    /// parallelogram, along the normal of the corners' order.
    #[inline]
    pub(crate) fn area_vector(&self, t: f64) -> DVec3 {
        let [first, last] = self.edges(t);
        first.cross(last)
    }
}

/// What a separation adds to a bound on projections onto `m`: infinity where
/// the length of `m` would underflow.
#[inline]
pub(crate) fn separation_bound(m: DVec3, separation: f64) -> f64 {
    if separation > 0.0 {
        let squared = m.length_squared();
        let length = if squared > UNDERFLOW { squared.sqrt() } else { f64::INFINITY };
        separation * length * LENGTH_UP
    } else {
        0.0
    }
}

/// Linear interpolation that is right at both ends.
#[inline]
pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// [`mix`] for points.
#[inline]
pub(crate) fn mix_points(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}

/// The smaller of two numbers; unlike `f64::min` one instruction, since it
/// promises nothing for NaN.
#[inline]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, likewise.
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Refuses points that are not finite.
pub(crate) fn check_finite(points: &[DVec3], end: StepEnd) -> Result<(), CcdError> {
    let bad = points.iter().enumerate().find(|(_, x)| !x.is_finite());
    bad.map_or(Ok(()), |(point, x)| {
        let value = x.to_array().into_iter().find(|c| !c.is_finite()).unwrap_or(f64::NAN);
        Err(CcdError::NotFinite { point, end, value })
    })
}
