//! Affine map between the world and a grid.
//!
//! One map takes a point to units of the grid: pose, origin and spacing folded together.
//! The steps after it are the same for every axis and have no branch, so that they
//! vectorize over many points.

use glam::{DMat3, DVec3};
use surface::Pose;

use crate::FieldGrid;
use crate::num::{coordinate, floor};

/// Cell that contains a point, by the coordinates of its lowest node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Location {
    pub(crate) cell: DVec3,
    /// Coordinates within the cell, `0.0..=1.0`.
    pub(crate) local: DVec3,
}

/// Affine map between the world and a grid in a pose; made once for many points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: DVec3,
    per_spacing: f64,
    /// The last node in units of the grid, by the arithmetic that points undergo.
    last: DVec3,
    last_cell: DVec3,
    /// `None` for the identity: rotations take a fifth of the time of a query.
    posed: Option<PosedMap>,
}

/// Affine map of a pose, with the spacing folded in.
#[derive(Clone, Copy, Debug)]
struct PosedMap {
    to_grid: DMat3,
    shift: DVec3,
    to_world: DMat3,
}

impl Frame {
    pub(crate) fn new(grid: &FieldGrid, pose: &Pose) -> Self {
        let (origin, per_spacing) = (grid.origin(), 1.0 / grid.spacing());
        let [nx, ny, nz] = grid.dims();
        let last = (grid.position([nx - 1, ny - 1, nz - 1]) - origin) * per_spacing;
        let last_cell = DVec3::from_array([nx - 2, ny - 2, nz - 2].map(coordinate));
        let mut frame = Self { origin, per_spacing, last, last_cell, posed: None };
        if *pose != Pose::IDENTITY {
            let to_grid = pose.rotation().transpose() * per_spacing;
            let shift = -(to_grid * pose.translation()) - origin * per_spacing;
            let to_world = pose.rotation() * per_spacing;
            frame.posed = Some(PosedMap { to_grid, shift, to_world });
        }
        frame
    }

    /// Finds the cell that contains `p`; `None` outside, or for NaN.
    #[inline]
    pub(crate) fn locate(&self, p: DVec3) -> Option<Location> {
        let u = self.grid_coordinates(p);
        // Written out: as a map over the axes it is a call per axis.
        let (i, x) = self.locate_along(u.x, 0);
        let (j, y) = self.locate_along(u.y, 1);
        let (k, z) = self.locate_along(u.z, 2);
        let local = DVec3::new(x, y, z);
        (!local.is_nan()).then_some(Location { cell: DVec3::new(i, j, k), local })
    }

    /// Finds the cells that contain many points; a local coordinate is NaN where a point is
    /// outside.
    #[inline]
    pub(crate) fn locate_batch<const N: usize>(
        &self,
        points: &[DVec3],
        cell: &mut [[f64; N]; 3],
        local: &mut [[f64; N]; 3],
    ) {
        // The coordinates pass through `local`; the pose is decided once for all points.
        match &self.posed {
            None => split(points, local, |p| self.unposed_grid_coordinates(p)),
            Some(posed) => split(points, local, |p| posed.grid_coordinates(p)),
        }

        // Axis by axis, the loops are without a branch and vectorize.
        for axis in 0..3 {
            for (cell, local) in cell[axis].iter_mut().zip(&mut local[axis]) {
                (*cell, *local) = self.locate_along(*local, axis);
            }
        }
    }

    /// Converts a point of the world to units of the grid.
    #[inline]
    pub(crate) fn grid_coordinates(&self, p: DVec3) -> DVec3 {
        match &self.posed {
            None => self.unposed_grid_coordinates(p),
            Some(posed) => posed.grid_coordinates(p),
        }
    }

    /// Returns the last node, in units of the grid.
    pub(crate) fn last(&self) -> DVec3 {
        self.last
    }

    /// Returns the cell that contains a point in units of the grid, or the nearest one.
    pub(crate) fn nearest_cell(&self, u: DVec3) -> DVec3 {
        u.floor().clamp(DVec3::ZERO, self.last_cell)
    }

    /// Returns true if the grid has a cell with this lowest node.
    pub(crate) fn has_cell(&self, cell: DVec3) -> bool {
        cell.cmpge(DVec3::ZERO).all() && cell.cmple(self.last_cell).all()
    }

    /// Converts a gradient from units of the grid to the world.
    #[inline]
    pub(crate) fn gradient_to_world(&self, gradient: DVec3) -> DVec3 {
        match &self.posed {
            None => gradient * self.per_spacing,
            Some(posed) => posed.to_world * gradient,
        }
    }

    #[inline]
    fn unposed_grid_coordinates(&self, p: DVec3) -> DVec3 {
        (p - self.origin) * self.per_spacing
    }

    /// Returns the cell and the place in it of a coordinate along an axis; the place is NaN
    /// where the coordinate is outside.
    #[inline]
    fn locate_along(&self, u: f64, axis: usize) -> (f64, f64) {
        // Selections, which need no branch, and take NaN for 0.
        let is_inside = (u >= 0.0) & (u <= self.last[axis]);
        let down = floor(if is_inside { u } else { 0.0 });
        let cell = if down < self.last_cell[axis] { down } else { self.last_cell[axis] };
        let local = if u - cell < 1.0 { u - cell } else { 1.0 };
        (cell, if is_inside { local } else { f64::NAN })
    }
}

impl PosedMap {
    #[inline]
    fn grid_coordinates(&self, p: DVec3) -> DVec3 {
        self.to_grid * p + self.shift
    }
}

/// Writes the coordinates of mapped points, one list per axis.
#[inline]
fn split<const N: usize>(
    points: &[DVec3],
    out: &mut [[f64; N]; 3],
    to_grid: impl Fn(DVec3) -> DVec3,
) {
    let [x, y, z] = out;
    for (((&p, x), y), z) in points.iter().zip(x).zip(y).zip(z) {
        DVec3 { x: *x, y: *y, z: *z } = to_grid(p);
    }
}
