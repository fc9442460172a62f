//! Quadric error metric: a weighted sum of squared distances from planes.
//!
//! Source: M. Garland and P. S. Heckbert, "Surface Simplification Using Quadric Error
//! Metrics", SIGGRAPH 1997.

use std::ops::AddAssign;

use glam::{DMat3, DVec3};
use surface::triangle;
use surface::vectors::outer;

/// Quadric `(x − o)·A (x − o) + 2 b·(x − o) + c` about an origin o that all quadrics share,
/// with the sum of the weights in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    pub(crate) const ZERO: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0, weight: 0.0 };

    /// Returns the squared distance from the plane of a triangle, weighted by its area; zero
    /// for a triangle without area.
    pub(crate) fn of_triangle(corners: [DVec3; 3]) -> Self {
        let normal = triangle::normal(corners);
        let length = normal.length();
        if length <= 0.0 {
            return Self::ZERO;
        }
        let (weight, n) = (0.5 * length, normal / length);
        let d = -n.dot(corners[0]);
        Self { a: outer(n, n) * weight, b: n * (weight * d), c: weight * d * d, weight }
    }

    /// Returns the weighted mean at a point given relative to the origin; 0 without planes.
    pub(crate) fn mean(&self, x: DVec3) -> f64 {
        let sum = x.dot(self.a * x) + 2.0 * self.b.dot(x) + self.c;
        if self.weight > 0.0 { sum.max(0.0) / self.weight } else { 0.0 }
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }
}

/// Computes the quadric of each vertex from its faces.
pub(crate) fn quadrics(faces: &[[u32; 3]], x: &[DVec3], origin: DVec3) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::ZERO; x.len()];
    for corners in faces {
        let quadric = Quadric::of_triangle(corners.map(|v| x[v as usize] - origin));
        for &vertex in corners {
            quadrics[vertex as usize] += quadric;
        }
    }
    quadrics
}
