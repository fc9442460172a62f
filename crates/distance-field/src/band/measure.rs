//! Distances of nodes from the faces that were carried to them, many at once.
//!
//! Node by node, the processor waits for each face's corners, and mispredicts which of its
//! edges is nearest. Here corners are loaded for many nodes before any is measured, and
//! measuring has no branch, so that it vectorizes. Small faces, which most are, are measured in
//! their planes and in single precision ([`super::flat`]), all others in double precision.

use glam::DVec3;
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use super::carry::max_distance;
use super::flat::{BYTES, FlatFace, LANES, MAX_DISTANCE, flat_faces, squared_distances};
use super::{BandParams, Nearest};
use crate::num::{coordinate, single};
use crate::units::{GridSurface, squared_distance_of_origin};

/// Nodes that are measured together: enough to hide the latency of memory, few enough that
/// their state (4 kB) stays in the first-level cache.
const BATCH: usize = 32;

type Lanes = [f64; BATCH];

/// Computes the squared distances of the nodes beyond the band from the faces that were
/// carried to them; nodes without a face are infinitely far.
pub(super) fn measure(
    surface: &GridSurface<'_>,
    nearest: &mut Nearest,
    [nx, ny, _]: [usize; 3],
    params: BandParams,
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    // Small faces near all of their nodes are measured in single precision, where they fit in the
    // memory that carrying had.
    let is_near = max_distance(params).is_some_and(|distance| distance < MAX_DISTANCE);
    let are_few = BYTES * surface.normals.len() <= 2 * nearest.face.len();
    let flat = if is_near && are_few { flat_faces(surface) } else { Vec::new() };

    let plane = nx * ny;
    let planes = nearest.squared.chunks_mut(plane).zip(nearest.face.chunks(plane));
    let mut planes: Vec<_> = planes.collect();
    let steps = progress.steps(planes.len());
    parallel::try_for_each_mut(&mut planes, |k, (squared, faces)| {
        steps.advance(1)?;
        let (mut beyond, mut batch) = (Vec::new(), MeasureBatch::new(surface));
        for (j, start) in (0..plane).step_by(nx).enumerate() {
            let row = start..start + nx;
            let (row_squared, row_faces) = (&mut squared[row.clone()], &faces[row]);
            list_beyond(row_squared, row_faces, &mut beyond);

            let first = DVec3::new(0.0, coordinate(j), coordinate(k));
            if !flat.is_empty() {
                measure_flat([j, k], row_faces, &flat, &mut beyond, row_squared);
            }
            for &i in &beyond {
                let p = DVec3 { x: coordinate(i), ..first };
                batch.add(start + i, p, faces[start + i] - 1, squared);
            }
        }
        batch.finish(squared);
        Ok(())
    })
}

/// Lists the nodes of a row that are beyond the band and have a face; all others get their
/// distances.
fn list_beyond(squared: &mut [f32], faces: &[u32], beyond: &mut Vec<usize>) {
    // Without a branch: where the band ends has no pattern.
    beyond.resize(squared.len(), 0);
    let mut count = 0;
    for (i, (squared, &face)) in squared.iter_mut().zip(faces).enumerate() {
        beyond[count] = i;
        count += usize::from((face != 0) & (squared.to_bits() == 0));
        *squared = if face == 0 { f32::INFINITY } else { squared.abs() };
    }
    beyond.truncate(count);
}

/// Measures the listed nodes of a row whose faces are small, and leaves the others in the list.
fn measure_flat(
    row: [usize; 2],
    faces: &[u32],
    flat: &[FlatFace],
    nodes: &mut Vec<usize>,
    squared: &mut [f32],
) {
    // The last node is repeated until all are fours.
    let Some(&last) = nodes.last() else {
        return;
    };
    nodes.resize(nodes.len().next_multiple_of(LANES), last);

    let mut others = 0;
    for start in (0..nodes.len()).step_by(LANES) {
        let four: [usize; LANES] = std::array::from_fn(|lane| nodes[start + lane]);
        let faces = four.map(|node| &flat[faces[node] as usize - 1]);
        let measured = squared_distances(faces, four, row);
        for (&node, measured) in four.iter().zip(measured.to_array()) {
            squared[node] = measured;
        }
        if !measured.is_finite().all() {
            for (&node, measured) in four.iter().zip(measured.to_array()) {
                nodes[others] = node;
                others += usize::from(!measured.is_finite());
            }
        }
    }
    nodes.truncate(others);
}

/// Nodes whose faces are loaded.
struct MeasureBatch<'a> {
    surface: &'a GridSurface<'a>,
    count: usize,
    node: [usize; BATCH],
    /// Corners relative to the node, and the normal; one list per coordinate.
    corners: [[Lanes; 3]; 3],
    normal: [Lanes; 3],
}

impl<'a> MeasureBatch<'a> {
    fn new(surface: &'a GridSurface<'a>) -> Self {
        let zeros = [[0.0; BATCH]; 3];
        Self { surface, count: 0, node: [0; BATCH], corners: [zeros; 3], normal: zeros }
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
        if self.count == BATCH {
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
        let mut measured = [0.0; BATCH];
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
