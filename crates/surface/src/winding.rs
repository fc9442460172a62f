//! Containment primitives: winding numbers by solid angles, and crossings of a ray
//! along +x for parity.
//!
//! The winding number sums over all faces and serves as the reference. The ray needs
//! only the faces that its line may cross, and decides each by exact predicates, so that
//! a crossing of an edge or a corner counts once.
//!
//! Sources: A. Van Oosterom and J. Strackee, "The Solid Angle of a Plane
//! Triangle", IEEE Transactions on Biomedical Engineering 30(2), 1983, eq. 8;
//! H. Edelsbrunner and E. P. Mücke, "Simulation of Simplicity", ACM Transactions
//! on Graphics 9(1), 1990, for the ties. Differs in taking the sign of each solid
//! angle from an exact orientation.
//!
//! # Points on the surface
//!
//! A ray starts as though its origin were moved up by an infinitesimal amount in x,
//! by one infinitely smaller in y, and by one smaller again in z. So a point on a
//! closed surface counts as inside where the ray enters the solid from it, and
//! each point of space is either inside or outside, also when the surface is cut
//! into other triangles. The winding number of a point on a face is 1/2, and on
//! an edge or at a corner the fraction of directions that lead inside, to rounding.

use std::f64::consts::PI;

use glam::DVec3;

use crate::predicates::{Sign, side_of_plane, sign, turn, without};
use crate::{Positions, TriangleSurface};

/// Computes the solid angle of a triangle at `p` \[sr\], from −2π to 2π: positive
/// where `p` is behind the triangle, so that its corners run clockwise.
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

/// Computes the winding number of a surface about `p`: 1 inside of a closed surface
/// whose faces point outward, 0 outside of it, a fraction where it is open.
///
/// Sums over all faces: the reference for faster methods. For a closed surface and a
/// point at distance δ from the nearest edge the result is within `1e-14 L / δ` of a
/// whole number, L being the size of the faces there; over the interior of a face,
/// points may be as near as coordinates can represent.
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

/// Returns the direction in which the ray from `p` along +x crosses a triangle: `Some(1)`
/// out through its back, `Some(-1)` in through its front, `None` where it does not.
///
/// Exact, for coordinates that are zero or between 1e-90 and 1e90 in size. Over
/// the faces of a closed surface the signs sum to the winding number, and an odd
/// number of crossings means inside; leaving out faces that the ray cannot reach
/// changes neither. A ray through an edge or a corner crosses as one beside it
/// does; a triangle parallel to the ray is never crossed. Points on the triangle:
/// see the module's documentation.
///
/// ```
/// use surface::{glam::DVec3, ray_crosses_triangle};
///
/// let wall = [DVec3::X, DVec3::new(1.0, 4.0, 0.0), DVec3::new(1.0, 0.0, 4.0)];
/// let from = |x: f64| DVec3::new(x, 1.0, 1.0);
/// assert_eq!(ray_crosses_triangle(from(0.0), wall), Some(1));
/// assert_eq!(ray_crosses_triangle(from(2.0), wall), None);
/// // Two walls share an edge, and a ray through it crosses one of them.
/// let other = [DVec3::X, DVec3::new(1.0, 0.0, 4.0), DVec3::new(1.0, -4.0, 0.0)];
/// let at_edge = DVec3::new(0.0, 0.0, 1.0);
/// let crossed = [wall, other].map(|corners| ray_crosses_triangle(at_edge, corners).is_some());
/// assert_eq!(crossed.iter().filter(|crossed| **crossed).count(), 1);
/// ```
#[inline]
#[must_use]
pub fn ray_crosses_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<i32> {
    // Boxes: nearly all faces end here.
    if !(spans([a.y, b.y, c.y], p.y) && spans([a.z, b.z, c.z], p.z)) {
        return None;
    }
    if a.x <= p.x && b.x <= p.x && c.x <= p.x {
        return None;
    }

    // The line crosses where the corners run around it; the ray, where it starts behind.
    let sign = turns_about(p, [a, b, c])?;
    let is_ahead = a.x > p.x && b.x > p.x && c.x > p.x;
    (is_ahead || side_of_plane([a, b, c], p) == -sign).then_some(sign)
}

/// Returns [`ray_crosses_triangle`] for a point that is moved down by the infinitesimal
/// instead of up.
///
/// Together they classify the corners of two surfaces as if one of the surfaces were
/// moved: the corners of the moved one by points moved up, those of the other by points
/// moved down.
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
pub fn ray_crosses_triangle_from_below(p: DVec3, [a, b, c]: [DVec3; 3]) -> Option<i32> {
    // Half a turn about the ray takes the move down, across the ray, to a move up.
    if !(spans([-a.y, -b.y, -c.y], -p.y) && spans([-a.z, -b.z, -c.z], -p.z)) {
        return None;
    }
    if a.x < p.x && b.x < p.x && c.x < p.x {
        return None;
    }

    // A point in the plane is moved back, so that the plane is ahead.
    let half_turn = |v: DVec3| DVec3::new(v.x, -v.y, -v.z);
    let (p, corners) = (half_turn(p), [a, b, c].map(half_turn));
    let sign = turns_about(p, corners)?;
    let is_ahead = a.x > p.x && b.x > p.x && c.x > p.x;
    (is_ahead || side_of_plane(corners, p) != sign).then_some(sign)
}

/// Returns true if a coordinate infinitesimally above `p` is within the corners' range.
#[inline]
fn spans(corners: [f64; 3], p: f64) -> bool {
    let above = corners.map(|c| c > p);
    above.contains(&true) && above.contains(&false)
}

/// Returns the direction in which the corners, viewed along −x, run about `p`; `None`
/// where they do not.
fn turns_about(p: DVec3, corners: [DVec3; 3]) -> Option<Sign> {
    let [a, b, c] = corners.map(|corner| without(0, corner));
    let p = without(0, p);
    let sign = turn_beside(a, b, p);
    let same = sign != 0 && turn_beside(b, c, p) == sign && turn_beside(c, a, p) == sign;
    same.then_some(sign)
}

/// Returns the turning direction of `a`, `b` and a point infinitesimally beside `p`: up in
/// the first coordinate, and by infinitely less in the second. 0 only where `a`
/// and `b` are one point.
fn turn_beside(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> Sign {
    let (exact, down, left) = (turn(a, b, p), sign(a[1] - b[1]), sign(b[0] - a[0]));
    [exact, down, left].into_iter().find(|sign| *sign != 0).unwrap_or(0)
}
