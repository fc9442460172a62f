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

/// Points, with the place of their samples.
pub(super) struct Task<'a> {
    pub(super) points: &'a [DVec3],
    pub(super) distance: &'a mut [f64],
    pub(super) gradient: &'a mut [DVec3],
}

/// Computes trilinear distances, less `offset`, and their gradients at points of the world.
pub(super) fn evaluate<T: Copy + Default + Into<f64>>(
    nodes: &NodeArray<T>,
    frame: &Frame,
    offset: f64,
    Task { points, distance, gradient }: Task<'_>,
) {
    let mut batch = Batch::<T>::default();
    let samples = distance.chunks_mut(LANES).zip(gradient.chunks_mut(LANES));
    for (points, (distance, gradient)) in points.chunks(LANES).zip(samples) {
        // All lanes undergo all steps; of those beyond the last point nothing is written.
        frame.locate_batch(points, &mut batch.cell, &mut batch.local);
        batch.load(nodes);
        batch.interpolate();
        batch.finish(frame, nodes.step(), offset, distance, gradient);
    }
}

/// State of some points between two steps, one list per quantity.
#[derive(Default)]
struct Batch<T> {
    cell: [Lanes; 3],
    local: [Lanes; 3],
    /// Ends of each cell's edges along x.
    edges: [[[T; 2]; LANES]; 4],
    value: Lanes,
    gradient: [Lanes; 3],
}

impl<T: Copy + Into<f64>> Batch<T> {
    /// Loads the corners of all cells.
    #[inline]
    fn load(&mut self, nodes: &NodeArray<T>) {
        let [x, y, z] = &self.cell;
        for lane in 0..LANES {
            let [low, high] = nodes.corners(DVec3::new(x[lane], y[lane], z[lane]));
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
    ///
    /// The frame is an argument rather than a field: writes to the samples cannot change it
    /// then, so that the compiler does not load it again for every point.
    #[inline]
    fn finish(
        &self,
        frame: &Frame,
        step: f64,
        offset: f64,
        distance: &mut [f64],
        gradient: &mut [DVec3],
    ) {
        let [dx, dy, dz] = &self.gradient;
        for (lane, (distance, gradient)) in distance.iter_mut().zip(gradient).enumerate() {
            let value = self.value[lane];
            let slope = step * DVec3::new(dx[lane], dy[lane], dz[lane]);
            let inside = Sample {
                distance: value * step - offset,
                gradient: frame.gradient_to_world(slope),
            };
            let sample = if value.is_nan() { Sample::OUTSIDE } else { inside };
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }
}
