//! Pairs of leaves of one tree that share no point.

use std::convert::Infallible;
use std::ops::ControlFlow;

use super::unbroken;
use crate::cluster::{Cluster, LeafQuads, QUADS};
use crate::neighbours::Shared;
use crate::quad::BELOW_DIAGONAL;
use crate::tree::DopTree;
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits every pair of leaves (the lower number first) that share no point and whose bounds
    /// come within `margin` (a length, `>= 0`) of each other.
    ///
    /// Neighbours in a mesh always touch; leaving out leaves that share a point leaves the pairs
    /// that may collide.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.5, 0.1, 0.0)];
    /// let chain = Tree::build(Leaves::Edges(&[[0, 1], [1, 2], [2, 3]]), &points)?;
    /// let mut met = Vec::new();
    /// chain.self_pairs(0.2, &mut Workspace::default(), |a, b| met.push((a, b)));
    /// assert_eq!(met, [(0, 2)]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn self_pairs(
        &self,
        margin: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32),
    ) {
        unbroken(self.try_self_pairs(margin, workspace, |a, b| {
            visit(a, b);
            ControlFlow::<Infallible>::Continue(())
        }));
    }

    /// As [`self_pairs`](Self::self_pairs), but ends as soon as a visit breaks.
    pub fn try_self_pairs<B>(
        &self,
        margin: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let margin = self.widening(margin);
        self.gather_self_pairs(margin.as_ref(), workspace);
        self.visit_leaf_self_pairs(margin.as_ref(), workspace, visit)
    }

    /// Lists the pairs of clusters of this tree that meet.
    pub(super) fn gather_self_pairs(
        &self,
        margin: Option<&[f32; S]>,
        workspace: &mut Workspace<S>,
    ) {
        workspace.counters = Counters::default();
        workspace.cluster_pairs.clear();
        workspace.node_pairs.clear();
        if !self.nodes.is_empty() {
            workspace.node_pairs.push((0, 0));
        }
        self.gather_cluster_pairs(self, margin, workspace);
    }

    /// Tests the leaves of every pair of clusters found.
    pub(super) fn visit_leaf_self_pairs<B>(
        &self,
        margin: Option<&[f32; S]>,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let neighbours = self.neighbours();
        let Workspace { cluster_pairs, a: cache_a, b: cache_b, counters, .. } = workspace;
        cache_a.reset();
        cache_b.reset();
        for &(a, b) in &*cluster_pairs {
            let (a, b) = (a.min(b), a.max(b));
            counters.clusters += 1;
            let bounds_a = cache_a.get(self, a, margin);
            let bounds_b = cache_b.get(self, b, None);
            let crowded = neighbours.are_crowded(a, b);
            let shared = neighbours.shared(a, b);
            let (cluster_a, cluster_b) = (&self.clusters[a as usize], &self.clusters[b as usize]);
            let mut halves = overlapping_halves(bounds_a, bounds_b, &shared);
            if a == b {
                halves &= !SECOND_WITH_FIRST;
            }
            while halves != 0 {
                let h = halves.trailing_zeros() as usize;
                halves &= halves - 1;
                let (ha, hb) = (h / QUADS, h % QUADS);
                let hits = bounds_a.quads[ha].overlaps(&bounds_b.quads[hb]);
                counters.quad_tests += 1;
                let mut hits = hits & !u32::from(shared[h]);
                if a == b && ha == hb {
                    hits &= BELOW_DIAGONAL;
                }
                while hits != 0 {
                    let bit = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let (i, j) = (4 * ha + bit / 4, 4 * hb + bit % 4);
                    if crowded && self.share_a_point((cluster_a, i), (cluster_b, j)) {
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
        ControlFlow::Continue(())
    }

    fn share_a_point(&self, (a, i): (&Cluster, usize), (b, j): (&Cluster, usize)) -> bool {
        let theirs = b.corner_points(j, &self.cluster_points);
        a.corner_points(i, &self.cluster_points).iter().any(|point| theirs.contains(point))
    }
}

/// The bit of the second half of a cluster with its first.
const SECOND_WITH_FIRST: u32 = 1 << QUADS;

/// Which halves of two clusters overlap and are not all neighbours: bit `QUADS · ha + hb`.
///
/// About every other one does, so all are tested without a branch.
#[inline(always)]
fn overlapping_halves<const S: usize>(a: &LeafQuads<S>, b: &LeafQuads<S>, shared: &Shared) -> u32 {
    (0..QUADS * QUADS).fold(0, |halves, h| {
        let overlap = a.whole[h / QUADS].overlaps::<S>(&b.whole[h % QUADS]);
        halves | u32::from(overlap & (shared[h] != u16::MAX)) << h
    })
}
