//! Faces grouped by common vertices.

use std::collections::BTreeMap;

use surface::{TriangleSurface, UnionFind, triangle};

use crate::SurfaceTree;

/// Connected groups of faces, joined by common vertices.
#[derive(Debug)]
pub(crate) struct FaceGroups {
    sets: UnionFind,
    /// Faces of each group, ascending, by the smallest vertex of the group.
    pub(crate) faces: BTreeMap<u32, Vec<u32>>,
}

impl FaceGroups {
    /// Groups some faces, given in ascending order.
    pub(crate) fn new(surface: &TriangleSurface, faces: &[u32]) -> Self {
        let mut sets = UnionFind::new(surface.vertex_count());
        for &face in faces {
            let [a, b, c] = surface.faces()[face as usize];
            sets.join(a, b);
            sets.join(b, c);
        }

        // A face is in the group of any of its corners.
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &face in faces {
            let corner = surface.faces()[face as usize][0];
            groups.entry(sets.find(corner)).or_default().push(face);
        }
        Self { sets, faces: groups }
    }

    /// Returns the smallest vertex of the group that a vertex is in.
    pub(crate) fn root(&mut self, vertex: u32) -> u32 {
        self.sets.find(vertex)
    }
}

/// Computes the area of some faces.
pub(crate) fn area(surface: &SurfaceTree, faces: &[u32]) -> f64 {
    faces.iter().map(|&face| triangle::area(surface.corners(face))).sum()
}
