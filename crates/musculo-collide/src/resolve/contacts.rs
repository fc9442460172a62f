//! What keeps bodies apart: a contact for every vertex that is inside another
//! body or near it, and one for every pair of faces that cross although none
//! of their vertices is inside.
//!
//! Two faces that cross by their edges are taken apart along the normal
//! between them: over the area in which they hide each other, seen along that
//! normal, the height of one above the other is linear piece by piece, so its
//! greatest value stands at a corner of that area, which is a vertex over a
//! face or two edges over each other.

use glam::{DVec2, DVec3};
use surface::{Anchor, Contact, Stencil, Term, TriangleSurface};

use crate::scene::Body;
use crate::{BodyKind, PairReport, Scene, VertexReport};

/// Unit normals of a body's vertices, weighted by the areas of their faces; 0
/// for a vertex without area.
pub(super) fn vertex_normals(surface: &TriangleSurface, x: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; x.len()];
    for face in surface.faces() {
        let [p, q, r] = face.map(|corner| x[corner as usize]);
        let normal = (q - p).cross(r - p);
        face.iter().for_each(|&corner| normals[corner as usize] += normal);
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// How far the edges of a pair's crossing faces pass beyond each other where no
/// vertex is inside: contacts, of which the gaps are negative.
pub(super) fn of_edges(scene: &Scene, pair: &PairReport) -> Vec<Contact> {
    let (a, b) = (scene.body(pair.a), scene.body(pair.b));
    if pair.crossing_faces.is_empty() {
        return Vec::new();
    }
    let inside = [inside(a, &pair.a_against_b), inside(b, &pair.b_against_a)];
    let normals = [a, b].map(|body| vertex_normals(body.surface(), body.positions()));
    let crossing = |&[fa, fb]: &[u32; 2]| {
        let faces = [a.surface().faces()[fa as usize], b.surface().faces()[fb as usize]];
        let holds_inside = |side: usize| faces[side].iter().any(|&v| inside[side][v as usize]);
        if holds_inside(0) || holds_inside(1) {
            return None;
        }
        let mean = |side: usize| faces[side].iter().map(|&v| normals[side][v as usize]).sum();
        let [of_a, of_b]: [DVec3; 2] = [mean(0), mean(1)];
        let normal = (of_b - of_a).try_normalize().or_else(|| of_b.try_normalize())?;
        let corners = [a.corners(fa), b.corners(fb)];
        let meeting = highest(corners, normal)?;
        Some(contact([(a, faces[0]), (b, faces[1])], &meeting, normal, corners))
    };
    pair.crossing_faces.iter().filter_map(crossing).collect()
}

fn inside(body: &Body, report: &VertexReport) -> Vec<bool> {
    let mut inside = vec![false; body.positions().len()];
    for near in report.near.iter().filter(|near| near.gap < 0.0) {
        inside[near.vertex as usize] = true;
    }
    inside
}

/// Points of two faces one over the other, in weights of their corners, and how
/// far the point of the second is above that of the first.
struct Meeting {
    weights: [[f64; 3]; 2],
    height: f64,
}

/// Where the second face is highest over the first, seen along `normal`.
fn highest([a, b]: [[DVec3; 3]; 2], normal: DVec3) -> Option<Meeting> {
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |corners: [DVec3; 3]| corners.map(|p| DVec2::new(p.dot(u), p.dot(v)));
    let (flat_a, flat_b) = (flat(a), flat(b));
    let mut best: Option<Meeting> = None;
    let mut offer = |weights: [[f64; 3]; 2]| {
        let height = (point(b, weights[1]) - point(a, weights[0])).dot(normal);
        if best.as_ref().is_none_or(|best| height > best.height) {
            best = Some(Meeting { weights, height });
        }
    };
    for k in 0..3 {
        if let Some(weights) = weights_within(flat_a[k], flat_b) {
            offer([corner(k), weights]);
        }
        if let Some(weights) = weights_within(flat_b[k], flat_a) {
            offer([weights, corner(k)]);
        }
    }
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let edge = |corners: [DVec2; 3], k: usize| [corners[k], corners[(k + 1) % 3]];
        if let Some([s, t]) = segments_cross(edge(flat_a, i), edge(flat_b, j)) {
            offer([along(i, s), along(j, t)]);
        }
    }
    best.filter(|best| {
        best.height > 0.0 && best.height < longest_edge(a).min(longest_edge(b)) / 2.0
    })
}

