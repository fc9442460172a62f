//! Vectors of rows: impulses, residuals and directions.

use glam::DVec3;

/// Vector of a row: along its normal and in its tangent plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    pub(super) normal: f64,
    pub(super) tangent: DVec3,
}

impl Parts {
    /// Computes the sum with `factor` times another one.
    pub(super) fn plus(self, factor: f64, other: Self) -> Self {
        Self {
            normal: self.normal + factor * other.normal,
            tangent: self.tangent + factor * other.tangent,
        }
    }

    pub(super) fn dot(self, other: Self) -> f64 {
        self.normal * other.normal + self.tangent.dot(other.tangent)
    }
}

/// Computes the sum of the products of all rows.
pub(super) fn dot(a: &[Parts], b: &[Parts]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
