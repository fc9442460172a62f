//! Balls of a body against those of another.

use glam::DVec3;
use medial::{Ball, PrimitiveContact, primitive_contacts_among};

use super::hold::SurfacePoint;
use super::{MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall};
use crate::Body;

/// Contacts of the balls of two detectors, given with their bodies. Trees must be
/// built.
pub(super) fn contacts(
    (a, of_a): (&MedialDetector, &Body),
    (b, of_b): (&MedialDetector, &Body),
    scratch: &mut MedialScratch,
) -> Vec<MedialContact> {
    let MedialScratch { workspace, pairs, primitives, .. } = scratch;
    pairs.clear();
    a.tree.tree().pairs(b.tree.tree(), a.margin, workspace, |i, j| pairs.push((i, j)));
    primitive_contacts_among(pairs, &a.medial, &b.medial, a.margin, primitives);
    let mut found: Vec<(u32, &PrimitiveContact)> = Vec::with_capacity(primitives.len());
    for contact in &*primitives {
        let border = border(a, contact, 0, -contact.normal);
        let hint = a.hints.of(&a.medial, contact.primitives[0], -contact.normal);
        if let Some(hold) = SurfacePoint::nearest(of_a, border, hint, workspace) {
            found.push((hold.corner(), contact));
        }
    }
    // Of equals the first stays: the order of the primitives is kept.
    found.sort_by(|(v, x), (w, y)| v.cmp(w).then(x.gap.total_cmp(&y.gap)));
    found.dedup_by_key(|(vertex, _)| *vertex);
    let contact = |(vertex, found): (u32, &PrimitiveContact)| {
        let normal = found.normal;
        let hold = SurfacePoint::vertex(of_a, vertex);
        // Under the vertex, which is a little beside the place of least distance.
        let beside = hold.point - border(a, found, 0, -normal);
        let under = border(b, found, 1, normal) + beside - beside.dot(normal) * normal;
        let hint = b.hints.of(&b.medial, found.primitives[1], normal);
        let on = SurfacePoint::nearest(of_b, under, hint, workspace)?;
        let ball =
            |k: usize| PrimitiveBall { primitive: found.primitives[k], weights: found.weights[k] };
        Some(MedialContact {
            contact: hold.contact(&on, normal, found.gap),
            ball: ball(1),
            feature: MedialFeature::Ball(ball(0)),
        })
    };
    found.into_iter().filter_map(contact).collect()
}

/// The border of one of the balls of a contact in the direction of `normal`.
fn border(
    detector: &MedialDetector,
    contact: &PrimitiveContact,
    side: usize,
    normal: DVec3,
) -> DVec3 {
    let balls = detector.medial.primitive_balls(contact.primitives[side]);
    let ball = Ball::interpolate(&balls, contact.weights[side]);
    ball.center + ball.radius * normal
}
