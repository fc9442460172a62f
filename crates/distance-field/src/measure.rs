//! Squared distances of nodes to the faces that were carried to them, some
//! dozens at once.
//!
//! One node after the other, the processor waits for each face's corners, and
//! guesses wrongly which of its edges is nearest. Here corners are fetched for
//! many nodes before any is measured, and measuring has no branch, so that it
//! works on vectors.

use glam::DVec3;

use crate::band::Nearest;
use crate::carry::Carried;
use crate::num::{coordinate, single};
use crate::par;
use crate::units::{Units, squared_distance};

/// Nodes that are measured together: enough to hide what the memory takes, few
/// enough that all they need stays in the nearest cache (4 kB).
const LANES: usize = 32;

type Lanes = [f64; LANES];

/// Measures the distance of carried nodes to their faces; nodes without one are
/// infinitely far.
pub(crate) fn measure(
    units: &Units<'_>,
    nearest: &mut Nearest,
    carried: &Carried,
    [nx, ny, _]: [usize; 3],
) {
    let plane = nx * ny;
    let planes = nearest.squared.chunks_mut(plane).zip(nearest.face.chunks(plane)).collect();
    par::for_each(planes, |k, (squared, face)| {
        let mut work = Work::new(units);
        for (j, row) in (0..plane).step_by(nx).enumerate() {
            for i in 0..nx {
                let node = row + i;
                if face[node] == 0 {
                    squared[node] = f32::INFINITY;
                } else if carried.is_carried(k * plane + node) {
                    let p = DVec3::new(coordinate(i), coordinate(j), coordinate(k));
                    work.add(node, p, face[node] - 1, squared);
                }
            }
        }
        work.finish(squared);
    });
}

/// Nodes whose faces have been fetched.
struct Work<'a> {
    units: &'a Units<'a>,
    count: usize,
    node: [usize; LANES],
    /// Corners as seen from the node, and the normal; each list one number a node.
    corners: [[Lanes; 3]; 3],
    normal: [Lanes; 3],
}

impl<'a> Work<'a> {
    fn new(units: &'a Units<'a>) -> Self {
        let zero = [[0.0; LANES]; 3];
        Self { units, count: 0, node: [0; LANES], corners: [zero; 3], normal: zero }
    }

    #[inline]
    fn add(&mut self, node: usize, p: DVec3, face: u32, squared: &mut [f32]) {
        let normal = self.units.normals[face as usize];
        if normal == DVec3::ZERO {
            squared[node] = single(self.units.face(face).squared_distance(p));
            return;
        }
        let lane = self.count;
        self.node[lane] = node;
        for (corner, list) in self.units.corners(face).into_iter().zip(&mut self.corners) {
            put(corner - p, list, lane);
        }
        put(normal, &mut self.normal, lane);
        self.count += 1;
        if self.count == LANES {
            self.finish(squared);
        }
    }

    /// Measures what has been fetched.
    fn finish(&mut self, squared: &mut [f32]) {
        let measured = self.all();
        for (&node, &measured) in self.node[..self.count].iter().zip(&measured) {
            squared[node] = single(measured);
        }
        self.count = 0;
    }

    #[inline(never)]
    fn all(&self) -> Lanes {
        let [a, b, c] = &self.corners;
        let mut measured = [0.0; LANES];
        for (lane, measured) in measured.iter_mut().enumerate() {
            let corners = [get(a, lane), get(b, lane), get(c, lane)];
            *measured = squared_distance(corners, get(&self.normal, lane));
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
