//! Exact geometric predicates: orientation in space and in a coordinate plane, and
//! collinearity of three points.
//!
//! Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and
//! Fast Robust Geometric Predicates", Discrete & Computational Geometry 18,
//! 1997, by way of the `robust` crate.
//!
//! Exact where no partial product overflows or underflows: coordinates that are
//! zero or between 1e-90 and 1e90 in size.

use glam::DVec3;
use robust::{Coord, Coord3D};

/// Sign of a predicate: `−1`, `0` or `1`.
pub(crate) type Sign = i32;

/// Returns the side of the plane through `a`, `b`, `c` that holds `p`: 1 where
/// `(b − a) × (c − a)` points, 0 in the plane.
#[inline]
pub(crate) fn side_of_plane(corners: [DVec3; 3], p: DVec3) -> Sign {
    exact_side(RoundedPlane::new(corners).side(p), corners, p)
}

/// Returns a side that rounded numbers have decided, or the exact one where they have not.
#[inline]
fn exact_side(rounded: Sign, corners: [DVec3; 3], p: DVec3) -> Sign {
    if rounded == 0 { sign(height_over_plane(corners, p)) } else { rounded }
}

/// Computes `((b − a) × (c − a)) · (p − a)` with an exact sign.
pub(crate) fn height_over_plane([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c, p] = [a, b, c, p].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    -robust::orient3d(a, b, c, p)
}

/// Returns the sides of the plane of `corners` that hold three points.
///
/// One normal serves the three, as far as a bound on its rounding allows; the exact
/// predicate is evaluated only within that bound.
#[inline]
pub(crate) fn sides_of_plane(corners: [DVec3; 3], points: [DVec3; 3]) -> [Sign; 3] {
    // The rounded heights decide nearly always; 0 stands for "within rounding".
    let plane = RoundedPlane::new(corners);
    let [p, q, r] = points;
    let (sp, sq, sr) = (plane.side(p), plane.side(q), plane.side(r));
    if sp != 0 && sq != 0 && sr != 0 {
        return [sp, sq, sr];
    }

    [(sp, p), (sq, q), (sr, r)].map(|(side, p)| exact_side(side, corners, p))
}

/// Plane of a triangle in rounded numbers: the filter before the exact predicate.
struct RoundedPlane {
    corner: DVec3,
    normal: DVec3,
    /// Bound on the rounding of a height over the plane, relative to the [`size`] of `p − corner`.
    bound: f64,
}

impl RoundedPlane {
    #[inline]
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        Self { corner: a, normal: u.cross(v), bound: PLANE_ROUNDING * size(u) * size(v) }
    }

    /// Returns the side of the plane that holds a point, or 0 within the bound on rounding.
    #[inline]
    fn side(&self, p: DVec3) -> Sign {
        let r = p - self.corner;
        let height = self.normal.dot(r);
        if height.abs() > self.bound * size(r) { sign(height) } else { 0 }
    }
}

/// Bound on the rounding of `(u × v) · r` relative to the product of the largest
/// components of u, v and r: it is a sum of six products, each of three rounded
/// differences that then pass at most five more roundings, 6 · 8 u = 24 ε, and a
/// little for higher orders.
const PLANE_ROUNDING: f64 = 25.0 * f64::EPSILON;

/// Returns the turning direction of `a`, `b`, `p` in a coordinate plane: 1
/// counter-clockwise.
pub(crate) fn turn(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> Sign {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    sign(robust::orient2d(coord(a), coord(b), coord(p)))
}

/// Returns the two coordinates other than `axis`, in cyclic order.
pub(crate) fn without(axis: usize, p: DVec3) -> [f64; 2] {
    [p[(axis + 1) % 3], p[(axis + 2) % 3]]
}

/// Finds an axis along which three points project to a triangle with area; `None`
/// where they are collinear.
pub(crate) fn projection_axis([a, b, c]: [DVec3; 3]) -> Option<usize> {
    let (u, v) = (b - a, c - a);
    let normal = u.cross(v).abs();

    // Along the normal's largest component the projection is largest.
    let widest = if normal.x >= normal.y && normal.x >= normal.z {
        0
    } else if normal.y >= normal.z {
        1
    } else {
        2
    };
    if normal[widest] > PLANE_ROUNDING * size(u) * size(v) {
        return Some(widest);
    }

    (0..3).find(|&axis| turn(without(axis, a), without(axis, b), without(axis, c)) != 0)
}

#[inline]
fn size(v: DVec3) -> f64 {
    v.abs().max_element()
}

#[inline]
pub(crate) fn sign(x: f64) -> Sign {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_follow_the_right_hand() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(side_of_plane(corners, DVec3::Z), 1);
        assert_eq!(sides_of_plane(corners, [DVec3::Z, DVec3::X, -DVec3::Z]), [1, 0, -1]);
        assert_eq!(turn([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]), 1);
        assert_eq!(projection_axis(corners), Some(2));
        assert_eq!(projection_axis([DVec3::ZERO, DVec3::ONE, DVec3::ONE * 3.0]), None);
    }

    /// Filtered signs equal the exact ones for points within ulps of a plane.
    #[test]
    fn the_filter_agrees_with_the_exact_sign() {
        fixtures::generate::cases(21, 1000, |u| {
            let mut coordinate = || Ok(f64::from(u.arbitrary::<i32>()?) / 2.0_f64.powi(31));
            let mut point = || Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
            let corners = [point()?, point()?, point()?];
            let (s, t) = (point()?, point()?);
            let points = [0, 1, 2].map(|k| {
                let foot = corners[0].lerp(corners[1], s[k]).lerp(corners[2], t[k]);
                let ulp = if k == 0 { 0.0 } else { f64::EPSILON };
                foot + ulp * s
            });
            let exact = points.map(|p| sign(height_over_plane(corners, p)));
            assert_eq!(sides_of_plane(corners, points), exact, "{corners:?} {points:?}");
            let single = points.map(|p| side_of_plane(corners, p));
            assert_eq!(single, exact, "{corners:?} {points:?}");
            Ok(())
        });
    }

    /// Differences of points on a line are rounded apart: the line spans no plane for that.
    #[test]
    fn points_on_a_line_have_no_projection_with_area() {
        fixtures::generate::cases(22, 200, |u| {
            let mut coordinate = || Ok(f64::from(u.arbitrary::<i32>()?));
            let d = DVec3::new(coordinate()?, coordinate()?, coordinate()?);
            let corners = [1.0, 2.0_f64.powi(31), -3.0 * 2.0_f64.powi(28)].map(|t| t * d);
            assert_eq!(projection_axis(corners), None, "{corners:?}");
            Ok(())
        });
    }
}
