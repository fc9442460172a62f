//! Separating-direction culling: lower bounds on the distance of a point or a primitive from a
//! primitive, before the exact distance is computed.
//!
//! Along a unit vector u, no ball of a primitive extends beyond its support
//! `h(u) = max (u·c + r)` over its three balls, since it is their hull. So `u·p − h(u)` is a lower
//! bound on the signed distance of a point p. It costs a tenth of the exact distance, and is often
//! sufficient. The largest bound is that of the direction away from the nearest ball; a direction
//! near it is found without the border of the primitive.

use glam::DVec3;
use surface::triangle;

use super::TestCounts;
use crate::Ball;
use crate::distance::TangentPlane;

/// Tests of separating directions, which it counts.
#[derive(Debug, Default)]
pub(super) struct SeparatingDirections {
    pub(super) counts: TestCounts,
}

/// Bounds on the distance of a point from a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct DistanceBounds {
    /// Lower bound, up to [`rounding`].
    pub(super) lower: f64,
    /// Upper bound.
    pub(super) upper: f64,
    /// Direction of the lower bound, or nearly; zero without one.
    pub(super) direction: DVec3,
}

/// Share of the coordinates' size by which rounding may raise a bound: a few operations on unit
/// vectors, with a factor to spare.
///
/// Below a few, contacts at the margin are lost; far above, fewer primitives are culled.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl SeparatingDirections {
    /// Computes a lower bound on the distance of `p` from a primitive, up to [`rounding`], in the
    /// direction away from its middle.
    pub(super) fn bound_from_middle(&mut self, p: DVec3, balls: &[Ball; 3]) -> f64 {
        self.bound_along((p - middle(balls)).normalize_or_zero(), p, balls)
    }

    /// Computes a lower bound on the distance of `p` from a primitive, up to [`rounding`], in a
    /// direction `u` with `|u| <= 1`.
    pub(super) fn bound_along(&mut self, u: DVec3, p: DVec3, balls: &[Ball; 3]) -> f64 {
        self.counts.direction_tests += 1;
        let [a, b, c] = balls.map(|ball| u.dot(p - ball.center) - ball.radius);
        a.min(b).min(c)
    }

    /// Computes bounds on the distance of `p` from a slab: by the plane that touches its balls and,
    /// unless that is beyond `limit`, by a ball near the closest one. Other primitives have
    /// infinite bounds.
    pub(super) fn bounds(&mut self, p: DVec3, balls: &[Ball; 3], limit: f64) -> DistanceBounds {
        let Some(plane) = TangentPlane::new(p, balls) else {
            let (lower, upper) = (f64::NEG_INFINITY, f64::INFINITY);
            return DistanceBounds { lower, upper, direction: DVec3::ZERO };
        };

        // The plane alone often shows that the slab is beyond the limit.
        let height = self.bound_along(plane.outward, p, balls);
        if height > limit {
            let upper = f64::INFINITY;
            return DistanceBounds { lower: height, upper, direction: plane.outward };
        }

        // A ball of the slab gives an upper bound, and the direction away from it a lower one.
        let foot = plane.near_foot(p, balls);
        let upper = foot.distance;
        if plane.is_below_point() {
            return DistanceBounds { lower: height, upper, direction: plane.outward };
        }
        let direction = foot.normal(p).unwrap_or(plane.outward);
        let lower = height.max(self.bound_along(direction, p, balls));
        DistanceBounds { lower, upper, direction }
    }

    /// Returns true if some direction separates two primitives by more than `margin`.
    pub(super) fn are_separated(&mut self, a: &[Ball; 3], b: &[Ball; 3], margin: f64) -> bool {
        let between = middle(a) - middle(b);
        let limit = margin + rounding(middle(a), b) + rounding(middle(b), a);
        self.distance_along(between.normalize_or_zero(), a, b) > limit
            || self.distance_along(oriented(sheet_normal(b), between), a, b) > limit
            || self.distance_along(oriented(sheet_normal(a), between), a, b) > limit
    }

    /// Computes the distance of two primitives along `u`, which points from `b` to `a`.
    fn distance_along(&mut self, u: DVec3, a: &[Ball; 3], b: &[Ball; 3]) -> f64 {
        self.counts.direction_tests += 1;
        min_along(u, a) + min_along(-u, b)
    }
}

/// Returns the smallest coordinate of a primitive along `u`.
fn min_along(u: DVec3, balls: &[Ball; 3]) -> f64 {
    let [a, b, c] = balls.map(|ball| u.dot(ball.center) - ball.radius);
    a.min(b).min(c)
}

fn middle([a, b, c]: &[Ball; 3]) -> DVec3 {
    (a.center + b.center + c.center) / 3.0
}

/// Returns the normal or its opposite, whichever is closer to `direction`.
fn oriented(normal: DVec3, direction: DVec3) -> DVec3 {
    if normal.dot(direction) < 0.0 { -normal } else { normal }
}

/// Returns the unit normal of the centers, or zero where they are on a line.
fn sheet_normal(balls: &[Ball; 3]) -> DVec3 {
    triangle::unit_normal(Ball::centers(balls))
}

/// Computes by how much rounding may raise a bound.
pub(super) fn rounding(p: DVec3, balls: &[Ball; 3]) -> f64 {
    let [a, b, c] = balls.each_ref().map(|ball| ball.center.abs().max_element() + ball.radius);
    ROUNDING * p.abs().max_element().max(a.max(b).max(c))
}
