//! Products of vectors.

use glam::{DMat3, DVec3};

/// Computes the outer product a bᵀ.
///
/// ```
/// use surface::{glam::DVec3, vectors::outer};
///
/// let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 4.0, 5.0));
/// assert_eq!(outer(a, b) * DVec3::Y, 4.0 * a);
/// ```
#[inline]
#[must_use]
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Computes the dot product of two lists of vectors, as one vector each, in their order.
///
/// ```
/// use surface::{glam::DVec3, vectors::dot};
///
/// assert_eq!(dot(&[DVec3::X, DVec3::Y], &[DVec3::ONE, 2.0 * DVec3::ONE]), 3.0);
/// ```
#[must_use]
pub fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Adds `factor` times a list of vectors to another.
#[inline]
pub fn add_scaled(to: &mut [DVec3], factor: f64, of: &[DVec3]) {
    for (to, of) in to.iter_mut().zip(of) {
        *to += factor * *of;
    }
}
