//! Bounds on depths by boxes alone.

use scene::{PairId, Scene};
use surface::Aabb;

/// Bounds the depth of a pair by the boxes around the faces of its bodies.
pub(crate) fn max_depth_by_face_boxes(scene: &Scene, pair: PairId) -> f64 {
    max_depth_by_boxes(scene, pair, pair.bodies().map(|id| scene.body(id).face_bounds()))
}

/// Bounds the depth of a pair by boxes around its bodies.
///
/// A point in both boxes leaves a body, and so meets its surface, within the way out of that
/// body's box along any axis.
pub(crate) fn max_depth_by_boxes(scene: &Scene, pair: PairId, boxes: [Aabb; 2]) -> f64 {
    let common = boxes[0].intersection(boxes[1]);
    if common.is_empty() {
        return 0.0;
    }

    let mut upper: f64 = 0.0;
    for (id, of_body) in pair.bodies().into_iter().zip(boxes) {
        if scene.body(id).has_inside().is_ok() {
            let way = (of_body.max - common.min).min(common.max - of_body.min);
            upper = upper.max(way.min(0.5 * of_body.sides()).min_element());
        }
    }
    upper
}
