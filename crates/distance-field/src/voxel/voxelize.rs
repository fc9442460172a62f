//! Voxelization: the voxels, centered on the nodes, that a surface switches on.
//!
//! The thin voxelization draws Bresenham lines along the edges of a face and one voxel per
//! column through its inside. Neighboring faces share the lines of their edges, but a path
//! from voxel to voxel across a common face can pass where two lines turn: with faces of
//! several voxels, a flood leaks through. The other two voxelizations test each voxel against
//! the face, thickened as much as the wanted separation requires, and do not leak.
//!
//! Source: J. E. Bresenham, "Algorithm for computer control of a digital plotter", IBM
//! Systems Journal 4(1), 1965, in three dimensions; M. Schwarz and H.-P. Seidel, "Fast
//! parallel surface and solid voxelization on GPUs", ACM TOG 29(6), 2010, sections 3 and 4.

use std::ops::Range;

use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, parallel};

use crate::Voxelization;
use crate::num::{coordinate, nearest, nodes_within};
use crate::units::GridSurface;

/// Planes of voxels per task.
const SLAB: usize = 32;

/// Faces between two progress reports.
const REPORT: u32 = 4096;

/// Switches on the voxels of all faces.
pub(super) fn voxelize(
    surface: &GridSurface<'_>,
    dims: [usize; 3],
    voxelization: Voxelization,
    voxels: &mut [bool],
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    let plane = dims[0] * dims[1];
    let mut slabs = Vec::new();
    for (s, voxels) in voxels.chunks_mut(plane * SLAB).enumerate() {
        let planes = s * SLAB..s * SLAB + voxels.len() / plane;
        slabs.push(Slab { dims, planes, voxels });
    }

    // Every slab runs over all faces: telling those that it needs costs little.
    let reports = surface.surface.faces().chunks(REPORT as usize).len();
    let steps = progress.steps(slabs.len() * reports);
    parallel::try_for_each_mut(&mut slabs, |_, slab| {
        let (first, last) = (coordinate(slab.planes.start), coordinate(slab.planes.end - 1));
        for (face, &normal) in (0..).zip(&surface.normals) {
            if face % REPORT == 0 {
                steps.advance(1)?;
            }
            // Half a voxel beyond its ends, and rounding.
            let corners = surface.corners(face);
            let Aabb { min, max } = Aabb::of_points(corners).inflate(1.0);
            if min.z <= last && max.z >= first {
                slab.add_face(corners, normal, voxelization);
            }
        }
        Ok(())
    })
}

/// Planes of voxels that one task works on.
struct Slab<'a> {
    dims: [usize; 3],
    planes: Range<usize>,
    voxels: &'a mut [bool],
}

