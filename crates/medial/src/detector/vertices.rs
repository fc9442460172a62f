//! Contacts of a body's vertices with balls.

use proximity::NearVertex;
use surface::TriangleSurface;

use super::on_surface::{near_vertex, vertex_contact};
use super::{
    ContactBody, MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall,
};
use crate::{
    Ball, CandidatePair, FootRule, MedialContactParams, PointContact, point_contacts_among,
};

impl MedialDetector {
    /// Finds the contacts of a body's vertices with the balls, which are those of `own`, in
    /// ascending order of the vertices.
    ///
    /// The balls are taken as they are: no vertex that is within the margin of them is lost.
    /// Outside the body, no vertex is lost whose distance from it is less than the margin by the
    /// bound of the deviation. With a margin of that bound, no vertex inside is lost, unless the
    /// union of balls has a void there. A ball that pokes through a face without reaching its
    /// corners is not detected; [`pair_contacts`](Self::pair_contacts) detects it.
    #[must_use]
    pub fn vertex_contacts(
        &self,
        body: &ContactBody<'_>,
        own: &ContactBody<'_>,
        scratch: &mut MedialScratch,
    ) -> Vec<MedialContact> {
        self.find_vertices(body, scratch);

        let mut contacts = Vec::with_capacity(scratch.points.len());
        for found in &scratch.points {
            // The contact acts on the face next to the border of the ball.
            let PointContact { point: vertex, primitive, foot, normal, gap, .. } = *found;
            let border = foot.ball.center + foot.ball.radius * normal;
            let workspace = &mut scratch.workspace;
            let Some(on) = self.closest_on(own, primitive, border, normal, workspace) else {
                continue;
            };
            contacts.push(MedialContact {
                contact: vertex_contact(body, vertex, own, &on, normal, gap),
                ball: PrimitiveBall { primitive, weights: foot.weights },
                feature: MedialFeature::Vertex(vertex),
            });
        }
        contacts
    }

    /// Finds the vertices within the margin of the balls whose gap to the body's own surface is at most
    /// `max_gap`, in ascending order, and adds them.
    ///
    /// The balls select vertices and the faces near them, and the surface measures them: so a
    /// dent that the balls do not follow makes no depth that is not there. No vertex outside is
    /// lost by less than the margin less [`surface_bound`](Self::surface_bound).
    pub fn near_vertices(
        &self,
        body: &ContactBody<'_>,
        own: &ContactBody<'_>,
        max_gap: f64,
        scratch: &mut MedialScratch,
        out: &mut Vec<NearVertex>,
    ) {
        self.find_vertices(body, scratch);

        let mut last = None;
        for found in &scratch.points {
            // Of several contacts of a vertex, the surface has one.
            let PointContact { point: vertex, primitive, normal, .. } = *found;
            if last.replace(vertex) == Some(vertex) {
                continue;
            }
            let p = body.tree.position(vertex);
            let hint = self.hints.face(&self.medial, primitive, normal);
            let closest = own.tree.closest_point(p, f64::INFINITY, hint, &mut scratch.workspace);
            let workspace = &mut scratch.workspace;
            let near = closest.map(|closest| near_vertex(own, vertex, p, &closest, workspace));
            out.extend(near.filter(|near| near.gap <= max_gap));
        }
    }

    /// Finds the vertices within the margin of the balls.
    fn find_vertices(&self, body: &ContactBody<'_>, scratch: &mut MedialScratch) {
        let MedialScratch { workspace, pairs, candidates, points, .. } = scratch;
        let surface = body.tree.surface();

        // Candidates are the vertices of the faces whose bounds come near.
        pairs.clear();
        self.tree.tree().pairs(body.tree.tree(), self.margin, workspace, |primitive, face| {
            for point in surface.faces()[face as usize] {
                if is_first_face(surface, point, face) {
                    pairs.push(CandidatePair { point, primitive });
                }
            }
        });

        // Contacts are those within the margin.
        let params = MedialContactParams {
            margin: self.margin,
            rule: FootRule::Exact,
            max_contacts: self.max_contacts,
        };
        let ball = |vertex| Ball::new(body.tree.position(vertex), 0.0);
        point_contacts_among(pairs, ball, &self.medial, &params, candidates, points);
    }
}

/// Returns true if a face is the first of those at one of its vertices, so that each vertex is a
/// candidate once.
fn is_first_face(surface: &TriangleSurface, vertex: u32, face: u32) -> bool {
    surface.vertex_faces(vertex).first() == Some(&face)
}
