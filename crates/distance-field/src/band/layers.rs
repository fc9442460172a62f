//! Search of the nodes of four narrow regions at once, layer by layer.
//!
//! A region is narrow across one axis of the grid: each layer of nodes across that axis cuts it
//! in a small rectangle, which moves from layer to layer along a line. Its nodes, one or a few per
//! layer, are compared with the sides of the region, four regions to a register, without a branch.
//!
//! All in single precision, relative to a node nearby: sides are moved out by [`SLACK`], far more
//! than rounding loses, so that every node of a region is found.

use glam::DVec3;
use wide::f32x4;

use crate::num::floor_index;

/// Regions that are searched together.
pub(super) const LANES: usize = 4;

/// Groups of nodes, one per region, that are collected before they are visited: as many as there
/// are bits.
const GROUPS: usize = 64 / LANES;

/// Distance by which sides are moved out \[spacings\]. Coordinates are below 40, and lose 2e-5.
pub(super) const SLACK: f32 = 1e-4;

/// Vectors, one per region, by their coordinates: that across the layers, and those along them.
pub(super) type Vectors = [f32x4; 3];

/// Four regions, in coordinates whose first axis is across their layers.
pub(super) struct Regions<const N: usize> {
    /// First layer.
    pub(super) first: f32x4,
    /// Number of layers.
    pub(super) layers: f32x4,
    /// Lower ends of the rectangles where the first coordinate is 0, and their change per layer.
    pub(super) at: [f32x4; 2],
    pub(super) slopes: [f32x4; 2],
    /// Widths of the rectangles.
    pub(super) widths: [f32x4; 2],
    /// Sides: inward normals, and distances of the origin from them.
    pub(super) normals: [Vectors; N],
    pub(super) offsets: [f32x4; N],
}

/// Nodes that may be in their regions, in groups of one per region.
#[derive(Default)]
pub(super) struct Found {
    nodes: [[[f32; LANES]; GROUPS]; 3],
    /// Least distance from the sides, moved out.
    distances: [[f32; LANES]; GROUPS],
}

/// Node that may be in a region, where it was found: read from there, since numbers that are
/// stored one by one and then loaded together are waited for.
pub(super) struct Candidate<'a> {
    found: &'a Found,
    group: usize,
    pub(super) lane: usize,
}

impl Candidate<'_> {
    /// Returns the position from the origin of the region, given the places of x, y and z among its
    /// coordinates.
    #[inline(always)]
    pub(super) fn node(&self, places: [usize; 3]) -> DVec3 {
        let [x, y, z] =
            places.map(|place| f64::from(self.found.nodes[place][self.group][self.lane]));
        DVec3::new(x, y, z)
    }

    /// Returns the least distance from the sides, moved out by the slack.
    #[inline(always)]
    pub(super) fn distance(&self) -> f32 {
        self.found.distances[self.group][self.lane]
    }
}

impl<const N: usize> Regions<N> {
    /// Visits all nodes that are within the sides, and some that are not.
    #[inline(always)]
    pub(super) fn search(&self, found: &mut Found, mut visit: impl FnMut(Candidate<'_>)) {
        let layers = largest(self.layers);
        let counts = [largest(self.widths[0]) + 1, largest(self.widths[1]) + 1];
        let half = splat(0.5);

        let (mut bits, mut group) = (0_u64, 0);
        let mut w = self.first;
        for _ in 0..layers {
            // The lowest node of the rectangle.
            let mut u = round(self.at[0] + self.slopes[0] * w + half);
            let first_v = round(self.at[1] + self.slopes[1] * w + half);
            let sides = self.normals.iter().zip(self.offsets);
            let mut distances = self.offsets;
            for (distance, ([a, b, c], offset)) in distances.iter_mut().zip(sides) {
                *distance = (*a * w + offset) + (*b * u + *c * first_v);
            }

            for _ in 0..counts[0] {
                let (mut v, mut here) = (first_v, distances);
                for _ in 0..counts[1] {
                    let mut least = here[0];
                    for distance in &here[1..] {
                        least = least.fast_min(*distance);
                    }
                    // A positive number has no sign bit.
                    bits |= u64::from(!least.to_bitmask() & 15) << (group * LANES);
                    found.nodes[0][group] = w.to_array();
                    found.nodes[1][group] = u.to_array();
                    found.nodes[2][group] = v.to_array();
                    found.distances[group] = least.to_array();
                    group += 1;
                    if group == GROUPS {
                        found.visit(bits, &mut visit);
                        (bits, group) = (0, 0);
                    }

                    v += splat(1.0);
                    for (distance, normal) in here.iter_mut().zip(&self.normals) {
                        *distance += normal[2];
                    }
                }
                u += splat(1.0);
                for (distance, normal) in distances.iter_mut().zip(&self.normals) {
                    *distance += normal[1];
                }
            }
            w += splat(1.0);
        }
        found.visit(bits, &mut visit);
    }
}

impl Found {
    /// Visits the nodes whose bits are set.
    #[inline(always)]
    fn visit(&self, mut bits: u64, visit: &mut impl FnMut(Candidate<'_>)) {
        while bits != 0 {
            let bit = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let (group, lane) = (bit / LANES, bit % LANES);
            visit(Candidate { found: self, group, lane });
        }
    }
}

/// Returns the largest of four numbers, rounded down; at least 0.
#[inline(always)]
fn largest(numbers: f32x4) -> usize {
    let [a, b, c, d] = numbers.to_array().map(f64::from);
    floor_index(a.max(b).max(c.max(d)))
}

/// Returns four times the same number.
#[inline(always)]
pub(super) fn splat(x: f32) -> f32x4 {
    f32x4::splat(x)
}

/// Rounds to the nearest whole numbers, for magnitudes below 2^22.
#[inline(always)]
pub(super) fn round(x: f32x4) -> f32x4 {
    // At this magnitude neighboring numbers are 1 apart.
    let whole = splat(12_582_912.0); // 1.5 · 2^23
    (x + whole) - whole
}

/// Computes dot products.
#[inline(always)]
pub(super) fn dot(a: Vectors, b: Vectors) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Computes cross products.
#[inline(always)]
pub(super) fn cross(a: Vectors, b: Vectors) -> Vectors {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Computes sums of vectors.
#[inline(always)]
pub(super) fn add(a: Vectors, b: Vectors) -> Vectors {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Computes vectors of other lengths.
#[inline(always)]
pub(super) fn times(a: Vectors, factor: f32x4) -> Vectors {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// Computes vectors of the other direction.
#[inline(always)]
pub(super) fn negated(a: Vectors) -> Vectors {
    [-a[0], -a[1], -a[2]]
}
