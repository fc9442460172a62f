//! A ball, and balls interpolated between others.

use glam::DVec3;

/// A ball: what a medial surface carries at each vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ball {
    /// Center, in the caller's length unit.
    pub center: DVec3,
    /// Radius, `>= 0`, in the same unit.
    pub radius: f64,
}

impl Ball {
    /// A ball around `center`.
    #[must_use]
    pub const fn new(center: DVec3, radius: f64) -> Self {
        Self { center, radius }
    }

    /// Signed distance from `p` to the ball, negative inside.
    #[must_use]
    pub fn distance(&self, p: DVec3) -> f64 {
        p.distance(self.center) - self.radius
    }

    /// The ball with weights `weights` of `balls`, center and radius alike.
    #[must_use]
    pub fn interpolate(balls: &[Self; 3], weights: [f64; 3]) -> Self {
        let [a, b, c] = balls;
        Self {
            center: weights[0] * a.center + weights[1] * b.center + weights[2] * c.center,
            radius: weights[0] * a.radius + weights[1] * b.radius + weights[2] * c.radius,
        }
    }

    /// Whether every number of it is finite and its radius is not negative.
    pub(crate) fn is_valid(&self) -> bool {
        self.center.is_finite() && self.radius.is_finite() && self.radius >= 0.0
    }
}
