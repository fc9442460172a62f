//! Crossings of triangles in general position, by simulation of simplicity.
//!
//! The first of two triangles is moved by an infinitesimal `E = (ε, ε², ε³)`. Every sign that a
//! crossing depends on is then `+1` or `−1`: corners that touch, edges that meet and faces of one
//! plane need no cases. [`ray_crosses_triangle`](crate::ray_crosses_triangle) makes the same move
//! for its point, so that crossings and insides agree.
//!
//! A sign that is zero is replaced by that of the first nonzero component, x before y before z, of
//! the derivative of its determinant with respect to `E`:
//!
//! | determinant | derivative |
//! |---|---|
//! | corner of A over face `g` of B | `+ n_g` |
//! | corner of B over face `f` of A | `− n_f` |
//! | edge `pq` of A against edge `rs` of B | `(q − p) × (s − r)` |
//!
//! Source: H. Edelsbrunner and E. P. Mücke, "Simulation of Simplicity: A Technique to Cope with
//! Degenerate Cases in Geometric Algorithms", ACM Transactions on Graphics 9(1), 1990. Differs in
//! moving one body as a whole instead of every point by itself.

use glam::DVec3;

use crate::crossing::apart;
use crate::expansion::{exact_height, sign_of_difference_cross};
use crate::predicates::{Sign, side_of_plane, sides_of_plane, turn, without};
use crate::triangle::edge;

/// Relation between two triangles, the first of which is moved by an infinitesimal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum PerturbedMeeting {
    /// The triangles share no point once the first is moved.
    Apart,
    /// The triangles cross in a stretch of a line.
    Crossing(Stretch),
    /// The triangles lie in one plane exactly; once the first is moved, they share no point.
    Coplanar {
        /// True if both normals point the same way.
        same_normal: bool,
        /// True if the first triangle moves to the side that its own normal points to.
        first_moves_outward: bool,
    },
}

/// The stretch in which two triangles cross, named by the edges that hold its ends.
///
/// It runs along `n_a × n_b`: in the first triangle with the inside of the second on the left, in
/// the second triangle the other way round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stretch {
    /// The point at which the stretch begins.
    pub begin: StretchEnd,
    /// The point at which the stretch ends.
    pub end: StretchEnd,
    /// True if the infinitesimal has settled a sign: without it the triangles may only touch.
    pub is_tie: bool,
}

/// An end of a stretch: the point where an edge of one triangle passes through the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StretchEnd {
    /// The triangle that the edge belongs to: 0 for the first, 1 for the second.
    pub triangle: usize,
    /// Corner of that triangle at which the edge begins; it ends at the next corner.
    pub edge: usize,
    /// True if the edge, run in this direction, passes from the front of the other triangle to
    /// its back.
    pub enters: bool,
}

/// Finds the stretch in which two triangles cross once the first is moved by an infinitesimal.
///
/// Exact, for coordinates that are zero or between 1e-90 and 1e90 in size. A triangle without area
/// has a stretch without length where it passes through one with area, and none in another without
/// area.
///
/// ```
/// use surface::{PerturbedMeeting, glam::DVec3, meet_perturbed};
///
/// let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
/// let blade = |z: f64| {
///     [DVec3::new(1.0, 1.0, z), DVec3::new(1.0, 1.0, z + 2.0), DVec3::new(1.0, 2.0, z + 2.0)]
/// };
/// let PerturbedMeeting::Crossing(stretch) = meet_perturbed(blade(-1.0), floor) else {
///     panic!("the blade cuts the floor")
/// };
/// assert_eq!((stretch.begin.triangle, stretch.end.triangle), (0, 0));
/// // A blade that stands on the floor is moved up and leaves it; the floor, if it is the first,
/// // is moved up into the blade.
/// assert_eq!(meet_perturbed(blade(0.0), floor), PerturbedMeeting::Apart);
/// assert!(matches!(meet_perturbed(floor, blade(0.0)), PerturbedMeeting::Crossing(_)));
/// ```
#[inline]
#[must_use]
pub fn meet_perturbed(a: [DVec3; 3], b: [DVec3; 3]) -> PerturbedMeeting {
    let sides_of_a = sides_of_plane(b, a);
    if apart(sides_of_a) {
        return PerturbedMeeting::Apart;
    }
    let sides_of_b = sides_of_plane(a, b);
    if apart(sides_of_b) {
        return PerturbedMeeting::Apart;
    }
    if sides_of_a.contains(&0) || sides_of_b.contains(&0) {
        return meet_with_ties(a, sides_of_a, b, sides_of_b);
    }
    crossing(a, sides_of_a, b, sides_of_b, false)
}

