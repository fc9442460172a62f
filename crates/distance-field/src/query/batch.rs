//! Trilinear values at many points together.
//!
//! Point by point, the processor waits for each point's corners before it can begin the
//! next. Here every step is done for all points before the next step: locate, load corners,
//! interpolate. Loading is nothing but loads, which wait for memory together; the other
//! steps vectorize.

use glam::DVec3;

use super::Sample;
use super::interpolate::trilinear;
use crate::frame::Frame;
use crate::store::NodeArray;

/// Points that undergo the steps together: enough to hide the latency of memory, few enough
/// that their state (6 kB) stays in the first-level cache.
const LANES: usize = 32;

type Lanes = [f64; LANES];

/// State of some points between two steps, one list per quantity.
pub(super) struct TrilinearBatch<'a, T> {
    nodes: &'a NodeArray<T>,
    frame: &'a Frame,
    offset: f64,
    cell: [Lanes; 3],
    local: [Lanes; 3],
    /// Ends of each cell's edges along x.
    edges: [[[T; 2]; LANES]; 4],
    value: Lanes,
    gradient: [Lanes; 3],
}

impl<'a, T: Copy + Default + Into<f64>> TrilinearBatch<'a, T> {
    pub(super) fn new(nodes: &'a NodeArray<T>, frame: &'a Frame, offset: f64) -> Self {
        let (zero, zeros) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let edges = [[[T::default(); 2]; LANES]; 4];
        Self {
            nodes,
            frame,
            offset,
            cell: zeros,
            local: zeros,
            edges,
            value: zero,
            gradient: zeros,
        }
    }

    /// Computes distances, less the offset, and gradients at points of the world.
    pub(super) fn evaluate(
        &mut self,
        points: &[DVec3],
        distance: &mut [f64],
        gradient: &mut [DVec3],
    ) {
        let samples = distance.chunks_mut(LANES).zip(gradient.chunks_mut(LANES));
        for (points, (distance, gradient)) in points.chunks(LANES).zip(samples) {
            self.frame.locate_batch(points, &mut self.cell, &mut self.local);
            self.load();
            self.interpolate();
            self.finish(distance, gradient);
        }
    }

    /// Loads the corners of all cells.
    #[inline]
    fn load(&mut self) {
        let [x, y, z] = &self.cell;
        for lane in 0..LANES {
            let [low, high] = self.nodes.corners(DVec3::new(x[lane], y[lane], z[lane]));
            self.edges[0][lane] = [low[0], low[1]];
            self.edges[1][lane] = [low[2], low[3]];
            self.edges[2][lane] = [high[0], high[1]];
            self.edges[3][lane] = [high[2], high[3]];
        }
    }

    /// Interpolates between the corners.
    #[inline]
    fn interpolate(&mut self) {
        let Self { local: [x, y, z], edges: e, value, gradient: [dx, dy, dz], .. } = self;
        for lane in 0..LANES {
            let [[a, b], [c, d]] = [e[0][lane], e[1][lane]];
            let [[p, q], [r, s]] = [e[2][lane], e[3][lane]];
            let local = DVec3::new(x[lane], y[lane], z[lane]);
            let (between, slope) = trilinear([[a, b, c, d], [p, q, r, s]], local);
            value[lane] = between;
            (dx[lane], dy[lane], dz[lane]) = (slope.x, slope.y, slope.z);
        }
    }

    /// Converts steps to lengths, and NaN to infinity.
    #[inline]
    fn finish(&self, distance: &mut [f64], gradient: &mut [DVec3]) {
        let step = self.nodes.step();
        let [dx, dy, dz] = &self.gradient;
        for (lane, (distance, gradient)) in distance.iter_mut().zip(gradient).enumerate() {
            let value = self.value[lane];
            let slope = step * DVec3::new(dx[lane], dy[lane], dz[lane]);
            let inside = Sample {
                distance: value * step - self.offset,
                gradient: self.frame.gradient_to_world(slope),
            };
            let sample = if value.is_nan() { Sample::OUTSIDE } else { inside };
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }
}
