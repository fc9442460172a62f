//! A surface in units of the grid: positions from its origin, in spacings.

use glam::DVec3;
use surface::{Positions, TriangleSurface, closest_on_triangle};

use crate::grid::FieldGrid;
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
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'_>, grid: &FieldGrid) -> Self {
        let x: Vec<DVec3> = x.as_slice().iter().map(|&p| grid.to_units(p)).collect();
        let faces = surface.faces();
        let normals = par::map(faces.len(), |f| normal(faces[f].map(|v| x[v as usize])));
        Self { surface, x, normals }
    }

    #[inline]
    pub(crate) fn face(&self, face: u32) -> Face {
        Face { corners: self.corners(face), normal: self.normals[face as usize] }
    }

    #[inline]
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.surface.faces()[face as usize];
        [self.x[a as usize], self.x[b as usize], self.x[c as usize]]
    }
}

/// A face with its normal, ready to be measured from many points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    corners: [DVec3; 3],
    normal: DVec3,
}

impl Face {
    /// Squared distance of a point.
    ///
    /// Over the inside of the face it is that of the plane; elsewhere that of the
    /// nearest edge that has the point on its outer side. Slivers, which have no
    /// usable normal, take the careful way.
    #[inline]
    pub(crate) fn squared_distance(&self, p: DVec3) -> f64 {
        let Self { corners, normal } = *self;
        if normal == DVec3::ZERO {
            return closest_on_triangle(p, corners).point.distance_squared(p);
        }
        squared_distance(corners.map(|corner| corner - p), normal)
    }
}

/// Squared distance of the origin to a face with this unit normal.
///
/// Written as selections without a branch, so that it works on many faces at once.
#[inline(always)]
pub(crate) fn squared_distance([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    let height = normal.dot(a);
    let beside = least(least(beyond(a, b, normal), beyond(b, c, normal)), beyond(c, a, normal));
    if beside < f64::INFINITY { beside } else { height * height }
}

/// Squared distance of the origin to an edge, where it is on the edge's outer side.
#[inline(always)]
fn beyond(from: DVec3, to: DVec3, normal: DVec3) -> f64 {
    let edge = to - from;
    let t = -from.dot(edge) / edge.length_squared();
    // An edge without length has no such place, and no outer side either.
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < 1.0 { t } else { 1.0 };
    let squared = (from + t * edge).length_squared();
    if normal.cross(edge).dot(from) > 0.0 { squared } else { f64::INFINITY }
}

#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (e, f) = (b - a, c - a);
    let n = e.cross(f);
    let area = n.length();
    let longest = e.length_squared().max(f.length_squared()).max((c - b).length_squared());
    if area <= SLIVER_SINE * longest { DVec3::ZERO } else { n / area }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same distance as by the careful way, for triangles of every shape that has a normal.
    #[test]
    fn quick_distances_are_the_careful_ones() {
        arbtest::arbtest(|u| {
            let mut number = || Ok(f64::from(u.int_in_range(-2000..=2000_i16)?) / 100.0);
            let mut point = || Ok(DVec3::new(number()?, number()?, number()?));
            let (a, b, thin) = (point()?, point()?, point()?);
            let shares = [1.0, 1e-2, 1e-4];
            for corners in shares.map(|share| [a, b, 0.5 * (a + b) + share * (thin - a)]) {
                let face = Face { corners, normal: normal(corners) };
                let p = point()?;
                let careful = closest_on_triangle(p, corners).point.distance(p);
                let quick = face.squared_distance(p).sqrt();
                assert!((quick - careful).abs() < 1e-6, "{quick} {careful}: {corners:?} {p}");
            }
            Ok(())
        });
    }
}
