//! Contacts of faces that cross although none of their vertices is inside.
//!
//! Two faces that cross by their edges are separated along the normal between them. Over the
//! area in which they cover each other, seen along that normal, the height of one over the
//! other is piecewise linear. Its maximum is at a corner of that area: a vertex over a face,
//! or two edges over each other.

use glam::{DVec2, DVec3};
use scene::{Body, PairReport, Scene, VertexReport};
use surface::{Contact, ContactSide, Term, vertex_normals};

/// Finds the contacts of a pair's crossing faces without a vertex inside. Their gaps are
/// negative.
pub(crate) fn edge_contacts(scene: &Scene, pair: &PairReport) -> Vec<Contact> {
    if pair.crossing_faces.is_empty() {
        return Vec::new();
    }
    let [a, b] = pair.pair.bodies().map(|id| scene.body(id));
    // A contact has one anchor at most: of two rigid bodies, the second.
    let [a_is_anchor, b_is_anchor] = [a.is_rigid() && !b.is_rigid(), b.is_rigid()];
    let a = CrossingSide::new(a, &pair.a_against_b, a_is_anchor);
    let b = CrossingSide::new(b, &pair.b_against_a, b_is_anchor);

    let contact = |&[face_a, face_b]: &[u32; 2]| {
        let [of_a, of_b] = [a.face_normal(face_a)?, b.face_normal(face_b)?];
        let normal = (of_b - of_a).try_normalize().or_else(|| of_b.try_normalize())?;
        let meeting = highest([a.body.corners(face_a), b.body.corners(face_b)], normal)?;

        let on_a = a.point(face_a, meeting.weights[0]);
        let on_b = b.point(face_b, meeting.weights[1]);
        Some(Contact::between(on_a.side(), on_b.side(), normal, -meeting.height))
    };
    pair.crossing_faces.iter().filter_map(contact).collect()
}

/// One body of a pair whose faces cross.
struct CrossingSide<'a> {
    body: &'a Body,
    /// Whether each vertex is inside the other body, |V|.
    is_inside: Vec<bool>,
    normals: Vec<DVec3>,
    /// Whether the body is the anchor of contacts.
    is_anchor: bool,
}

impl<'a> CrossingSide<'a> {
    fn new(body: &'a Body, report: &VertexReport, is_anchor: bool) -> Self {
        let mut is_inside = vec![false; body.positions().len()];
        for near in report.near.iter().filter(|near| near.gap < 0.0) {
            is_inside[near.vertex as usize] = true;
        }
        let normals = vertex_normals(body.surface().faces(), body.positions());
        Self { body, is_inside, normals, is_anchor }
    }

    /// Sums the normals of a face's corners; `None` where one of them is inside.
    fn face_normal(&self, face: u32) -> Option<DVec3> {
        let corners = self.body.surface().faces()[face as usize].map(|vertex| vertex as usize);
        let is_outside = !corners.iter().any(|&vertex| self.is_inside[vertex]);
        is_outside.then(|| corners.iter().map(|&vertex| self.normals[vertex]).sum())
    }

    /// Returns the point of a face with these weights of its corners.
    fn point(&self, face: u32, weights: [f64; 3]) -> FacePoint {
        if self.is_anchor {
            return FacePoint::Anchor(interpolate(self.body.corners(face), weights));
        }
        let numbers = self.body.particle_numbers();
        let corners = self.body.surface().faces()[face as usize].into_iter().zip(weights);
        let terms =
            corners.map(|(vertex, weight)| Term { particle: numbers.particle(vertex), weight });
        FacePoint::Particles(terms.filter(|term| term.weight != 0.0).collect())
    }
}

/// Point of a face, by what carries it.
enum FacePoint {
    Anchor(DVec3),
    Particles(Vec<Term>),
}

impl FacePoint {
    /// Returns the point as one side of a contact; an anchor is at rest.
    fn side(&self) -> ContactSide<'_> {
        match self {
            Self::Anchor(point) => ContactSide::at_rest(*point),
            Self::Particles(terms) => ContactSide::Particles(terms),
        }
    }
}

/// Points of two faces over each other.
struct Meeting {
    /// Weights of the corners of either face.
    weights: [[f64; 3]; 2],
    /// Height of the second point over the first.
    height: f64,
}

/// Finds where the second face is highest over the first, seen along `normal`.
///
/// `None` where it is nowhere over it, and where the height exceeds half the longest edge of a
/// face: the faces then belong to parts that are seen from the side.
fn highest([a, b]: [[DVec3; 3]; 2], normal: DVec3) -> Option<Meeting> {
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |corners: [DVec3; 3]| corners.map(|p| DVec2::new(p.dot(u), p.dot(v)));
    let (flat_a, flat_b) = (flat(a), flat(b));

    // The corners of the area in which the faces cover each other.
    let mut corners: Vec<[[f64; 3]; 2]> = Vec::new();
    for k in 0..3 {
        corners.extend(weights_within(flat_a[k], flat_b).map(|of_b| [along(k, 0.0), of_b]));
        corners.extend(weights_within(flat_b[k], flat_a).map(|of_a| [of_a, along(k, 0.0)]));
    }
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let edge = |corners: [DVec2; 3], k: usize| [corners[k], corners[(k + 1) % 3]];
        let crossing = segments_cross(edge(flat_a, i), edge(flat_b, j));
        corners.extend(crossing.map(|[s, t]| [along(i, s), along(j, t)]));
    }

    let mut highest: Option<Meeting> = None;
    for weights in corners {
        let height = (interpolate(b, weights[1]) - interpolate(a, weights[0])).dot(normal);
        if highest.as_ref().is_none_or(|highest| height > highest.height) {
            highest = Some(Meeting { weights, height });
        }
    }
    let max_height = longest_edge(a).min(longest_edge(b)) / 2.0;
    highest.filter(|highest| highest.height > 0.0 && highest.height < max_height)
}

fn longest_edge([p, q, r]: [DVec3; 3]) -> f64 {
    p.distance(q).max(q.distance(r)).max(r.distance(p))
}

fn interpolate(corners: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    corners.iter().zip(weights).map(|(&corner, weight)| weight * corner).sum()
}

/// Returns the weights of the point at the fraction `s` of a face's edge `k`.
fn along(k: usize, s: f64) -> [f64; 3] {
    let mut weights = [0.0; 3];
    weights[k] = 1.0 - s;
    weights[(k + 1) % 3] = s;
    weights
}

/// Computes the barycentric coordinates of a point in a triangle; `None` outside.
fn weights_within(p: DVec2, [a, b, c]: [DVec2; 3]) -> Option<[f64; 3]> {
    let areas = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
    let whole: f64 = areas.iter().sum();
    let weights = areas.map(|area| area / whole);
    weights.iter().all(|weight| (0.0..=1.0).contains(weight)).then_some(weights)
}

/// Computes where two segments cross, as fractions of both.
fn segments_cross([a0, a1]: [DVec2; 2], [b0, b1]: [DVec2; 2]) -> Option<[f64; 2]> {
    let (a, b) = (a1 - a0, b1 - b0);
    let turn = a.perp_dot(b);
    let fractions = [(b0 - a0).perp_dot(b) / turn, (b0 - a0).perp_dot(a) / turn];
    fractions.iter().all(|fraction| (0.0..=1.0).contains(fraction)).then_some(fractions)
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
        let [p, q] =
            [(above, 0), (below, 1)].map(|(face, k)| interpolate(face, meeting.weights[k]));
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
