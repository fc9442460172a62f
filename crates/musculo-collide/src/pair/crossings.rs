//! Faces of two surfaces that cross or touch, by exact predicates.

use surface::{Meeting, triangles_meet};

use super::Scratch;
use crate::scene::Body;

/// Where two surfaces meet.
pub(super) struct Cut {
    /// Pairs of faces that properly cross, ascending.
    pub(super) crossing: Vec<[u32; 2]>,
    /// Faces of `a` that share a point at least with `b`, ascending.
    pub(super) faces_of_a: Vec<u32>,
    /// Faces of `b` that share a point at least with `a`, ascending.
    pub(super) faces_of_b: Vec<u32>,
}

pub(super) fn find(a: &Body, b: &Body, scratch: &mut Scratch) -> Cut {
    let mut cut = Cut { crossing: Vec::new(), faces_of_a: Vec::new(), faces_of_b: Vec::new() };
    a.tree().pairs(b.tree(), 0.0, &mut scratch.traversal, |fa, fb| {
        match triangles_meet(a.corners(fa), b.corners(fb)) {
            Meeting::Disjoint => return,
            Meeting::Touching => {}
            Meeting::Crossing => cut.crossing.push([fa, fb]),
        }
        cut.faces_of_a.push(fa);
        cut.faces_of_b.push(fb);
    });
    cut.crossing.sort_unstable();
    for faces in [&mut cut.faces_of_a, &mut cut.faces_of_b] {
        faces.sort_unstable();
        faces.dedup();
    }
    cut
}
