//! Closest points on segments and triangles, and between them.
//!
//! A triangle whose angle at its first corner is neither small nor flat is
//! solved by its Gram matrix. A sliver would lose twice its digits there: it is
//! solved about its longest edge, along which a dot product is accurate however
//! thin the triangle is, and at right angles to it. A triangle that has
//! collapsed is treated as its three edges.
//!
//! Source: C. Ericson, *Real-Time Collision Detection*, 2005, sections 5.1.2,
//! 5.1.5 and 5.1.9. Differs in the treatment of slivers and of nearly parallel
//! segments, and in returning the feature that holds the foot.
//!
//! # Accuracy
//!
//! With L the longest edge and u = 2⁻⁵³, the distance to the returned foot
//! exceeds the exact distance by at most `256 u (L + |p − a| + |p|)`, for needles
//! and caps of any thinness and offsets from the origin up to 10⁶ edge lengths.
//! The tests hold this against rational arithmetic.
//!
//! Squares of lengths must not overflow or underflow: lengths from 1e-150 to
//! 1e150. The result is finite there for any finite input.

use glam::DVec3;

use crate::triangle::edge;

/// Weights of a triangle's corners: non-negative, with the sum 1. Their zeros are positive.
pub type Barycentric = [f64; 3];

/// Feature of a triangle: its interior, an edge or a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TriangleFeature {
    /// The interior of the face.
    Face,
    /// The interior of the edge from corner `k` to the next.
    Edge(usize),
    /// Corner `k`.
    Corner(usize),
}

/// Closest point of a segment to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestOnSegment {
    /// The foot, in the caller's length unit.
    pub point: DVec3,
    /// Parameter of the foot from the first end to the second, in `0.0..=1.0`.
    pub t: f64,
}

/// Closest point of a triangle to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestOnTriangle {
    /// The foot, in the caller's length unit.
    pub point: DVec3,
    /// Barycentric coordinates of the foot.
    pub barycentric: Barycentric,
    /// Feature that holds the foot: the corners with non-zero weights.
    pub feature: TriangleFeature,
}

/// Closest points of two segments to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestBetweenSegments {
    /// The foot on the first segment, then that on the second.
    pub points: [DVec3; 2],
    /// Parameter along the first segment, in `0.0..=1.0`.
    pub s: f64,
    /// Parameter along the second segment, in `0.0..=1.0`.
    pub t: f64,
}

/// Closest points of two triangles to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestBetweenTriangles {
    /// The foot on the first triangle, then that on the second.
    pub points: [DVec3; 2],
    /// Barycentric coordinates of both feet.
    pub barycentric: [Barycentric; 2],
}

/// Squared sine of the angle at a triangle's first corner, below which the triangle
/// counts as a sliver; and of the angle between two segments, below which they count
/// as nearly parallel.
///
/// Its inverse is the precision that the quick way may lose: here 6 bits of 53, at
/// 7 degrees. A smaller value loses more; a larger one sends ordinary triangles the
/// long way.
const SLIVER_SINE_SQUARED: f64 = 1.0 / 64.0;

/// Height of a triangle over its longest edge, relative to that edge, below
/// which it counts as collapsed: the rounding of its corners' differences.
const COLLAPSED_HEIGHT: f64 = 4.0 * f64::EPSILON;

/// Finds the point of a segment closest to `p`. The ends may coincide.
///
/// ```
/// use surface::{closest_on_segment, glam::DVec3};
///
/// let foot = closest_on_segment(DVec3::new(1.0, 5.0, 0.0), [DVec3::ZERO, DVec3::X * 4.0]);
/// assert_eq!((foot.t, foot.point), (0.25, DVec3::X));
/// ```
#[inline]
#[must_use]
pub fn closest_on_segment(p: DVec3, [a, b]: [DVec3; 2]) -> ClosestOnSegment {
    let ab = b - a;
    let t = clamped_ratio((p - a).dot(ab), ab.length_squared());
    ClosestOnSegment { point: along(a, b, t), t }
}

