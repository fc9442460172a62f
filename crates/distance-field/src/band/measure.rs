//! Distances of nodes from the faces that were carried to them, many at once.
//!
//! Node by node, the processor waits for each face's corners, and mispredicts which of its
//! edges is nearest. Here corners are loaded for many nodes before any is measured, and
//! measuring has no branch, so that it vectorizes.

use glam::DVec3;
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use super::Nearest;
use crate::num::{coordinate, single};
use crate::units::{GridSurface, squared_distance_of_origin};

/// Nodes that are measured together: enough to hide the latency of memory, few enough that
/// their state (4 kB) stays in the first-level cache.
const LANES: usize = 32;

type Lanes = [f64; LANES];

/// Computes the squared distances of the nodes beyond the band from the faces that were
/// carried to them; nodes without a face are infinitely far.
pub(super) fn measure(
    surface: &GridSurface<'_>,
    nearest: &mut Nearest,
    [nx, ny, _]: [usize; 3],
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    // Plane by plane, nodes are gathered into batches across rows.
    let plane = nx * ny;
    let planes = nearest.squared.chunks_mut(plane).zip(nearest.face.chunks(plane));
    let mut planes: Vec<_> = planes.collect();
    let steps = progress.steps(planes.len());
    parallel::try_for_each_mut(&mut planes, |k, (squared, faces)| {
        steps.advance(1)?;
        let mut batch = MeasureBatch::new(surface);
        for j in 0..ny {
            for i in 0..nx {
                let node = i + nx * j;
                let (face, found) = (faces[node], squared[node]);
                if face == 0 {
                    squared[node] = f32::INFINITY;
                } else if found.to_bits() == 0 {
                    let p = DVec3::new(coordinate(i), coordinate(j), coordinate(k));
                    batch.add(node, p, face - 1, squared);
                } else {
                    squared[node] = found.abs();
                }
            }
        }
        batch.finish(squared);
        Ok(())
    })
}

/// Nodes whose faces are loaded.
struct MeasureBatch<'a> {
    surface: &'a GridSurface<'a>,
    count: usize,
    node: [usize; LANES],
    /// Corners relative to the node, and the normal; one list per coordinate.
    corners: [[Lanes; 3]; 3],
    normal: [Lanes; 3],
}

impl<'a> MeasureBatch<'a> {
    fn new(surface: &'a GridSurface<'a>) -> Self {
        let zeros = [[0.0; LANES]; 3];
        Self { surface, count: 0, node: [0; LANES], corners: [zeros; 3], normal: zeros }
    }

    /// Loads a face for the node at `p`; measures once the batch is full.
    #[inline]
    fn add(&mut self, node: usize, p: DVec3, face: u32, squared: &mut [f32]) {
        let normal = self.surface.normals[face as usize];
        if normal == DVec3::ZERO {
            squared[node] = single(self.surface.squared_distance(p, face));
            return;
        }

        // Relative to the node, a distance is that of the origin.
        let lane = self.count;
        self.node[lane] = node;
        for (corner, list) in self.surface.corners(face).into_iter().zip(&mut self.corners) {
            put(corner - p, list, lane);
        }
        put(normal, &mut self.normal, lane);
        self.count += 1;
        if self.count == LANES {
            self.finish(squared);
        }
    }

    /// Measures the nodes that are loaded.
    ///
    /// All lanes are measured: those that are not loaded cost less than a loop of a length that
    /// the compiler does not have.
    fn finish(&mut self, squared: &mut [f32]) {
        let measured = self.measure();
        for (&node, &measured) in self.node[..self.count].iter().zip(&measured) {
            squared[node] = single(measured);
        }
        self.count = 0;
    }

    #[inline(never)]
    fn measure(&self) -> Lanes {
        let [a, b, c] = &self.corners;
        let mut measured = [0.0; LANES];
        for (lane, measured) in measured.iter_mut().enumerate() {
            let corners = [get(a, lane), get(b, lane), get(c, lane)];
            *measured = squared_distance_of_origin(corners, get(&self.normal, lane));
        }
        measured
    }
}

#[inline]
fn put(p: DVec3, [x, y, z]: &mut [Lanes; 3], lane: usize) {
    (x[lane], y[lane], z[lane]) = (p.x, p.y, p.z);
}

#[inline]
fn get([x, y, z]: &[Lanes; 3], lane: usize) -> DVec3 {
    DVec3::new(x[lane], y[lane], z[lane])
}