/// Heights beyond half an edge are those of faces that are seen from the side.
fn longest_edge([p, q, r]: [DVec3; 3]) -> f64 {
    p.distance(q).max(q.distance(r)).max(r.distance(p))
}

fn point(corners: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    corners.iter().zip(weights).map(|(&corner, weight)| weight * corner).sum()
}

fn corner(k: usize) -> [f64; 3] {
    along(k, 0.0)
}

/// Weights of the point at share `s` of a face's edge `k`.
fn along(k: usize, s: f64) -> [f64; 3] {
    let mut weights = [0.0; 3];
    weights[k] = 1.0 - s;
    weights[(k + 1) % 3] = s;
    weights
}

fn weights_within(p: DVec2, [a, b, c]: [DVec2; 3]) -> Option<[f64; 3]> {
    let areas = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
    let whole: f64 = areas.iter().sum();
    let weights = areas.map(|area| area / whole);
    weights.iter().all(|weight| (0.0..=1.0).contains(weight)).then_some(weights)
}

fn segments_cross([a0, a1]: [DVec2; 2], [b0, b1]: [DVec2; 2]) -> Option<[f64; 2]> {
    let (a, b) = (a1 - a0, b1 - b0);
    let turn = a.perp_dot(b);
    let shares = [(b0 - a0).perp_dot(b) / turn, (b0 - a0).perp_dot(a) / turn];
    shares.iter().all(|share| (0.0..=1.0).contains(share)).then_some(shares)
}

/// The contact of two faces: a rigid body is the anchor, at rest.
fn contact(
    [(a, face_a), (b, face_b)]: [(&Body, [u32; 3]); 2],
    meeting: &Meeting,
    normal: DVec3,
    corners: [[DVec3; 3]; 2],
) -> Contact {
    let Meeting { weights, height } = *meeting;
    let terms = |body: &Body, face: [u32; 3], weights: [f64; 3], sign: f64| -> Vec<Term> {
        let first = body.particles().start;
        let each = face.iter().zip(weights).filter(|&(_, weight)| weight != 0.0);
        each.map(|(&v, weight)| Term { particle: first + v, weight: sign * weight }).collect()
    };
    let rigid = |body: &Body| body.kind() == BodyKind::Rigid;
    let anchored = |side: usize| {
        Some(Anchor { point: point(corners[side], weights[side]), ..Anchor::default() })
    };
    let (of_a, of_b) = (terms(a, face_a, weights[0], -1.0), terms(b, face_b, weights[1], 1.0));
    let (terms, anchor, normal) = if rigid(b) {
        (of_a, anchored(1), normal)
    } else if rigid(a) {
        (terms(b, face_b, weights[1], -1.0), anchored(0), -normal)
    } else {
        ([of_a, of_b].concat(), None, normal)
    };
    let stencil = Stencil::new(&terms).expect("a vertex over a face or two edges: four at most");
    Contact { stencil, anchor, normal, offset: 0.0, gap: -height, time: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two faces whose edges cross at right angles, the second `height` too low.
    fn crossed(height: f64) -> [[DVec3; 3]; 2] {
        let below = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::Z * -5.0];
        let above = [DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.0), DVec3::Z * 5.0];
        [below, above.map(|corner| corner - height * DVec3::Z)]
    }

    #[test]
    fn edges_that_cross_meet_at_their_height() {
        let [below, above] = crossed(0.25);
        let meeting = highest([above, below], DVec3::Z).expect("they cross");
        assert!((meeting.height - 0.25).abs() < 1e-12, "{}", meeting.height);
        let [p, q] = [point(above, meeting.weights[0]), point(below, meeting.weights[1])];
        assert!((q - p - 0.25 * DVec3::Z).length() < 1e-12, "{p} {q}");
        assert!(p.truncate().length() < 1e-12, "where the edges cross: {p}");
    }

    #[test]
    fn edges_that_are_apart_or_seen_from_the_side_do_not_meet() {
        let [below, above] = crossed(-0.25);
        assert!(highest([above, below], DVec3::Z).is_none(), "one is over the other");
        // Each face is 5.1 long; what passes by more than half of that is another part.
        let [below, above] = crossed(2.7);
        assert!(highest([above, below], DVec3::Z).is_none(), "too deep for these two");
    }
}
