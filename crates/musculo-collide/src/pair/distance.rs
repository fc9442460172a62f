//! Distance between two surfaces that do not meet, edges included.

use surface::closest_between_triangles;

use super::Scratch;
use crate::scene::Body;

/// The smallest distance between points of both surfaces, if it is at most
/// `within`: the smallest distance of a vertex, where one is known, leaves few
/// faces to compare.
pub(super) fn between(a: &Body, b: &Body, within: f64, scratch: &mut Scratch) -> Option<f64> {
    let mut best = None;
    let mut bound = within;
    a.tree().pairs(b.tree(), within, &mut scratch.traversal, |fa, fb| {
        let distance = closest_between_triangles(a.corners(fa), b.corners(fb)).distance();
        if distance <= bound {
            bound = distance;
            best = Some(distance);
        }
    });
    best
}
