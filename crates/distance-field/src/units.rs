//! A surface in units of the grid: positions from its origin, in spacings.

use glam::DVec3;
use surface::{Positions, TriangleSurface};

use crate::grid::Grid;
use crate::par;

/// Sine of a face's angle below which it has no usable normal.
///
/// The normal of a thinner face has lost half its digits, while every point of
/// the face is within 1e-8 of its length of one of its edges, which are handled
/// on their own.
const SLIVER_SINE: f64 = 1e-8;

/// A surface in units of the grid, with the unit normals of its faces.
#[derive(Debug)]
pub(crate) struct Units<'a> {
    pub(crate) surface: &'a TriangleSurface,
    /// Vertices from the grid's origin, in spacings.
    pub(crate) x: Vec<DVec3>,
    /// Normals of the faces; zero for slivers.
    pub(crate) normals: Vec<DVec3>,
}

impl<'a> Units<'a> {
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'_>, grid: &Grid) -> Self {
        let x: Vec<DVec3> = x.as_slice().iter().map(|&p| grid.to_units(p)).collect();
        let faces = surface.faces();
        let normals = par::map(faces.len(), |f| normal(faces[f].map(|v| x[v as usize])));
        Self { surface, x, normals }
    }

    #[inline]
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.surface.faces()[face as usize];
        [self.x[a as usize], self.x[b as usize], self.x[c as usize]]
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (e, f) = (b - a, c - a);
    let n = e.cross(f);
    let area = n.length();
    let longest = e.length_squared().max(f.length_squared()).max((c - b).length_squared());
    if area <= SLIVER_SINE * longest { DVec3::ZERO } else { n / area }
}