/// Finds the point of a triangle closest to `p`.
///
/// The corners may be collinear or coincide; the weights are then one of
/// several valid choices.
///
/// ```
/// use surface::{TriangleFeature, closest_on_triangle, glam::DVec3};
///
/// let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let foot = closest_on_triangle(DVec3::new(1.0, -2.0, 3.0), corners);
/// assert_eq!(foot.point, DVec3::X);
/// assert_eq!(foot.barycentric, [0.75, 0.25, 0.0]);
/// assert_eq!(foot.feature, TriangleFeature::Edge(0));
/// ```
#[inline]
#[must_use]
pub fn closest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> ClosestOnTriangle {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (uu, uv, vv) = (ab.length_squared(), ab.dot(ac), ac.length_squared());
    let (up, vp) = (ab.dot(ap), ac.dot(ap));
    let det = uu * vv - uv * uv;
    let well_shaped = det > SLIVER_SINE_SQUARED * (uu * vv) && det > f64::MIN_POSITIVE;
    if !well_shaped {
        return closest_on_sliver(p, [a, b, c]);
    }

    // Barycentric coordinates times the determinant, so that most queries, which are
    // not over the face, need no division.
    let (y, z) = (vv * up - uv * vp, uu * vp - uv * up);
    let x = det - y - z;
    if x > 0.0 && y > 0.0 && z > 0.0 {
        let inverse = 1.0 / det;
        let (y, z) = (y * inverse, z * inverse);
        return ClosestOnTriangle {
            point: a + (y * ab + z * ac),
            barycentric: [(1.0 - y - z).max(0.0), y, z],
            feature: TriangleFeature::Face,
        };
    }
    closest_on_border([a, b, c], [uu, uv, vv, up, vp], [x, y, z])
}

/// Finds the points of two segments that are closest to each other. Either may
/// have coinciding ends, and they may be parallel.
///
/// ```
/// use surface::{closest_between_segments, glam::DVec3};
///
/// let a = [DVec3::ZERO, DVec3::X * 4.0];
/// let b = [DVec3::new(1.0, -2.0, 3.0), DVec3::new(1.0, 2.0, 3.0)];
/// let closest = closest_between_segments(a, b);
/// assert_eq!((closest.s, closest.t), (0.25, 0.5));
/// assert_eq!(closest.points[0].distance(closest.points[1]), 3.0);
/// ```
#[inline]
#[must_use]
pub fn closest_between_segments(a: [DVec3; 2], b: [DVec3; 2]) -> ClosestBetweenSegments {
    let (u, v, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let det = uu * vv - uv * uv;
    let well_shaped = det > SLIVER_SINE_SQUARED * (uu * vv) && det > f64::MIN_POSITIVE;
    if !well_shaped {
        return closest_between_parallels(a, b);
    }

    // Closest point of the first segment to the second line, and its foot there; where
    // that foot is beyond an end, the end's own foot on the first segment.
    let (ur, vr) = (u.dot(r), v.dot(r));
    let s = ((uv * vr - vv * ur) / det).clamp(0.0, 1.0);
    let t = (uv * s + vr) / vv;
    let (s, t) = if t < 0.0 {
        (clamped_ratio(-ur, uu), 0.0)
    } else if t > 1.0 {
        (clamped_ratio(uv - ur, uu), 1.0)
    } else {
        (s, t)
    };
    between(a, b, s, t)
}

/// Finds the points of two triangles that do not cross and are closest to each
/// other: the closest of six corner–triangle and nine edge–edge pairs.
///
/// Triangles that cross have the distance 0, which no such pair yields: test with
/// [`triangles_meet`](crate::triangles_meet) first.
///
/// ```
/// use surface::{closest_between_triangles, glam::DVec3};
///
/// let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// let b = a.map(|corner| corner + DVec3::new(0.25, 0.25, 2.0));
/// assert_eq!(closest_between_triangles(a, b).distance(), 2.0);
/// ```
#[must_use]
pub fn closest_between_triangles(a: [DVec3; 3], b: [DVec3; 3]) -> ClosestBetweenTriangles {
    // Two convex sets that do not cross are closest at a corner or between two edges.
    let mut nearest = NearestFeet::NONE;
    for k in 0..3 {
        let foot = closest_on_triangle(a[k], b);
        nearest.offer([a[k], foot.point], [on_edge(k, 0.0), foot.barycentric]);
        let foot = closest_on_triangle(b[k], a);
        nearest.offer([foot.point, b[k]], [foot.barycentric, on_edge(k, 0.0)]);
    }
    for i in 0..3 {
        for j in 0..3 {
            let feet = closest_between_segments(edge(a, i), edge(b, j));
            nearest.offer(feet.points, [on_edge(i, feet.s), on_edge(j, feet.t)]);
        }
    }
    nearest.feet
}

impl ClosestBetweenTriangles {
    /// Returns the distance of the feet, in the caller's length unit.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.points[0].distance(self.points[1])
    }
}

