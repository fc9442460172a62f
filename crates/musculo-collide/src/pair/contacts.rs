//! Contacts for a response, from what was found between two bodies.

use glam::DVec3;
use surface::{Anchor, Contact, Stencil, Term};

use super::{NearVertex, PairReport, VertexReport};
use crate::scene::Body;
use crate::{BodyKind, Scene};

impl PairReport {
    /// One contact for each vertex that is inside or within reach, those of `a`
    /// first, with particles numbered by [`Body::particles`].
    ///
    /// A rigid body is the anchor of its contacts, at rest; where it holds the
    /// vertex, the point of the other body's face is the colliding point and
    /// the normal is turned round.
    ///
    /// # Panics
    ///
    /// When the report is of another scene.
    #[must_use]
    pub fn contacts(&self, scene: &Scene) -> Vec<Contact> {
        let (a, b) = (scene.body(self.a), scene.body(self.b));
        let of_side = |p, q, report: &VertexReport| -> Vec<Contact> {
            report.near.iter().map(|near| contact(p, q, near)).collect()
        };
        let mut contacts = of_side(a, b, &self.a_against_b);
        contacts.extend(of_side(b, a, &self.b_against_a));
        contacts
    }
}

/// A vertex of `p` against the face of `q` that holds its foot.
fn contact(p: &Body, q: &Body, near: &NearVertex) -> Contact {
    let vertex = p.particles().start + near.vertex;
    let corners = q.surface().faces()[near.face as usize];
    let face = corners.map(|corner| q.particles().start + corner);
    let anchored = |stencil, point, normal| {
        let anchor = Some(Anchor { point, ..Anchor::default() });
        Contact { stencil, anchor, normal, offset: 0.0, gap: near.gap, time: None }
    };
    let contact = if q.kind() == BodyKind::Rigid {
        let term = Term { particle: vertex, weight: -1.0 };
        anchored(Stencil::single(term), near.foot, near.normal)
    } else if p.kind() == BodyKind::Rigid {
        let weights = near.barycentric.map(|weight| -weight);
        let position = p.positions()[near.vertex as usize];
        anchored(Stencil::face(face, weights), position, -near.normal)
    } else {
        let stencil = Stencil::vertex_face(vertex, face, near.barycentric);
        Contact { anchor: None, ..anchored(stencil, near.foot, near.normal) }
    };
    debug_assert!(satisfies_identity(&contact, p, q), "{contact:?}");
    contact
}

fn satisfies_identity(contact: &Contact, p: &Body, q: &Body) -> bool {
    let at = |particle: u32| -> DVec3 {
        let body = if p.particles().contains(&particle) { p } else { q };
        body.positions()[(particle - body.particles().start) as usize]
    };
    let scale = contact.stencil.terms().iter().map(|term| at(term.particle).abs().max_element());
    contact.identity_error(at) <= 64.0 * f64::EPSILON * scale.fold(contact.gap.abs(), f64::max)
}
