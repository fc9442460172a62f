//! Inside or outside: winding numbers by solid angles, and the crossings of a
//! ray along +x for parity.
//!
//! The winding number looks at every face and serves as the reference. The ray
//! needs only the faces it may meet, and finds by exact signs which of them it
//! does meet, so that a ray through an edge or a corner counts it once.
//!
//! Sources: A. Van Oosterom and J. Strackee, "The Solid Angle of a Plane
//! Triangle", IEEE Transactions on Biomedical Engineering 30(2), 1983, eq. 8;
//! H. Edelsbrunner and E. P. Mücke, "Simulation of Simplicity", ACM Transactions
//! on Graphics 9(1), 1990, for the ties. Differs in taking the sign of each solid
//! angle from an exact orientation.
//!
//! # Points on the surface
//!
//! A ray starts as though its point were moved up by an infinitesimal amount in x,
//! by one infinitely smaller in y, and by one smaller again in z. So a point on a
//! closed surface counts as inside where the ray enters the solid from it, and
//! each point of space is either inside or outside, also when the surface is cut
//! into other triangles. The winding number of a point on a face is 1/2, and on
//! an edge or at a corner the share of directions that lead inside, to rounding.

use std::f64::consts::PI;

use glam::DVec3;

use crate::predicates::{Sign, side_of_plane, turn, without};
use crate::{Positions, TriangleSurface};

/// Solid angle that a triangle covers seen from `p` \[sr\], from −2π to 2π:
/// positive where `p` is behind it, so that its corners run clockwise.
///
/// Its sign is exact. Zero for a point in the triangle's plane, and for a
/// triangle without area.
///
/// ```
/// use std::f64::consts::PI;
/// use surface::{glam::DVec3, solid_angle};
///
/// // An octant.
/// let angle = solid_angle(DVec3::ZERO, [DVec3::X, DVec3::Y, DVec3::Z]);
/// assert!((angle - PI / 2.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn solid_angle(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let side = side_of_plane(corners, p);
    if side == 0 {
        return 0.0;
    }
    let [a, b, c] = corners.map(|corner| corner - p);
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let triple = a.dot(b.cross(c)).abs();
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    -f64::from(side) * 2.0 * triple.atan2(denominator)
}

/// How many times a surface winds about `p`: 1 inside of a closed surface whose
/// faces look outward, 0 outside of it, a fraction where it is open.
///
/// Takes every face: the reference that quicker answers are compared with. For
/// a closed surface and a point δ away from the nearest edge it is within
/// `1e-14 L / δ` of a whole number, L being the size of the faces there; over
/// the inside of a face, points may be as near as coordinates can tell.
///
/// ```
/// use surface::{TriangleSurface, glam::DVec3, winding_number};
///
/// let tetrahedron = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let x = tetrahedron.positions(&x)?;
/// assert!((winding_number(&tetrahedron, x, DVec3::splat(0.1)) - 1.0).abs() < 1e-15);
/// assert!(winding_number(&tetrahedron, x, DVec3::ONE).abs() < 1e-15);
/// # Ok::<(), surface::SurfaceError>(())
/// ```
///
/// # Panics
///
/// When `x` was checked against a surface with fewer vertices.
#[must_use]
pub fn winding_number(surface: &TriangleSurface, x: Positions<'_>, p: DVec3) -> f64 {
    let total: f64 = surface.faces().iter().map(|face| solid_angle(p, x.corners(*face))).sum();
    total / (4.0 * PI)
}

