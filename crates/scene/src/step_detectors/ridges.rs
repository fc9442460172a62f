//! Contacts of ridges with each other: where two edges cross, no vertex need be near.

use glam::DVec3;
use proximity::{NearFaces, PairProximity};
use surface::{
    Contact, ContactSide, NO_EDGE, Term, closest_between_segments, segment_meets_triangle,
};

use super::methods::ComparedSurface;
use crate::closest_pairs::{RIDGE_COSINE, SurfaceState};

/// Cosine by which a normal may lie outside the normals between the faces beside an edge.
/// Smaller, contacts come and go where an edge lies in a face; larger, they lean over.
const CONE_SLACK: f64 = 0.05;

/// Sine of the angle below which edges have no common normal of their own.
const PARALLEL_SINE: f64 = 1e-3;

/// Memory of the ridges of two surfaces, reused from pair to pair.
#[derive(Debug, Default)]
pub(super) struct RidgeScratch {
    /// Per edge of each surface, true if it is a ridge near the other.
    is_ridge: [Vec<bool>; 2],
    pairs: Vec<[u32; 2]>,
}

impl RidgeScratch {
    /// Adds the contacts between ridges of two surfaces whose near faces are known;
    /// returns their number.
    pub(super) fn add_contacts(
        &mut self,
        surfaces: &PairProximity,
        sides: [ComparedSurface<'_>; 2],
        reach: f64,
        found: &mut Vec<Contact>,
    ) -> usize {
        // Where one of both has no ridges near, as round bodies, there is nothing to do.
        let [of_a, of_b] = surfaces.sides();
        let near_faces = [of_a.near_faces(), of_b.near_faces()];
        for ((side, near), is_ridge) in sides.iter().zip(near_faces).zip(&mut self.is_ridge) {
            if !mark_ridges(side, near, is_ridge) {
                return 0;
            }
        }
        self.find_pairs(sides, of_a.near_faces());

        let before = found.len();
        for &edges in &self.pairs {
            found.extend(contact_of(sides, edges, reach));
        }
        found.len() - before
    }

    /// Lists the pairs of ridges of faces that are near each other, each once.
    fn find_pairs(&mut self, [a, b]: [ComparedSurface<'_>; 2], near_faces: &NearFaces) {
        let Self { is_ridge: [of_a, of_b], pairs } = self;
        let ridges = |side: &ComparedSurface<'_>, face: u32, is_ridge: &[bool]| {
            let edges = side.tree.surface().face_edges()[face as usize];
            edges.map(|edge| (edge != NO_EDGE && is_ridge[edge as usize]).then_some(edge))
        };

        pairs.clear();
        for (face, others) in near_faces.iter() {
            for edge in ridges(&a, face, of_a).into_iter().flatten() {
                for &other in others {
                    let of_other = ridges(&b, other, of_b).into_iter().flatten();
                    pairs.extend(of_other.map(|other| [edge, other]));
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
    }
}

/// Marks the ridges of near faces; returns false if there are none.
fn mark_ridges(side: &ComparedSurface<'_>, near: &NearFaces, is_ridge: &mut Vec<bool>) -> bool {
    let (surface, state) = (side.tree.surface(), side.state());
    is_ridge.clear();
    is_ridge.resize(surface.edges().len(), false);
    let mut has_ridges = false;
    for (face, _) in near.iter() {
        for edge in surface.face_edges()[face as usize] {
            if edge != NO_EDGE && !is_ridge[edge as usize] {
                is_ridge[edge as usize] = is_convex_ridge(&state, edge);
                has_ridges |= is_ridge[edge as usize];
            }
        }
    }
    has_ridges
}

/// Returns true if two faces meet at an edge by more than the angle of a ridge, and stick out there.
fn is_convex_ridge(state: &SurfaceState<'_>, edge: u32) -> bool {
    let &[face, other] = state.surface.edge_faces(edge) else { return false };
    let [normal, of_other] = [face, other].map(|face| state.normal(face));
    let start = state.x.at(state.surface.edges()[edge as usize][0]);
    let corners = state.x.corners(state.surface.faces()[other as usize]);

    // Two of these corners are on the edge, at height 0 up to rounding.
    let mut height = 0.0;
    for corner in corners {
        height += normal.dot(corner - start);
    }
    normal.dot(of_other) < RIDGE_COSINE && height < 0.0
}

/// Returns the contact of two ridges that are closest to each other between their ends.
///
/// Their common normal must be between those of the faces beside each. Then they are mutually
/// closest, or, where faces beside them cross, the nearest way out of each other.
fn contact_of(sides: [ComparedSurface<'_>; 2], edges: [u32; 2], reach: f64) -> Option<Contact> {
    let ([a, b], [of_a, of_b]) = (sides, edges);
    let (a, b) = (Ridge::new(a, of_a), Ridge::new(b, of_b));
    let closest = closest_between_segments(a.ends, b.ends);
    if !is_between_ends(closest.s) || !is_between_ends(closest.t) {
        return None;
    }

    // Out of the second, and into the first.
    let [along_a, along_b] = [&a, &b].map(|ridge| ridge.ends[1] - ridge.ends[0]);
    let across = along_a.cross(along_b);
    if across.length() < PARALLEL_SINE * along_a.length() * along_b.length() {
        return None;
    }
    let across = across.normalize();
    let normal = if across.dot(b.outward) < 0.0 { -across } else { across };
    if !b.has_normal(normal) || !a.has_normal(-normal) {
        return None;
    }

    // Beyond each other only where each cuts into the other, not on two sides of a body.
    let [p, on] = closest.points;
    let gap = (p - on).dot(normal);
    if gap > reach || (gap < 0.0 && !(a.cuts(&b) && b.cuts(&a))) {
        return None;
    }
    let (of_p, of_on) = (a.terms(closest.s), b.terms(closest.t));
    Some(Contact::between(a.contact_side(p, &of_p), b.contact_side(on, &of_on), normal, gap))
}

/// Returns true if a parameter of a segment is at neither of its ends.
fn is_between_ends(t: f64) -> bool {
    t > 0.0 && t < 1.0
}

/// Ridge of a surface.
struct Ridge<'a> {
    side: ComparedSurface<'a>,
    edge: u32,
    vertices: [u32; 2],
    ends: [DVec3; 2],
    /// Sum of the unit normals of the faces beside it.
    outward: DVec3,
}

impl<'a> Ridge<'a> {
    fn new(side: ComparedSurface<'a>, edge: u32) -> Self {
        let state = side.state();
        let vertices = state.surface.edges()[edge as usize];
        let ends = vertices.map(|vertex| state.x.at(vertex));
        let faces = state.surface.edge_faces(edge);
        let outward = faces.iter().map(|&face| state.normal(face)).sum();
        Self { side, edge, vertices, ends, outward }
    }

    /// Returns true if a unit vector across the ridge is between the normals beside it.
    fn has_normal(&self, normal: DVec3) -> bool {
        // The cosine of half the angle between two unit vectors is half the length of their sum.
        let length = self.outward.length();
        normal.dot(self.outward) >= (0.5 * length - CONE_SLACK) * length
    }

    /// Returns true if it meets a face beside another ridge.
    fn cuts(&self, other: &Self) -> bool {
        for &face in other.side.tree.surface().edge_faces(other.edge) {
            if segment_meets_triangle(self.ends, other.side.tree.corners(face)).shares_a_point() {
                return true;
            }
        }
        false
    }

    fn terms(&self, t: f64) -> [Term; 2] {
        let [from, to] = self.vertices.map(|vertex| self.side.contact.particles.particle(vertex));
        [Term { particle: from, weight: 1.0 - t }, Term { particle: to, weight: t }]
    }

    fn contact_side<'t>(&self, point: DVec3, terms: &'t [Term]) -> ContactSide<'t> {
        if self.side.contact.is_rigid {
            ContactSide::at_rest(point)
        } else {
            ContactSide::Particles(terms)
        }
    }
}
