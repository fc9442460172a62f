//! Clusters of up to eight neighboring leaves, whose own bounds are computed on demand.

use std::ops::Range;

use crate::dop4::Dop4;
use crate::packed::PackedDop;
use crate::projections::Projections;

/// Maximum number of leaves per cluster.
///
/// Twice as many halve the nodes again, but a traversal that comes to a cluster computes the bounds
/// of all its leaves. Half as many make a refit read every point nearly twice as often.
pub(crate) const MAX_LEAVES: usize = 8;

/// Halves of a cluster: groups of four leaves, whose bounds are tested together.
pub(crate) const HALVES: usize = MAX_LEAVES / 4;

/// Run of leaves in tree order, and the points they use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cluster {
    /// Position of its first leaf in tree order.
    pub(crate) first_leaf: u32,
    /// Position of its first point in the points of all clusters.
    pub(crate) first_point: u32,
    pub(crate) leaf_count: u8,
    pub(crate) point_count: u8,
    /// Corners of each leaf, as positions among the points of the cluster.
    pub(crate) corners: [[u8; 3]; MAX_LEAVES],
}

impl Cluster {
    /// Returns the positions of its leaves in tree order.
    #[inline(always)]
    pub(crate) fn leaves(&self) -> Range<usize> {
        let first = self.first_leaf as usize;
        first..first + self.leaf_count as usize
    }

    /// Returns the positions of its points among those of all clusters.
    #[inline(always)]
    pub(crate) fn points(&self) -> Range<usize> {
        let first = self.first_point as usize;
        first..first + self.point_count as usize
    }

    /// Bounds every leaf; `rows` returns the lower and the upper row of a point of the cluster.
    #[inline(always)]
    pub(crate) fn bound_leaves<'a, const S: usize>(
        &self,
        bounds: &mut LeafDops<S>,
        rows: impl Fn(u8) -> [&'a [f32; S]; 2],
    ) {
        for h in 0..HALVES {
            // Lanes without a leaf stay empty, and overlap nothing.
            let mut leaves = [PackedDop::EMPTY; 4];
            let mut union = PackedDop::EMPTY;
            for (i, leaf) in (4 * h..self.leaf_count as usize).zip(&mut leaves) {
                *leaf = PackedDop::around(self.corners[i].map(&rows));
                union.merge::<S>(leaf);
            }
            bounds.halves[h].set(&leaves);
            bounds.unions[h] = union;
        }
    }
}

/// All clusters of a tree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Clusters {
    pub(crate) list: Vec<Cluster>,
    /// Points of each cluster without repetition, as numbered by the caller.
    pub(crate) points: Vec<u32>,
}

impl Clusters {
    /// Returns a cluster by number.
    #[inline(always)]
    pub(crate) fn get(&self, cluster: u32) -> &Cluster {
        &self.list[cluster as usize]
    }

    /// Returns the points of a cluster, as numbered by the caller.
    #[inline(always)]
    pub(crate) fn points_of(&self, cluster: &Cluster) -> &[u32] {
        &self.points[cluster.points()]
    }

    /// Returns the points of one leaf of a cluster, as numbered by the caller.
    #[inline(always)]
    pub(crate) fn corners_of(&self, cluster: &Cluster, leaf: usize) -> [u32; 3] {
        let points = self.points_of(cluster);
        cluster.corners[leaf].map(|corner| points[corner as usize])
    }

    /// Returns the size on the heap in bytes.
    pub(crate) const fn bytes(&self) -> usize {
        self.list.capacity() * size_of::<Cluster>() + self.points.capacity() * size_of::<u32>()
    }

    /// Bounds a whole cluster.
    #[inline(always)]
    pub(crate) fn bound<const S: usize>(
        &self,
        cluster: u32,
        projections: &Projections<S>,
    ) -> PackedDop {
        // A point that several leaves share is read once.
        let points = self.points_of(self.get(cluster));
        let mut bound = PackedDop::EMPTY;
        if let Some(rows) = projections.at_rest() {
            for &point in points {
                bound.include_point(&rows[point as usize]);
            }
            return bound;
        }
        let (lo, hi) = (projections.lo(), projections.hi());
        for &point in points {
            bound.include(&lo[point as usize], &hi[point as usize]);
        }
        bound
    }

    /// Bounds every leaf of a cluster.
    pub(crate) fn bound_leaves<const S: usize>(
        &self,
        cluster: &Cluster,
        projections: &Projections<S>,
        bounds: &mut LeafDops<S>,
    ) {
        let points = self.points_of(cluster);
        if let Some(rows) = projections.at_rest() {
            return cluster.bound_leaves(bounds, |corner| {
                let row = &rows[points[corner as usize] as usize];
                [row, row]
            });
        }
        let (lo, hi) = (projections.lo(), projections.hi());
        cluster.bound_leaves(bounds, |corner| {
            let point = points[corner as usize] as usize;
            [&lo[point], &hi[point]]
        });
    }

    /// Bounds every leaf of a cluster by its box, a third of the work of [`bound_leaves`](Self::bound_leaves).
    #[inline(always)]
    pub(crate) fn leaf_boxes<const S: usize>(
        &self,
        cluster: &Cluster,
        projections: &Projections<S>,
    ) -> [Dop4<3>; HALVES] {
        let (lo, hi) = (projections.lo(), projections.hi());
        let points = self.points_of(cluster);
        let mut boxes = [Dop4::EMPTY; HALVES];
        for (h, half) in boxes.iter_mut().enumerate() {
            let mut leaves = [PackedDop::EMPTY; 4];
            for (i, leaf) in (4 * h..cluster.leaf_count as usize).zip(&mut leaves) {
                for corner in cluster.corners[i] {
                    let point = points[corner as usize] as usize;
                    leaf.include_box(&lo[point], &hi[point]);
                }
            }
            half.set(&leaves);
        }
        boxes
    }
}

/// Bounds of the leaves of a cluster: leaf `4 h + i` is lane `i` of half `h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafDops<const S: usize> {
    pub(crate) halves: [Dop4<S>; HALVES],
    /// Union of each half, for a first test.
    pub(crate) unions: [PackedDop; HALVES],
}

impl<const S: usize> LeafDops<S> {
    pub(crate) const EMPTY: Self =
        Self { halves: [Dop4::EMPTY; HALVES], unions: [PackedDop::EMPTY; HALVES] };

    /// Moves all bounds outward.
    pub(crate) fn widen(&mut self, margin: &[f32; S]) {
        for (half, union) in self.halves.iter_mut().zip(&mut self.unions) {
            *half = half.widened(margin);
            *union = half.union();
        }
    }
}
