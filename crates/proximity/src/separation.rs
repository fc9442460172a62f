//! Certified bounds on the distance between two surfaces.
//!
//! The lower bound is that of a separating direction: along any direction, the distance
//! between two triangles is at least the interval between their projections. Along the line
//! of their closest points it is the distance itself, up to rounding. So the closest points
//! only suggest a direction, and an error of theirs makes the bound smaller, never wrong.

use glam::DVec3;
use kdop::Workspace;
use surface::closest_between_triangles;

use crate::SurfaceTree;
use crate::distance::are_farther;

/// Certified bounds on the distance between two surfaces: `lower <= distance <= upper`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SeparationBounds {
    /// Lower bound, rounding included; 0 where the surfaces may meet.
    pub lower: f64,
    /// Distance of two points of the surfaces, up to its own rounding.
    pub upper: f64,
    /// Faces that hold these points, of the first and of the second surface.
    pub faces: [u32; 2],
    /// These points.
    pub points: [DVec3; 2],
}

impl SeparationBounds {
    /// Computes bounds on the distance between two surfaces; `None` where it is certainly
    /// larger than `max_distance`.
    ///
    /// `lower` is at most `max_distance`: farther faces are not compared. Whether one surface
    /// is inside the other is not examined.
    ///
    /// ```
    /// use kdop::Workspace;
    /// use proximity::{SeparationBounds, SurfaceTree};
    /// use proximity::glam::DVec3;
    ///
    /// let cube = fixtures::shapes::cube(1.0);
    /// let far = cube.clone().translated(1.25 * DVec3::X);
    /// let [a, b] = [cube, far].map(|mesh| SurfaceTree::new(mesh.surface(), mesh.positions));
    /// let (a, b, workspace) = (a?, b?, &mut Workspace::default());
    ///
    /// let bounds = SeparationBounds::compute(&a, &b, 0.5, workspace).ok_or("they are near")?;
    /// assert!(bounds.lower <= 0.25 && 0.25 <= bounds.upper);
    /// assert!(bounds.upper - bounds.lower < 1e-13);
    /// assert!(SeparationBounds::compute(&a, &b, 0.125, workspace).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn compute(
        a: &SurfaceTree,
        b: &SurfaceTree,
        max_distance: f64,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        let mut bounds: Option<Self> = None;
        a.tree().pairs(b.tree(), max_distance, workspace, |face_a, face_b| {
            // Most pairs of faces are told apart by their planes.
            let corners = [a.corners(face_a), b.corners(face_b)];
            let limit = bounds.map_or(max_distance, |bounds| bounds.lower);
            if are_farther(corners[0], corners[1], limit) {
                return;
            }

            let closest = closest_between_triangles(corners[0], corners[1]);
            let [on_a, on_b] = closest.points;
            let lower = interval_along(on_b - on_a, corners[0], corners[1]);
            if lower > limit {
                return;
            }
            let (upper, faces) = (closest.distance(), [face_a, face_b]);
            let found = Self { lower, upper, faces, points: closest.points };
            bounds = Some(bounds.map_or(found, |bounds| bounds.merged(found)));
        });
        bounds
    }

    /// Returns the bounds on the smaller of two distances, with the nearer points.
    fn merged(self, other: Self) -> Self {
        let nearest = if other.upper < self.upper { other } else { self };
        Self { lower: self.lower.min(other.lower), ..nearest }
    }
}

/// Computes a lower bound on the interval between the projections of two triangles on a
/// direction, from the first to the second; 0 where they overlap.
fn interval_along(direction: DVec3, a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    /// Bound on the rounding of a difference and of a dot product, relative to the sum of
    /// the magnitudes of the products: four roundings of 2⁻⁵³ each, doubled.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;

    let mut interval = f64::INFINITY;
    for p in a {
        for q in b {
            let difference = q - p;
            let magnitude = difference.abs().dot(direction.abs());
            interval = interval.min(difference.dot(direction) - ROUNDING * magnitude);
        }
    }

    // The length is rounded up.
    let length = direction.length() * (1.0 + ROUNDING);
    if interval > 0.0 { interval / length * (1.0 - ROUNDING) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    #[test]
    fn bounds_hold_a_planted_distance_far_from_the_origin() {
        let mut random = Random(7);
        for _ in 0..2000 {
            // Coordinates of few bits, so that all differences are exact.
            let mut number = |scale: f64| (random.unit() * scale * 1024.0).round() / 1024.0;
            let origin = DVec3::new(number(512.0), number(512.0), number(512.0));
            let gap = number(8.0) + 1.0 / 65536.0;
            let floor = [DVec3::ZERO, 8.0 * DVec3::X, 8.0 * DVec3::Y].map(|p| p + origin);
            let tip = origin + DVec3::new(1.0 + number(0.5), 1.0 + number(0.5), gap);
            let up = [DVec3::ZERO, DVec3::new(0.5, 0.25, 1.0), DVec3::new(-0.25, 0.5, 1.0)];
            let over = up.map(|p| p + tip);

            let [on_floor, on_tip] = closest_between_triangles(floor, over).points;
            let lower = interval_along(on_tip - on_floor, floor, over);
            assert!(lower <= gap, "{lower} > {gap}");
            assert!(gap - lower < 1e-10, "{lower} is far below {gap}");
        }
    }

    #[test]
    fn a_wrong_direction_makes_the_bound_smaller() {
        let floor = [DVec3::ZERO, 8.0 * DVec3::X, 8.0 * DVec3::Y];
        let over = floor.map(|p| p + 0.5 * DVec3::Z);
        assert!((interval_along(DVec3::Z, floor, over) - 0.5).abs() < 1e-14);
        let aslant = interval_along(DVec3::new(0.01, 0.0, 1.0), floor, over);
        assert!(aslant < 0.5 && aslant > 0.4, "{aslant}");
        assert!(interval_along(DVec3::X, floor, over) == 0.0, "projections overlap");
    }
}
