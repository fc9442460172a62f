//! Pairs of leaves of one tree that share no point.

use std::convert::Infallible;

use crate::cluster::{Cluster, HALVES, LeafDops};
use crate::dop4::{ABOVE_DIAGONAL, ALL_PAIRS, ON_OR_ABOVE_DIAGONAL, set_bits};
use crate::neighbors::SharedPairs;
use crate::traverse::pairs::TestedPairs;
use crate::tree::DopTree;
use crate::workspace::Workspace;

impl<const S: usize> DopTree<S> {
    /// Visits every pair of leaves (the lower number first) that share no point and whose bounds
    /// are within `margin` (a length, `>= 0`) of each other.
    ///
    /// Neighbors in a mesh always touch. Without leaves that share a point, the pairs that may
    /// collide remain. A fan about one point takes no longer than other leaves; leaves about
    /// several points in the same place take time by the square of their number.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.5, 0.1, 0.0)];
    /// let chain = Tree::build(Leaves::Edges(&[[0, 1], [1, 2], [2, 3]]), &points)?;
    /// let mut near = Vec::new();
    /// chain.self_pairs(0.2, &mut Workspace::default(), |a, b| near.push((a, b)));
    /// assert_eq!(near, [(0, 2)]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn self_pairs(
        &self,
        margin: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32),
    ) {
        let Ok(()) = self.try_self_pairs(margin, workspace, |first, second| {
            visit(first, second);
            Ok::<_, Infallible>(())
        });
    }

    /// As [`self_pairs`](Self::self_pairs), ended by the first error of `visit`.
    ///
    /// # Errors
    ///
    /// The error that ended it.
    pub fn try_self_pairs<E>(
        &self,
        margin: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        let margin = self.widening(margin);
        // Of a node and itself, every pair of children is tested in one order only.
        // Nodes whose leaves all share a point have no pairs.
        let tested = TestedPairs {
            of_one_node: ON_OR_ABOVE_DIAGONAL,
            common: self.neighbors().common.as_ref(),
        };
        self.gather_cluster_pairs(self, margin.as_ref(), tested, workspace);
        self.visit_leaf_self_pairs(margin.as_ref(), workspace, visit)
    }

    /// Tests the leaves of every pair of clusters listed, until an error of `visit`.
    fn visit_leaf_self_pairs<E>(
        &self,
        margin: Option<&[f32; S]>,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        let neighbors = self.neighbors();
        let Workspace { cluster_pairs, a: cache_a, b: cache_b, counters, .. } = workspace;
        cache_a.reset();
        cache_b.reset();
        for &(a, b) in &*cluster_pairs {
            let (a, b) = (a.min(b), a.max(b));
            counters.clusters += 1;
            // Without a margin both caches hold the same bounds, and each copies from the other.
            if margin.is_none() {
                cache_a.load(self, a, cache_b);
                cache_b.load(self, b, cache_a);
            }
            let bounds_a = cache_a.get(self, a, margin);
            let bounds_b = cache_b.get(self, b, None);
            let crowded = neighbors.are_crowded(a, b);
            let shared = neighbors.shared(a, b);
            let (cluster_a, cluster_b) = (self.clusters.get(a), self.clusters.get(b));

            // Of a cluster and itself, every pair of halves is tested in one order only.
            let mut halves = overlapping_halves(bounds_a, bounds_b, &shared);
            if a == b {
                halves &= !SECOND_WITH_FIRST;
            }
            for h in set_bits(halves) {
                let (half_a, half_b) = (h / HALVES, h % HALVES);

                // Leaves that share a point are neighbors, not candidates.
                let is_same = a == b && half_a == half_b;
                let pairs = if is_same { ABOVE_DIAGONAL } else { ALL_PAIRS };
                let pairs = pairs & !u32::from(shared[h]);
                let hits = bounds_a.halves[half_a].overlaps(&bounds_b.halves[half_b], pairs);
                counters.bound_tests += 1;

                for bit in set_bits(hits) {
                    let (i, j) = (4 * half_a + bit / 4, 4 * half_b + bit % 4);
                    // Neighbors at a crowded point are not listed.
                    if crowded && self.share_a_point(cluster_a, i, cluster_b, j) {
                        continue;
                    }
                    let pair = (self.leaf(cluster_a, i), self.leaf(cluster_b, j));
                    if let (Some(leaf_a), Some(leaf_b)) = pair {
                        counters.reported += 1;
                        visit(leaf_a.min(leaf_b), leaf_a.max(leaf_b))?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns true if leaf `i` of cluster `a` and leaf `j` of cluster `b` share a point.
    fn share_a_point(&self, a: &Cluster, i: usize, b: &Cluster, j: usize) -> bool {
        let others = self.clusters.corners_of(b, j);
        self.clusters.corners_of(a, i).iter().any(|point| others.contains(point))
    }
}

/// The bit of the second half of a cluster with its first.
const SECOND_WITH_FIRST: u32 = 1 << HALVES;

/// Tests the halves of two clusters: bit `HALVES · half_a + half_b` is set where they overlap and
/// are not all neighbors.
///
/// About every other pair overlaps, so all are tested without a branch.
#[inline(always)]
fn overlapping_halves<const S: usize>(
    a: &LeafDops<S>,
    b: &LeafDops<S>,
    shared: &SharedPairs,
) -> u32 {
    let mut halves = 0;
    for (h, shared) in shared.iter().enumerate() {
        let overlap = a.unions[h / HALVES].overlaps::<S>(&b.unions[h % HALVES]);
        halves |= u32::from(overlap & (*shared != u16::MAX)) << h;
    }
    halves
}
