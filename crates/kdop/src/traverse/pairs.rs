//! Pairs of leaves of two trees.
//!
//! Source: J. T. Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies
//! of k-DOPs", IEEE TVCG 4(1), 1998, section 5, with sixteen tests at a time. Where one side is a
//! cluster and the other still a node, only the node is descended, so trees of unequal depth lose
//! nothing. Pairs of clusters are gathered first; then the leaves of each cluster are bounded once.

use std::convert::Infallible;

use crate::cluster::{HALVES, LeafDops};
use crate::common_points::CommonPoints;
use crate::dop4::{ALL_PAIRS, SplatDop, set_bits};
use crate::node::Child;
use crate::tree::DopTree;
use crate::workspace::{Counters, Workspace};

/// Pairs that a descent comes to.
#[derive(Clone, Copy)]
pub(super) struct TestedPairs<'a> {
    /// Pairs of children that are tested of two nodes of one number: of a tree and itself, those on
    /// or above the diagonal are enough to list each pair once.
    pub(super) of_one_node: u32,
    /// Common points of the leaves of one tree, whose pairs are left out.
    pub(super) common: Option<&'a CommonPoints>,
}

impl TestedPairs<'_> {
    /// Returns true if no pair of leaves of two children is to be listed.
    #[inline(always)]
    fn excludes(&self, a: Child, b: Child) -> bool {
        self.common.is_some_and(|common| common.share(a, b))
    }
}

