//! Connected patches of a surface in contact with another.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::triangle;

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

    let groups = connected(a, &faces);
    let mut patches: Vec<ContactPatch> =
        groups.into_iter().map(|faces| measure(a, faces, &gaps)).collect();
    patches.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
    patches
}

/// Splits faces (ascending) into groups joined by common vertices.
fn connected(a: &SurfaceTree, faces: &[u32]) -> Vec<Vec<u32>> {
    let mut is_grouped = vec![false; faces.len()];
    let mut groups = Vec::new();
    for start in 0..faces.len() {
        if is_grouped[start] {
            continue;
        }
        is_grouped[start] = true;
        let mut group = vec![faces[start]];
        let mut next = 0;
        while next < group.len() {
            add_neighbors(a, group[next], faces, &mut is_grouped, &mut group);
            next += 1;
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// Adds the faces of the list that share a vertex with `face` and are in no group yet.
fn add_neighbors(
    a: &SurfaceTree,
    face: u32,
    faces: &[u32],
    is_grouped: &mut [bool],
    group: &mut Vec<u32>,
) {
    for vertex in a.surface().faces()[face as usize] {
        for neighbor in a.surface().vertex_faces(vertex) {
            if let Ok(i) = faces.binary_search(neighbor)
                && !std::mem::replace(&mut is_grouped[i], true)
            {
                group.push(*neighbor);
            }
        }
    }
}

fn measure(a: &SurfaceTree, faces: Vec<u32>, gaps: &BTreeMap<u32, f64>) -> ContactPatch {
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    let mut min_gap: Option<f64> = None;
    for &face in &faces {
        let corners = a.corners(face);
        let face_area = triangle::area(corners);
        area += face_area;
        moment += face_area / 3.0 * (corners[0] + corners[1] + corners[2]);

        let corners = a.surface().faces()[face as usize];
        let gaps = corners.iter().filter_map(|vertex| gaps.get(vertex).copied());
        min_gap = min_gap.into_iter().chain(gaps).min_by(f64::total_cmp);
    }
    let center = if area > 0.0 { moment / area } else { a.corners(faces[0])[0] };
    ContactPatch { faces, area, min_gap, center }
}
