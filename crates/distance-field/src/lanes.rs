//! Trilinear values and gradients at many points, step by step for some dozens
//! of points together.
//!
//! Point after point, the processor waits for each point's corners before it
//! gets far with the next. Here a step is done for all points before the next
//! begins: where they are, then what is at their corners, then what lies between.
//! The second step is nothing but loads, which wait for memory together, and the
//! others work on vectors.

use glam::DVec3;

use crate::frame::Frame;
use crate::interpolate::trilinear;
use crate::query::Sample;
use crate::store::Nodes;

/// Points that go through the steps together: enough to hide what the memory
/// takes, few enough that all they need stays in the nearest cache (6 kB).
const LANES: usize = 32;

type Lanes = [f64; LANES];

/// What some points have between two steps, each list one number a point.
struct Work<T> {
    cell: [Lanes; 3],
    place: [Lanes; 3],
    /// The two ends of each cell's edges along x.
    edges: [[[T; 2]; LANES]; 4],
    value: Lanes,
    slope: [Lanes; 3],
}

/// Distances, less `offset`, and gradients at `points`; infinite and zero
/// outside the grid.
pub(crate) fn trilinear_all<N: Nodes>(
    nodes: &N,
    frame: &Frame,
    offset: f64,
    points: &[DVec3],
    (distance, gradient): (&mut [f64], &mut [DVec3]),
) {
    let mut work = Work::<N::Value>::new();
    let parts =
        points.chunks(LANES).zip(distance.chunks_mut(LANES)).zip(gradient.chunks_mut(LANES));
    for ((points, distance), gradient) in parts {
        frame.locate_all(points, &mut work.cell, &mut work.place);
        work.load(nodes);
        work.interpolate();
        work.finish(frame, nodes.step(), offset, (distance, gradient));
    }
}

impl<T: Copy + Default + Into<f64>> Work<T> {
    fn new() -> Self {
        let (none, zero) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let edges = [[[T::default(); 2]; LANES]; 4];
        Self { cell: zero, place: zero, edges, value: none, slope: zero }
    }

    #[inline]
    fn load(&mut self, nodes: &impl Nodes<Value = T>) {
        let [x, y, z] = &self.cell;
        for lane in 0..LANES {
            let [low, high] = nodes.cell(DVec3::new(x[lane], y[lane], z[lane]));
            let edges =
                [[low[0], low[1]], [low[2], low[3]], [high[0], high[1]], [high[2], high[3]]];
            for (list, edge) in self.edges.iter_mut().zip(edges) {
                list[lane] = edge;
            }
        }
    }

    #[inline]
    fn interpolate(&mut self) {
        let Self { place: [x, y, z], edges: e, value, slope: [dx, dy, dz], .. } = self;
        for lane in 0..LANES {
            let [[a, b], [c, d]] = [e[0][lane], e[1][lane]];
            let (low, [[p, q], [r, s]]) = ([a, b, c, d], [e[2][lane], e[3][lane]]);
            let high = [p, q, r, s];
            let at = DVec3::new(x[lane], y[lane], z[lane]);
            let (between, rise) = trilinear(low, high, at);
            value[lane] = between;
            (dx[lane], dy[lane], dz[lane]) = (rise.x, rise.y, rise.z);
        }
    }

    /// Turns steps into lengths, and what is not a number into infinity.
    #[inline]
    fn finish(
        &self,
        frame: &Frame,
        step: f64,
        offset: f64,
        (distance, gradient): (&mut [f64], &mut [DVec3]),
    ) {
        let [dx, dy, dz] = &self.slope;
        for (lane, (distance, gradient)) in distance.iter_mut().zip(gradient).enumerate() {
            let value = self.value[lane];
            let slope = step * DVec3::new(dx[lane], dy[lane], dz[lane]);
            let found =
                Sample { distance: value * step - offset, gradient: frame.slope_to_world(slope) };
            let sample = if value.is_nan() { Sample::OUTSIDE } else { found };
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    }
}
