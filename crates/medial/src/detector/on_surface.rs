//! Transfer of contacts from balls to the body's surface.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex, contact};
use surface::{Contact, Pseudonormals, triangle};

use super::{ContactBody, MedialDetector};
use crate::surface_distance::is_needle;

/// Distance from a foot, relative to the coordinates, below which its direction is rounding: a
/// direction at this distance is good to 1e-6.
const AT_SURFACE: f64 = 1e-10;

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

/// Measures a vertex at its closest point of a surface, outward by the pseudonormal there, or beside
/// needles by parity.
pub(super) fn near_vertex(
    on: &ContactBody<'_>,
    vertex: u32,
    p: DVec3,
    closest: &ClosestPoint,
    workspace: &mut Workspace,
) -> NearVertex {
    let ClosestPoint { face, foot, .. } = *closest;
    let (surface, x) = (on.tree.surface(), on.tree.positions());
    let mut outward = Pseudonormals::of_feature(surface, x, face, foot.feature);
    if outward == DVec3::ZERO {
        outward = triangle::normal(on.tree.corners(face)).normalize_or(DVec3::Z);
    }

    // At the surface the direction from the foot is rounding.
    let away = p - foot.point;
    let is_behind = if is_beside_needle(on, closest) {
        on.tree.contains(p, workspace)
    } else {
        away.dot(outward) < 0.0
    };
    let side = if is_behind { -1.0 } else { 1.0 };
    let scale = p.abs().max(foot.point.abs()).max_element();
    let is_off_surface = away.length() > AT_SURFACE * scale;
    let normal = if is_off_surface { side * away.normalize() } else { outward.normalize() };
    let (gap, barycentric) = (away.dot(normal), foot.barycentric);
    NearVertex { vertex, gap, foot: foot.point, face, barycentric, normal }
}

/// Returns true if a face at the closest point is so flat that its normal is rounding.
fn is_beside_needle(on: &ContactBody<'_>, closest: &ClosestPoint) -> bool {
    let faces = on.tree.surface().faces_around(&closest.face, closest.foot.feature);
    faces.iter().any(|&face| is_needle(on.tree.corners(face)))
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
