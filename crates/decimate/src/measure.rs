//! Deviation of a collapsed surface from the full one.
//!
//! The collapses provide the hints of the search: a vertex that has moved is near the faces
//! around the vertex that it has moved into, or around a neighbor of that one; and many faces
//! of the coarser surface are unchanged.

use std::sync::Arc;

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, SurfaceTree};
use surface::progress::{Interrupted, Progress};
use surface::{DirectedHausdorff, HausdorffBounds, TriangleSurface};

use crate::DecimateError;
use crate::collapsed::Collapsed;
use crate::directed::{Accuracy, directed_distance};
use crate::target::{Target, adjacent_faces};

/// A full surface and a collapsed one.
pub(crate) struct Measure<'a> {
    full: Target<'a>,
    /// Per face of the collapsed surface, its number in the full surface.
    sources: Vec<u32>,
    reduced: SurfaceTree,
    /// [Adjacent faces](adjacent_faces) of the collapsed surface.
    adjacent: Vec<[u32; 3]>,
    /// Per vertex of the full surface, a point of the collapsed one that is near; `None`
    /// where no face uses the vertex.
    near: Vec<Option<ClosestPoint>>,
}

/// Vertices between two polls for interruption: some milliseconds.
const POLL_INTERVAL: usize = 1024;

impl<'a> Measure<'a> {
    pub(crate) fn new(full: Target<'a>, collapsed: Collapsed) -> Result<Self, DecimateError> {
        let Collapsed { moved_into, kept, faces, sources } = collapsed;
        let x = kept.iter().map(|&vertex| full.tree.position(vertex)).collect();
        let reduced = SurfaceTree::new(TriangleSurface::new(kept.len(), faces)?, x)?;
        let adjacent = adjacent_faces(reduced.surface());
        let near = near_vertices(full.tree, &reduced, &moved_into, &kept);
        Ok(Self { full, sources, reduced, adjacent, near })
    }

    /// Returns the collapsed surface.
    pub(crate) fn surface(&self) -> Arc<TriangleSurface> {
        self.reduced.shared_surface()
    }

    /// Computes the largest distance of a vertex of the full surface from the collapsed one.
    pub(crate) fn max_vertex_distance(&self, progress: Progress<'_>) -> Result<f64, Interrupted> {
        let (target, mut workspace) = (self.target(), Workspace::default());
        let mut max_distance = 0.0;
        let x = self.full.tree.positions().as_slice();
        for (number, (&p, near)) in x.iter().zip(&self.near).enumerate() {
            if number.is_multiple_of(POLL_INTERVAL) {
                progress.report(0.0)?;
            }
            // The distance of the near point is an upper bound.
            if let Some(near) = near
                && near.distance > max_distance
            {
                let (_, distance) = target.nearest(p, near.face, &mut workspace);
                max_distance = distance.max(max_distance);
            }
        }
        Ok(max_distance)
    }

    /// Bounds the deviation; from above by infinity where it exceeds the accuracy's limit.
    pub(crate) fn deviation(
        &self,
        accuracy: Accuracy,
        progress: Progress<'_>,
    ) -> Result<HausdorffBounds, Interrupted> {
        // A face of the full surface is near the points that are near its corners.
        let faces = self.full.tree.surface().faces();
        let hints = |face: u32| faces[face as usize].map(|vertex| self.near_face(vertex));
        let part = progress.part(0.0, 0.5);
        let forward = directed_distance(self.full.tree, self.target(), hints, accuracy, part)?;
        if forward.upper > accuracy.limit {
            let backward = DirectedHausdorff { lower: 0.0, upper: f64::INFINITY };
            return Ok(HausdorffBounds { forward, backward });
        }

        // A face of the collapsed surface is near the one that it was.
        let hints = |face: u32| [self.sources[face as usize]; 3];
        let part = progress.part(0.5, 1.0);
        let backward = directed_distance(&self.reduced, self.full, hints, accuracy, part)?;
        Ok(HausdorffBounds { forward, backward })
    }

    /// Returns a face of the collapsed surface near a vertex of the full one.
    fn near_face(&self, vertex: u32) -> u32 {
        self.near[vertex as usize].map_or(0, |near| near.face)
    }

    /// Returns the collapsed surface as the target of distances.
    fn target(&self) -> Target<'_> {
        Target { tree: &self.reduced, adjacent: &self.adjacent }
    }
}

/// Finds a near point of the collapsed surface for each vertex of the full one.
fn near_vertices(
    full: &SurfaceTree,
    reduced: &SurfaceTree,
    moved_into: &[u32],
    kept: &[u32],
) -> Vec<Option<ClosestPoint>> {
    let mut numbers = vec![None; moved_into.len()];
    for (number, &vertex) in (0_u32..).zip(kept) {
        numbers[vertex as usize] = Some(number);
    }

    let mut near = Vec::with_capacity(moved_into.len());
    for (&p, &into) in full.positions().as_slice().iter().zip(moved_into) {
        let start = numbers[into as usize];
        near.push(start.and_then(|start| descend(reduced, p, start)));
    }
    near
}

/// Walks from a vertex to the nearest face around it, then around that face's nearest corner,
/// while the distance decreases.
fn descend(reduced: &SurfaceTree, p: DVec3, start: u32) -> Option<ClosestPoint> {
    let mut vertex = start;
    let mut best: Option<ClosestPoint> = None;
    loop {
        let before = best.map_or(f64::INFINITY, |best| best.distance);
        for &face in reduced.surface().vertex_faces(vertex) {
            let found = reduced.closest_on_face(p, face);
            if best.is_none_or(|best| found.distance < best.distance) {
                best = Some(found);
            }
        }

        let ClosestPoint { face, foot, distance } = best?;
        let corner = reduced.surface().faces()[face as usize][largest(foot.barycentric)];
        if corner == vertex || distance >= before || distance <= 0.0 {
            return best;
        }
        vertex = corner;
    }
}

/// Returns the index of the largest weight, the first of equals.
fn largest([x, y, z]: [f64; 3]) -> usize {
    match (x >= y && x >= z, y >= z) {
        (true, _) => 0,
        (false, true) => 1,
        (false, false) => 2,
    }
}
