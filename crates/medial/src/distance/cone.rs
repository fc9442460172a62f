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
    let t = ConeAxis::new(a, b).parameter(p);
    Foot::at(p, &[a, b, b], [1.0 - t, t, 0.0])
}

/// Axis of a cone, with what its feet have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConeAxis {
    start: DVec3,
    /// Unit vector to the second center.
    unit: DVec3,
    length: f64,
    /// k / √(1 − k²), with k the slope of the radius.
    tangent: f64,
    /// Weight of the second ball, where one of them contains the other.
    constant: Option<f64>,
}

impl ConeAxis {
    pub(super) fn new(a: Ball, b: Ball) -> Self {
        let axis = b.center - a.center;
        let length = axis.length();
        let growth = b.radius - a.radius;
        let constant = if growth > 0.0 { 1.0 } else { 0.0 };
        Self {
            start: a.center,
            unit: axis / length,
            length,
            // Factored so that it keeps its digits as k approaches 1.
            tangent: growth / ((length - growth) * (length + growth)).sqrt(),
            constant: (growth.abs() >= length).then_some(constant),
        }
    }

    /// Computes the weight t in `0.0..=1.0` of the second ball in the nearest one to `p`.
    ///
    /// With u the unit axis, L its length, k the slope of the radius, x the height of P along the
    /// axis and y its distance from it, f is stationary where `tL − x = k |P − c|` and
    /// `|P − c| = y / √(1 − k²)`.
    #[inline]
    pub(super) fn parameter(&self, p: DVec3) -> f64 {
        if let Some(constant) = self.constant {
            return constant;
        }

        // Height and distance of the point from the axis; the nearest ball is ahead by the slope.
        let w = p - self.start;
        let x = w.dot(self.unit);
        let y = (w - x * self.unit).length();
        ((x + self.tangent * y) / self.length).clamp(0.0, 1.0)
    }
}
