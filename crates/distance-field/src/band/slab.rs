//! Planes of nodes that one task works on.

use std::ops::Range;

use glam::DVec3;

use super::ON_SURFACE;
use super::sides::Sides;
use crate::num::{coordinate, single, whole_index};

/// Squared distances and faces of the nodes of a slab.
pub(super) struct Nodes<'a> {
    pub(super) squared: &'a mut [f32],
    pub(super) face: &'a mut [u32],
}

/// Planes of nodes that one task works on.
pub(super) struct Slab<'a> {
    pub(super) number: usize,
    pub(super) dims: [usize; 3],
    pub(super) planes: Range<usize>,
    pub(super) band: f64,
    /// First and last node along each axis.
    pub(super) lowest: DVec3,
    pub(super) highest: DVec3,
    pub(super) nodes: Nodes<'a>,
    /// Sides of the region that is visited, in memory that is reused.
    pub(super) sides: Sides,
    /// Edges from the vertex that is visited, in memory that is reused.
    pub(super) edges: Vec<DVec3>,
}

impl<'a> Slab<'a> {
    pub(super) fn new(
        number: usize,
        dims: [usize; 3],
        planes: Range<usize>,
        band: f64,
        nodes: Nodes<'a>,
    ) -> Self {
        let lowest = DVec3::new(0.0, 0.0, coordinate(planes.start));
        let highest = DVec3::from_array([dims[0], dims[1], planes.end].map(coordinate)) - 1.0;
        let (sides, edges) = (Sides::default(), Vec::new());
        Self { number, dims, planes, band, lowest, highest, nodes, sides, edges }
    }

    /// Keeps the shorter distance of a node at `p` and the face that has it; nothing beyond the slab
    /// or the band.
    #[inline(always)]
    pub(super) fn keep(&mut self, p: DVec3, squared: f64, face: u32) {
        let is_within = self.lowest.cmple(p).all() && p.cmple(self.highest).all();
        if is_within && squared <= self.band * self.band {
            let [i, j, k] = [whole_index(p.x), whole_index(p.y), whole_index(p.z)];
            let index = i + self.dims[0] * (j + self.dims[1] * (k - self.planes.start));
            self.nodes.keep_nearer(index, single(squared), face + 1);
        }
    }
}

impl Nodes<'_> {
    /// Keeps the nearer of two faces, or the first of two as near.
    ///
    /// Selected without a branch: the processor goes on with other nodes while one comes from memory.
    #[inline(always)]
    pub(super) fn keep_nearer(&mut self, index: usize, squared: f32, face: u32) {
        // Numbers that are not negative are in the order of their bits.
        let (best, id) = (&mut self.squared[index], &mut self.face[index]);
        let key =
            |squared: f32, face: u32| u64::from(squared.abs().to_bits()) << 32 | u64::from(face);
        let is_nearer = (*id == 0) | (key(squared, face) < key(*best, *id));
        let squared = if squared == 0.0 { ON_SURFACE } else { squared };
        let mask = u32::from(is_nearer).wrapping_neg();
        *best = f32::from_bits(squared.to_bits() & mask | best.to_bits() & !mask);
        *id = face & mask | *id & !mask;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_faces_as_near_is_kept_in_any_order() {
        for squared in [0.0, 0.25] {
            for order in [[2, 5, 9], [9, 5, 2], [5, 2, 9]] {
                let (mut best, mut id) = ([0.0], [0]);
                let mut nodes = Nodes { squared: &mut best, face: &mut id };
                nodes.keep_nearer(0, 1.0, 1);
                for face in order {
                    nodes.keep_nearer(0, squared, face);
                }
                assert_eq!((best, id), ([squared], [2]), "{order:?}");
            }
        }
    }
}
