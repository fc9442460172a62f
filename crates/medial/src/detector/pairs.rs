//! Contacts between the balls of two bodies.

use glam::DVec3;

use super::on_surface::vertex_contact;
use super::{
    ContactBody, MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall,
};
use crate::{Ball, PrimitiveContact, primitive_contacts_among};

/// Contact of two primitives with the vertex that it acts on.
struct AtVertex<'a> {
    vertex: u32,
    found: &'a PrimitiveContact,
}

impl MedialDetector {
    /// Finds the contacts between two bodies by the balls of both, in ascending order of the
    /// vertices of `own`.
    ///
    /// Each contact is of a pair of primitives whose unions come within the margin of this
    /// detector. It acts on the vertex of `own` nearest to where they do; of several at one vertex,
    /// the deepest is kept. Depths are those of the balls, wherever they meet: nothing is lost
    /// between vertices.
    #[must_use]
    pub fn pair_contacts(
        &self,
        own: &ContactBody<'_>,
        other: &Self,
        other_body: &ContactBody<'_>,
        scratch: &mut MedialScratch,
    ) -> Vec<MedialContact> {
        // Pairs of primitives within the margin.
        let MedialScratch { workspace, primitive_pairs: pairs, primitives, .. } = scratch;
        pairs.clear();
        let other_tree = other.tree.tree();
        self.tree.tree().pairs(other_tree, self.margin, workspace, |i, j| pairs.push([i, j]));
        primitive_contacts_among(pairs, &self.medial, &other.medial, self.margin, primitives);

        // The vertex nearest to the border of the ball.
        let mut at_vertices = Vec::with_capacity(primitives.len());
        for found in &*primitives {
            let (primitive, normal) = (found.primitives[0], -found.normal);
            let border = self.border(found, 0, normal);
            if let Some(on) = self.closest_on(own, primitive, border, normal, workspace) {
                let corner = largest(on.foot.barycentric);
                let vertex = own.tree.surface().faces()[on.face as usize][corner];
                at_vertices.push(AtVertex { vertex, found });
            }
        }
        keep_deepest(&mut at_vertices);

        let mut contacts = Vec::with_capacity(at_vertices.len());
        for AtVertex { vertex, found } in at_vertices {
            // Under the vertex, which is a little beside the place of the smallest distance.
            let normal = found.normal;
            let beside = own.tree.position(vertex) - self.border(found, 0, -normal);
            let under = other.border(found, 1, normal) + beside - beside.dot(normal) * normal;
            let primitive = found.primitives[1];
            let Some(on) = other.closest_on(other_body, primitive, under, normal, workspace) else {
                continue;
            };
            contacts.push(MedialContact {
                contact: vertex_contact(own, vertex, other_body, &on, normal, found.gap),
                ball: primitive_ball(found, 1),
                feature: MedialFeature::Ball(primitive_ball(found, 0)),
            });
        }
        contacts
    }

    /// Returns the border of one of the balls of a contact, in the direction of `normal`.
    fn border(&self, found: &PrimitiveContact, side: usize, normal: DVec3) -> DVec3 {
        let balls = self.medial.primitive_balls(found.primitives[side]);
        let ball = Ball::interpolate(&balls, found.weights[side]);
        ball.center + ball.radius * normal
    }
}

/// Keeps the deepest contact at each vertex, of equals the first, in ascending order.
fn keep_deepest(at_vertices: &mut Vec<AtVertex<'_>>) {
    at_vertices
        .sort_by(|a, b| a.vertex.cmp(&b.vertex).then_with(|| a.found.gap.total_cmp(&b.found.gap)));
    at_vertices.dedup_by_key(|at| at.vertex);
}

fn primitive_ball(found: &PrimitiveContact, side: usize) -> PrimitiveBall {
    PrimitiveBall { primitive: found.primitives[side], weights: found.weights[side] }
}

/// Returns the corner with the largest weight, the first of equals.
fn largest([a, b, c]: [f64; 3]) -> usize {
    if b > a { if c > b { 2 } else { 1 } } else { 2 * usize::from(c > a) }
}
