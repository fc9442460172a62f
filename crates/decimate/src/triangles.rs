//! Triangles with positions, and the nearest of them.

use glam::DVec3;
use kdop::{Leaves, Tree, TreeError, Workspace};
use surface::{NO_EDGE, TriangleSurface, closest_on_triangle};

/// Stands for a face across an edge where there is none.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A surface with its positions.
#[derive(Clone, Copy)]
pub(crate) struct Triangles<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: &'a [DVec3],
}

impl<'a> Triangles<'a> {
    pub(crate) fn faces(&self) -> &'a [[u32; 3]] {
        self.surface.faces()
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces()[face as usize].map(|v| self.x[v as usize])
    }

    pub(crate) fn distance(&self, p: DVec3, face: u32) -> f64 {
        closest_on_triangle(p, self.corners(face)).point.distance(p)
    }

    /// Diagonal of the box around all positions.
    pub(crate) fn size(&self) -> f64 {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = self.x.iter().fold(start, |[low, high], x| [low.min(*x), high.max(*x)]);
        if low.x <= high.x { low.distance(high) } else { 0.0 }
    }

    /// For each face those on the other sides of its edges; [`NOTHING`] where there is
    /// not one that continues it.
    pub(crate) fn across(&self) -> Vec<[u32; 3]> {
        let around = |face: u32| [0, 1, 2].map(|k| self.beyond(face, k).unwrap_or(NOTHING));
        (0_u32..).zip(self.faces()).map(|(face, _)| around(face)).collect()
    }

    fn beyond(&self, face: u32, k: usize) -> Option<u32> {
        let edge = self.surface.face_edges()[face as usize][k];
        if edge == NO_EDGE {
            return None;
        }
        let other = match *self.surface.edge_faces(edge) {
            [first, second] if first == face && second != face => second,
            [first, second] if second == face && first != face => first,
            _ => return None,
        };
        let corners = self.faces()[face as usize];
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let [a, b, c] = self.faces()[other as usize];
        [[a, b], [b, c], [c, a]].contains(&[to, from]).then_some(other)
    }

    pub(crate) fn tree(&self) -> Result<Tree, TreeError> {
        Tree::build(Leaves::Triangles(self.faces()), self.x)
    }
}

/// Faces to which distances are measured: at least one.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) triangles: Triangles<'a>,
    pub(crate) tree: &'a Tree,
    pub(crate) across: &'a [[u32; 3]],
}

impl Target<'_> {
    /// The nearest face, of equals that with the lowest number, and its distance.
    /// A `guess` that is near makes it fast.
    pub(crate) fn nearest(&self, p: DVec3, guess: u32, workspace: &mut Workspace) -> (u32, f64) {
        let mut best = (self.triangles.distance(p, guess), guess);
        self.tree.nearest(p, best.0, workspace, |face, _| {
            let distance = self.triangles.distance(p, face);
            if (distance, face) < best {
                best = (distance, face);
            }
            best.0
        });
        (best.1, best.0)
    }
}
