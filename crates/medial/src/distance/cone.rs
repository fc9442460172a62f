//! Nearest ball of a cone.

use glam::DVec3;

use super::Foot;
use crate::Ball;

/// Computes the ball between `a` and `b` with the smallest signed distance to `p`, exactly.
///
/// The third weight of the foot is zero. Where one ball contains the other (their radii differ by
/// at least the distance between their centers), the cone is the larger ball.
///
/// ```
/// use glam::DVec3;
/// use medial::{Ball, cone_foot};
///
/// // The radius grows by half the way along x. The nearest ball lies ahead of the foot of the
/// // perpendicular, and the point is nearer than that one.
/// let (a, b) = (Ball::new(DVec3::ZERO, 1.0), Ball::new(DVec3::X * 4.0, 3.0));
/// let p = DVec3::new(1.0, 5.0, 0.0);
/// let foot = cone_foot(p, a, b);
/// let perpendicular = 5.0 - 1.5;
/// assert!(foot.distance < perpendicular);
/// assert!((foot.distance - (5.0 * 0.75_f64.sqrt() + 0.5 * -1.0 - 1.0)).abs() < 1e-14);
/// ```
#[must_use]
pub fn cone_foot(p: DVec3, a: Ball, b: Ball) -> Foot {
    let t = cone_parameter(p, a, b);
    Foot::at(p, &[a, b, b], [1.0 - t, t, 0.0])
}

/// Computes the weight t in `0.0..=1.0` of `b` in that ball.
///
/// With u the unit axis, L its length, k the slope of the radius, x the height of P along the axis
/// and y its distance from it, f is stationary where `tL − x = k |P − c|` and
/// `|P − c| = y / √(1 − k²)`.
pub(super) fn cone_parameter(p: DVec3, a: Ball, b: Ball) -> f64 {
    let axis = b.center - a.center;
    let length = axis.length();
    let growth = b.radius - a.radius;
    if growth.abs() >= length {
        return if growth > 0.0 { 1.0 } else { 0.0 };
    }

    // Height and distance of the point from the axis; the nearest ball is ahead by the slope.
    let u = axis / length;
    let x = (p - a.center).dot(u);
    let y = (p - a.center - x * u).length();
    // k / √(1 − k²), factored so that it keeps its digits as k approaches 1.
    let tangent = growth / ((length - growth) * (length + growth)).sqrt();
    ((x + tangent * y) / length).clamp(0.0, 1.0)
}
