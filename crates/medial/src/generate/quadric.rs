//! Spherical quadric error: the squared distances of a ball from touching a set of planes.
//!
//! Source: J.-M. Thiery, É. Guy and T. Boubekeur, "Sphere-Meshes: Shape Approximation using
//! Spherical Quadric Error Metrics", ACM TOG 32(6), 2013.

use glam::{DVec3, DVec4, Vec4Swizzles as _};

use crate::Ball;
use crate::symmetric::{DIAGONAL, Symmetric4};

/// Quadratic function `sᵀ A s − 2 bᵀ s + c` of `s = (center, radius)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    a: Symmetric4,
    b: DVec4,
    c: f64,
}

impl Quadric {
    /// Returns `weight (n·(p − center) − radius)²`: the squared distance of the ball from touching
    /// the plane through `p` with outward normal `n`, from inside.
    pub(super) fn plane(p: DVec3, n: DVec3, weight: f64) -> Self {
        let v = n.extend(1.0);
        let height = n.dot(p);
        let a = Symmetric4::outer(v).scaled(weight);
        Self { a, b: weight * height * v, c: weight * height * height }
    }

    /// Returns `weight |s − ball|²`.
    pub(super) fn near(ball: Ball, weight: f64) -> Self {
        let s = ball.center.extend(ball.radius);
        let mut a = Symmetric4::default();
        for place in DIAGONAL {
            a.0[place] = weight;
        }
        Self { a, b: weight * s, c: weight * s.length_squared() }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.a.add_scaled(1.0, &other.a);
        self.b += other.b;
        self.c += other.c;
    }

    pub(super) fn sum(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.add(other);
        sum
    }

    /// Evaluates the function for a ball.
    pub(super) fn value(&self, ball: Ball) -> f64 {
        let s = ball.center.extend(ball.radius);
        (s.dot(self.a.times(s)) - 2.0 * self.b.dot(s) + self.c).max(0.0)
    }

    /// Computes the ball of the minimum, with a radius of at least 0; `None` where the quadric does
    /// not define one.
    pub(super) fn minimum(&self) -> Option<Ball> {
        let s = self.a.solve(self.b)?;
        Some(Ball::new(s.xyz(), s.w.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_in_a_corner_touches_its_planes() {
        // Inscribed ball of the tetrahedron under the plane x + y + z = 1.
        let mut quadric = Quadric::default();
        for axis in DVec3::AXES {
            quadric.add(&Quadric::plane(DVec3::ZERO, -axis, 1.0));
        }
        quadric.add(&Quadric::plane(DVec3::X, DVec3::ONE.normalize(), 1.0));
        let ball = quadric.minimum().unwrap();
        let radius = 1.0 / (3.0 + 3.0_f64.sqrt());
        assert!((ball.radius - radius).abs() < 1e-14, "{ball:?}");
        assert!((ball.center - radius).length() < 1e-14, "{ball:?}");
        assert!(quadric.value(ball) < 1e-14);
    }

    #[test]
    fn one_plane_defines_no_ball() {
        assert!(Quadric::plane(DVec3::ZERO, DVec3::X, 1.0).minimum().is_none());
    }
}
