//! Balls, and balls interpolated between others.

use glam::{DVec3, DVec4};

/// Ball at a vertex of a medial surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ball {
    /// Center, in the caller's length unit.
    pub center: DVec3,
    /// Radius, `>= 0`, in the same unit.
    pub radius: f64,
}

impl Ball {
    /// Returns a ball around `center`.
    #[must_use]
    pub const fn new(center: DVec3, radius: f64) -> Self {
        Self { center, radius }
    }

    /// Computes the signed distance from `p` to the ball, negative inside.
    #[must_use]
    pub fn distance(&self, p: DVec3) -> f64 {
        p.distance(self.center) - self.radius
    }

    /// Computes the weighted mean of `balls`, of centers and radii alike.
    #[must_use]
    pub fn interpolate(balls: &[Self; 3], weights: [f64; 3]) -> Self {
        let [a, b, c] = balls;
        Self {
            center: weights[0] * a.center + weights[1] * b.center + weights[2] * c.center,
            radius: weights[0] * a.radius + weights[1] * b.radius + weights[2] * c.radius,
        }
    }

    /// Computes the weighted mean of two balls, with `t` the weight of the second.
    pub(crate) fn between(first: Self, second: Self, t: f64) -> Self {
        Self {
            center: (1.0 - t) * first.center + t * second.center,
            radius: (1.0 - t) * first.radius + t * second.radius,
        }
    }

    /// Returns the centers of balls.
    pub(crate) fn centers(balls: &[Self; 3]) -> [DVec3; 3] {
        balls.map(|ball| ball.center)
    }

    /// Returns the ball in the middle between two.
    pub(crate) fn midpoint(self, other: Self) -> Self {
        let center = self.center.midpoint(other.center);
        Self { center, radius: self.radius.midpoint(other.radius) }
    }

    /// Returns the ball moved and grown by `(dc, dr)`; its radius stays at least 0.
    pub(crate) fn stepped(self, step: DVec4) -> Self {
        Self::new(self.center + step.truncate(), (self.radius + step.w).max(0.0))
    }

    /// Returns true if its numbers are finite and its radius is not negative.
    pub(crate) fn is_valid(&self) -> bool {
        self.center.is_finite() && self.radius.is_finite() && self.radius >= 0.0
    }
}
