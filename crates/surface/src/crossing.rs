//! Exact intersection tests between triangles and segments: disjoint, touching or
//! crossing.
//!
//! Each triangle's corners are classified by the plane of the other. Where both have
//! corners on both sides, each meets the line common to the planes in an interval, and
//! two more orientations decide whether these overlap. Triangles that only touch a
//! plane are rare, and are decided edge by edge.
//!
//! Source: P. Guigue and O. Devillers, "Fast and Robust Triangle-Triangle
//! Overlap Test Using Orientation Predicates", Journal of Graphics Tools 8(1),
//! 2003, section 2. Differs in separating touching from crossing, and in accepting
//! triangles without area.
//!
//! Every sign is exact, for coordinates that are zero or between 1e-90 and 1e90
//! in size; so the result does not depend on the order of the corners or of the
//! triangles. The tests compare it with rational arithmetic on triangles that
//! touch, or are an ulp away from it.

use glam::DVec3;

use crate::predicates::{Sign, projection_axis, side_of_plane, sides_of_plane, turn, without};

/// Relation of two closed sets of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Meeting {
    /// They share no point.
    Disjoint,
    /// They share a point, but do not cross.
    Touching,
    /// They pass through each other.
    Crossing,
}

impl Meeting {
    /// Returns true if the closed sets share a point: touching or crossing.
    #[must_use]
    pub fn shares_a_point(self) -> bool {
        self != Self::Disjoint
    }
}

/// Returns the relation of two triangles, with their borders.
///
/// - [`Crossing`](Meeting::Crossing): they are not in one plane and their
///   interiors share a point, hence a stretch of a line. It is enough that each
///   has corners strictly on both sides of the other's plane and the stretches
///   in which they meet the common line overlap in more than a point; a corner
///   may lie in the plane of the other, and an edge may run through an edge.
/// - [`Touching`](Meeting::Touching): any other shared point. A corner or edge
///   against the other without passing its plane; two edges that meet in the
///   one point the triangles share; triangles of one plane, however far they
///   overlap. Neighbors in a mesh touch at least.
/// - A triangle without area never crosses; it touches or is disjoint.
///
/// ```
/// use surface::{Meeting, glam::DVec3, triangles_meet};
///
/// let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let blade = |z: f64| {
///     [DVec3::new(1.0, 1.0, z), DVec3::new(1.0, 1.0, z + 2.0), DVec3::new(1.0, 2.0, z + 2.0)]
/// };
/// assert_eq!(triangles_meet(floor, blade(-1.0)), Meeting::Crossing);
/// assert_eq!(triangles_meet(floor, blade(0.0)), Meeting::Touching);
/// assert_eq!(triangles_meet(floor, blade(1e-300)), Meeting::Disjoint);
/// assert_eq!(triangles_meet(floor, floor), Meeting::Touching);
/// ```
#[must_use]
pub fn triangles_meet(a: [DVec3; 3], b: [DVec3; 3]) -> Meeting {
    // Most pairs of a broad phase end at one of the two planes.
    let sides_of_b = sides_of_plane(b, a);
    if apart(sides_of_b) {
        return Meeting::Disjoint;
    }
    let sides_of_a = sides_of_plane(a, b);
    if apart(sides_of_a) {
        return Meeting::Disjoint;
    }

    // In general position two intervals on the common line decide; a corner or an edge in
    // the other's plane is decided edge by edge.
    if straddles(sides_of_a) && straddles(sides_of_b) {
        return intervals_meet(a, sides_of_b, b, sides_of_a);
    }
    touching_if(triangles_touch(a, b))
}

/// Returns the relation of a segment, with its ends, to a triangle, with its border.
///
/// They cross where the ends are strictly on opposite sides of the triangle's
/// plane and the segment passes the triangle's interior. Any other shared point,
/// as on the border, is a touch.
///
/// ```
/// use surface::{Meeting, glam::DVec3, segment_meets_triangle};
///
/// let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let stake = |x: f64| [DVec3::new(x, 1.0, -1.0), DVec3::new(x, 1.0, 1.0)];
/// assert_eq!(segment_meets_triangle(stake(1.0), floor), Meeting::Crossing);
/// assert_eq!(segment_meets_triangle(stake(0.0), floor), Meeting::Touching);
/// assert_eq!(segment_meets_triangle(stake(-1.0), floor), Meeting::Disjoint);
/// ```
#[must_use]
pub fn segment_meets_triangle([p, q]: [DVec3; 2], corners: [DVec3; 3]) -> Meeting {
    let edges = edges(corners);
    let Some(axis) = projection_axis(corners) else {
        // Without area, the triangle is its edges.
        return touching_if(edges.into_iter().any(|edge| segments_touch([p, q], edge)));
    };
    let (sp, sq) = (side_of_plane(corners, p), side_of_plane(corners, q));
    if sp == 0 && sq == 0 {
        return touching_if(segment_touches_in_plane(axis, [p, q], corners));
    }
    if sp * sq > 0 {
        return Meeting::Disjoint;
    }

    // The line passes the triangle where all edges turn about it the same way.
    let around = edges.map(|[from, to]| side_of_plane([p, q, from], to));
    if around.contains(&1) && around.contains(&-1) {
        Meeting::Disjoint
    } else if sp * sq == 0 || around.contains(&0) {
        Meeting::Touching
    } else {
        Meeting::Crossing
    }
}

