//! Moving convex polygon against the origin: the common form of both queries.
//!
//! A vertex meets a face when the face relative to the vertex contains the origin. Two edges meet
//! when the parallelogram of all differences of their points contains it. Corners move on straight
//! lines, so their projections onto a fixed direction `m` are linear in time. If all are positive
//! at both ends of an interval, there is no contact within it, whatever `m` is and however
//! inaccurately it was computed. That is the *direction certificate*.

use glam::DVec3;

use crate::outline::{Outline, Scaling};
use crate::rounding::{DIRECTION, LENGTH_UP, TURNING, UNDERFLOW};
use crate::scalar::{fast_max, fast_min, max_each, mix, mix_points};
use crate::shape::{Corners, PolygonShape};

/// Convex polygon with `N` corners (3 or 4) that move on straight lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingPolygon<'a, const N: usize> {
    pub(crate) outline: &'a Outline,
    /// Corners at time 0.
    pub(crate) start: [DVec3; N],
    /// Corners at time 1.
    pub(crate) end: [DVec3; N],
}

/// Direction that changes linearly in time during an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningDirection {
    pub(crate) start: DVec3,
    pub(crate) end: DVec3,
}

impl<'a, const N: usize> MovingPolygon<'a, N>
where
    PolygonShape<N>: Corners<N>,
{
    /// Computes the corners of the polygon of which `outline` is the outline.
    #[inline]
    pub(crate) fn new(outline: &'a Outline, [x0, x1]: [&[DVec3; 4]; 2]) -> Self {
        if outline.scaling != Scaling::NONE {
            return Self::scaled(outline, [x0, x1]);
        }
        Self { outline, start: corners(x0), end: corners(x1) }
    }

    #[cold]
    fn scaled(outline: &'a Outline, points: [&[DVec3; 4]; 2]) -> Self {
        let scaling = outline.scaling;
        let [start, end] = points
            .map(|x| corners::<N>(&x.map(|x| scaling.point(x))).map(|q| scaling.difference(q)));
        Self { outline, start, end }
    }
}

/// Computes the corners of the polygon of four points.
#[inline]
fn corners<const N: usize>(x: &[DVec3; 4]) -> [DVec3; N]
where
    PolygonShape<N>: Corners<N>,
{
    std::array::from_fn(|i| {
        let (to, from) = PolygonShape::<N>::PAIRS[i];
        x[to] - x[from]
    })
}

