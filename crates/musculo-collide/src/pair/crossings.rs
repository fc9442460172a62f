//! Faces of two surfaces that cross or touch, by exact predicates.

use kdop::Workspace;
use surface::{Meeting, triangles_meet};

use crate::shape::Shape;

/// Where two surfaces meet.
#[derive(Debug, Default)]
pub(super) struct Cut {
    /// Pairs of faces that share a point at least.
    pub(super) meeting: Vec<[u32; 2]>,
    /// Those that properly cross, ascending.
    pub(super) crossing: Vec<[u32; 2]>,
    /// Faces of `a` that share a point at least with `b`, ascending.
    pub(super) faces_of_a: Vec<u32>,
    /// Faces of `b` that share a point at least with `a`, ascending.
    pub(super) faces_of_b: Vec<u32>,
}

impl Cut {
    /// Finds where `a` and `b` meet, in place of what was found before.
    pub(super) fn find(&mut self, a: &Shape, b: &Shape, traversal: &mut Workspace) {
        let Self { meeting, crossing, faces_of_a, faces_of_b } = self;
        meeting.clear();
        crossing.clear();
        a.tree().pairs(b.tree(), 0.0, traversal, |fa, fb| {
            match triangles_meet(a.corners(fa), b.corners(fb)) {
                Meeting::Disjoint => return,
                Meeting::Touching => {}
                Meeting::Crossing => crossing.push([fa, fb]),
            }
            meeting.push([fa, fb]);
        });
        crossing.sort_unstable();
        for (faces, side) in [(faces_of_a, 0), (faces_of_b, 1)] {
            faces.clear();
            faces.extend(meeting.iter().map(|pair| pair[side]));
            faces.sort_unstable();
            faces.dedup();
        }
    }
}