/// Returns the relation of closed sets that do not cross.
fn touching_if(shares_a_point: bool) -> Meeting {
    if shares_a_point { Meeting::Touching } else { Meeting::Disjoint }
}

/// Returns true if all corners are strictly on one side of the plane.
#[inline]
pub(crate) fn apart(sides: [Sign; 3]) -> bool {
    sides[0] != 0 && sides[1] == sides[0] && sides[2] == sides[0]
}

/// Returns true if corners are strictly on both sides of the plane.
fn straddles(sides: [Sign; 3]) -> bool {
    sides.contains(&1) && sides.contains(&-1)
}

/// Compares the intervals in which triangles meet the line common to their planes, where
/// both have corners on both sides of the other's plane.
///
/// With p1 alone on its side and facing the front of the other triangle, the
/// interval of `a` runs from edge p1 q1 to edge p1 r1.
fn intervals_meet(
    mut a: [DVec3; 3],
    of_a: [Sign; 3],
    mut b: [DVec3; 3],
    of_b: [Sign; 3],
) -> Meeting {
    let (ka, kb) = (lone_corner(of_a), lone_corner(of_b));
    a.rotate_left(ka);
    b.rotate_left(kb);
    let ([p1, mut q1, mut r1], [p2, mut q2, mut r2]) = (a, b);

    // Orient each triangle so that the lone corner of the other faces its front.
    if of_a[ka] < 0 {
        (q2, r2) = (r2, q2);
    }
    if of_b[kb] < 0 {
        (q1, r1) = (r1, q1);
    }

    let gaps = [side_of_plane([p1, q1, p2], q2), side_of_plane([p1, r1, r2], p2)];
    match gaps.into_iter().max() {
        Some(-1) => Meeting::Crossing,
        Some(0) => Meeting::Touching,
        _ => Meeting::Disjoint,
    }
}

/// Finds the corner that is strictly on one side, with none of the others there.
fn lone_corner([a, b, c]: [Sign; 3]) -> usize {
    if a != 0 && a != b && a != c {
        0
    } else if b != 0 && b != c && b != a {
        1
    } else if c != 0 && c != a && c != b {
        2
    } else {
        0
    }
}

/// Returns true if closed triangles share a point, where they do not cross or have
/// no area: some edge of one then meets the other.
fn triangles_touch(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    for (edges, corners) in [(edges(a), b), (edges(b), a)] {
        for edge in edges {
            if segment_meets_triangle(edge, corners).shares_a_point() {
                return true;
            }
        }
    }
    false
}

fn edges([a, b, c]: [DVec3; 3]) -> [[DVec3; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Returns true if a segment in the plane of a triangle with area shares a point with
/// it: some edge meets it, or the triangle contains it.
fn segment_touches_in_plane(axis: usize, segment: [DVec3; 2], corners: [DVec3; 3]) -> bool {
    let start = without(axis, segment[0]);
    let edges = edges(corners).map(|edge| project(axis, edge));

    let around = edges.map(|[from, to]| turn(from, to, start));
    let contains_start = !(around.contains(&1) && around.contains(&-1));
    let segment = project(axis, segment);
    contains_start || edges.into_iter().any(|edge| projected_segments_touch(segment, edge))
}

/// Returns true if two closed segments, which may be points, share a point.
fn segments_touch(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    // Three ends that are not collinear span the only plane in which they can touch.
    let [[a0, a1], [b0, b1]] = [a, b];
    for corners in [[a0, a1, b0], [a0, a1, b1], [b0, b1, a0], [b0, b1, a1]] {
        if let Some(axis) = projection_axis(corners) {
            let coplanar = [a0, a1, b0, b1].iter().all(|x| side_of_plane(corners, *x) == 0);
            return coplanar && projections_touch(axis, a, b);
        }
    }

    // All on one line: they share a point where all three projections do.
    (0..3).all(|axis| projections_touch(axis, a, b))
}

fn projections_touch(axis: usize, a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    projected_segments_touch(project(axis, a), project(axis, b))
}

/// Returns true if two closed segments in a coordinate plane share a point.
fn projected_segments_touch(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    let lines_separate = turn(a[0], a[1], b[0]) * turn(a[0], a[1], b[1]) > 0
        || turn(b[0], b[1], a[0]) * turn(b[0], b[1], a[1]) > 0;
    !lines_separate && (0..2).all(|k| intervals_touch([a[0][k], a[1][k]], [b[0][k], b[1][k]]))
}

fn intervals_touch(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0].max(a[1]) >= b[0].min(b[1]) && b[0].max(b[1]) >= a[0].min(a[1])
}

fn project(axis: usize, [p, q]: [DVec3; 2]) -> [[f64; 2]; 2] {
    [without(axis, p), without(axis, q)]
}
