//! Sampling of node values in either number format.

use glam::DVec3;
use surface::parallel;

use super::batch::TrilinearBatch;
use super::interpolate::{Block, cubic, outer_weight, smooth, trilinear};
use super::{Interpolation, QueryParams, Sample, SampleBatch};
use crate::DistanceField;
use crate::frame::{Frame, Location};
use crate::num::whole_index;
use crate::store::NodeArray;

/// Points per task of a parallel batch; fewer are not worth a task.
const TASK: usize = 4096;

/// Node values of a field, with the parameters of a query.
pub(super) struct Sampler<'a, T> {
    nodes: &'a NodeArray<T>,
    dims: [usize; 3],
    frame: &'a Frame,
    params: &'a QueryParams,
    /// Weight of the outer neighbors in the cubic.
    outer_weight: f64,
}

/// Points of a task, with the place of their samples.
struct Task<'a> {
    points: &'a [DVec3],
    distance: &'a mut [f64],
    gradient: &'a mut [DVec3],
}

impl<'a, T: Copy + Default + Into<f64> + Sync> Sampler<'a, T> {
    /// `frame` is that of the grid in the pose of the query.
    #[inline]
    pub(super) fn new(
        field: &DistanceField,
        nodes: &'a NodeArray<T>,
        frame: &'a Frame,
        params: &'a QueryParams,
    ) -> Self {
        let outer_weight = outer_weight(field.node_values());
        Self { nodes, dims: field.grid().dims(), frame, params, outer_weight }
    }

    /// Evaluates one point; `None` outside the grid.
    #[inline]
    pub(super) fn sample(&self, p: DVec3) -> Option<Sample> {
        let Location { cell, local } = self.frame.locate(p)?;
        let (value, gradient) = match self.params.interpolation {
            Interpolation::Trilinear => trilinear(self.nodes.corners(cell), local),
            Interpolation::Smooth => smooth(&self.block(cell), local),
            Interpolation::Cubic => cubic(&self.block(cell), local, self.outer_weight),
        };
        let step = self.nodes.step();
        let gradient = self.frame.gradient_to_world(step * gradient);
        Some(Sample { distance: value * step - self.params.offset, gradient })
    }

    /// Evaluates many points, with the same bits as one by one.
    pub(super) fn batch(&self, points: &[DVec3], out: &mut SampleBatch) {
        out.distance.resize(points.len(), 0.0);
        out.gradient.resize(points.len(), DVec3::ZERO);
        if points.len() <= TASK {
            self.run(Task { points, distance: &mut out.distance, gradient: &mut out.gradient });
            return;
        }

        let samples = out.distance.chunks_mut(TASK).zip(out.gradient.chunks_mut(TASK));
        let tasks = points.chunks(TASK).zip(samples);
        let tasks = tasks.map(|(points, (distance, gradient))| Task { points, distance, gradient });
        parallel::for_each(tasks.collect(), |_, task| self.run(task));
    }

    fn run(&self, task: Task<'_>) {
        let Task { points, distance, gradient } = task;
        if self.params.interpolation == Interpolation::Trilinear {
            let mut batch = TrilinearBatch::new(self.nodes, self.frame, self.params.offset);
            batch.evaluate(points, distance, gradient);
            return;
        }
        for ((&p, distance), gradient) in points.iter().zip(distance).zip(gradient) {
            let sample = self.sample(p).unwrap_or(Sample::OUTSIDE);
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }

    /// Returns the nodes around a cell. Beyond the border, the last two nodes are
    /// extrapolated linearly.
    fn block(&self, cell: DVec3) -> Block {
        let [i, j, k] = cell.to_array().map(whole_index);
        let [nx, ny, nz] = self.dims;
        let is_inner = |n: usize, count: usize| n > 0 && n + 2 < count;
        let is_interior = is_inner(i, nx) && is_inner(j, ny) && is_inner(k, nz);

        // Extrapolated nodes are numbered one higher, so that −1 can be written.
        let mut block = [[[0.0; 4]; 4]; 4];
        for (c, plane) in block.iter_mut().enumerate() {
            for (b, row) in plane.iter_mut().enumerate() {
                if is_interior {
                    *row = self.nodes.row_of_four([i - 1, j + b - 1, k + c - 1]).map(Into::into);
                } else {
                    *row = [0, 1, 2, 3].map(|a| self.extrapolated([i + a, j + b, k + c]));
                }
            }
        }
        block
    }

    /// Returns the value of the node `shifted − 1`, which may be one beyond the border.
    fn extrapolated(&self, shifted: [usize; 3]) -> f64 {
        let beyond = (0..3).find(|&axis| shifted[axis] == 0 || shifted[axis] > self.dims[axis]);
        let Some(axis) = beyond else {
            return self.nodes.node(shifted.map(|n| n - 1)).into();
        };
        let inward = |steps: usize| {
            let mut inner = shifted;
            inner[axis] = if shifted[axis] == 0 { steps } else { shifted[axis] - steps };
            self.extrapolated(inner)
        };
        2.0 * inward(1) - inward(2)
    }
}
