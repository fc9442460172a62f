//! Minima, maxima and interpolation in as few instructions as the certificates allow.

use glam::DVec3;

/// Returns the smaller of two numbers in one instruction; unlike `f64::min`, NaN gives `b`.
#[inline]
pub(crate) fn fast_min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the larger of two numbers in one instruction; unlike `f64::max`, NaN gives `b`.
#[inline]
pub(crate) fn fast_max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns the larger of each coordinate.
#[inline]
pub(crate) fn max_each(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(fast_max(a.x, b.x), fast_max(a.y, b.y), fast_max(a.z, b.z))
}

/// Interpolates linearly, exactly at both ends.
#[inline]
pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// Interpolates points linearly, exactly at both ends.
#[inline]
pub(crate) fn mix_points(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}
