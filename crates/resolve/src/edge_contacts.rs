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
pub(crate) fn edge_contacts(scene: &Scene, report: &PairReport) -> Vec<Contact> {
    if report.crossing_faces.is_empty() {
        return Vec::new();
    }

    let [a, b] = FaceSide::of_pair([scene.body(report.pair.a), scene.body(report.pair.b)]);
    let a = CrossingBody::new(a, inside(a.body, &report.a_against_b));
    let b = CrossingBody::new(b, inside(b.body, &report.b_against_a));

    let mut contacts = Vec::new();
    for &faces in &report.crossing_faces {
        contacts.extend(contact(&a, &b, faces));
    }
    contacts
}

/// Finds the contacts of a body's own faces that cross without a vertex inside.
pub(crate) fn self_edge_contacts(
    body: &Body,
    is_inside: Vec<bool>,
    crossing_faces: &[[u32; 2]],
) -> Vec<Contact> {
    let own = CrossingBody::new(FaceSide { body, is_anchor: false }, is_inside);
    let mut contacts = Vec::new();
    for &faces in crossing_faces {
        contacts.extend(contact(&own, &own, faces));
    }
    contacts
}

/// Marks the vertices of a body that are inside another, |V|.
fn inside(body: &Body, report: &VertexReport) -> Vec<bool> {
    let mut is_inside = vec![false; body.positions().len()];
    for near in &report.near {
        is_inside[near.vertex as usize] = near.gap < 0.0;
    }
    is_inside
}

/// Makes the contact of two crossing faces; `None` where one has a vertex inside, or where no
/// height of one over the other is found.
fn contact(a: &CrossingBody<'_>, b: &CrossingBody<'_>, faces: [u32; 2]) -> Option<Contact> {
    // Where the faces are highest over each other, seen along the normal between them.
    let [of_a, of_b] = [a.face_normal(faces[0])?, b.face_normal(faces[1])?];
    let normal = (of_b - of_a).try_normalize().or_else(|| of_b.try_normalize())?;
    contact_along([a.side, b.side], faces, normal)
}

/// Makes the contact of two faces where the second one is highest over the first, seen along `normal`; `None`
/// where no height is found.
pub(crate) fn contact_along(
    [a, b]: [FaceSide<'_>; 2],
    faces: [u32; 2],
    normal: DVec3,
) -> Option<Contact> {
    let meeting = highest([a.body.corners(faces[0]), b.body.corners(faces[1])], normal)?;
    let [on_a, on_b] = meeting.weights;
    let (terms_a, terms_b) = (a.terms(faces[0], on_a), b.terms(faces[1], on_b));
    let on_a = a.contact_side(faces[0], on_a, &terms_a);
    let on_b = b.contact_side(faces[1], on_b, &terms_b);
    Some(Contact::between(on_a, on_b, normal, -meeting.height))
}

/// Faces of one body as sides of contacts.
#[derive(Clone, Copy)]
pub(crate) struct FaceSide<'a> {
    pub(crate) body: &'a Body,
    /// True for the anchor of contacts.
    is_anchor: bool,
}

impl<'a> FaceSide<'a> {
    /// Builds the sides of a pair. A contact has one anchor at most: of two rigid bodies, the second.
    pub(crate) fn of_pair([a, b]: [&'a Body; 2]) -> [Self; 2] {
        let anchors = [a.is_rigid() && !b.is_rigid(), b.is_rigid()];
        [Self { body: a, is_anchor: anchors[0] }, Self { body: b, is_anchor: anchors[1] }]
    }

    /// Returns the particles of a face with these weights, without those of weight 0.
    fn terms(&self, face: u32, weights: [f64; 3]) -> Vec<Term> {
        let numbers = self.body.particle_numbers();
        let mut terms = Vec::new();
        for (vertex, weight) in self.body.surface().faces()[face as usize].into_iter().zip(weights)
        {
            if weight != 0.0 {
                terms.push(Term { particle: numbers.particle(vertex), weight });
            }
        }
        terms
    }

    /// Returns the point of a face with these weights as one side of a contact; an anchor is at
    /// rest.
    fn contact_side<'t>(&self, face: u32, weights: [f64; 3], terms: &'t [Term]) -> ContactSide<'t> {
        if self.is_anchor {
            ContactSide::at_rest(interpolate(self.body.corners(face), weights))
        } else {
            ContactSide::Particles(terms)
        }
    }
}

