//! Axis-aligned bounding boxes.

use glam::DVec3;

/// Axis-aligned bounding box, by its lower and its upper corner.
///
/// Empty where a coordinate of `min` exceeds that of `max`, as in [`Aabb::EMPTY`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box of no point, which every union leaves unchanged.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Computes the smallest box that contains all points.
    ///
    /// ```
    /// use surface::{Aabb, glam::DVec3};
    ///
    /// let bounds = Aabb::of_points([DVec3::new(1.0, 5.0, 0.0), DVec3::new(4.0, 1.0, 0.0)]);
    /// assert_eq!(bounds.min, DVec3::new(1.0, 1.0, 0.0));
    /// assert_eq!(bounds.diagonal(), 5.0);
    /// assert!(Aabb::of_points([]).is_empty());
    /// ```
    #[inline]
    #[must_use]
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }

    /// Returns the smallest box that contains this box and a point.
    #[inline]
    #[must_use]
    pub fn with_point(self, p: DVec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// Returns the smallest box that contains both boxes.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns the box of the points in both boxes, empty where they are disjoint.
    #[inline]
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Returns the box moved outward by `margin` on every side.
    #[inline]
    #[must_use]
    pub fn inflate(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Returns true if no point is in the box.
    #[inline]
    #[must_use]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Returns true if the boxes share a point; boxes that touch do.
    #[inline]
    #[must_use]
    pub fn overlaps(self, other: Self) -> bool {
        !self.intersection(other).is_empty()
    }

    /// Returns true if the point is in the box or on its border.
    #[inline]
    #[must_use]
    pub fn contains(self, p: DVec3) -> bool {
        self.min.cmple(p).all() && p.cmple(self.max).all()
    }

    /// Returns the center; not finite for an empty box.
    #[inline]
    #[must_use]
    pub fn center(self) -> DVec3 {
        self.min.midpoint(self.max)
    }

    /// Returns the lengths of the sides; negative for an empty box.
    #[inline]
    #[must_use]
    pub fn sides(self) -> DVec3 {
        self.max - self.min
    }

    /// Returns the length of the diagonal, 0 for an empty box.
    #[inline]
    #[must_use]
    pub fn diagonal(self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.distance(self.max) }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "exact by construction")]

    use super::*;

    #[test]
    fn boxes_that_touch_overlap() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let beside = Aabb { min: DVec3::X, max: DVec3::X + DVec3::ONE };
        assert!(unit.overlaps(beside) && unit.contains(DVec3::X));
        assert_eq!(unit.intersection(beside).sides(), DVec3::new(0.0, 1.0, 1.0));
        assert_eq!(unit.union(beside).center(), DVec3::new(1.0, 0.5, 0.5));
        assert!(!unit.overlaps(beside.inflate(-0.1)));
    }

    #[test]
    fn the_empty_box_holds_nothing_and_changes_no_union() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        assert!(Aabb::EMPTY.is_empty() && !Aabb::EMPTY.contains(DVec3::ZERO));
        assert!(!Aabb::EMPTY.overlaps(unit));
        assert_eq!(Aabb::EMPTY.union(unit), unit);
        assert_eq!(Aabb::EMPTY.diagonal(), 0.0);
    }
}
