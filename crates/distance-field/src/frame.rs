//! From points of the world to cells of a grid, and from slopes there back.
//!
//! One affine map takes a point to units of the grid: pose, origin and spacing
//! folded together. What follows is the same for every axis and has no branch,
//! so that it works on many points at once.

use glam::{DMat3, DVec3};
use surface::Pose;

use crate::grid::FieldGrid;
use crate::num::floor;

/// A cell, by the coordinates of its lowest node, and a place in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    pub(crate) cell: DVec3,
    pub(crate) place: DVec3,
}

/// Where a grid is in the world; made once for many points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: DVec3,
    per_spacing: f64,
    /// The last node in units of the grid, by the arithmetic that points take.
    last: DVec3,
    last_cell: DVec3,
    /// Only where there is a pose: turning takes a fifth of the time.
    turned: Option<Turned>,
}

/// A pose with the spacing folded in.
#[derive(Clone, Copy, Debug)]
struct Turned {
    into: DMat3,
    shift: DVec3,
    out: DMat3,
}

impl Frame {
    pub(crate) fn new(grid: &FieldGrid, pose: &Pose) -> Self {
        let (origin, per_spacing) = (grid.origin(), 1.0 / grid.spacing());
        let last_node = grid.position(grid.dims().map(|n| n - 1));
        let into = pose.rotation().transpose() * per_spacing;
        let turned = (*pose != Pose::IDENTITY).then(|| Turned {
            into,
            shift: -(into * pose.translation()) - origin * per_spacing,
            out: pose.rotation() * per_spacing,
        });
        let last = (last_node - origin) * per_spacing;
        let last_cell = DVec3::from_array(grid.dims().map(|n| crate::num::coordinate(n - 2)));
        Self { origin, per_spacing, last, last_cell, turned }
    }

    /// The cell that holds `p`; none outside, or when `p` is not a number.
    #[inline]
    pub(crate) fn locate(&self, p: DVec3) -> Option<Located> {
        let u = self.units(p);
        let [x, y, z] = [0, 1, 2].map(|axis| self.along(u[axis], axis));
        let place = DVec3::new(x.1, y.1, z.1);
        (!place.is_nan()).then(|| Located { cell: DVec3::new(x.0, y.0, z.0), place })
    }

    /// Cells and places of many points; at least one place is not a number where
    /// a point is outside.
    #[inline]
    pub(crate) fn locate_all<const N: usize>(
        &self,
        points: &[DVec3],
        cell: &mut [[f64; N]; 3],
        place: &mut [[f64; N]; 3],
    ) {
        // The coordinates pass through the places.
        match &self.turned {
            None => split(points, place, |p| self.straight(p)),
            Some(turned) => split(points, place, |p| turned.units(p)),
        }
        for axis in 0..3 {
            for (cell, place) in cell[axis].iter_mut().zip(&mut place[axis]) {
                (*cell, *place) = self.along(*place, axis);
            }
        }
    }

    /// A point of the world in units of the grid.
    #[inline]
    pub(crate) fn units(&self, p: DVec3) -> DVec3 {
        self.turned.map_or_else(|| self.straight(p), |turned| turned.units(p))
    }

    /// The last node in units of the grid.
    pub(crate) fn last(&self) -> DVec3 {
        self.last
    }

    /// The cell that holds a point given in units of the grid, or the nearest.
    pub(crate) fn cell(&self, u: DVec3) -> DVec3 {
        u.floor().clamp(DVec3::ZERO, self.last_cell)
    }

    /// Whether there is a cell with this lowest node.
    pub(crate) fn has_cell(&self, cell: DVec3) -> bool {
        cell.cmpge(DVec3::ZERO).all() && cell.cmple(self.last_cell).all()
    }

    /// A slope in units of the grid, in the world.
    #[inline]
    pub(crate) fn slope_to_world(&self, slope: DVec3) -> DVec3 {
        self.turned.map_or_else(|| slope * self.per_spacing, |turned| turned.out * slope)
    }

    #[inline]
    fn straight(&self, p: DVec3) -> DVec3 {
        (p - self.origin) * self.per_spacing
    }

    /// The cell and the place in it of a coordinate along an axis; the place is
    /// not a number where the coordinate is outside.
    #[inline]
    fn along(&self, u: f64, axis: usize) -> (f64, f64) {
        // Written as selections, which need no branch and take what is not a number for 0.
        let is_inside = (u >= 0.0) & (u <= self.last[axis]);
        let down = floor(if is_inside { u } else { 0.0 });
        let cell = if down < self.last_cell[axis] { down } else { self.last_cell[axis] };
        let place = if u - cell < 1.0 { u - cell } else { 1.0 };
        (cell, if is_inside { place } else { f64::NAN })
    }
}

impl Turned {
    #[inline]
    fn units(&self, p: DVec3) -> DVec3 {
        self.into * p + self.shift
    }
}

#[inline]
fn split<const N: usize>(
    points: &[DVec3],
    out: &mut [[f64; N]; 3],
    units: impl Fn(DVec3) -> DVec3,
) {
    let [x, y, z] = out;
    for (((&p, x), y), z) in points.iter().zip(x).zip(y).zip(z) {
        DVec3 { x: *x, y: *y, z: *z } = units(p);
    }
}
