//! Sampling of node values in either number format.

use glam::DVec3;
use surface::parallel;

use super::batch::{self, Task};
use super::interpolate::{cubic, outer_weight, smooth, trilinear};
use super::{Interpolation, QueryParams, Sample, SampleBatch};
use crate::DistanceField;
use crate::frame::{Frame, Location};
use crate::num::whole_index;
use crate::store::{Block, NodeArray};

/// Points per task of a parallel batch; fewer are not worth a task.
const TASK: usize = 4096;

/// Node values of a field, with the parameters of a query.
pub(super) struct Sampler<'a, T> {
    pub(super) field: &'a DistanceField,
    pub(super) nodes: &'a NodeArray<T>,
    /// Frame of the grid in the pose of the query.
    pub(super) frame: &'a Frame,
    pub(super) params: &'a QueryParams,
}

impl<T: Copy + Default + Into<f64> + Sync> Sampler<'_, T> {
    /// Evaluates one point; `None` outside the grid.
    #[inline]
    pub(super) fn sample(&self, p: DVec3) -> Option<Sample> {
        let Location { cell, local } = self.frame.locate(p)?;
        let (value, gradient) = match self.params.interpolation {
            Interpolation::Trilinear => trilinear(self.nodes.corners(cell), local),
            Interpolation::Smooth => smooth(&self.block(cell), local),
            Interpolation::Cubic => {
                cubic(&self.block(cell), local, outer_weight(self.field.node_values()))
            }
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

        let mut tasks = Vec::with_capacity(points.len().div_ceil(TASK));
        let samples = out.distance.chunks_mut(TASK).zip(out.gradient.chunks_mut(TASK));
        for (points, (distance, gradient)) in points.chunks(TASK).zip(samples) {
            tasks.push(Task { points, distance, gradient });
        }
        parallel::for_each(tasks, |_, task| self.run(task));
    }

    fn run(&self, task: Task<'_>) {
        if self.params.interpolation == Interpolation::Trilinear {
            batch::evaluate(self.nodes, self.frame, self.params.offset, task);
            return;
        }
        let Task { points, distance, gradient } = task;
        for ((&p, distance), gradient) in points.iter().zip(distance).zip(gradient) {
            let sample = self.sample(p).unwrap_or(Sample::OUTSIDE);
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }

    /// Returns the nodes around a cell. Beyond the border, the last two nodes are
    /// extrapolated linearly.
    fn block(&self, cell: DVec3) -> Block {
        let [i, j, k] = cell.to_array().map(whole_index);
        let [nx, ny, nz] = self.field.grid.dims();
        if is_inner(i, nx) && is_inner(j, ny) && is_inner(k, nz) {
            return self.nodes.block([i - 1, j - 1, k - 1]);
        }

        // Extrapolated nodes are numbered one higher, so that −1 can be written.
        let mut block = [[[0.0; 4]; 4]; 4];
        for (c, plane) in block.iter_mut().enumerate() {
            for (b, row) in plane.iter_mut().enumerate() {
                for (a, node) in row.iter_mut().enumerate() {
                    *node = self.extrapolated([i + a, j + b, k + c]);
                }
            }
        }
        block
    }

    /// Returns the value of the node `shifted − 1`, which may be one beyond the border.
    fn extrapolated(&self, shifted: [usize; 3]) -> f64 {
        let dims = self.field.grid.dims();
        for axis in 0..3 {
            let [mut first, mut second] = [shifted; 2];
            if shifted[axis] == 0 {
                (first[axis], second[axis]) = (1, 2);
            } else if shifted[axis] > dims[axis] {
                (first[axis], second[axis]) = (shifted[axis] - 1, shifted[axis] - 2);
            } else {
                continue;
            }
            return 2.0 * self.extrapolated(first) - self.extrapolated(second);
        }
        self.nodes.node(shifted.map(|n| n - 1)).into()
    }
}

/// Returns true if a cell has a node beyond its own on both sides along an axis.
fn is_inner(node: usize, count: usize) -> bool {
    node > 0 && node + 2 < count
}
