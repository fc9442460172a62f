//! Images of the vertices of a full surface on a coarse one.

use std::collections::BinaryHeap;

use surface::TotalF64;
use surface::progress::{Interrupted, Progress};

use crate::mesh_point::MeshPoint;
use crate::surfaces::{Coarse, Full, NearPoint};

/// Images of all vertices, in numbers of the coarse surface.
pub(crate) struct VertexImages {
    /// Per vertex, its image; any where no face uses the vertex.
    pub(crate) images: Vec<MeshPoint>,
    /// Largest distance of a vertex from its image.
    pub(crate) max_distance: f64,
    /// Vertices that are farther from their images than the limit.
    pub(crate) too_far: Vec<u32>,
}

/// Vertices between two polls for interruption: about a millisecond.
const POLL_INTERVAL: usize = 1024;

impl VertexImages {
    /// Finds near points for all vertices. Kept vertices are their own images.
    pub(crate) fn find(
        full: Full<'_>,
        coarse: Coarse<'_>,
        limit: f64,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        let mut numbers = vec![0; full.x.len()];
        for (number, &vertex) in (0..).zip(full.kept) {
            numbers[vertex as usize] = number;
        }

        // Walks begin at the vertices that the others have moved into.
        let (mut images, mut distances) = (Vec::with_capacity(full.x.len()), Vec::new());
        let steps = progress.steps(full.x.len());
        for (vertex, &into) in (0_u32..).zip(full.moved_into) {
            if (vertex as usize).is_multiple_of(POLL_INTERVAL) {
                steps.advance(POLL_INTERVAL)?;
            }

            let mut image = MeshPoint::vertex(numbers[into as usize]);
            if full.is_moved(vertex) {
                let near = coarse.descend(full.x[vertex as usize], numbers[into as usize]);
                distances.push((TotalF64(near.distance), vertex));
                image = near.image;
            }
            images.push(image);
        }

        // Some walks end at the foot of a fold.
        let mut found = Self { images, max_distance: 0.0, too_far: Vec::new() };
        found.bring_nearer(full, coarse, limit, distances.into());
        Ok(found)
    }

    /// Improves the farthest image until that is possible no more, for all beyond the limit.
    fn bring_nearer(
        &mut self,
        full: Full<'_>,
        coarse: Coarse<'_>,
        limit: f64,
        mut pending: BinaryHeap<(TotalF64, u32)>,
    ) {
        while let Some((TotalF64(distance), vertex)) = pending.pop() {
            let near = self.near_by_neighbors(vertex, full, coarse);
            if near.distance >= distance {
                self.max_distance = self.max_distance.max(distance);
                if distance <= limit {
                    return;
                }
                self.too_far.push(vertex);
                continue;
            }
            self.images[vertex as usize] = near.image;
            pending.push((TotalF64(near.distance), vertex));
        }
    }

    /// Finds the nearest end of a walk that begins at the image of a neighbor.
    fn near_by_neighbors(&self, vertex: u32, full: Full<'_>, coarse: Coarse<'_>) -> NearPoint {
        let p = full.x[vertex as usize];
        let mut nearest =
            NearPoint { image: self.images[vertex as usize], distance: f64::INFINITY };
        for &face in full.surface.vertex_faces(vertex) {
            for neighbor in full.surface.faces()[face as usize] {
                let near = coarse.descend(p, self.images[neighbor as usize].main_vertex());
                if near.distance < nearest.distance {
                    nearest = near;
                }
            }
        }
        nearest
    }

    /// Brings the images of two neighbors into one face: moves that of one to the nearest point
    /// of a face with the other's, if that is nearer than `distance`. Returns the one.
    pub(crate) fn join(
        &mut self,
        ends: [u32; 2],
        distance: f64,
        full: Full<'_>,
        coarse: Coarse<'_>,
    ) -> Option<u32> {
        // Either may move, but for kept vertices.
        let (mut min_distance, mut joined) = (distance, None);
        let [a, b] = ends;
        for (vertex, other) in [(a, b), (b, a)] {
            if !full.is_moved(vertex) {
                continue;
            }
            for face in coarse.faces_with(self.images[other as usize].carrier()) {
                let near = coarse.closest_on_face(full.x[vertex as usize], face);
                if near.distance < min_distance {
                    min_distance = near.distance;
                    joined = Some((vertex, near.image));
                }
            }
        }

        let (vertex, image) = joined?;
        self.images[vertex as usize] = image;
        Some(vertex)
    }
}
