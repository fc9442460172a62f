//! Contacts for a response, from what was found between two bodies.

use glam::DVec3;
use surface::{Anchor, Contact, Stencil, Term};

use super::{NearVertex, PairReport};
use crate::scene::Body;
use crate::shape::Shape;
use crate::{BodyKind, Scene};

/// One side of a contact: a shape, and which particles its vertices are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Party<'a> {
    pub(crate) kind: BodyKind,
    pub(crate) shape: &'a Shape,
    pub(crate) first_particle: u32,
    /// For a shape that stands for a finer one: the vertices of that one which
    /// it has kept, ascending.
    pub(crate) kept: Option<&'a [u32]>,
}

impl PairReport {
    /// One contact for each vertex that is inside or within the margin, those of `a`
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
        let [a, b] = [self.a, self.b].map(|id| Party::of(scene.body(id)));
        let of_a = self.a_against_b.near.iter().map(|near| contact(a, b, near));
        let of_b = self.b_against_a.near.iter().map(|near| contact(b, a, near));
        of_a.chain(of_b).collect()
    }
}

impl<'a> Party<'a> {
    /// A body as it is.
    pub(crate) fn of(body: &'a Body) -> Self {
        let first_particle = body.particles().start;
        Self { kind: body.kind(), shape: body.shape(), first_particle, kept: None }
    }

    pub(crate) fn particle(&self, vertex: u32) -> u32 {
        self.first_particle + self.kept.map_or(vertex, |kept| kept[vertex as usize])
    }

    /// The vertex that a particle is, if it is one of this party.
    fn vertex(&self, particle: u32) -> Option<u32> {
        let number = particle.checked_sub(self.first_particle)?;
        let vertex = match self.kept {
            None => number as usize,
            Some(kept) => kept.binary_search(&number).ok()?,
        };
        (vertex < self.shape.positions().len()).then(|| u32::try_from(vertex).ok())?
    }
}

/// A vertex of `p` against the face of `q` that holds its foot.
pub(crate) fn contact(p: Party<'_>, q: Party<'_>, near: &NearVertex) -> Contact {
    let vertex = p.particle(near.vertex);
    let face = q.shape.surface().faces()[near.face as usize].map(|corner| q.particle(corner));
    let anchored = |stencil, point, normal| {
        let anchor = Some(Anchor { point, ..Anchor::default() });
        Contact { stencil, anchor, normal, offset: 0.0, gap: near.gap, time: None }
    };
    let contact = if q.kind == BodyKind::Rigid {
        let term = Term { particle: vertex, weight: -1.0 };
        anchored(Stencil::single(term), near.foot, near.normal)
    } else if p.kind == BodyKind::Rigid {
        let weights = near.barycentric.map(|weight| -weight);
        let position = p.shape.positions()[near.vertex as usize];
        anchored(Stencil::face(face, weights), position, -near.normal)
    } else {
        let stencil = Stencil::vertex_face(vertex, face, near.barycentric);
        Contact { anchor: None, ..anchored(stencil, near.foot, near.normal) }
    };
    debug_assert!(satisfies_identity(&contact, p, q), "{contact:?}");
    contact
}

fn satisfies_identity(contact: &Contact, p: Party<'_>, q: Party<'_>) -> bool {
    let at = |particle: u32| -> DVec3 {
        let of = |party: Party<'_>| {
            party.vertex(particle).map(|vertex| party.shape.positions()[vertex as usize])
        };
        of(p).or_else(|| of(q)).expect("a particle of one of the two")
    };
    let scale = contact.stencil.terms().iter().map(|term| at(term.particle).abs().max_element());
    contact.identity_error(at) <= 64.0 * f64::EPSILON * scale.fold(contact.gap.abs(), f64::max)
}
