//! Whether two triangles are apart, touch, or pass through each other, exactly.
//!
//! Each triangle's corners are told by the plane of the other. Where both have
//! corners on both sides, each meets the line common to the planes in an
//! interval, and two more orientations tell whether these overlap. What touches
//! a plane without passing it is rare, and is settled edge by edge.
//!
//! Source: P. Guigue and O. Devillers, "Fast and Robust Triangle-Triangle
//! Overlap Test Using Orientation Predicates", Journal of Graphics Tools 8(1),
//! 2003, section 2. Differs in telling a touch from a crossing, and in taking
//! triangles without area.
//!
//! Every sign is exact, for coordinates that are zero or between 1e-90 and 1e90
//! in size; so the answer does not depend on the order of the corners or of the
//! triangles. The tests compare it with rational arithmetic on triangles that
//! touch, or miss that by an ulp.

use glam::DVec3;

use crate::predicates::{Sign, projection_axis, side_of_plane, sides_of_plane, turn, without};

/// How two closed sets of points lie to each other.
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
    /// Whether the closed sets share a point: touching or crossing.
    #[must_use]
    pub fn shares_a_point(self) -> bool {
        self != Self::Disjoint
    }
}

/// Tells how two triangles, with their borders, lie to each other.
///
/// - [`Crossing`](Meeting::Crossing): they are not in one plane and their
///   insides share a point, hence a stretch of a line. It is enough that each
///   has corners strictly on both sides of the other's plane and the stretches
///   in which they meet the common line overlap in more than a point; a corner
///   may lie in the plane of the other, and an edge may run through an edge.
/// - [`Touching`](Meeting::Touching): any other shared point. A corner or edge
///   against the other without passing its plane; two edges that meet in the
///   one point the triangles share; triangles of one plane, however far they
///   overlap. Neighbors in a mesh touch at least.
/// - A triangle without area never crosses; it touches or is apart.
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
    let sides_of_b = sides_of_plane(b, a);
    if apart(sides_of_b) {
        return Meeting::Disjoint;
    }
    let sides_of_a = sides_of_plane(a, b);
    if apart(sides_of_a) {
        return Meeting::Disjoint;
    }
    if straddles(sides_of_a) && straddles(sides_of_b) {
        return intervals_meet(a, sides_of_b, b, sides_of_a);
    }
    if triangles_touch(a, b) { Meeting::Touching } else { Meeting::Disjoint }
}

/// Tells how a segment, with its ends, and a triangle, with its border, lie to
/// each other.
///
/// They cross where the ends are strictly on opposite sides of the triangle's
/// plane and the segment passes the triangle's inside. Any other shared point,
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
    let Some(axis) = projection_axis(corners) else {
        let touch = edges(corners).into_iter().any(|edge| segments_touch([p, q], edge));
        return if touch { Meeting::Touching } else { Meeting::Disjoint };
    };
    let [sp, sq] = [p, q].map(|end| side_of_plane(corners, end));
    if sp == 0 && sq == 0 {
        let touch = segment_touches_in_plane(axis, [p, q], corners);
        return if touch { Meeting::Touching } else { Meeting::Disjoint };
    }
    if sp * sq > 0 {
        return Meeting::Disjoint;
    }
    let around = edges(corners).map(|[from, to]| side_of_plane([p, q, from], to));
    if around.contains(&1) && around.contains(&-1) {
        Meeting::Disjoint
    } else if sp * sq == 0 || around.contains(&0) {
        Meeting::Touching
    } else {
        Meeting::Crossing
    }
}

/// Ends of the stretch that two crossing triangles share, rounded; `None` where
/// they do not cross.
///
/// Where an edge of one runs within rounding in the plane of the other, or one
/// is a sliver, the end that lies on it may be anywhere on that edge: this is
/// for pictures and patches, not for decisions.
///
/// ```
/// use surface::{crossing_segment, glam::DVec3};
///
/// let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let blade = [DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 1.0)];
/// let [from, to] = crossing_segment(floor, blade).expect("they cross");
/// assert_eq!(from.distance(to), 0.5);
/// ```
#[must_use]
pub fn crossing_segment(a: [DVec3; 3], b: [DVec3; 3]) -> Option<[DVec3; 2]> {
    if triangles_meet(a, b) != Meeting::Crossing {
        return None;
    }
    let [[a0, a1], [b0, b1]] = [stretch_in_plane(a, b), stretch_in_plane(b, a)];
    let direction = normal(a).cross(normal(b));
    let mut ends = [a0, a1, b0, b1].map(|p| ((p - a0).dot(direction), p));
    // Two stretches that overlap share what is between the middle two ends.
    ends.sort_by(|p, q| p.0.total_cmp(&q.0));
    Some([ends[1].1, ends[2].1])
}

