//! Vectors at both ends of a step, one end to a SIMD lane.

use glam::DVec3;
use wide::f64x2;

use crate::scalar::{fast_max, fast_min};
use crate::shape::Coordinates;

/// A vector at time 0 and at time 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends {
    pub(crate) x: f64x2,
    pub(crate) y: f64x2,
    pub(crate) z: f64x2,
}

impl Coordinates for Ends {
    #[inline]
    fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        self.each(other, f64x2::fast_min)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        self.each(other, f64x2::fast_max)
    }
}

impl Ends {
    /// Pairs a vector at both ends.
    #[inline]
    pub(crate) fn new(start: DVec3, end: DVec3) -> Self {
        Self {
            x: f64x2::new([start.x, end.x]),
            y: f64x2::new([start.y, end.y]),
            z: f64x2::new([start.z, end.z]),
        }
    }

    #[inline]
    fn each(self, other: Self, f: impl Fn(f64x2, f64x2) -> f64x2) -> Self {
        Self { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }

    #[inline]
    pub(crate) fn plus(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    /// Multiplies all coordinates by a factor per end.
    #[inline]
    pub(crate) fn times(self, factor: f64x2) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    #[inline]
    pub(crate) fn dot(self, other: Self) -> f64x2 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Exchanges both ends.
    #[inline]
    pub(crate) fn swapped(self) -> Self {
        Self { x: swapped(self.x), y: swapped(self.y), z: swapped(self.z) }
    }

    /// Returns the vector of each end.
    #[inline]
    pub(crate) fn to_array(self) -> [DVec3; 2] {
        let ([x0, x1], [y0, y1], [z0, z1]) =
            (self.x.to_array(), self.y.to_array(), self.z.to_array());
        [DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1)]
    }

    /// Interpolates between both ends, exactly at each.
    #[inline]
    pub(crate) fn at(self, t: f64) -> DVec3 {
        let Self { x, y, z } = self.times(f64x2::new([1.0 - t, t]));
        DVec3::new(sum(x), sum(y), sum(z))
    }

    /// Returns the larger absolute value of each coordinate.
    #[inline]
    pub(crate) fn max_abs(self) -> DVec3 {
        DVec3::new(max(self.x.abs()), max(self.y.abs()), max(self.z.abs()))
    }

    /// Returns the smaller value of each coordinate.
    #[inline]
    pub(crate) fn lower(self) -> DVec3 {
        DVec3::new(min(self.x), min(self.y), min(self.z))
    }

    /// Returns the larger value of each coordinate.
    #[inline]
    pub(crate) fn upper(self) -> DVec3 {
        DVec3::new(max(self.x), max(self.y), max(self.z))
    }
}

/// Exchanges the values of both ends.
#[inline]
fn swapped(x: f64x2) -> f64x2 {
    let [start, end] = x.to_array();
    f64x2::new([end, start])
}

/// Adds the values of both ends.
#[inline]
pub(crate) fn sum(x: f64x2) -> f64 {
    let [start, end] = x.to_array();
    start + end
}

#[inline]
fn min(x: f64x2) -> f64 {
    let [start, end] = x.to_array();
    fast_min(start, end)
}

#[inline]
fn max(x: f64x2) -> f64 {
    let [start, end] = x.to_array();
    fast_max(start, end)
}
