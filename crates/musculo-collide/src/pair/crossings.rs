//! Faces of two surfaces that cross or touch, by exact predicates.

use kdop::Workspace;
use surface::{Meeting, triangles_meet};

use crate::shape::Shape;

/// Where two surfaces meet.
#[derive(Debug, Default)]
pub(super) struct Cut {
    /// Pairs of faces that properly cross, ascending.
    pub(super) crossing: Vec<[u32; 2]>,
    /// Faces of `a` that share a point at least with `b`, ascending.
    pub(super) faces_of_a: Vec<u32>,
    /// Faces of `b` that share a point at least with `a`, ascending.
    pub(super) faces_of_b: Vec<u32>,
}

impl Cut {
    /// Finds where `a` and `b` meet, in place of what was found before.
    pub(super) fn find(&mut self, a: &Shape, b: &Shape, traversal: &mut Workspace) {
        let Self { crossing, faces_of_a, faces_of_b } = self;
        crossing.clear();
        faces_of_a.clear();
        faces_of_b.clear();
        a.tree().pairs(b.tree(), 0.0, traversal, |fa, fb| {
            match triangles_meet(a.corners(fa), b.corners(fb)) {
                Meeting::Disjoint => return,
                Meeting::Touching => {}
                Meeting::Crossing => crossing.push([fa, fb]),
            }
            faces_of_a.push(fa);
            faces_of_b.push(fb);
        });
        crossing.sort_unstable();
        for faces in [faces_of_a, faces_of_b] {
            faces.sort_unstable();
            faces.dedup();
        }
    }
}
