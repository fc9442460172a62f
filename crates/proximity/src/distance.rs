//! Distance between two surfaces that do not meet, edges included.

use kdop::Workspace;
use surface::closest_between_triangles;

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
        let closest = closest_between_triangles(a.corners(face_a), b.corners(face_b));
        let distance = closest.distance();
        if distance <= bound {
            bound = distance;
            best = Some(distance);
        }
    });
    best
}
