//! Connected patches of a surface in contact with another.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::triangle;

use crate::face_groups::{FaceGroups, area};
use crate::{NearVertex, SurfaceTree};

/// Connected patch of one surface that is in contact with the other: faces that share a point
/// with it, or have a corner inside or within the margin. Faces are connected by common vertices.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactPatch {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// Sum of their areas, in the square of the length unit.
    pub area: f64,
    /// Smallest signed distance of a vertex of the patch, negative inside; `None` where no
    /// corner is inside or within the margin.
    pub min_gap: Option<f64>,
    /// Area-weighted mean of the faces' centers.
    pub center: DVec3,
}

/// Finds the patches of `a`, largest area first, then by first face.
///
/// `cut_faces` share a point with the other surface; `near` are the vertices inside or within
/// the margin.
pub(crate) fn find(a: &SurfaceTree, cut_faces: &[u32], near: &[NearVertex]) -> Vec<ContactPatch> {
    let gaps: BTreeMap<u32, f64> = near.iter().map(|found| (found.vertex, found.gap)).collect();
    let near_faces = gaps.keys().flat_map(|&vertex| a.surface().vertex_faces(vertex));
    let mut faces: Vec<u32> = near_faces.chain(cut_faces).copied().collect();
    faces.sort_unstable();
    faces.dedup();

    let groups = FaceGroups::new(a.surface(), &faces).faces;
    let mut patches: Vec<ContactPatch> =
        groups.into_values().map(|faces| measure(a, faces, &gaps)).collect();
    patches.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
    patches
}

fn measure(a: &SurfaceTree, faces: Vec<u32>, gaps: &BTreeMap<u32, f64>) -> ContactPatch {
    let mut moment = DVec3::ZERO;
    for &face in &faces {
        let [p, q, r] = a.corners(face);
        moment += triangle::area([p, q, r]) / 3.0 * (p + q + r);
    }
    let area = area(a, &faces);
    let center = if area > 0.0 { moment / area } else { a.corners(faces[0])[0] };

    let corners = faces.iter().flat_map(|&face| a.surface().faces()[face as usize]);
    let min_gap = corners.filter_map(|corner| gaps.get(&corner).copied()).min_by(f64::total_cmp);
    ContactPatch { faces, area, min_gap, center }
}
