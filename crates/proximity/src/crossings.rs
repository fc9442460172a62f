//! Faces of two surfaces that cross or touch, by exact predicates.

use kdop::Workspace;
use surface::progress::{Interrupted, Progress};
use surface::{Meeting, triangles_meet};

use crate::SurfaceTree;

/// Intersection of two surfaces, face by face.
#[derive(Debug, Default)]
pub(crate) struct Crossings {
    /// Number of pairs of faces whose bounds overlap.
    pub(crate) tested: usize,
    /// Pairs of faces that share at least one point.
    pub(crate) meeting: Vec<[u32; 2]>,
    /// Pairs of faces that properly cross, ascending.
    pub(crate) crossing: Vec<[u32; 2]>,
    /// Faces of `a` that share at least one point with `b`, ascending.
    pub(crate) cut_faces_of_a: Vec<u32>,
    /// Faces of `b` that share at least one point with `a`, ascending.
    pub(crate) cut_faces_of_b: Vec<u32>,
}

impl Crossings {
    /// Forgets all faces.
    pub(crate) fn clear(&mut self) {
        self.tested = 0;
        self.meeting.clear();
        self.crossing.clear();
        self.cut_faces_of_a.clear();
        self.cut_faces_of_b.clear();
    }

    /// Finds the faces of `a` and `b` that meet, in place of earlier ones.
    pub(crate) fn find(
        &mut self,
        a: &SurfaceTree,
        b: &SurfaceTree,
        workspace: &mut Workspace,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        /// Pairs of faces between two polls for interruption: a millisecond.
        const POLL_INTERVAL: u32 = 4096;

        self.clear();
        let Self { tested, meeting, crossing, cut_faces_of_a, cut_faces_of_b } = self;

        // The trees leave the faces whose bounds overlap; the predicate is exact.
        let mut polls = progress.every(POLL_INTERVAL);
        a.tree().try_pairs(b.tree(), 0.0, workspace, |face_a, face_b| {
            polls.step()?;
            *tested += 1;
            match triangles_meet(a.corners(face_a), b.corners(face_b)) {
                Meeting::Disjoint => return Ok(()),
                Meeting::Touching => {}
                Meeting::Crossing => crossing.push([face_a, face_b]),
            }
            meeting.push([face_a, face_b]);
            Ok(())
        })?;
        crossing.sort_unstable();

        // The faces of each surface, once each.
        for (faces, side) in [(cut_faces_of_a, 0), (cut_faces_of_b, 1)] {
            faces.extend(meeting.iter().map(|pair| pair[side]));
            faces.sort_unstable();
            faces.dedup();
        }
        Ok(())
    }
}