impl<const S: usize> DopTree<S> {
    /// Visits every pair of a leaf of this tree and one of the other whose bounds are within
    /// `margin` (a length, `>= 0`) of each other. Bounds that touch are.
    ///
    /// No pair of leaves within `margin` is left out. The margin is applied to the bounds of this
    /// tree as they are tested: no refit is needed, and 0 costs nothing. The order of visits
    /// depends on the two trees alone.
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
        let Ok(()) = self.try_pairs(other, margin, workspace, |leaf, of_other| {
            visit(leaf, of_other);
            Ok::<_, Infallible>(())
        });
    }

    /// As [`pairs`](Self::pairs), ended by the first error of `visit`.
    ///
    /// # Errors
    ///
    /// The error that ended it.
    pub fn try_pairs<E>(
        &self,
        other: &Self,
        margin: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        let margin = self.widening(margin);
        let tested = TestedPairs { of_one_node: ALL_PAIRS, common: None };
        self.gather_cluster_pairs(other, margin.as_ref(), tested, workspace);
        let bound = |cluster, bounds: &mut LeafDops<S>| {
            let cluster = self.clusters.get(cluster);
            self.clusters.bound_leaves(cluster, &self.projections, bounds);
            if let Some(margin) = &margin {
                bounds.widen(margin);
            }
        };
        self.visit_leaf_pairs(other, workspace, bound, visit)
    }

    /// Lists the pairs of clusters that overlap, by descent from the roots.
    pub(super) fn gather_cluster_pairs(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        tested: TestedPairs<'_>,
        workspace: &mut Workspace<S>,
    ) {
        workspace.counters = Counters::default();
        workspace.cluster_pairs.clear();
        workspace.node_pairs.clear();
        let root = Child::Node(0);
        if !self.nodes.is_empty() && !other.nodes.is_empty() && !tested.excludes(root, root) {
            workspace.node_pairs.push((0, 0));
        }
        while let Some(pair) = workspace.node_pairs.pop() {
            self.descend(other, margin, tested, pair, workspace);
        }
    }

    /// Tests the children of two nodes.
    ///
    /// Pairs of nodes that overlap go on the stack, pairs of clusters on the list.
    #[inline(always)]
    fn descend(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        tested: TestedPairs<'_>,
        (i, j): (u32, u32),
        workspace: &mut Workspace<S>,
    ) {
        let Workspace { node_pairs, nodes, cluster_pairs, counters, .. } = workspace;
        // The margin widens the bounds of this tree only.
        let (a, b) = (&self.nodes[i as usize], &other.nodes[j as usize]);
        let widened;
        let bounds = match margin {
            None => &a.bounds,
            Some(margin) => {
                widened = a.bounds.widened(margin);
                &widened
            }
        };

        let pairs = if i == j { tested.of_one_node } else { ALL_PAIRS };
        let hits = bounds.overlaps(&b.bounds, pairs);
        counters.bound_tests += 1;

        for bit in set_bits(hits) {
            let (lane_a, lane_b) = (bit / 4, bit % 4);
            let (child_a, child_b) = (a.children[lane_a].get(), b.children[lane_b].get());
            if tested.excludes(child_a, child_b) {
                continue;
            }
            match (child_a, child_b) {
                (Child::Node(x), Child::Node(y)) => node_pairs.push((x, y)),
                (Child::Cluster(x), Child::Cluster(y)) => cluster_pairs.push((x, y)),
                // One side has no more nodes: descend the other alone.
                (Child::Cluster(x), Child::Node(y)) => {
                    let bound = bounds.splat(lane_a);
                    let found = |y| cluster_pairs.push((x, y));
                    counters.bound_tests += other.clusters_below(y, &bound, nodes, found);
                }
                (Child::Node(x), Child::Cluster(y)) => {
                    let bound = match margin {
                        None => b.bounds.splat(lane_b),
                        Some(margin) => b.bounds.widened(margin).splat(lane_b),
                    };
                    let found = |x| cluster_pairs.push((x, y));
                    counters.bound_tests += self.clusters_below(x, &bound, nodes, found);
                }
                (Child::None, _) | (_, Child::None) => {}
            }
        }
    }

    /// Finds the clusters below a node that overlap one bound; returns the number of tests.
    pub(super) fn clusters_below(
        &self,
        node: u32,
        bound: &SplatDop<S>,
        stack: &mut Vec<u32>,
        mut found: impl FnMut(u32),
    ) -> u64 {
        let mut tests = 0;
        stack.clear();
        stack.push(node);
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            tests += 1;
            for lane in set_bits(node.bounds.overlaps_one(bound)) {
                match node.children[lane].get() {
                    Child::Node(below) => stack.push(below),
                    Child::Cluster(cluster) => found(cluster),
                    Child::None => {}
                }
            }
        }
        tests
    }

    /// Tests the leaves of every pair of clusters listed, until an error of `visit`; `bound` bounds
    /// those of this tree.
    pub(super) fn visit_leaf_pairs<E>(
        &self,
        other: &Self,
        workspace: &mut Workspace<S>,
        bound: impl Fn(u32, &mut LeafDops<S>),
        mut visit: impl FnMut(u32, u32) -> Result<(), E>,
    ) -> Result<(), E> {
        let Workspace { cluster_pairs, a: cache_a, b: cache_b, counters, .. } = workspace;
        cache_a.reset();
        cache_b.reset();
        for &(a, b) in &*cluster_pairs {
            counters.clusters += 1;
            let bounds_a = cache_a.get_with(a, |bounds| bound(a, bounds));
            let bounds_b = cache_b.get(other, b, None);
            let (a, b) = (self.clusters.get(a), other.clusters.get(b));

            // Unions of four leaves reject most halves before sixteen pairs are tested.
            for h in 0..HALVES * HALVES {
                let (half_a, half_b) = (h / HALVES, h % HALVES);
                if !bounds_a.unions[half_a].overlaps::<S>(&bounds_b.unions[half_b]) {
                    continue;
                }
                let hits = bounds_a.halves[half_a].overlaps(&bounds_b.halves[half_b], ALL_PAIRS);
                counters.bound_tests += 1;
                for bit in set_bits(hits) {
                    let leaf_a = self.leaf(a, 4 * half_a + bit / 4);
                    let leaf_b = other.leaf(b, 4 * half_b + bit % 4);
                    if let (Some(leaf_a), Some(leaf_b)) = (leaf_a, leaf_b) {
                        counters.reported += 1;
                        visit(leaf_a, leaf_b)?;
                    }
                }
            }
        }
        Ok(())
    }
}