impl Slab<'_> {
    /// Switches on the voxels of a face.
    fn add_face(&mut self, corners: [DVec3; 3], normal: DVec3, voxelization: Voxelization) {
        match voxelization {
            Voxelization::Bresenham => self.add_thin(corners, normal),
            Voxelization::SixSeparating => self.add_thick(corners, normal, DVec3::max_element),
            Voxelization::Conservative => self.add_thick(corners, normal, DVec3::element_sum),
        }
    }

    fn set(&mut self, [i, j, k]: [usize; 3]) {
        if i < self.dims[0] && j < self.dims[1] && self.planes.contains(&k) {
            self.voxels[i + self.dims[0] * (j + self.dims[1] * (k - self.planes.start))] = true;
        }
    }

    fn set_if_inside(&mut self, voxel: [i64; 3]) {
        if let [Ok(i), Ok(j), Ok(k)] = voxel.map(usize::try_from) {
            self.set([i, j, k]);
        }
    }

    /// Switches on the lines of the edges, and one voxel per column inside.
    fn add_thin(&mut self, corners: [DVec3; 3], normal: DVec3) {
        let [a, b, c] = corners.map(nearest_voxel);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            bresenham_line(from, to, |voxel| self.set_if_inside(voxel));
        }
        if normal != DVec3::ZERO {
            self.add_columns(corners, normal);
        }
    }

    /// Switches on one voxel per column inside a face, along the dominant axis of its normal.
    fn add_columns(&mut self, corners: [DVec3; 3], normal: DVec3) {
        let w = dominant_axis(normal);
        let [u, v] = [(w + 1) % 3, (w + 2) % 3];
        let [a, b, c] = corners;
        let Aabb { min, max } = Aabb::of_points(corners);
        for q in nodes_within(min[v], max[v], self.dims[v]) {
            for p in nodes_within(min[u], max[u], self.dims[u]) {
                // In projection along the axis, left of all edges or right of all.
                let at = [coordinate(p), coordinate(q)];
                let mut is_inside = true;
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let turn = (to[u] - from[u]) * (at[1] - from[v])
                        - (to[v] - from[v]) * (at[0] - from[u]);
                    is_inside &= turn * normal[w].signum() >= 0.0;
                }
                if is_inside {
                    let slope = normal[u] * (at[0] - a[u]) + normal[v] * (at[1] - a[v]);
                    let mut voxel = [0; 3];
                    [voxel[u], voxel[v], voxel[w]] =
                        [nearest(at[0]), nearest(at[1]), nearest(a[w] - slope / normal[w])];
                    self.set_if_inside(voxel);
                }
            }
        }
    }

    /// Switches on every voxel whose center is within the thickened face: by half of the
    /// `extent` of each normal, in its plane's and in its edges' projections.
    fn add_thick(&mut self, corners: [DVec3; 3], normal: DVec3, extent: fn(DVec3) -> f64) {
        let Aabb { min, max } = Aabb::of_points(corners).inflate(0.5);
        let sides = half_spaces(corners, normal, extent);
        for k in nodes_within(min.z, max.z, self.dims[2]) {
            if !self.planes.contains(&k) {
                continue;
            }
            for j in nodes_within(min.y, max.y, self.dims[1]) {
                for i in nodes_within(min.x, max.x, self.dims[0]) {
                    let p = DVec3::new(coordinate(i), coordinate(j), coordinate(k));
                    if sides.iter().all(|side| side.normal.dot(p) + side.offset >= 0.0) {
                        self.set([i, j, k]);
                    }
                }
            }
        }
    }
}

/// Returns the voxel that contains a point.
fn nearest_voxel(p: DVec3) -> [i64; 3] {
    p.to_array().map(nearest)
}

/// Half-space `normal · p + offset >= 0`.
struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

impl HalfSpace {
    /// Returns the half-space through `at`, moved out by half of the normal's extent, and by the rounding of
    /// coordinates up to `largest`: a face in the middle between two voxels may not fall between both.
    fn new(normal: DVec3, at: DVec3, extent: fn(DVec3) -> f64, largest: f64) -> Self {
        let rounding = 8.0 * f64::EPSILON * largest * normal.abs().element_sum();
        Self { normal, offset: 0.5 * extent(normal.abs()) - normal.dot(at) + rounding }
    }
}

/// Returns the half-spaces that the center of a voxel of a face must be in.
fn half_spaces(corners: [DVec3; 3], normal: DVec3, extent: fn(DVec3) -> f64) -> Vec<HalfSpace> {
    let [a, b, c] = corners;
    let Aabb { min, max } = Aabb::of_points(corners).inflate(1.0);
    let largest = min.abs().max(max.abs()).max_element();
    let half_space = |normal, at| HalfSpace::new(normal, at, extent, largest);
    let mut sides = vec![half_space(normal, a), half_space(-normal, a)];
    for (from, to) in [(a, b), (b, c), (c, a)] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            // In projection along the axis: at right angles to the edge, into the face.
            let facing = if normal.dot(axis) < 0.0 { -axis } else { axis };
            sides.push(half_space(facing.cross(to - from), from));
        }
    }
    sides
}

/// Returns the axis along which a vector is longest, the first of several.
fn dominant_axis(v: DVec3) -> usize {
    let [x, y, z] = v.abs().to_array();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Visits the voxels of the line between two, one per step along its longest axis.
fn bresenham_line(from: [i64; 3], to: [i64; 3], mut visit: impl FnMut([i64; 3])) {
    let (mut step, mut length) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let along = to[axis] - from[axis];
        (step[axis], length[axis]) = (along.signum(), along.abs());
    }

    // Per axis, twice the distance from the line less half a voxel, in units of 1 / steps.
    let steps = length[0].max(length[1]).max(length[2]);
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
