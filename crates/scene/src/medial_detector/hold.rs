//! Point of a body's surface that a contact of balls acts on.

use glam::DVec3;
use kdop::Workspace;
use medial::{Links, MedialSurface};
use surface::{Anchor, Contact, Stencil, Term, TriangleSurface};

use crate::Body;
use crate::BodyKind;

/// No face is a hint.
const NO_HINT: u32 = u32::MAX;

/// A point of a body's surface, by the particles that carry it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint<'a> {
    body: &'a Body,
    pub(super) point: DVec3,
    particles: [u32; 3],
    weights: [f64; 3],
}

impl<'a> SurfacePoint<'a> {
    pub(super) fn vertex(body: &'a Body, vertex: u32) -> Self {
        let particles = [body.particles().start + vertex; 3];
        let point = body.positions()[vertex as usize];
        Self { body, point, particles, weights: [1.0, 0.0, 0.0] }
    }

    /// The point of the surface nearest to `p`; `hint` is a face that is likely
    /// near.
    pub(super) fn nearest(
        body: &'a Body,
        p: DVec3,
        hint: u32,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        let hint = (hint != NO_HINT).then_some(hint);
        let found = body.tree()?.closest_point(p, f64::INFINITY, hint, workspace)?;
        let (face, foot) = (found.face, found.foot);
        let corners = body.surface().faces()[face as usize];
        let particles = corners.map(|corner| body.particles().start + corner);
        Some(Self { body, point: foot.point, particles, weights: foot.barycentric })
    }

    /// The corner with the largest share.
    pub(super) fn corner(&self) -> u32 {
        let [a, b, c] = self.weights;
        let k = if b > a { if c > b { 2 } else { 1 } } else { 2 * usize::from(c > a) };
        self.particles[k] - self.body.particles().start
    }

    /// The contact of this vertex with a point `on` another body, out of which
    /// `normal` points, at the distance `gap` of the balls.
    pub(super) fn contact(&self, on: &Self, normal: DVec3, gap: f64) -> Contact {
        let anchored = |stencil, point| {
            let anchor = Some(Anchor { point, ..Anchor::default() });
            Contact { stencil, anchor, normal, offset: 0.0, gap, time: None }
        };
        let contact = if on.body.kind() == BodyKind::Rigid {
            let term = Term { particle: self.particles[0], weight: -1.0 };
            anchored(Stencil::single(term), on.point)
        } else if self.body.kind() == BodyKind::Rigid {
            let stencil = Stencil::face(on.particles, on.weights.map(|weight| -weight));
            Contact { normal: -normal, ..anchored(stencil, self.point) }
        } else {
            let stencil = Stencil::vertex_face(self.particles[0], on.particles, on.weights);
            Contact { anchor: None, ..anchored(stencil, on.point) }
        };
        settled(contact, (self.point - on.point).dot(normal))
    }

    /// The contact of this point with the point `anchor` of a bone, out of which
    /// `normal` points, at the distance `gap` of ball and bone.
    pub(super) fn anchored(&self, anchor: Anchor, normal: DVec3, gap: f64) -> Contact {
        let stencil = Stencil::face(self.particles, self.weights.map(|weight| -weight));
        let anchor_point = anchor.point;
        let contact =
            Contact { stencil, anchor: Some(anchor), normal, offset: 0.0, gap, time: None };
        settled(contact, (self.point - anchor_point).dot(normal))
    }
}

/// Puts what lies between the surface and the balls into the offset, or, where
/// the surface reaches farther than the balls, into the gap.
fn settled(contact: Contact, height: f64) -> Contact {
    let gap = contact.gap.min(height);
    Contact { gap, offset: height - gap, ..contact }
}

/// For each primitive and each side of it, a face of the surface that is near.
#[derive(Debug)]
pub(super) struct Hints(Vec<[u32; 2]>);

impl Hints {
    pub(super) fn new(medial: &MedialSurface, surface: &TriangleSurface, links: &Links) -> Self {
        let mut hints = vec![[NO_HINT; 2]; medial.primitives().len()];
        for (vertex, link) in (0_u32..).zip(links.links()) {
            let of_side = &mut hints[link.primitive as usize][usize::from(link.side > 0)];
            if let Some(&face) = surface.vertex_faces(vertex).first() {
                *of_side = face;
            }
        }
        // A side that no vertex touches: the other one is not far.
        for [a, b] in &mut hints {
            (*a, *b) = (if *a == NO_HINT { *b } else { *a }, if *b == NO_HINT { *a } else { *b });
        }
        Self(hints)
    }

    /// A face near the border of a primitive in the direction of `normal`.
    pub(super) fn of(&self, medial: &MedialSurface, primitive: u32, normal: DVec3) -> u32 {
        let [a, b, c] = medial.primitive_balls(primitive).map(|ball| ball.center);
        let side = (b - a).cross(c - a).dot(normal) > 0.0;
        self.0[primitive as usize][usize::from(side)]
    }
}