/// Whether the ray from `p` along +x passes a triangle, and how: `Some(1)` out
/// through its back, so that it leaves a solid, `Some(-1)` in through its front.
///
/// Exact, for coordinates that are zero or between 1e-90 and 1e90 in size. Over
/// the faces of a closed surface the signs sum to the winding number, and an odd
/// number of passages means inside; faces that were left out because the ray
/// surely misses them change neither. A ray through an edge or a corner passes
/// as one beside it does; a triangle parallel to the ray is never passed. Points
/// on the triangle: see the module's head.
///
/// ```
/// use surface::{glam::DVec3, ray_crosses_triangle};
///
/// let wall = [DVec3::X, DVec3::new(1.0, 4.0, 0.0), DVec3::new(1.0, 0.0, 4.0)];
/// let from = |x: f64| DVec3::new(x, 1.0, 1.0);
/// assert_eq!(ray_crosses_triangle(from(0.0), wall), Some(1));
/// assert_eq!(ray_crosses_triangle(from(2.0), wall), None);
/// // Two walls share an edge, and the ray that meets it passes one of them.
/// let other = [DVec3::X, DVec3::new(1.0, 0.0, 4.0), DVec3::new(1.0, -4.0, 0.0)];
/// let at_edge = DVec3::new(0.0, 0.0, 1.0);
/// let passed = [wall, other].map(|corners| ray_crosses_triangle(at_edge, corners).is_some());
/// assert_eq!(passed.iter().filter(|passed| **passed).count(), 1);
/// ```
#[inline]
#[must_use]
pub fn ray_crosses_triangle(p: DVec3, corners: [DVec3; 3]) -> Option<i32> {
    if !(spans(corners.map(|c| c.y), p.y) && spans(corners.map(|c| c.z), p.z)) {
        return None;
    }
    if corners.iter().all(|c| c.x <= p.x) {
        return None;
    }
    let sign = turns_about(p, corners)?;
    let ahead = corners.iter().all(|c| c.x > p.x) || side_of_plane(corners, p) == -sign;
    ahead.then_some(sign)
}

/// [`ray_crosses_triangle`] for a point that is moved down by the infinitesimal instead of up.
///
/// With both, the corners of two surfaces are told inside or outside of each other as if one of
/// the surfaces were moved: the corners of the moved one by a point moved up, those of the other
/// by a point moved down.
///
/// ```
/// use surface::{glam::DVec3, ray_crosses_triangle, ray_crosses_triangle_from_below};
///
/// let wall = [DVec3::X, DVec3::new(1.0, 4.0, 0.0), DVec3::new(1.0, 0.0, 4.0)];
/// let on_wall = DVec3::new(1.0, 1.0, 1.0);
/// assert_eq!(ray_crosses_triangle(on_wall, wall), None);
/// assert_eq!(ray_crosses_triangle_from_below(on_wall, wall), Some(1));
/// ```
#[inline]
#[must_use]
pub fn ray_crosses_triangle_from_below(p: DVec3, corners: [DVec3; 3]) -> Option<i32> {
    // Half a turn about the ray takes the move down, across the ray, to a move up.
    let half_turn = |v: DVec3| DVec3::new(v.x, -v.y, -v.z);
    let (p, corners) = (half_turn(p), corners.map(half_turn));
    if !(spans(corners.map(|c| c.y), p.y) && spans(corners.map(|c| c.z), p.z)) {
        return None;
    }
    if corners.iter().all(|c| c.x < p.x) {
        return None;
    }
    let sign = turns_about(p, corners)?;
    // A point in the plane is moved back, so that the plane is ahead.
    let ahead = corners.iter().all(|c| c.x > p.x) || side_of_plane(corners, p) != sign;
    ahead.then_some(sign)
}

/// Whether a coordinate infinitesimally above `p` is within the corners' range.
#[inline]
fn spans(corners: [f64; 3], p: f64) -> bool {
    let above = corners.map(|c| c > p);
    above.contains(&true) && above.contains(&false)
}

/// Direction in which the corners, seen along −x, run about `p`; `None` where
/// they do not.
fn turns_about(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<Sign> {
    let flat = |x: DVec3| without(0, x);
    let sign = turn_beside(flat(a), flat(b), flat(p));
    let same = |from, to| turn_beside(flat(from), flat(to), flat(p)) == sign;
    (sign != 0 && same(b, c) && same(c, a)).then_some(sign)
}

/// Turning direction of `a`, `b` and a point infinitesimally beside `p`: up in
/// the first coordinate, and by infinitely less in the second. 0 only where `a`
/// and `b` are one point.
fn turn_beside(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> Sign {
    let order = |x: f64, y: f64| i32::from(x > y) - i32::from(x < y);
    [turn(a, b, p), order(a[1], b[1]), order(b[0], a[0])]
        .into_iter()
        .find(|sign| *sign != 0)
        .unwrap_or(0)
}
