//! Bare triangles, and the nearest of them.

use glam::DVec3;
use kdop::{Leaves, Tree, TreeError, Workspace};
use surface::closest_on_triangle;

/// Faces with their positions.
#[derive(Clone, Copy)]
pub(crate) struct Triangles<'a> {
    pub(crate) faces: &'a [[u32; 3]],
    pub(crate) x: &'a [DVec3],
}

impl Triangles<'_> {
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces[face as usize].map(|v| self.x[v as usize])
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

    pub(crate) fn tree(&self) -> Result<Tree, TreeError> {
        Tree::build(Leaves::Triangles(self.faces), self.x)
    }
}

/// Faces to which distances are measured: at least one.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) triangles: Triangles<'a>,
    pub(crate) tree: &'a Tree,
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
