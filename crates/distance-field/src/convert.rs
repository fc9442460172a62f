//! Which voxels, centred on the nodes, a surface switches on.
//!
//! The thin conversion draws Bresenham lines along the edges of a face and one
//! voxel for each column through its inside. Neighbouring faces share the lines
//! of their edges, but a path from voxel to voxel across a common face can pass
//! where two lines turn: with faces of several voxels, a flood leaks through.
//! The other two conversions test each voxel against the face, thickened as
//! much as the wanted separation needs, and do not leak.
//!
//! Sources: J. E. Bresenham, "Algorithm for computer control of a digital
//! plotter", IBM Systems Journal 4(1), 1965, in three dimensions;
//! M. Schwarz and H.-P. Seidel, "Fast parallel surface and solid voxelization on
//! GPUs", ACM TOG 29(6), 2010, sections 3 and 4.

use std::ops::Range;

use glam::DVec3;

use crate::Voxelization;
use crate::num::{coordinate, nearest, nodes_within};
use crate::par;
use crate::units::Units;

/// Planes that are converted together.
const SLAB: usize = 32;

/// Switches on the voxels of all faces.
pub(crate) fn convert(
    units: &Units<'_>,
    dims: [usize; 3],
    conversion: Voxelization,
    voxels: &mut [bool],
) {
    let plane = dims[0] * dims[1];
    par::for_each(voxels.chunks_mut(plane * SLAB).collect(), |s, voxels| {
        let planes = s * SLAB..s * SLAB + voxels.len() / plane;
        let [first, last] = [planes.start, planes.end - 1].map(coordinate);
        let mut slab = Slab { dims, planes, voxels };
        for (face, normal) in (0..).zip(&units.normals) {
            let corners = units.corners(face);
            let heights = corners.map(|p| p.z);
            let lo = heights.into_iter().fold(f64::INFINITY, f64::min);
            let hi = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
            // Half a voxel beyond its ends, and rounding.
            if lo <= last + 1.0 && hi >= first - 1.0 {
                slab.face(corners, *normal, conversion);
            }
        }
    });
}

struct Slab<'a> {
    dims: [usize; 3],
    planes: Range<usize>,
    voxels: &'a mut [bool],
}

impl Slab<'_> {
    fn face(&mut self, corners: [DVec3; 3], normal: DVec3, conversion: Voxelization) {
        match conversion {
            Voxelization::Bresenham => self.thin(corners, normal),
            Voxelization::SixSeparating => self.thick(corners, normal, DVec3::max_element),
            Voxelization::Conservative => self.thick(corners, normal, DVec3::element_sum),
        }
    }

    fn set(&mut self, [i, j, k]: [usize; 3]) {
        if i < self.dims[0] && j < self.dims[1] && self.planes.contains(&k) {
            self.voxels[i + self.dims[0] * (j + self.dims[1] * (k - self.planes.start))] = true;
        }
    }

    fn set_nearest(&mut self, voxel: [i64; 3]) {
        if let [Ok(i), Ok(j), Ok(k)] = voxel.map(usize::try_from) {
            self.set([i, j, k]);
        }
    }

    fn thin(&mut self, corners: [DVec3; 3], normal: DVec3) {
        let [a, b, c] = corners.map(|p| p.to_array().map(nearest));
        for [from, to] in [[a, b], [b, c], [c, a]] {
            line(from, to, |voxel| self.set_nearest(voxel));
        }
        if normal != DVec3::ZERO {
            self.columns(corners, normal);
        }
    }

    /// One voxel a column, along the axis that the face looks to most.
    fn columns(&mut self, [a, b, c]: [DVec3; 3], normal: DVec3) {
        let w = dominant(normal.abs().to_array());
        let [u, v] = [(w + 1) % 3, (w + 2) % 3];
        let facing = normal[w].signum();
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        for q in nodes_within(lo[v], hi[v], self.dims[v]) {
            for p in nodes_within(lo[u], hi[u], self.dims[u]) {
                let at = [coordinate(p), coordinate(q)];
                let left_of = |[from, to]: [DVec3; 2]| {
                    let turn = (to[u] - from[u]) * (at[1] - from[v])
                        - (to[v] - from[v]) * (at[0] - from[u]);
                    turn * facing >= 0.0
                };
                if [[a, b], [b, c], [c, a]].into_iter().all(left_of) {
                    let slope = normal[u] * (at[0] - a[u]) + normal[v] * (at[1] - a[v]);
                    let mut voxel = [0; 3];
                    [voxel[u], voxel[v], voxel[w]] =
                        [nearest(at[0]), nearest(at[1]), nearest(a[w] - slope / normal[w])];
                    self.set_nearest(voxel);
                }
            }
        }
    }

    /// Every voxel within the face once it is thickened: by half of `extent` of
    /// each normal, in the plane's and in the edges' projections.
    fn thick(&mut self, corners: [DVec3; 3], normal: DVec3, extent: fn(DVec3) -> f64) {
        let [a, b, c] = corners;
        let (lo, hi) = (a.min(b).min(c) - 0.5, a.max(b).max(c) + 0.5);
        let sides = sides(corners, normal, extent);
        for k in nodes_within(lo.z, hi.z, self.dims[2]) {
            if !self.planes.contains(&k) {
                continue;
            }
            for j in nodes_within(lo.y, hi.y, self.dims[1]) {
                for i in nodes_within(lo.x, hi.x, self.dims[0]) {
                    let p = DVec3::new(coordinate(i), coordinate(j), coordinate(k));
                    if sides.iter().all(|(normal, offset)| normal.dot(p) + offset >= 0.0) {
                        self.set([i, j, k]);
                    }
                }
            }
        }
    }
}

/// Half-spaces, as inward normal and offset, that a voxel's centre must be in.
fn sides(corners: [DVec3; 3], normal: DVec3, extent: fn(DVec3) -> f64) -> Vec<(DVec3, f64)> {
    let half_space = |n: DVec3, at: DVec3| (n, 0.5 * extent(n.abs()) - n.dot(at));
    let [a, b, c] = corners;
    let mut sides = vec![half_space(normal, a), half_space(-normal, a)];
    for (from, to) in [(a, b), (b, c), (c, a)] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            // Seen along the axis: at right angles to the edge, into the face.
            let facing = if normal.dot(axis) < 0.0 { -axis } else { axis };
            sides.push(half_space(facing.cross(to - from), from));
        }
    }
    sides
}

fn dominant([x, y, z]: [f64; 3]) -> usize {
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Voxels of the line between two, one for each step along its longest axis.
fn line(from: [i64; 3], to: [i64; 3], mut visit: impl FnMut([i64; 3])) {
    let step = [0, 1, 2].map(|axis| (to[axis] - from[axis]).signum());
    let length = [0, 1, 2].map(|axis| (to[axis] - from[axis]).abs());
    let steps = length.into_iter().max().unwrap_or(0);
    let mut error = length.map(|length| 2 * length - steps);
    let mut voxel = from;
    visit(voxel);
    for _ in 0..steps {
        for axis in 0..3 {
            if error[axis] > 0 {
                voxel[axis] += step[axis];
                error[axis] -= 2 * steps;
            }
            error[axis] += 2 * length[axis];
        }
        visit(voxel);
    }
}
