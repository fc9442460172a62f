//! Center, radius and quarters of a triangle.

use glam::DVec3;

/// Returns the center of a triangle and the largest distance of a corner from it.
pub(crate) fn radius_about_center(corners: [DVec3; 3]) -> (DVec3, f64) {
    let [a, b, c] = corners;
    let center = (a + b + c) / 3.0;
    let mut radius: f64 = 0.0;
    for corner in corners {
        radius = radius.max(corner.distance(center));
    }
    (center, radius)
}

/// Splits a triangle in four at the middles of its edges.
pub(crate) fn quarters([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}
