//! Transfer of contacts from balls to the body's surface.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex, contact};
use surface::Contact;

use super::{ContactBody, MedialDetector};

impl MedialDetector {
    /// Finds the point of the body's surface nearest to a point of the border of a primitive, in
    /// the direction of `normal`.
    pub(super) fn closest_on(
        &self,
        body: &ContactBody<'_>,
        primitive: u32,
        border: DVec3,
        normal: DVec3,
        workspace: &mut Workspace,
    ) -> Option<ClosestPoint> {
        let hint = self.hints.face(&self.medial, primitive, normal);
        body.tree.closest_point(border, f64::INFINITY, hint, workspace)
    }
}

/// Builds the contact of a vertex of `p` with a point of `q`, out of which `normal` points.
///
/// `gap` is the distance of the vertex from the balls of `q`.
pub(super) fn vertex_contact(
    p: &ContactBody<'_>,
    vertex: u32,
    q: &ContactBody<'_>,
    on: &ClosestPoint,
    normal: DVec3,
    gap: f64,
) -> Contact {
    let height = (p.tree.position(vertex) - on.foot.point).dot(normal);
    // The contact with the surface, by its height.
    let near = NearVertex {
        vertex,
        gap: height,
        foot: on.foot.point,
        face: on.face,
        barycentric: on.foot.barycentric,
        normal,
    };
    with_ball_gap(contact(&p.surface(), &q.surface(), &near), gap)
}

/// Splits the height over the surface into a gap and an offset.
///
/// Where the balls extend beyond the surface, the difference is the offset. Where the surface
/// extends beyond the balls, the gap is that over the surface.
pub(super) fn with_ball_gap(contact: Contact, ball_gap: f64) -> Contact {
    let height = contact.gap;
    let gap = ball_gap.min(height);
    Contact { gap, offset: height - gap, ..contact }
}
