//! Pairs of leaves of one tree that share no point.

use std::convert::Infallible;
use std::ops::ControlFlow;

use super::unbroken;
use crate::cluster::{Cluster, QUADS};
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
        workspace.counters = Counters::default();
        workspace.cluster_pairs.clear();
        workspace.node_pairs.clear();
        if !self.nodes.is_empty() {
            workspace.node_pairs.push((0, 0));
        }
        self.gather_cluster_pairs(self, self.widening(margin).as_ref(), workspace);
        self.visit_leaf_self_pairs(margin, workspace, visit)
    }

    /// Tests the leaves of every pair of clusters found. Both sides read the same bounds, so each
    /// is moved outward by half the margin.
    pub(super) fn visit_leaf_self_pairs<B>(
        &self,
        margin: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let half_margin = self.widening(0.5 * margin);
        let half_margin = half_margin.as_ref();
        let neighbours = self.neighbours();
        let Workspace { cluster_pairs, a: cache, counters, .. } = workspace;
        cache.reset(self.clusters.len());
        for &(a, b) in &*cluster_pairs {
            let (a, b) = (a.min(b), a.max(b));
            counters.clusters += 1;
            let slot_a = cache.slot(self, a, half_margin);
            let slot_b = cache.slot(self, b, half_margin);
            let (bounds_a, bounds_b) = (cache.get(slot_a), cache.get(slot_b));
            let crowded = neighbours.are_crowded(a, b);
            let shared = neighbours.shared(a, b);
            let (cluster_a, cluster_b) = (&self.clusters[a as usize], &self.clusters[b as usize]);
            for (h, shared) in shared.into_iter().enumerate() {
                let (ha, hb) = (h / QUADS, h % QUADS);
                if shared == u16::MAX
                    || a == b && ha > hb
                    || !bounds_a.whole[ha].overlaps::<S>(&bounds_b.whole[hb])
                {
                    continue;
                }
                let hits = bounds_a.quads[ha].overlaps(&bounds_b.quads[hb]);
                counters.quad_tests += 1;
                let mut hits = hits & !u32::from(shared);
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
