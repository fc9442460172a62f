//! Bodies that coincide: one mesh under two names, or two meshes of one surface.

use std::cmp::Ordering;

use glam::DVec3;
use overlap::Overlap;
use proximity::SurfaceTree;
use surface::{Aabb, triangle};

/// Way in which two bodies are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Coincidence {
    /// Both have the same vertices and faces, in any order.
    SameMesh,
    /// Both are the same surface, divided into other faces.
    SameSurface,
}

impl Coincidence {
    /// Compares vertices and faces.
    pub(crate) fn of_meshes(bodies: [&SurfaceTree; 2]) -> Option<Self> {
        let [a, b] = bodies.map(SurfaceTree::surface);
        if (a.vertex_count(), a.faces().len()) != (b.vertex_count(), b.faces().len()) {
            return None;
        }
        let [a, b] = bodies.map(bounds);
        if a != b {
            return None;
        }

        // Sorting takes longer than all else, and is left to bodies that are very likely one.
        let [a, b] = bodies.map(sorted_faces);
        (a == b).then_some(Self::SameMesh)
    }

    /// Compares the area in which faces coincide with the areas of both surfaces.
    pub(crate) fn of_overlap(overlap: &Overlap, bodies: [&SurfaceTree; 2]) -> Option<Self> {
        /// Rounding of areas, relative.
        const ROUNDING: f64 = 1e-9;

        let flush = overlap.total.flush_area;
        if flush <= 0.0 {
            return None;
        }
        for body in bodies {
            if (area(body) - flush).abs() > ROUNDING * flush {
                return None;
            }
        }
        Some(Self::SameSurface)
    }
}

/// Computes the diagonal of a body's box.
pub(crate) fn size(body: &SurfaceTree) -> f64 {
    bounds(body).diagonal()
}

fn bounds(body: &SurfaceTree) -> Aabb {
    body.surface().bounds(body.positions())
}

fn area(body: &SurfaceTree) -> f64 {
    let mut sum = 0.0;
    for &face in body.surface().faces() {
        sum += triangle::area(body.positions().corners(face));
    }
    sum
}

/// Returns the corners of all faces, without the order of faces and of corners.
fn sorted_faces(body: &SurfaceTree) -> Vec<[DVec3; 3]> {
    let mut faces = Vec::with_capacity(body.surface().faces().len());
    for &face in body.surface().faces() {
        // A coordinate of 0 has one sign.
        let mut corners = body.positions().corners(face).map(|corner| corner + DVec3::ZERO);
        corners.sort_by(compare);
        faces.push(corners);
    }
    faces.sort_by(compare_faces);
    faces
}

/// Compares faces by their corners, in lexical order.
fn compare_faces(p: &[DVec3; 3], q: &[DVec3; 3]) -> Ordering {
    compare(&p[0], &q[0]).then(compare(&p[1], &q[1])).then(compare(&p[2], &q[2]))
}

/// Compares points by their coordinates, in lexical order.
fn compare(p: &DVec3, q: &DVec3) -> Ordering {
    p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z))
}
