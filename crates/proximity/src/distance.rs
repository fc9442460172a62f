//! Distance between two surfaces that do not meet, edges included.

use glam::DVec3;
use kdop::Workspace;
use surface::{closest_between_triangles, triangle};

use crate::SurfaceTree;

/// Computes the smallest distance between points of two surfaces, if it is at most
/// `max_distance`.
///
/// The smaller that is, the fewer pairs of faces are compared: the smallest distance of a vertex
/// is a good one.
pub(crate) fn distance_between(
    a: &SurfaceTree,
    b: &SurfaceTree,
    max_distance: f64,
    workspace: &mut Workspace,
) -> Option<f64> {
    // The traversal keeps its margin; pairs beyond the best so far cost one comparison each.
    let mut best = None;
    let mut bound = max_distance;
    a.tree().pairs(b.tree(), max_distance, workspace, |face_a, face_b| {
        let (corners_a, corners_b) = (a.corners(face_a), b.corners(face_b));
        if are_farther(corners_a, corners_b, bound) {
            return;
        }
        let closest = closest_between_triangles(corners_a, corners_b);
        let distance = closest.distance();
        if distance <= bound {
            bound = distance;
            best = Some(distance);
        }
    });
    best
}

/// Returns true if the planes across the normal of one of two triangles keep them farther apart
/// than a distance, by more than rounding.
///
/// Surfaces that run beside each other have many pairs of faces that are little farther than the
/// nearest, and nearly all of them are told by these planes.
#[inline]
pub(crate) fn are_farther(a: [DVec3; 3], b: [DVec3; 3], distance: f64) -> bool {
    /// Bound on the rounding of a height, relative to the largest length.
    const ROUNDING: f64 = 1e-12;

    let size = distance + a[0].abs().max_element() + b[0].abs().max_element();
    let limit = distance + ROUNDING * size;
    [(a, b), (b, a)].into_iter().any(|(own, other)| {
        // All corners of one triangle are in the plane of height 0.
        let normal = triangle::normal(own);
        let [p, q, r] = other.map(|corner| normal.dot(corner - own[0]));
        let height = p.min(q).min(r).max(-p.max(q).max(r));
        height > 0.0 && height * height > limit * limit * normal.length_squared()
    })
}