/// Computes the parameter at which the edge from `u` to `v` crosses the plane of a triangle.
///
/// The edge must cross the plane; the parameter is in `0.0..=1.0` whatever rounding does.
#[must_use]
pub fn passing_share([u, v]: [DVec3; 2], corners: [DVec3; 3]) -> f64 {
    let (from, to) = (precise_height(corners, u).abs(), precise_height(corners, v).abs());
    let sum = from + to;
    if sum > 0.0 { (from / sum).clamp(0.0, 1.0) } else { 0.0 }
}

/// Share of the terms' size below which a rounded triple product has lost half of its
/// digits.
const CANCELLATION: f64 = 1e-8;

/// Computes `((b − a) × (c − a)) · (p − a)`, exactly where the rounded number has lost its digits.
fn precise_height([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let (u, v, w) = (b - a, c - a, p - a);
    let rounded = u.cross(v).dot(w);
    let size = u.abs().max_element() * v.abs().max_element() * w.abs().max_element();
    if rounded.abs() > CANCELLATION * size { rounded } else { exact_height([a, b, c], p) }
}

/// Settles the signs that are zero, then as without ties.
#[cold]
fn meet_with_ties(
    a: [DVec3; 3],
    sides_of_a: [Sign; 3],
    b: [DVec3; 3],
    sides_of_b: [Sign; 3],
) -> PerturbedMeeting {
    let (tie_of_a, tie_of_b) = (leading_normal_sign(b), -leading_normal_sign(a));
    match (tie_of_a, tie_of_b) {
        (0, 0) => return PerturbedMeeting::Apart,
        (tie, 0) => return segment_crossing(0, a, sides_of_a, tie, b),
        (0, tie) => return segment_crossing(1, b, sides_of_b, tie, a),
        _ => {}
    }

    // One plane: the move separates the triangles.
    if sides_of_a == [0; 3] {
        let same_normal = tie_of_a == -tie_of_b;
        return PerturbedMeeting::Coplanar { same_normal, first_moves_outward: tie_of_b < 0 };
    }

    let (sides_of_a, sides_of_b) = (settle(sides_of_a, tie_of_a), settle(sides_of_b, tie_of_b));
    if apart(sides_of_a) || apart(sides_of_b) {
        return PerturbedMeeting::Apart;
    }
    crossing(a, sides_of_a, b, sides_of_b, true)
}

/// Finds the stretch of a triangle without area, which is a segment, in one with area.
///
/// The segment has edges there and back. Where it passes through the other triangle, one of them
/// passes upward and one downward, at the same point: the stretch from one to the other has no
/// length. `of` is 0 if the segment is the first triangle, which is moved.
fn segment_crossing(
    of: usize,
    segment: [DVec3; 3],
    sides: [Sign; 3],
    tie: Sign,
    other: [DVec3; 3],
) -> PerturbedMeeting {
    let mut is_tie = sides.contains(&0);
    let sides = settle(sides, tie);
    if apart(sides) {
        return PerturbedMeeting::Apart;
    }

    // An edge that passes upward has all edges of the other triangle on its left.
    let (leaves, enters) = (edge_upward(sides), edge_downward(sides));
    let upward = edge(segment, leaves);
    let is_through = (0..3).all(|k| {
        let around = edge(other, k);
        let (side, settled) =
            if of == 0 { side_of_edge(upward, around) } else { side_of_edge(around, upward) };
        is_tie |= settled;
        side > 0
    });
    if !is_through {
        return PerturbedMeeting::Apart;
    }

    let leaves = StretchEnd { triangle: of, edge: leaves, enters: false };
    let enters = StretchEnd { triangle: of, edge: enters, enters: true };
    let [begin, end] = if of == 0 { [leaves, enters] } else { [enters, leaves] };
    PerturbedMeeting::Crossing(Stretch { begin, end, is_tie })
}

/// Replaces the sides that are zero.
fn settle(sides: [Sign; 3], tie: Sign) -> [Sign; 3] {
    sides.map(|side| if side == 0 { tie } else { side })
}

/// Finds the stretch of two triangles, each of which has corners on both sides of the other.
///
/// Along `n_a × n_b`, the plane of B is met by A from the edge on which A leaves B's back to the
/// edge on which it enters there, and the plane of A by B the other way round. The triangles cross
/// where these two intervals overlap; the order of two ends is the side on which one edge passes
/// the other.
fn crossing(
    a: [DVec3; 3],
    sides_of_a: [Sign; 3],
    b: [DVec3; 3],
    sides_of_b: [Sign; 3],
    corners_tie: bool,
) -> PerturbedMeeting {
    let (a_leaves, a_enters) = (edge_upward(sides_of_a), edge_downward(sides_of_a));
    let (b_leaves, b_enters) = (edge_upward(sides_of_b), edge_downward(sides_of_b));

    // The intervals overlap where each begins before the other ends.
    let mut is_tie = corners_tie;
    let mut side = |i: usize, j: usize| {
        let (side, settled) = side_of_edge(edge(a, i), edge(b, j));
        is_tie |= settled;
        side
    };
    if side(a_leaves, b_leaves) < 0 || side(a_enters, b_enters) > 0 {
        return PerturbedMeeting::Apart;
    }

    // The stretch begins at the later beginning, and ends at the earlier end.
    let begins_on_b = side(a_leaves, b_enters) < 0;
    let ends_on_a = side(a_enters, b_leaves) < 0;
    let begin = if begins_on_b {
        StretchEnd { triangle: 1, edge: b_enters, enters: true }
    } else {
        StretchEnd { triangle: 0, edge: a_leaves, enters: false }
    };
    let end = if ends_on_a {
        StretchEnd { triangle: 0, edge: a_enters, enters: true }
    } else {
        StretchEnd { triangle: 1, edge: b_leaves, enters: false }
    };
    PerturbedMeeting::Crossing(Stretch { begin, end, is_tie })
}

/// Returns the side on which the line of `rs` passes that of `pq`: the sign of
/// `((q − p) × (r − p)) · (s − p)`, and true if the infinitesimal has settled it.
fn side_of_edge([p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> (Sign, bool) {
    let side = side_of_plane([p, q, r], s);
    if side != 0 {
        return (side, false);
    }

    // The edges meet or are parallel: the derivative by the infinitesimal decides.
    for axis in 0..3 {
        let [p, q, r, s] = [p, q, r, s].map(|x| without(axis, x));
        let side = sign_of_difference_cross([p, q], [r, s]);
        if side != 0 {
            return (side, true);
        }
    }
    (0, true)
}

/// Returns the sign of the first nonzero component of a triangle's normal; 0 without area.
fn leading_normal_sign(corners: [DVec3; 3]) -> Sign {
    for axis in 0..3 {
        let [a, b, c] = corners.map(|corner| without(axis, corner));
        if turn(a, b, c) != 0 {
            return turn(a, b, c);
        }
    }
    0
}

/// Returns the edge on which the sides rise from −1 to 1.
fn edge_upward(sides: [Sign; 3]) -> usize {
    (0..3).find(|&k| sides[k] < 0 && sides[(k + 1) % 3] > 0).unwrap_or(0)
}

/// Returns the edge on which the sides fall from 1 to −1.
fn edge_downward(sides: [Sign; 3]) -> usize {
    (0..3).find(|&k| sides[k] > 0 && sides[(k + 1) % 3] < 0).unwrap_or(0)
}
