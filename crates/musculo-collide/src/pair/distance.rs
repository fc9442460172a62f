//! Distance between two surfaces that do not meet, edges included.

use kdop::Workspace;
use surface::closest_between_triangles;

use crate::shape::Shape;

/// The smallest distance between points of both surfaces, if it is at most
/// `within`: the smallest distance of a vertex, where one is known, leaves few
/// faces to compare.
pub(super) fn between(a: &Shape, b: &Shape, within: f64, traversal: &mut Workspace) -> Option<f64> {
    let mut best = None;
    let mut bound = within;
    a.tree().pairs(b.tree(), within, traversal, |fa, fb| {
        let distance = closest_between_triangles(a.corners(fa), b.corners(fb)).distance();
        if distance <= bound {
            bound = distance;
            best = Some(distance);
        }
    });
    best
}
