//! Vertices of a body against balls.

use medial::{Ball, FootRule, MedialContactParams, PointContact, point_contacts_among};

use super::hold::SurfacePoint;
use super::{MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall};
use crate::Body;

/// Contacts of the vertices of `body` with the detector's balls, which are those
/// of `of`. Trees must be built.
pub(super) fn contacts(
    body: &Body,
    (detector, of): (&MedialDetector, &Body),
    scratch: &mut MedialScratch,
) -> Vec<MedialContact> {
    let MedialScratch { workspace, pairs, points, .. } = scratch;
    pairs.clear();
    let Some(tree) = body.tree() else { return Vec::new() };
    detector.tree.tree().pairs(tree.tree(), detector.margin, workspace, |primitive, face| {
        let own = body.surface().faces()[face as usize].into_iter();
        pairs.extend(own.filter(|&v| is_first(body, v, face)).map(|vertex| (vertex, primitive)));
    });
    let reach = MedialContactParams {
        margin: detector.margin,
        rule: FootRule::Exact,
        max_contacts: detector.most,
    };
    let ball = |vertex: u32| Ball::new(body.positions()[vertex as usize], 0.0);
    point_contacts_among(pairs, ball, &detector.medial, &reach, None, points);
    let contact = |found: &PointContact| {
        let PointContact { point: vertex, primitive, foot, normal, .. } = *found;
        let border = foot.ball.center + foot.ball.radius * normal;
        let hint = detector.hints.of(&detector.medial, primitive, normal);
        let on = SurfacePoint::nearest(of, border, hint, workspace)?;
        Some(MedialContact {
            contact: SurfacePoint::vertex(body, vertex).contact(&on, normal, found.gap),
            ball: PrimitiveBall { primitive, weights: foot.weights },
            feature: MedialFeature::Vertex(vertex),
        })
    };
    points.iter().filter_map(contact).collect()
}

/// Returns true if a face is the first of those at one of its vertices, so that each
/// vertex is looked at once.
fn is_first(body: &Body, vertex: u32, face: u32) -> bool {
    body.surface().vertex_faces(vertex).first() == Some(&face)
}