impl<const N: usize> MovingPolygon<'_, N> {
    /// Returns `E(m)`, which projections onto `m` must exceed for the direction certificate to hold
    /// with the given separation.
    #[inline]
    pub(crate) fn direction_bound(&self, m: DVec3, separation: f64) -> f64 {
        DIRECTION * m.abs().dot(self.outline.max_abs())
            + UNDERFLOW
            + separation_bound(m, separation)
    }

    /// Evaluates the direction certificate: returns true if `m` or `-m` keeps all corners farther
    /// than `separation` from the origin during `lo..=hi`.
    #[inline]
    pub(crate) fn direction_separates(&self, m: DVec3, lo: f64, hi: f64, separation: f64) -> bool {
        // Projections are linear in time, so those at both ends bound all.
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..N {
            let (s0, s1) = (m.dot(self.start[i]), m.dot(self.end[i]));
            let (a, b) = (mix(s0, s1, lo), mix(s0, s1, hi));
            min = fast_min(min, fast_min(a, b));
            max = fast_max(max, fast_max(a, b));
        }
        let bound = self.direction_bound(m, separation);
        min > bound || max < -bound
    }

    /// Finds the last time up to which a direction that turns during `lo..=hi` keeps all corners on
    /// its positive side, farther than `separation` from the origin; `None` if it does not at `lo`.
    ///
    /// Projections are quadratic in time. An edge that is perpendicular to the direction at both
    /// ends deviates from that by the square of the time in between, where a fixed direction would
    /// lose one of its corners at once.
    pub(crate) fn clear_until(
        &self,
        m: TurningDirection,
        lo: f64,
        hi: f64,
        separation: f64,
    ) -> Option<f64> {
        let fraction = self.clear_fraction(m, lo, hi, separation);
        if fraction >= 1.0 {
            return Some(hi);
        }
        if fraction <= 0.0 {
            return None;
        }

        // The fraction is a hint: it is rounded down, then certified.
        for fraction in [fraction * (1.0 - 1e-9), fraction * 0.99] {
            let t = lo + fraction * (hi - lo);
            let part =
                TurningDirection { start: m.start, end: mix_points(m.start, m.end, fraction) };
            if t > lo && self.clear_fraction(part, lo, t, separation) >= 1.0 {
                return Some(t);
            }
        }
        Some(lo)
    }

    /// Evaluates the certificate of a turning direction: a fraction of at least 1 means that the
    /// direction separates during all of `lo..=hi`.
    ///
    /// A smaller fraction is an estimate of where it stops to separate.
    fn clear_fraction(&self, m: TurningDirection, lo: f64, hi: f64, separation: f64) -> f64 {
        let [bound_lo, bound_hi] = self.turning_bounds(m, separation);
        let middle = 0.5 * (bound_lo + bound_hi);
        let mut fraction = 1.0;
        for i in 0..N {
            let q = [lo, hi].map(|t| mix_points(self.start[i], self.end[i], t));
            let [at_lo, between, at_hi] = projections(m, q);

            // Coefficients above their bounds certify the corner.
            let above = [at_lo - bound_lo, between - middle, at_hi - bound_hi];
            if fast_min(above[0], fast_min(above[1], above[2])) <= 0.0 {
                fraction = fast_min(fraction, first_zero(above));
            }
        }
        fraction
    }

    /// Returns what the first and the last coefficient of projections onto a turning direction must
    /// exceed; those between must exceed the mean of both.
    pub(crate) fn turning_bounds(&self, m: TurningDirection, separation: f64) -> [f64; 2] {
        let largest = max_each(m.start.abs(), m.end.abs());
        let rounding = TURNING * largest.dot(self.outline.max_abs()) + UNDERFLOW;
        [m.start, m.end].map(|m| rounding + separation_bound(m, separation))
    }

    /// Computes the velocity of the point with the given weights of the corners.
    pub(crate) fn velocity(&self, weights: [f64; N]) -> DVec3 {
        (0..N).map(|i| (self.end[i] - self.start[i]) * weights[i]).sum()
    }

    /// Returns the corners at time `t`.
    #[inline]
    pub(crate) fn corners(&self, t: f64) -> [DVec3; N] {
        std::array::from_fn(|i| mix_points(self.start[i], self.end[i], t))
    }
}

/// Computes the Bernstein coefficients of the projection of a point that moves from `q[0]` to
/// `q[1]` onto a turning direction.
#[inline]
pub(crate) fn projections(m: TurningDirection, q: [DVec3; 2]) -> [f64; 3] {
    let between = 0.5 * (m.start.dot(q[1]) + m.end.dot(q[0]));
    [m.start.dot(q[0]), between, m.end.dot(q[1])]
}

/// Estimates the first zero in `0..=1` of a quadratic with these Bernstein coefficients, one of
/// which is not positive; returns just below 1 if there is none.
fn first_zero([at_0, between, at_1]: [f64; 3]) -> f64 {
    if at_0 <= 0.0 {
        return 0.0;
    }
    let (slope, curvature) = (2.0 * (between - at_0), at_0 - 2.0 * between + at_1);
    let root = (slope * slope - 4.0 * at_0 * curvature).sqrt();
    let zero = 2.0 * at_0 / (root - slope);
    if (0.0..1.0).contains(&zero) { zero } else { 1.0 - f64::EPSILON }
}

/// Returns what a separation adds to a bound on projections onto `m`: infinity where the length of
/// `m` would underflow.
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
