//! Directions that part a point or a primitive from a primitive, tried before their
//! exact distance is asked for.
//!
//! For a unit vector u, no ball of a primitive reaches beyond its support
//! `h(u) = max (u·c + r)` over its three balls, since it is their hull. So a point p
//! is not nearer to it, and not less deep in it, than `u·p − h(u)`; which costs a
//! tenth of the exact distance, and is often all that is needed. The best direction is
//! that away from the nearest ball; one near it is found without a look at borders.

use glam::DVec3;

use super::probe::Candidate;
use crate::Ball;
use crate::distance::Touching;

/// How much work a sieve was, and left.
#[derive(Debug, Default)]
pub(super) struct SeparatingDirections {
    /// Directions tried.
    pub(super) tests: u64,
    /// Distances asked for.
    pub(super) leaf_tests: u64,
    /// Memory for primitives that a point may be the deepest in.
    pub(super) rivals: Vec<Candidate>,
}

/// Share of the coordinates' size by which rounding may raise a bound: a few
/// operations on unit vectors, with a factor to spare.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl SeparatingDirections {
    /// Lower bound of the distance of `p` from a primitive, up to [`rounding`], in
    /// the direction away from its middle.
    pub(super) fn away(&mut self, p: DVec3, balls: &[Ball; 3]) -> f64 {
        self.along((p - middle(balls)).normalize_or_zero(), p, balls)
    }

    /// Lower and upper bound of the distance of `p` from a primitive, the lower one up
    /// to [`rounding`], and a direction that shows the lower one, or nearly.
    ///
    /// Of a slab, by the plane that touches its balls and, unless that is farther than
    /// `limit`, by a ball near the one that `p` is nearest to. Of others nothing is told.
    pub(super) fn between(&mut self, p: DVec3, balls: &[Ball; 3], limit: f64) -> ([f64; 2], DVec3) {
        let Some(touching) = Touching::of(p, balls) else {
            return ([f64::NEG_INFINITY, f64::INFINITY], DVec3::ZERO);
        };
        let height = self.along(touching.outward, p, balls);
        if height > limit {
            return ([height, f64::INFINITY], touching.outward);
        }
        let foot = touching.near_foot(p, balls);
        if touching.is_above() {
            return ([height, foot.distance], touching.outward);
        }
        let outward = foot.normal(p).unwrap_or(touching.outward);
        ([height.max(self.along(outward, p, balls)), foot.distance], outward)
    }

    /// Lower bound of the distance of `p` from a primitive, up to [`rounding`], in a
    /// direction `u` with `|u| <= 1`.
    pub(super) fn along(&mut self, u: DVec3, p: DVec3, balls: &[Ball; 3]) -> f64 {
        self.tests += 1;
        let [a, b, c] = balls.map(|ball| u.dot(p - ball.center) - ball.radius);
        a.min(b).min(c)
    }

    /// Whether some direction shows two primitives to be farther than `reach` from
    /// each other.
    pub(super) fn parts(&mut self, a: &[Ball; 3], b: &[Ball; 3], reach: f64) -> bool {
        let between = middle(a) - middle(b);
        let limit = reach + rounding(middle(a), b) + rounding(middle(b), a);
        let mut is_parted = |u: DVec3| {
            self.tests += 1;
            let lowest = |balls: &[Ball; 3], u: DVec3| {
                let [a, b, c] = balls.map(|ball| u.dot(ball.center) - ball.radius);
                a.min(b).min(c)
            };
            lowest(a, u) + lowest(b, -u) > limit
        };
        is_parted(between.normalize_or_zero())
            || is_parted(towards(between, normal(b)))
            || is_parted(towards(between, normal(a)))
    }
}

fn middle([a, b, c]: &[Ball; 3]) -> DVec3 {
    (a.center + b.center + c.center) / 3.0
}

/// The normal or its opposite, whichever is closer to `d`.
fn towards(d: DVec3, normal: DVec3) -> DVec3 {
    if normal.dot(d) < 0.0 { -normal } else { normal }
}

/// Unit normal of the sheet, or zero.
fn normal(balls: &[Ball; 3]) -> DVec3 {
    let [a, b, c] = balls.map(|ball| ball.center);
    (b - a).cross(c - a).normalize_or_zero()
}

/// What rounding may add to a bound.
pub(super) fn rounding(p: DVec3, balls: &[Ball; 3]) -> f64 {
    let size = |ball: &Ball| ball.center.abs().max_element() + ball.radius;
    let sizes = size(&balls[0]).max(size(&balls[1])).max(size(&balls[2]));
    ROUNDING * p.abs().max_element().max(sizes)
}