/// One body of a pair whose faces cross.
struct CrossingBody<'a> {
    side: FaceSide<'a>,
    /// True for vertices inside the other body, |V|.
    is_inside: Vec<bool>,
    /// Outward vertex normals, |V|.
    normals: Vec<DVec3>,
}

impl<'a> CrossingBody<'a> {
    fn new(side: FaceSide<'a>, is_inside: Vec<bool>) -> Self {
        let body = side.body;
        let mut normals = vertex_normals(body.surface().faces(), body.positions());
        if body.is_inside_out() {
            normals.iter_mut().for_each(|normal| *normal = -*normal);
        }
        Self { side, is_inside, normals }
    }

    /// Sums the normals of a face's corners; `None` where one of them is inside.
    fn face_normal(&self, face: u32) -> Option<DVec3> {
        let mut sum = DVec3::ZERO;
        for vertex in self.side.body.surface().faces()[face as usize] {
            if self.is_inside[vertex as usize] {
                return None;
            }
            sum += self.normals[vertex as usize];
        }
        Some(sum)
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
    // The height is linear in between: its maximum is at a corner.
    let max_height = longest_edge(a).min(longest_edge(b)) / 2.0;
    let mut highest: Option<Meeting> = None;
    for weights in corners_of_overlap(a, b, normal) {
        let height = (interpolate(b, weights[1]) - interpolate(a, weights[0])).dot(normal);
        if highest.as_ref().is_none_or(|highest| height > highest.height) {
            highest = Some(Meeting { weights, height });
        }
    }
    highest.filter(|highest| highest.height > 0.0 && highest.height < max_height)
}

/// Finds the corners of the area in which two faces cover each other, seen along `normal`, as
/// weights of the corners of either face.
fn corners_of_overlap(a: [DVec3; 3], b: [DVec3; 3], normal: DVec3) -> Vec<[[f64; 3]; 2]> {
    // Corners of either face over the other.
    let axes = normal.any_orthonormal_pair();
    let (a, b) = (flatten(a, axes), flatten(b, axes));
    let mut corners = Vec::new();
    for i in 0..3 {
        if let Some(on_b) = weights_within(a[i], b) {
            corners.push([along(i, 0.0), on_b]);
        }
        if let Some(on_a) = weights_within(b[i], a) {
            corners.push([on_a, along(i, 0.0)]);
        }
    }

    // Edges over edges.
    for i in 0..3 {
        for j in 0..3 {
            if let Some([s, t]) = segments_cross([a[i], a[(i + 1) % 3]], [b[j], b[(j + 1) % 3]]) {
                corners.push([along(i, s), along(j, t)]);
            }
        }
    }
    corners
}

/// Projects a face onto the plane of two axes.
fn flatten(corners: [DVec3; 3], (u, v): (DVec3, DVec3)) -> [DVec2; 3] {
    corners.map(|p| DVec2::new(p.dot(u), p.dot(v)))
}

fn longest_edge([p, q, r]: [DVec3; 3]) -> f64 {
    p.distance(q).max(q.distance(r)).max(r.distance(p))
}

fn interpolate([p, q, r]: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    DVec3::ZERO + weights[0] * p + weights[1] * q + weights[2] * r
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
    let [s, t] = [(b0 - a0).perp_dot(b) / turn, (b0 - a0).perp_dot(a) / turn];
    let is_within = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    is_within.then_some([s, t])
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
