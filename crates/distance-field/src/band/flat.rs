//! Squared distances of four nodes from a small face each, in single precision.
//!
//! A face is kept in its own plane: from a corner, along an edge and across it. There a distance is
//! that of a point from a triangle in two dimensions, for half the operations. Positions are
//! relative to a node nearby, so that nothing is lost to the size of the grid.

use glam::DVec3;
use surface::parallel;
use wide::{f32x4, i32x4};

use super::layers::{cross, dot, splat};
use crate::num::{nearest_whole, single, whole};
use crate::units::GridSurface;

/// Nodes that are measured together.
pub(super) const LANES: usize = 4;

/// Maximum distance of a node from its face \[spacings\]: with [`MAX_SIDE`], coordinates lose less
/// than 3e-6.
pub(super) const MAX_DISTANCE: f64 = 24.0;

/// Maximum length of an edge \[spacings\].
const MAX_SIDE: f64 = 8.0;

/// Minimum length of the longest edge \[spacings\], whose square single precision holds.
const MIN_SIDE: f64 = 1e-4;

/// Minimum of doubled area over the square of the longest edge: the tip of a narrower face is not
/// told from its inside.
const MIN_SINE: f64 = 1e-3;

/// Parts of a spacing in which corners are counted: an error of half a part in 1e6, and whole
/// numbers of 32 bits for all of [`MAX_COORDINATE`].
const PARTS: f64 = (1 << PART_BITS) as f64;
const PART_BITS: u32 = 20;

/// Maximum coordinate of a corner \[spacings\].
const MAX_COORDINATE: f64 = 2000.0;

/// Face in its own plane. A normal that is not a number stands for a face that is none of the small
/// ones.
#[derive(Clone, Copy)]
pub(super) struct FlatFace {
    /// First corner, in parts of a spacing.
    corner: [i32; 3],
    /// Length of the first edge.
    length: f32,
    /// Direction of the first edge, and coordinate along it of the third corner.
    along: [f32; 4],
    /// Normal, and coordinate of the third corner across the first edge.
    normal: [f32; 4],
}

/// Memory of a face \[bytes\].
pub(super) const BYTES: usize = size_of::<FlatFace>();

/// Returns all faces in their planes, or none where all are large or narrow.
pub(super) fn flat_faces(surface: &GridSurface<'_>) -> Vec<FlatFace> {
    let count = surface.normals.len();
    let faces = parallel::map(count, |face| {
        // In the order of the vertices, so that faces the other way around have the same distances.
        let mut corners = surface.surface.faces()[face];
        corners.sort_unstable();
        let corners = corners.map(|vertex| surface.x[vertex as usize]);
        FlatFace::new(corners, surface.normals[face])
    });
    if faces.iter().any(FlatFace::is_finite) { faces } else { Vec::new() }
}

impl FlatFace {
    /// Returns a face in its plane, given its unit normal to either side.
    fn new([a, b, c]: [DVec3; 3], normal: DVec3) -> Self {
        let (ab, ac) = (b - a, c - a);
        let length = ab.length();
        let along = ab / length;
        let x = along.dot(ac);
        let y = normal.cross(along).dot(ac);
        let (y, normal) = if y < 0.0 { (-y, -normal) } else { (y, normal) };

        let squares = [ab.length_squared(), ac.length_squared(), (c - b).length_squared()];
        let longest = squares[0].max(squares[1]).max(squares[2]);
        let is_small = (MIN_SIDE * MIN_SIDE..=MAX_SIDE * MAX_SIDE).contains(&longest);
        let is_flat = is_small & (y * length >= MIN_SINE * longest);
        let is_near = a.abs().max_element() <= MAX_COORDINATE;
        let normal = if is_flat & is_near { normal } else { DVec3::NAN };

        let row = |v: DVec3, last: f64| [v.x, v.y, v.z, last].map(single);
        Self {
            corner: (a * PARTS).to_array().map(nearest_whole),
            length: single(length),
            along: row(along, x),
            normal: row(normal, y),
        }
    }

    fn is_finite(&self) -> bool {
        self.normal[0].is_finite()
    }
}

