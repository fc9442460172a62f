//! Clusters: up to eight neighbouring leaves, whose own bounds are computed when asked for.

use crate::quad::Quad;
use crate::rows::{Packed, Rows};

/// Leaves a cluster holds at most.
///
/// Twice as many halve the nodes again, but a traversal that touches a cluster computes the bounds
/// of all its leaves; four make a refit read every point nearly twice as often.
pub(crate) const CLUSTER: usize = 8;
/// Quads that hold the bounds of a cluster's leaves.
pub(crate) const QUADS: usize = CLUSTER / 4;

/// A run of leaves in tree order, and the points they use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    /// Position of its first leaf in tree order.
    pub(crate) first_leaf: u32,
    /// Position of its first point in the list of points by cluster.
    pub(crate) first_point: u32,
    pub(crate) leaf_count: u8,
    pub(crate) point_count: u8,
    /// Corners of each leaf, as positions among the cluster's points.
    pub(crate) corners: [[u8; 3]; CLUSTER],
}

/// The leaves of a cluster, bounded: leaf `4 h + i` is lane `i` of quad `h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafQuads<const S: usize> {
    pub(crate) quads: [Quad<S>; QUADS],
    /// The union of each quad, for a first test.
    pub(crate) whole: [Packed; QUADS],
}

impl<const S: usize> LeafQuads<S> {
    pub(crate) const EMPTY: Self =
        Self { quads: [Quad::EMPTY; QUADS], whole: [Packed::EMPTY; QUADS] };

    /// Moves all bounds outward.
    pub(crate) fn widen(&mut self, margin: &[f32; S]) {
        for (quad, whole) in self.quads.iter_mut().zip(&mut self.whole) {
            *quad = quad.widened(margin);
            *whole = quad.enclosing();
        }
    }
}

impl Cluster {
    /// The cluster's points, as numbers of the caller's.
    #[inline(always)]
    pub(crate) fn points<'a>(&self, cluster_points: &'a [u32]) -> &'a [u32] {
        let first = self.first_point as usize;
        &cluster_points[first..first + self.point_count as usize]
    }

    /// Bound of the whole cluster.
    #[inline(always)]
    pub(crate) fn bound<const S: usize>(&self, cluster_points: &[u32], rows: &Rows<S>) -> Packed {
        let (lo, hi) = (rows.lo(), rows.hi());
        let mut bound = Packed::EMPTY;
        for &point in self.points(cluster_points) {
            bound.include(&lo[point as usize], &hi[point as usize]);
        }
        bound
    }

    /// Bounds its leaves.
    pub(crate) fn bound_leaves<const S: usize>(
        &self,
        cluster_points: &[u32],
        rows: &Rows<S>,
        bounds: &mut LeafQuads<S>,
    ) {
        let (lo, hi) = (rows.lo(), rows.hi());
        let points = self.points(cluster_points);
        for h in 0..QUADS {
            let mut leaves = [Packed::EMPTY; 4];
            let mut whole = Packed::EMPTY;
            for (i, leaf) in (4 * h..self.leaf_count as usize).zip(&mut leaves) {
                for corner in self.corners[i] {
                    let point = points[corner as usize] as usize;
                    leaf.include(&lo[point], &hi[point]);
                }
                whole.merge::<S>(leaf);
            }
            bounds.quads[h].set(&leaves);
            bounds.whole[h] = whole;
        }
    }

    /// The caller's numbers of the points of one of its leaves.
    #[inline(always)]
    pub(crate) fn corner_points(&self, leaf: usize, cluster_points: &[u32]) -> [u32; 3] {
        let points = self.points(cluster_points);
        self.corners[leaf].map(|corner| points[corner as usize])
    }
}
