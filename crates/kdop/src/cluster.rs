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

    /// Bounds of its leaves.
    pub(crate) fn leaf_quads<const S: usize>(
        &self,
        cluster_points: &[u32],
        rows: &Rows<S>,
    ) -> LeafQuads<S> {
        let (lo, hi) = (rows.lo(), rows.hi());
        let points = self.points(cluster_points);
        let bound = |leaf: usize| {
            let mut bound = Packed::EMPTY;
            if leaf < self.leaf_count as usize {
                for corner in self.corners[leaf] {
                    let point = points[corner as usize] as usize;
                    bound.include(&lo[point], &hi[point]);
                }
            }
            bound
        };
        let quads =
            std::array::from_fn(|h| Quad::from_packed(&std::array::from_fn(|i| bound(4 * h + i))));
        let whole = std::array::from_fn(|h: usize| {
            let quad: &Quad<S> = &quads[h];
            quad.enclosing()
        });
        LeafQuads { quads, whole }
    }

    /// The caller's numbers of the points of one of its leaves.
    #[inline(always)]
    pub(crate) fn corner_points(&self, leaf: usize, cluster_points: &[u32]) -> [u32; 3] {
        let points = self.points(cluster_points);
        self.corners[leaf].map(|corner| points[corner as usize])
    }
}
