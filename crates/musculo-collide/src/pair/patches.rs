//! Connected parts of a surface in contact with another.

use std::collections::BTreeMap;

use glam::DVec3;

use super::projection::NearVertex;
use crate::shape::Shape;

/// A connected part of one body's surface that is in contact with the other
/// body: faces that share a point with it, or that have a corner inside or
/// within the margin. Faces are connected by a common vertex.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactPatch {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// Sum of their areas, in the square of the length unit.
    pub area: f64,
    /// Smallest signed distance of a vertex of the patch, negative inside;
    /// `None` where no corner is inside or within the margin.
    pub min_gap: Option<f64>,
    /// Area-weighted mean of the faces' centres.
    pub centre: DVec3,
}

/// Patches of `body`, largest area first, then by first face.
pub(super) fn find(body: &Shape, cut_faces: &[u32], near: &[NearVertex]) -> Vec<ContactPatch> {
    let gaps: BTreeMap<u32, f64> = near.iter().map(|vertex| (vertex.vertex, vertex.gap)).collect();
    let near_faces = gaps.keys().flat_map(|&vertex| body.surface().vertex_faces(vertex));
    let mut faces: Vec<u32> = near_faces.chain(cut_faces).copied().collect();
    faces.sort_unstable();
    faces.dedup();
    let mut patches: Vec<ContactPatch> =
        connected(body, &faces).into_iter().map(|faces| measure(body, faces, &gaps)).collect();
    patches.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
    patches
}

/// Splits faces (ascending) into groups joined by common vertices.
fn connected(body: &Shape, faces: &[u32]) -> Vec<Vec<u32>> {
    let mut reached = vec![false; faces.len()];
    let mut groups = Vec::new();
    for start in 0..faces.len() {
        if reached[start] {
            continue;
        }
        reached[start] = true;
        let mut group = vec![faces[start]];
        let mut next = 0;
        while next < group.len() {
            for vertex in body.surface().faces()[group[next] as usize] {
                for neighbour in body.surface().vertex_faces(vertex) {
                    if let Ok(at) = faces.binary_search(neighbour)
                        && !std::mem::replace(&mut reached[at], true)
                    {
                        group.push(*neighbour);
                    }
                }
            }
            next += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

fn measure(body: &Shape, faces: Vec<u32>, gaps: &BTreeMap<u32, f64>) -> ContactPatch {
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for &face in &faces {
        let [p, q, r] = body.corners(face);
        let face_area = 0.5 * (q - p).cross(r - p).length();
        area += face_area;
        moment += face_area / 3.0 * (p + q + r);
    }
    let corners = faces.iter().flat_map(|&face| body.surface().faces()[face as usize]);
    let min_gap = corners.filter_map(|vertex| gaps.get(&vertex).copied()).min_by(f64::total_cmp);
    let centre = if area > 0.0 { moment / area } else { body.corners(faces[0])[0] };
    ContactPatch { faces, area, min_gap, centre }
}
