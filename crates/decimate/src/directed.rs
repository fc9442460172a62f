//! Directed Hausdorff distance of triangles from a target surface, by branch and bound.
//!
//! The distance from one target face is convex, so on a patch it is largest at a corner; and
//! the distance from the target is no larger than that from the nearest face. Where no single
//! face is near all of a patch, the height of the faces that cover it bounds it. Patches whose
//! bound is not tight enough are split in four.

use glam::DVec3;
use kdop::Workspace;
use proximity::{MaximumSearch, SurfaceTree};
use surface::DirectedHausdorff;
use surface::progress::{Interrupted, Progress};

use crate::cover::Cover;
use crate::target::Target;

/// Accuracy of a distance, and the work that it may take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accuracy {
    /// A bound no more than this above the largest evaluated distance is tight enough.
    pub(crate) min_slack: f64,
    /// Splits before the search ends with the bound that it has.
    pub(crate) max_splits: usize,
}

/// Splits between two reports of progress: about ten milliseconds of work.
const REPORT_EVERY: usize = 512;

/// Bounds the largest distance of a point of `from` to the target.
///
/// `near` has a target face per vertex of `from`: the nearer, the faster.
pub(crate) fn directed_distance(
    from: &SurfaceTree,
    target: Target<'_>,
    near: &[u32],
    accuracy: Accuracy,
    progress: Progress<'_>,
) -> Result<DirectedHausdorff, Interrupted> {
    let mut search = Search {
        target,
        pieces: MaximumSearch::new(accuracy.min_slack, f64::INFINITY),
        cover: Cover::new(target.adjacent.len()),
        workspace: Workspace::default(),
    };

    // Every face of `from` is a patch at first.
    for (face, vertices) in (0..).zip(from.surface().faces()) {
        let (corners, near) = (from.corners(face), vertices.map(|v| near[v as usize]));
        search.add(Patch { corners, near, is_covered: false }, f64::INFINITY);
    }
    search.run(accuracy, progress)
}

/// Triangle whose distance is to be bounded.
#[derive(Clone, Copy, Debug)]
struct Patch {
    corners: [DVec3; 3],
    /// Per corner, a target face that may be near.
    near: [u32; 3],
    /// True if its bound takes the faces that cover it into account.
    is_covered: bool,
}

impl Patch {
    /// Computes the smallest, over its target faces, of the largest distance at a corner.
    fn bound(&self, target: &Target<'_>) -> f64 {
        let mut bound = f64::INFINITY;
        for (k, &face) in self.near.iter().enumerate() {
            if self.near[..k].contains(&face) {
                continue;
            }
            let [a, b, c] = self.corners.map(|corner| target.distance(corner, face));
            bound = bound.min(a.max(b).max(c));
        }
        bound
    }
}

/// Point with the target face that is nearest to it.
#[derive(Clone, Copy, Debug)]
struct Located {
    point: DVec3,
    face: u32,
}

/// Search state.
struct Search<'a> {
    target: Target<'a>,
    pieces: MaximumSearch<Patch>,
    cover: Cover,
    workspace: Workspace,
}

impl Search<'_> {
    /// Covers or splits the patch with the largest bound until the bounds are tight enough.
    fn run(
        mut self,
        accuracy: Accuracy,
        progress: Progress<'_>,
    ) -> Result<DirectedHausdorff, Interrupted> {
        let steps = progress.steps(accuracy.max_splits);
        let mut splits = 0;
        while splits < accuracy.max_splits
            && let Some((bound, patch)) = self.pieces.next()
        {
            if patch.is_covered {
                self.split(&patch, bound);
                splits += 1;
                if splits.is_multiple_of(REPORT_EVERY) {
                    steps.advance(REPORT_EVERY)?;
                }
            } else {
                self.cover(patch, bound);
            }
        }
        Ok(self.pieces.bounds())
    }

    /// Adds a patch with no distance above `bound`.
    fn add(&mut self, patch: Patch, bound: f64) {
        let bound = bound.min(patch.bound(&self.target));
        self.pieces.add(bound, patch);
    }

    /// Bounds a patch by faces that cover it: around its corners, or over its center.
    fn cover(&mut self, patch: Patch, bound: f64) {
        // The faces over the center are searched for where those at the corners leave gaps.
        let target = self.target;
        let mut height = self.cover.height(&target, patch.corners, patch.near, bound);
        if height.is_none() {
            let [a, b, c] = patch.corners;
            let over = self.locate((a + b + c) / 3.0, patch.near[0]).face;
            height = self.cover.height(&target, patch.corners, [over; 3], bound);
        }
        self.pieces.add(height.unwrap_or(bound), Patch { is_covered: true, ..patch });
    }

    /// Splits a patch in four at the midpoints of its edges.
    fn split(&mut self, patch: &Patch, bound: f64) {
        // Every corner gets its nearest face, since a covered patch may have had others.
        let [a, b, c] = [0, 1, 2].map(|k| self.locate(patch.corners[k], patch.near[k]));
        let ab = self.locate(a.point.midpoint(b.point), a.face);
        let bc = self.locate(b.point.midpoint(c.point), b.face);
        let ca = self.locate(c.point.midpoint(a.point), c.face);

        for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let (corners, near) = (quarter.map(|c| c.point), quarter.map(|c| c.face));
            self.add(Patch { corners, near, is_covered: false }, bound);
        }
    }

    /// Finds the nearest face of a point, and records its distance.
    fn locate(&mut self, point: DVec3, hint: u32) -> Located {
        let (face, distance) = self.target.nearest(point, hint, &mut self.workspace);
        self.pieces.evaluated(distance);
        Located { point, face }
    }
}
