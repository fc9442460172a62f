//! Pairs of leaves of two trees.
//!
//! Source: J. T. Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies
//! of k-DOPs", IEEE TVCG 4(1), 1998, section 5, with sixteen tests at a time. Where one side is a
//! cluster and the other still a node, the node alone is descended, so trees of unequal depth lose
//! nothing. Pairs of clusters are gathered first; then the leaves of each cluster are bounded once.

use std::convert::Infallible;
use std::ops::ControlFlow;

use super::unbroken;
use crate::cluster::{Cluster, QUADS};
use crate::quad::{BELOW_OR_ON_DIAGONAL, Splat};
use crate::tree::{Below, DopTree};
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits every pair of a leaf of this tree and one of the other whose bounds come within
    /// `margin` (a length, `>= 0`) of each other; touching bounds do.
    ///
    /// No pair of leaves within `margin` is left out. The margin is applied to this tree's bounds
    /// as they are tested: no refit is needed, and 0 costs nothing. The order of visits depends on
    /// the two trees alone.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let a = Tree::build(Leaves::Points, &[DVec3::ZERO, DVec3::X * 3.0])?;
    /// let b = Tree::build(Leaves::Points, &[DVec3::X])?;
    /// let mut near = Vec::new();
    /// a.pairs(&b, 1.5, &mut Workspace::default(), |i, j| near.push((i, j)));
    /// assert_eq!(near, [(0, 0)]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn pairs(
        &self,
        other: &Self,
        margin: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32),
    ) {
        unbroken(self.try_pairs(other, margin, workspace, |a, b| {
            visit(a, b);
            ControlFlow::<Infallible>::Continue(())
        }));
    }

    /// As [`pairs`](Self::pairs), but ends as soon as a visit breaks.
    pub fn try_pairs<B>(
        &self,
        other: &Self,
        margin: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let margin = self.widening(margin);
        let margin = margin.as_ref();
        workspace.counters = Counters::default();
        workspace.cluster_pairs.clear();
        workspace.node_pairs.clear();
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            workspace.node_pairs.push((0, 0));
        }
        self.gather_cluster_pairs(other, margin, workspace);
        self.visit_leaf_pairs(other, margin, workspace, visit)
    }

    /// Descends from the pairs of nodes on the stack to pairs of clusters. For a tree and itself,
    /// each pair is met once.
    pub(super) fn gather_cluster_pairs(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        workspace: &mut Workspace<S>,
    ) {
        while let Some(pair) = workspace.node_pairs.pop() {
            self.descend(other, margin, pair, workspace);
        }
    }

    /// Tests the children of two nodes; pairs of nodes go on the stack, pairs of clusters on the
    /// list.
    #[inline(always)]
    pub(super) fn descend(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        (i, j): (u32, u32),
        workspace: &mut Workspace<S>,
    ) {
        let Workspace { node_pairs, nodes, cluster_pairs, counters, .. } = workspace;
        let (a, b) = (&self.nodes[i as usize], &other.nodes[j as usize]);
        let widened;
        let quad = match margin {
            None => &a.quad,
            Some(margin) => {
                widened = a.quad.widened(margin);
                &widened
            }
        };
        let mut hits = quad.overlaps(&b.quad);
        counters.quad_tests += 1;
        if i == j && std::ptr::eq(self, other) {
            hits &= BELOW_OR_ON_DIAGONAL;
        }
        while hits != 0 {
            let bit = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let (lane_a, lane_b) = (bit / 4, bit % 4);
            match (a.children[lane_a].below(), b.children[lane_b].below()) {
                (Below::Node(x), Below::Node(y)) => node_pairs.push((x, y)),
                (Below::Cluster(x), Below::Cluster(y)) => cluster_pairs.push((x, y)),
                (Below::Cluster(x), Below::Node(y)) => {
                    let bound = quad.splat(lane_a);
                    let found = |y| cluster_pairs.push((x, y));
                    counters.quad_tests += other.clusters_below(y, &bound, nodes, found);
                }
                (Below::Node(x), Below::Cluster(y)) => {
                    let bound = match margin {
                        None => b.quad.splat(lane_b),
                        Some(margin) => b.quad.widened(margin).splat(lane_b),
                    };
                    let found = |x| cluster_pairs.push((x, y));
                    counters.quad_tests += self.clusters_below(x, &bound, nodes, found);
                }
                (Below::Nothing, _) | (_, Below::Nothing) => {}
            }
        }
    }

    /// Finds the clusters below a node that one bound overlaps; returns how many tests it took.
    fn clusters_below(
        &self,
        node: u32,
        bound: &Splat<S>,
        stack: &mut Vec<u32>,
        mut found: impl FnMut(u32),
    ) -> u64 {
        let mut tests = 0;
        stack.clear();
        stack.push(node);
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            let mut hits = node.quad.overlaps_one(bound);
            tests += 1;
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                match node.children[lane].below() {
                    Below::Node(below) => stack.push(below),
                    Below::Cluster(cluster) => found(cluster),
                    Below::Nothing => {}
                }
            }
        }
        tests
    }

    /// Tests the leaves of every pair of clusters found.
    pub(super) fn visit_leaf_pairs<B>(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let Workspace { cluster_pairs, a: cache_a, b: cache_b, counters, .. } = workspace;
        cache_a.reset();
        cache_b.reset();
        for &(a, b) in &*cluster_pairs {
            counters.clusters += 1;
            let bounds_a = cache_a.get(self, a, margin);
            let bounds_b = cache_b.get(other, b, None);
            let (a, b) = (&self.clusters[a as usize], &other.clusters[b as usize]);
            for h in 0..QUADS * QUADS {
                let (ha, hb) = (h / QUADS, h % QUADS);
                if !bounds_a.whole[ha].overlaps::<S>(&bounds_b.whole[hb]) {
                    continue;
                }
                let mut hits = bounds_a.quads[ha].overlaps(&bounds_b.quads[hb]);
                counters.quad_tests += 1;
                while hits != 0 {
                    let bit = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let leaf_a = self.leaf(a, 4 * ha + bit / 4);
                    let leaf_b = other.leaf(b, 4 * hb + bit % 4);
                    if let (Some(leaf_a), Some(leaf_b)) = (leaf_a, leaf_b) {
                        counters.reported += 1;
                        visit(leaf_a, leaf_b)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The caller's number of leaf `i` of a cluster. There may be none: a margin as large as the
    /// range of f32 makes empty lanes overlap too.
    #[inline(always)]
    pub(super) fn leaf(&self, cluster: &Cluster, i: usize) -> Option<u32> {
        (i < cluster.leaf_count as usize).then(|| self.leaves[cluster.first_leaf as usize + i])
    }
}
