//! Path of an edge's image over the faces of a coarse surface.
//!
//! Between two faces of a path, a point of the edge is taken to a point of the coarse edge that
//! both faces share. The closest points of both edges are taken: their distance depends on
//! these two alone, so that the path with the smallest largest distance is found as shortest
//! paths are (Dijkstra), with the maximum in place of the sum.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use surface::{TotalF64, closest_between_segments};

use crate::mesh_point::MeshPoint;
use crate::surfaces::Coarse;

/// Point of an edge with its image on a coarse edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Position between the ends of the edge.
    pub(crate) s: f64,
    pub(crate) image: MeshPoint,
}

/// Step of a path into a face.
#[derive(Clone, Copy, Debug)]
struct Step {
    face: u32,
    /// Largest squared distance of a crossing up to here.
    max_squared: f64,
    /// Last crossing, and the step before it; none where a path begins.
    entry: Option<(Crossing, usize)>,
}

/// Search for paths, in memory that is reused.
pub(crate) struct EdgePaths<'a> {
    coarse: Coarse<'a>,
    /// Distance that no crossing may exceed.
    limit: f64,
    steps: Vec<Step>,
    /// Numbers of steps that are to be continued, by their largest distance.
    pending: BinaryHeap<Reverse<(TotalF64, usize)>>,
    /// Per coarse face, the stamp of the last search that entered it.
    entered: Vec<u32>,
    stamp: u32,
}

impl<'a> EdgePaths<'a> {
    pub(crate) fn new(coarse: Coarse<'a>, limit: f64) -> Self {
        Self {
            coarse,
            limit,
            steps: Vec::new(),
            pending: BinaryHeap::new(),
            entered: vec![0; coarse.surface.faces().len()],
            stamp: 0,
        }
    }

    /// Appends the crossings of an edge between the images of its ends to `out`, and returns
    /// their largest distance. `None` where all paths exceed the limit.
    pub(crate) fn find(
        &mut self,
        ends: [DVec3; 2],
        images: [MeshPoint; 2],
        out: &mut Vec<Crossing>,
    ) -> Option<f64> {
        if self.coarse.common_face(&images).is_some() {
            return Some(0.0);
        }

        // Start in every face that contains the first image.
        let (coarse, [from, to]) = (self.coarse, images);
        self.stamp += 1;
        self.steps.clear();
        self.pending.clear();
        for face in coarse.faces_with(from.carrier()) {
            self.push(Step { face, max_squared: 0.0, entry: None });
        }

        // Continue the path whose largest distance is the smallest: the first that arrives is
        // the best.
        while let Some(Reverse((_, number))) = self.pending.pop() {
            let step = self.steps[number];
            if coarse.has_corners(step.face, to.carrier()) {
                self.append_crossings(step, out);
                return Some(step.max_squared.sqrt());
            }
            if std::mem::replace(&mut self.entered[step.face as usize], self.stamp) != self.stamp {
                self.leave(step, number, ends);
            }
        }
        None
    }

    /// Adds the steps from a face across its edges.
    fn leave(&mut self, step: Step, number: usize, ends: [DVec3; 2]) {
        let Coarse { surface, x } = self.coarse;
        for edge in surface.face_edges()[step.face as usize] {
            for &face in surface.edge_faces(edge) {
                if self.entered[face as usize] == self.stamp {
                    continue;
                }

                // Faces that were entered before are on a path at least as good.
                let corners = surface.edges()[edge as usize];
                let found = closest_between_segments(ends, corners.map(|v| x[v as usize]));
                let [p, q] = found.points;
                let max_squared = p.distance_squared(q).max(step.max_squared);
                let image = MeshPoint::on_edge(corners, found.t);
                let entry = Some((Crossing { s: found.s, image }, number));
                self.push(Step { face, max_squared, entry });
            }
        }
    }

    /// Adds a step, unless it is too far.
    fn push(&mut self, step: Step) {
        if step.max_squared <= self.limit * self.limit {
            self.pending.push(Reverse((TotalF64(step.max_squared), self.steps.len())));
            self.steps.push(step);
        }
    }

    /// Appends the crossings up to a step, from the first to the last.
    fn append_crossings(&self, last: Step, out: &mut Vec<Crossing>) {
        let (first, mut step) = (out.len(), last);
        while let Some((crossing, before)) = step.entry {
            out.push(crossing);
            step = self.steps[before];
        }
        out[first..].reverse();
    }
}