/// Closest of the feet that were offered.
struct NearestFeet {
    distance_squared: f64,
    feet: ClosestBetweenTriangles,
}

impl NearestFeet {
    const NONE: Self = Self {
        distance_squared: f64::INFINITY,
        feet: ClosestBetweenTriangles { points: [DVec3::ZERO; 2], barycentric: [[0.0; 3]; 2] },
    };

    fn offer(&mut self, points: [DVec3; 2], barycentric: [Barycentric; 2]) {
        let distance_squared = points[0].distance_squared(points[1]);
        if distance_squared < self.distance_squared {
            let feet = ClosestBetweenTriangles { points, barycentric };
            *self = Self { distance_squared, feet };
        }
    }
}

/// Returns `numerator / denominator` clamped to `0.0..=1.0`; 0 for a segment without
/// length.
#[inline]
fn clamped_ratio(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
}

/// Computes `a + t (b − a)` from the nearer end, so that both ends are met exactly.
#[inline]
fn along(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    if t <= 0.5 { a + (b - a) * t } else { b - (b - a) * (1.0 - t) }
}

/// Finds the foot of a point that is not over the face, by the Voronoi regions of the
/// corners and edges, for a triangle that is no sliver; `[x, y, z]` have the signs of
/// the barycentric coordinates.
///
/// Inlined: callers that need only the point leave the rest out.
#[inline]
fn closest_on_border(
    corners: [DVec3; 3],
    [uu, uv, vv, up, vp]: [f64; 5],
    [x, y, z]: Barycentric,
) -> ClosestOnTriangle {
    // Corners: the query is behind both edges.
    if up <= 0.0 && vp <= 0.0 {
        return at_border(corners, 0, 0.0);
    }
    let (from_b, from_c) = ([up - uu, vp - uv], [up - uv, vp - vv]); // b − p, c − p along ab, ac
    if from_b[0] >= 0.0 && from_b[1] <= from_b[0] {
        return at_border(corners, 1, 0.0);
    }
    if from_c[1] >= 0.0 && from_c[0] <= from_c[1] {
        return at_border(corners, 2, 0.0);
    }

    // Edges: the query is outside of the edge and between its ends.
    if z <= 0.0 && up >= 0.0 && from_b[0] <= 0.0 {
        return at_border(corners, 0, up / uu);
    }
    if y <= 0.0 && vp >= 0.0 && from_c[1] <= 0.0 {
        return at_border(corners, 2, 1.0 - vp / vv);
    }
    debug_assert!(x <= 0.0 || y.min(z) <= 0.0, "the foot is not on the face");
    let along_bc = from_b[1] - from_b[0];
    at_border(corners, 1, clamped_ratio(along_bc, along_bc + (from_c[0] - from_c[1])))
}

/// Returns the point with parameter `t` on edge `k`.
#[inline]
fn at_border(corners: [DVec3; 3], k: usize, t: f64) -> ClosestOnTriangle {
    let [from, to] = edge(corners, k);
    let (barycentric, feature) = (on_edge(k, t), edge_feature(k, t));
    ClosestOnTriangle { point: along(from, to, t), barycentric, feature }
}

/// Finds the foot of a point outside of at least one edge: the closest point of a
/// convex polygon lies on an edge that the query is outside of. `weights` need
/// only have the signs of the barycentric coordinates.
fn closest_on_outer_edges(
    p: DVec3,
    corners: [DVec3; 3],
    weights: Barycentric,
) -> ClosestOnTriangle {
    let (mut best_squared, mut best_edge, mut best_t) = (f64::INFINITY, 0, 0.0);
    for k in (0..3).filter(|k| weights[(k + 2) % 3] <= 0.0) {
        let [from, to] = edge(corners, k);
        let (u, r) = (to - from, p - from);
        let t = clamped_ratio(r.dot(u), u.length_squared());
        let distance_squared = (r - t * u).length_squared();
        if distance_squared < best_squared {
            (best_squared, best_edge, best_t) = (distance_squared, k, t);
        }
    }
    at_border(corners, best_edge, best_t)
}