/// Computes the squared distances of four nodes of a row from a face each; not a number where it is
/// none of the small ones.
#[inline(always)]
pub(super) fn squared_distances(
    faces: [&FlatFace; LANES],
    x: [usize; LANES],
    [y, z]: [usize; 2],
) -> f32x4 {
    // The node from the first corner: what is beyond 32 bits is beyond the largest coordinate.
    let from = |axis: usize, node: [usize; LANES]| {
        let parts =
            |lane: usize| (whole(node[lane]) << PART_BITS).wrapping_sub(faces[lane].corner[axis]);
        i32x4::new(std::array::from_fn(parts)).round_float() * splat(single(1.0 / PARTS))
    };
    let from = [from(0, x), from(1, [y; LANES]), from(2, [z; LANES])];

    // Its coordinates along the first edge, across it and above.
    let columns =
        |row: fn(&FlatFace) -> [f32; 4]| f32x4::transpose(faces.map(|face| f32x4::new(row(face))));
    let [u0, u1, u2, x] = columns(|face| face.along);
    let [n0, n1, n2, y] = columns(|face| face.normal);
    let length = f32x4::new(faces.map(|face| face.length));
    let (along, normal) = ([u0, u1, u2], [n0, n1, n2]);
    let (u, height) = (dot(from, along), dot(from, normal));
    let v = dot(from, cross(normal, along));

    // From the first edge, which is along the first axis.
    let (zero, one) = (splat(0.0), splat(1.0));
    let beside = u - u.fast_max(zero).fast_min(length);
    let first = beside * beside + v * v;

    // From the edges that end at the third corner, each from its other end.
    let edge = |u: f32x4, x: f32x4| {
        let t = (u * x + v * y) / (x * x + y * y);
        let t = t.fast_max(zero).fast_min(one);
        let (du, dv) = (u - t * x, v - t * y);
        (du * du + dv * dv, x * v - y * u)
    };
    let (second, right) = edge(u - length, x - length);
    let (third, left) = edge(u, x);

    // Inside it is on the inner side of all three, else as far as from the nearest.
    let is_outside = v.fast_min(right).fast_min(-left).simd_lt(zero);
    height * height + (is_outside & first.fast_min(second).fast_min(third))
}

#[cfg(test)]
mod tests {
    use surface::{closest_on_triangle, triangle};

    use super::*;
    use crate::num::floor_index;

    /// Distances in single precision beside exact projection, of faces of every shape, far from the
    /// origin of the grid, and nodes as far from them as they may be.
    #[test]
    fn distances_are_those_of_the_closest_point() {
        let mut measured = 0;
        fixtures::generate::cases(21, 3000, |u| {
            let mut number =
                |max: i16| Ok(f64::from(u.int_in_range(-1000..=1000)?) / 1000.0 * f64::from(max));
            let mut point = |max: i16| Ok(DVec3::new(number(max)?, number(max)?, number(max)?));
            let node = (point(500)? + 500.0).round();
            let (center, [a, b, thin]) = (point(13)?, [point(2)?, point(2)?, point(2)?]);
            for width in [1.0, 1e-2, 1e-4, 1e-9] {
                let corners = [a, b, 0.5 * (a + b) + width * (thin - a)].map(|p| node + center + p);
                let normal = triangle::normal(corners).normalize_or_zero();
                let face = FlatFace::new(corners, normal);
                let [x, y, z] = node.to_array().map(floor_index);
                let found =
                    f64::from(squared_distances([&face; LANES], [x; LANES], [y, z]).to_array()[0])
                        .sqrt();
                if found.is_finite() {
                    let exact = closest_on_triangle(node, corners).point.distance(node);
                    assert!((found - exact).abs() < 4e-6, "{found} {exact}: {corners:?} {node}");
                    measured += 1;
                }
            }
            Ok(())
        });
        assert!(measured > 4000, "{measured} are small and not too narrow");
    }

    #[test]
    fn large_and_narrow_faces_are_left_out() {
        let face = |b: DVec3, c: DVec3| {
            let corners = [DVec3::ZERO, b, c];
            FlatFace::new(corners, triangle::normal(corners).normalize_or_zero())
        };
        assert!(face(DVec3::X, DVec3::Y).is_finite());
        assert!(!face(1.1 * MAX_SIDE * DVec3::X, DVec3::Y).is_finite());
        assert!(!face(DVec3::X, 0.9 * MIN_SINE * DVec3::Y).is_finite());
        assert!(!face(0.5 * MIN_SIDE * DVec3::X, 0.5 * MIN_SIDE * DVec3::Y).is_finite());
        assert!(!face(DVec3::ZERO, DVec3::X).is_finite());
    }
}
