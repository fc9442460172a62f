//! Surface that distances are measured to, with its face adjacency.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::{NO_EDGE, TriangleSurface};

/// Stands for the face across an edge where none continues the surface.
pub(crate) const NO_FACE: u32 = u32::MAX;

/// Surface with at least one face that distances are measured to.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) tree: &'a SurfaceTree,
    /// [Adjacent faces](adjacent_faces).
    pub(crate) adjacent: &'a [[u32; 3]],
}

impl Target<'_> {
    /// Returns the distance to one face.
    pub(crate) fn distance(&self, p: DVec3, face: u32) -> f64 {
        self.tree.closest_on_face(p, face).distance
    }

    /// Finds the nearest face and its distance. A `hint` near the result makes it fast.
    pub(crate) fn nearest(&self, p: DVec3, hint: u32, workspace: &mut Workspace) -> (u32, f64) {
        match self.tree.closest_point(p, f64::INFINITY, Some(hint), workspace) {
            Some(found) => (found.face, found.distance),
            None => (hint, f64::INFINITY),
        }
    }
}

/// Finds, per face, the faces across its edges that continue it with the same orientation;
/// [`NO_FACE`] where there is not exactly one.
pub(crate) fn adjacent_faces(surface: &TriangleSurface) -> Vec<[u32; 3]> {
    let faces = (0_u32..).take(surface.faces().len());
    faces.map(|face| [0, 1, 2].map(|k| across(surface, face, k).unwrap_or(NO_FACE))).collect()
}

/// Returns the face across the `k`th edge of a face.
fn across(surface: &TriangleSurface, face: u32, k: usize) -> Option<u32> {
    let edge = surface.face_edges()[face as usize][k];
    if edge == NO_EDGE {
        return None;
    }
    let other = match *surface.edge_faces(edge) {
        [first, second] if first == face && second != face => second,
        [first, second] if second == face && first != face => first,
        _ => return None,
    };

    // The other face must run along the edge the opposite way.
    let corners = surface.faces()[face as usize];
    let (from, to) = (corners[k], corners[(k + 1) % 3]);
    let [a, b, c] = surface.faces()[other as usize];
    [[a, b], [b, c], [c, a]].contains(&[to, from]).then_some(other)
}