/// Finds the foot on any triangle, solved about its longest edge: `s` along that edge
/// `u`, `z` along the height over it, relative to their lengths.
#[cold]
fn closest_on_sliver(p: DVec3, corners: [DVec3; 3]) -> ClosestOnTriangle {
    let first = longest_edge(corners);
    let mut rotated = corners;
    rotated.rotate_left(first);
    let [a, b, c] = rotated;

    // Height of the opposite corner over the longest edge.
    let (u, v, ap) = (b - a, c - a, p - a);
    let uu = u.length_squared();
    let foot_of_c = clamped_ratio(v.dot(u), uu);
    let height = v - foot_of_c * u;
    let hh = height.length_squared();
    if hh <= COLLAPSED_HEIGHT * COLLAPSED_HEIGHT * uu {
        return closest_on_outer_edges(p, corners, [0.0; 3]);
    }

    // Barycentric coordinates from two orthogonal projections, in the given order of
    // the corners.
    let s = ap.dot(u) / uu;
    let z = (ap - s * u).dot(height) / hh;
    let y = s - foot_of_c * z;
    let x = 1.0 - s - (1.0 - foot_of_c) * z;
    let mut barycentric = [x, y, z];
    barycentric.rotate_right(first);
    if x > 0.0 && y > 0.0 && z > 0.0 {
        let point = a + (s * u + z * height);
        return ClosestOnTriangle { point, barycentric, feature: TriangleFeature::Face };
    }
    closest_on_outer_edges(p, corners, barycentric)
}

/// Finds the closest points of any two segments: the best of the lines' feet, where
/// these lie on the segments, and of the four ends' feet.
#[cold]
fn closest_between_parallels(a: [DVec3; 2], b: [DVec3; 2]) -> ClosestBetweenSegments {
    let (u, v, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let normal = u.cross(v);
    let s = clamped_ratio(-r.cross(v).dot(normal), normal.length_squared());

    // Where the lines are exactly parallel the first candidate is arbitrary, and an end's
    // foot is as close.
    let candidates = [
        (s, closest_on_segment(along(a[0], a[1], s), b).t),
        (0.0, closest_on_segment(a[0], b).t),
        (1.0, closest_on_segment(a[1], b).t),
        (closest_on_segment(b[0], a).t, 0.0),
        (closest_on_segment(b[1], a).t, 1.0),
    ];

    // Distances as linear combinations: rounded differences of feet would cancel.
    let (mut best_squared, mut best) = (f64::INFINITY, (0.0, 0.0));
    for (s, t) in candidates {
        let distance_squared = (r + s * u - t * v).length_squared();
        if distance_squared < best_squared {
            (best_squared, best) = (distance_squared, (s, t));
        }
    }
    between(a, b, best.0, best.1)
}

#[inline]
fn between(a: [DVec3; 2], b: [DVec3; 2], s: f64, t: f64) -> ClosestBetweenSegments {
    ClosestBetweenSegments { points: [along(a[0], a[1], s), along(b[0], b[1], t)], s, t }
}

/// Returns the number of the longest edge, the first of equally long ones.
fn longest_edge([a, b, c]: [DVec3; 3]) -> usize {
    let squared = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    let mut longest = 0;
    for k in 1..3 {
        if squared[k] > squared[longest] {
            longest = k;
        }
    }
    longest
}

/// Returns the weights of the point with parameter `t` on edge `k`: a zero is the positive one,
/// also where `t` is −0.
#[inline]
fn on_edge(k: usize, t: f64) -> Barycentric {
    let mut weights = [0.0; 3];
    weights[k] = 1.0 - t;
    weights[(k + 1) % 3] = t + 0.0;
    weights
}

/// Returns the feature that holds the point with parameter `t` on edge `k`.
fn edge_feature(k: usize, t: f64) -> TriangleFeature {
    if t <= 0.0 {
        TriangleFeature::Corner(k)
    } else if t >= 1.0 {
        TriangleFeature::Corner((k + 1) % 3)
    } else {
        TriangleFeature::Edge(k)
    }
}
