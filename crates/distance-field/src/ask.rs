//! Answers to a query, whatever the field is stored as.

use glam::DVec3;

use crate::field::DistanceField;
use crate::frame::{Frame, Located};
use crate::interpolate::{Block, cubic, outer_weight, smooth, trilinear};
use crate::lanes::trilinear_all;
use crate::num::whole_index;
use crate::par;
use crate::query::{Interpolation, QueryParams, Sample, SampleBatch};
use crate::store::Nodes;

/// Points that one thread takes at a time; fewer are not worth sharing out.
const BATCH: usize = 4096;

/// A query of one field.
pub(crate) struct Asked<'a, N> {
    nodes: &'a N,
    dims: [usize; 3],
    /// Of the cubic.
    outer: f64,
    frame: &'a Frame,
    query: &'a QueryParams,
}

impl<'a, N: Nodes> Asked<'a, N> {
    /// `frame` is that of the grid in the pose of the query.
    #[inline]
    pub(crate) fn new(
        nodes: &'a N,
        field: &DistanceField,
        frame: &'a Frame,
        query: &'a QueryParams,
    ) -> Self {
        let outer = outer_weight(field.node_values());
        Self { nodes, dims: field.grid().dims(), outer, frame, query }
    }

    /// The answer at one point; none outside the grid.
    #[inline]
    pub(crate) fn at(&self, p: DVec3) -> Option<Sample> {
        let Located { cell, place } = self.frame.locate(p)?;
        let (value, slope) = match self.query.interpolation {
            Interpolation::Trilinear => {
                let [low, high] = self.nodes.cell(cell);
                trilinear(low, high, place)
            }
            Interpolation::Smooth => smooth(&self.block(cell), place),
            Interpolation::Cubic => cubic(&self.block(cell), place, self.outer),
        };
        let step = self.nodes.step();
        let gradient = self.frame.slope_to_world(step * slope);
        Some(Sample { distance: value * step - self.query.offset, gradient })
    }

    /// The answers at many points; to the bit those at each.
    pub(crate) fn all(&self, points: &[DVec3], out: &mut SampleBatch) {
        out.distance.resize(points.len(), 0.0);
        out.gradient.resize(points.len(), DVec3::ZERO);
        if points.len() <= BATCH {
            self.batch(points, &mut out.distance, &mut out.gradient);
            return;
        }
        let parts = points
            .chunks(BATCH)
            .zip(out.distance.chunks_mut(BATCH))
            .zip(out.gradient.chunks_mut(BATCH));
        par::for_each(parts.collect(), |_, ((points, distance), gradient)| {
            self.batch(points, distance, gradient);
        });
    }

    fn batch(&self, points: &[DVec3], distance: &mut [f64], gradient: &mut [DVec3]) {
        if self.query.interpolation == Interpolation::Trilinear {
            let Self { nodes, frame, query, .. } = self;
            trilinear_all(*nodes, frame, query.offset, points, (distance, gradient));
            return;
        }
        for ((&p, distance), gradient) in points.iter().zip(distance).zip(gradient) {
            let sample = self.at(p).unwrap_or(Sample::OUTSIDE);
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }

    /// The nodes around a cell; beyond the border the last two nodes are continued
    /// in a straight line.
    fn block(&self, cell: DVec3) -> Block {
        let [i, j, k] = cell.to_array().map(whole_index);
        let [nx, ny, nz] = self.dims;
        let is_interior = |n: usize, count: usize| n > 0 && n + 2 < count;
        if is_interior(i, nx) && is_interior(j, ny) && is_interior(k, nz) {
            let mut block = [[[0.0; 4]; 4]; 4];
            for (c, plane) in block.iter_mut().enumerate() {
                for (b, row) in plane.iter_mut().enumerate() {
                    let [p, q, r, s] = self.nodes.four([i - 1, j + b - 1, k + c - 1]);
                    *row = [p.into(), q.into(), r.into(), s.into()];
                }
            }
            return block;
        }
        // One more than the node, so that −1 can be written.
        std::array::from_fn(|c| {
            std::array::from_fn(|b| std::array::from_fn(|a| self.continued([i + a, j + b, k + c])))
        })
    }

    /// Value of the node `shifted − 1`, which may be one beyond the border.
    fn continued(&self, shifted: [usize; 3]) -> f64 {
        let beyond = (0..3).find(|&axis| shifted[axis] == 0 || shifted[axis] > self.dims[axis]);
        let Some(axis) = beyond else {
            return self.nodes.node(shifted.map(|n| n - 1)).into();
        };
        let step = |by: usize| {
            let mut inner = shifted;
            inner[axis] = if shifted[axis] == 0 { by } else { shifted[axis] - by };
            self.continued(inner)
        };
        2.0 * step(1) - step(2)
    }
}
