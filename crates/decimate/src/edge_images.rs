//! Images of the edges of a full surface on a coarse one.

use surface::progress::{Interrupted, Progress};

use crate::edge_path::{Crossing, EdgePaths};
use crate::surfaces::{Coarse, Full};
use crate::vertex_images::VertexImages;

/// Crossings of all edges.
#[derive(Default)]
pub(crate) struct EdgeImages {
    crossings: Vec<Crossing>,
    /// Per edge, the end of its crossings in the list.
    ends: Vec<usize>,
}

/// Edges between two polls for interruption: about a millisecond.
const POLL_INTERVAL: usize = 1024;

impl EdgeImages {
    /// Finds paths for all edges. Moves images of vertices where that brings an edge nearer.
    ///
    /// An edge whose paths all exceed `limit` gets no crossings; its faces can then not be
    /// mapped.
    pub(crate) fn find(
        full: Full<'_>,
        coarse: Coarse<'_>,
        vertices: &mut VertexImages,
        limit: f64,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        let mut found = Self::default();
        let mut paths = EdgePaths::new(coarse, limit);
        let mut is_moved = vec![false; full.x.len()];
        let steps = progress.steps(full.surface.edges().len());
        for (number, &ends) in full.surface.edges().iter().enumerate() {
            if number.is_multiple_of(POLL_INTERVAL) {
                steps.advance(POLL_INTERVAL)?;
            }

            // Over a ridge an edge may be farther than its ends, which need not be on both
            // sides of it.
            let distance = found.push(full, vertices, ends, &mut paths);
            if distance > vertices.max_distance
                && let Some(vertex) = vertices.join(ends, distance.min(limit), full, coarse)
            {
                is_moved[vertex as usize] = true;
            }
        }

        // Paths from moved images are found anew, once: a second round brought next to nothing.
        Ok(if is_moved.contains(&true) {
            found.updated(full, vertices, &is_moved, &mut paths)
        } else {
            found
        })
    }

    /// Returns the crossings of an edge, from its first end to its second.
    pub(crate) fn crossings(&self, edge: usize) -> &[Crossing] {
        let start = if edge > 0 { self.ends[edge - 1] } else { 0 };
        &self.crossings[start..self.ends[edge]]
    }

    /// Adds the next edge, and returns the largest distance of its crossings.
    fn push(
        &mut self,
        full: Full<'_>,
        vertices: &VertexImages,
        ends: [u32; 2],
        paths: &mut EdgePaths<'_>,
    ) -> f64 {
        let images = ends.map(|vertex| vertices.images[vertex as usize]);
        let positions = ends.map(|vertex| full.x[vertex as usize]);
        let distance = paths.find(positions, images, &mut self.crossings);
        self.ends.push(self.crossings.len());
        distance.unwrap_or(f64::INFINITY)
    }

    /// Returns the same with new paths for edges whose ends have other images now.
    fn updated(
        &self,
        full: Full<'_>,
        vertices: &VertexImages,
        is_moved: &[bool],
        paths: &mut EdgePaths<'_>,
    ) -> Self {
        // Most paths are copied.
        let mut updated = Self::default();
        for (number, &ends) in full.surface.edges().iter().enumerate() {
            if ends.iter().any(|&vertex| is_moved[vertex as usize]) {
                updated.push(full, vertices, ends, paths);
            } else {
                updated.crossings.extend_from_slice(self.crossings(number));
                updated.ends.push(updated.crossings.len());
            }
        }
        updated
    }
}
