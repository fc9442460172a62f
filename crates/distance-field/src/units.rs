//! Surface in units of the grid.

use glam::DVec3;
use surface::{Positions, TriangleSurface, closest_on_triangle, parallel, triangle};

use crate::FieldGrid;

/// Sine of a triangle's angle below which it has no usable normal.
///
/// The normal of a thinner triangle has lost half its digits, while every point of it is
/// within 1e-8 of its length of one of its edges, which are handled on their own.
const SLIVER_SINE: f64 = 1e-8;

/// Surface in units of the grid, with the unit normals of its faces.
#[derive(Debug)]
pub(crate) struct GridSurface<'a> {
    pub(crate) surface: &'a TriangleSurface,
    /// Vertices from the grid's origin, in spacings.
    pub(crate) x: Vec<DVec3>,
    /// Normals of the faces; zero for slivers.
    pub(crate) normals: Vec<DVec3>,
}

impl<'a> GridSurface<'a> {
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'_>, grid: &FieldGrid) -> Self {
        let x: Vec<DVec3> = x.as_slice().iter().map(|&p| grid.to_spacings(p)).collect();
        let faces = surface.faces();
        let normals = parallel::map(faces.len(), |f| {
            let [a, b, c] = faces[f];
            unit_normal([x[a as usize], x[b as usize], x[c as usize]])
        });
        Self { surface, x, normals }
    }

    /// Returns the corners of a face.
    #[inline]
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.surface.faces()[face as usize];
        [self.x[a as usize], self.x[b as usize], self.x[c as usize]]
    }

    /// Computes the squared distance of a point from a face.
    #[inline]
    pub(crate) fn squared_distance(&self, p: DVec3, face: u32) -> f64 {
        squared_distance(p, self.corners(face), self.normals[face as usize])
    }
}

/// Computes the squared distance of a point from a triangle with this unit normal, which is
/// zero for slivers.
#[inline]
fn squared_distance(p: DVec3, corners: [DVec3; 3], normal: DVec3) -> f64 {
    if normal == DVec3::ZERO {
        return closest_on_triangle(p, corners).point.distance_squared(p);
    }
    let [a, b, c] = corners;
    squared_distance_of_origin([a - p, b - p, c - p], normal)
}

/// Computes the squared distance of the origin from a triangle with this unit normal.
///
/// Over the inside of the triangle it is that from the plane; elsewhere that from the
/// nearest edge that has the origin on its outer side. Selections without a branch, which
/// vectorize.
#[inline(always)]
pub(crate) fn squared_distance_of_origin([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    let height = normal.dot(a);
    let edges = min(beyond(a, b, normal), beyond(b, c, normal));
    let beside = min(edges, beyond(c, a, normal));
    if beside < f64::INFINITY { beside } else { height * height }
}

/// Computes the squared distance of the origin from an edge; infinite where it is on the
/// edge's inner side.
#[inline(always)]
fn beyond(from: DVec3, to: DVec3, normal: DVec3) -> f64 {
    let edge = to - from;
    let t = -from.dot(edge) / edge.length_squared();
    // An edge without length yields NaN, and has no outer side.
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < 1.0 { t } else { 1.0 };
    let squared = (from + t * edge).length_squared();
    if normal.cross(edge).dot(from) > 0.0 { squared } else { f64::INFINITY }
}

#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Computes the unit normal of a triangle; zero for slivers.
fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = triangle::normal([a, b, c]);
    let doubled_area = normal.length();
    let lengths = [b - a, c - a, c - b].map(DVec3::length_squared);
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    if doubled_area <= SLIVER_SINE * longest { DVec3::ZERO } else { normal / doubled_area }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same distance as by exact projection, for triangles of every shape that has a
    /// normal.
    #[test]
    fn distances_are_those_of_the_closest_point() {
        fixtures::generate::cases(21, 1000, |u| {
            let mut number = || Ok(f64::from(u.int_in_range(-2000..=2000_i16)?) / 100.0);
            let mut point = || Ok(DVec3::new(number()?, number()?, number()?));
            let (a, b, thin) = (point()?, point()?, point()?);
            let widths = [1.0, 1e-2, 1e-4];
            for corners in widths.map(|width| [a, b, 0.5 * (a + b) + width * (thin - a)]) {
                let p = point()?;
                let exact = closest_on_triangle(p, corners).point.distance(p);
                let fast = squared_distance(p, corners, unit_normal(corners)).sqrt();
                assert!((fast - exact).abs() < 1e-6, "{fast} {exact}: {corners:?} {p}");
            }
            Ok(())
        });
    }
}
