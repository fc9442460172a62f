//! Normals, areas and volumes of single triangles.
//!
//! A [`normal`] has twice the triangle's area as its length; functions that need the area
//! as well take it from there instead of computing the cross product again.

use glam::DVec3;

/// Computes `(b − a) × (c − a)`: the normal that points to where the corners run
/// counter-clockwise, with twice the area as its length.
#[inline]
#[must_use]
pub fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Computes the unit normal; zero for a triangle without area.
#[inline]
#[must_use]
pub fn unit_normal(corners: [DVec3; 3]) -> DVec3 {
    normal(corners).normalize_or_zero()
}

/// Computes the area.
///
/// ```
/// use surface::{glam::DVec3, triangle};
///
/// assert_eq!(triangle::area([DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 3.0]), 6.0);
/// ```
#[inline]
#[must_use]
pub fn area(corners: [DVec3; 3]) -> f64 {
    0.5 * normal(corners).length()
}

/// Returns the center of a triangle and the largest distance of a corner from it.
#[must_use]
pub fn radius_about_center(corners: [DVec3; 3]) -> (DVec3, f64) {
    let [a, b, c] = corners;
    let center = (a + b + c) / 3.0;
    let mut radius: f64 = 0.0;
    for corner in corners {
        radius = radius.max(corner.distance(center));
    }
    (center, radius)
}

/// Splits a triangle in four at the middles of its edges.
#[must_use]
pub fn quarters([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Computes the triple product `(a − p) · ((b − p) × (c − p))`: six times the signed volume
/// of the tetrahedron over the triangle with apex `p`, positive where `p` is behind the
/// triangle.
#[inline]
#[must_use]
pub fn triple_product([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    (a - p).dot((b - p).cross(c - p))
}

/// Computes the signed volume enclosed by triangles; negative where they face inward.
///
/// `origin` changes the result by rounding only where the triangles are closed: a point
/// near them loses the fewest digits.
///
/// ```
/// use surface::{glam::DVec3, triangle};
///
/// let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|face| face.map(|v: usize| x[v]));
/// assert_eq!(triangle::signed_volume(faces, x[0]), 1.0 / 6.0);
/// ```
#[must_use]
pub fn signed_volume(triangles: impl IntoIterator<Item = [DVec3; 3]>, origin: DVec3) -> f64 {
    let six_volumes = triangles.into_iter().map(|corners| triple_product(corners, origin));
    six_volumes.sum::<f64>() / 6.0
}

/// Returns the ends of edge `k`, from corner `k` to the next.
#[inline]
pub(crate) fn edge(corners: [DVec3; 3], k: usize) -> [DVec3; 2] {
    [corners[k], corners[(k + 1) % 3]]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "exact by construction")]

    use super::*;

    #[test]
    fn a_triangle_without_area_has_no_unit_normal() {
        let needle = [DVec3::ZERO, DVec3::ONE, 2.0 * DVec3::ONE];
        assert_eq!(unit_normal(needle), DVec3::ZERO);
        assert_eq!(unit_normal([DVec3::ZERO, DVec3::X * 3.0, DVec3::Y]), DVec3::Z);
    }

    #[test]
    fn volume_changes_its_sign_with_the_orientation() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let [a, b, c] = corners;
        assert_eq!(triple_product(corners, DVec3::ZERO), 1.0);
        assert_eq!(triple_product([a, c, b], DVec3::ZERO), -1.0);
    }
}