fn apart(sides: [Sign; 3]) -> bool {
    sides[0] != 0 && sides[1] == sides[0] && sides[2] == sides[0]
}

fn straddles(sides: [Sign; 3]) -> bool {
    sides.contains(&1) && sides.contains(&-1)
}

/// Both triangles have corners on both sides of the other's plane: compares the
/// stretches in which they meet the common line.
///
/// With p1 alone on its side and facing the front of the other triangle, the
/// stretch of `a` runs from edge p1 q1 to edge p1 r1.
fn intervals_meet(a: [DVec3; 3], of_a: [Sign; 3], b: [DVec3; 3], of_b: [Sign; 3]) -> Meeting {
    let (ka, kb) = (lone_corner(of_a), lone_corner(of_b));
    let [p1, mut q1, mut r1] = [0, 1, 2].map(|k| a[(ka + k) % 3]);
    let [p2, mut q2, mut r2] = [0, 1, 2].map(|k| b[(kb + k) % 3]);
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

/// A corner strictly on one side, with none of the others there.
fn lone_corner(sides: [Sign; 3]) -> usize {
    let alone =
        |k: &usize| sides[*k] != 0 && sides.iter().filter(|s| **s == sides[*k]).count() == 1;
    (0..3).find(alone).unwrap_or_default()
}

/// Whether the closed triangles share a point, where they do not cross or have
/// no area: some edge of one then meets the other.
fn triangles_touch(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let meets = |edge, corners| segment_meets_triangle(edge, corners).shares_a_point();
    edges(a).into_iter().any(|edge| meets(edge, b))
        || edges(b).into_iter().any(|edge| meets(edge, a))
}

fn edges([a, b, c]: [DVec3; 3]) -> [[DVec3; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// A segment in the plane of a triangle with area: some edge meets it, or the
/// triangle holds it whole.
fn segment_touches_in_plane(axis: usize, [p, q]: [DVec3; 2], corners: [DVec3; 3]) -> bool {
    let flat = |x: DVec3| without(axis, x);
    let around = edges(corners).map(|[from, to]| turn(flat(from), flat(to), flat(p)));
    let holds = !(around.contains(&1) && around.contains(&-1));
    holds
        || edges(corners)
            .into_iter()
            .any(|[from, to]| segments_touch_flat([flat(p), flat(q)], [flat(from), flat(to)]))
}

/// Whether two closed segments, which may be points, share a point.
fn segments_touch(a: [DVec3; 2], b: [DVec3; 2]) -> bool {
    let triples = [[a[0], a[1], b[0]], [a[0], a[1], b[1]], [b[0], b[1], a[0]], [b[0], b[1], a[1]]];
    let plane = triples.into_iter().find_map(|t| projection_axis(t).map(|axis| (axis, t)));
    let flat = |axis: usize| {
        let flat = |x: DVec3| without(axis, x);
        segments_touch_flat(a.map(flat), b.map(flat))
    };
    match plane {
        Some((axis, corners)) => {
            a.into_iter().chain(b).all(|x| side_of_plane(corners, x) == 0) && flat(axis)
        }
        // All on one line: its shadows meet in each plane where it does.
        None => (0..3).all(flat),
    }
}

/// Whether two closed segments in a coordinate plane share a point.
fn segments_touch_flat(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    let of_a = b.map(|x| turn(a[0], a[1], x));
    let of_b = a.map(|x| turn(b[0], b[1], x));
    of_a[0] * of_a[1] <= 0 && of_b[0] * of_b[1] <= 0 && boxes_touch(a, b)
}

fn boxes_touch(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    (0..2).all(|k| {
        a[0][k].max(a[1][k]) >= b[0][k].min(b[1][k]) && b[0][k].max(b[1][k]) >= a[0][k].min(a[1][k])
    })
}

/// Where two edges of `a` pass the plane of `b`.
fn stretch_in_plane(a: [DVec3; 3], b: [DVec3; 3]) -> [DVec3; 2] {
    let sides = sides_of_plane(b, a);
    let k = lone_corner(sides);
    let n = normal(b);
    let height = |p: DVec3| n.dot(p - b[0]).abs();
    [1, 2].map(|next| {
        let (p, q) = (a[k], a[(k + next) % 3]);
        let (hp, hq) = (height(p), height(q));
        let share = if hp + hq > 0.0 { hp / (hp + hq) } else { 0.5 };
        p + (q - p) * share
    })
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
