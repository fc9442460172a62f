//! 4-ary tree of k-DOPs (the source's quadtree): nodes over clusters of leaves.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::build::Arrangement;
use crate::cluster::{Cluster, Clusters, LeafDops};
use crate::dop::Dop;
use crate::error::TreeError;
use crate::extents::Extents;
use crate::leaves::Leaves;
use crate::neighbors::Neighbors;
use crate::node::{Child, ChildRef, Node};
use crate::projections::Projections;

/// 4-ary bounding volume hierarchy of k-DOPs (`k = 2 S`) over leaves that the caller numbers.
///
/// Every node holds the bounds of its four children side by side. Below the nodes are clusters of
/// up to eight leaves. The bounds of single leaves are computed from the projected points when a
/// traversal comes to their cluster, so every reported pair is one of single leaves.
///
/// A tree can be shared between threads; traversals write to a [`Workspace`](crate::Workspace).
/// The default tree has no leaves and overlaps nothing.
#[derive(Clone, Debug, Default)]
pub struct DopTree<const S: usize> {
    /// Parents before children.
    pub(crate) nodes: Vec<Node<S>>,
    pub(crate) clusters: Clusters,
    /// Leaves in tree order, as numbered by the caller.
    pub(crate) leaves: Vec<u32>,
    pub(crate) projections: Projections<S>,
    /// Summed widths of all children when the tree was built.
    built_size: f64,
    /// Found at the first traversal of the tree with itself.
    neighbors: OnceLock<Neighbors>,
    /// One for all clones of a tree: a refit leaves leaves and clusters as they are.
    origin: Arc<()>,
}

/// 4-ary tree of 18-DOPs.
pub type Tree = DopTree<9>;

impl<const S: usize> DopTree<S> {
    /// Builds a tree over leaves on points at rest (|P|).
    ///
    /// # Errors
    ///
    /// [`TreeError::PointOutOfRange`], [`TreeError::NonFinite`], or [`TreeError::TooMany`] before
    /// anything is allocated.
    pub fn build(leaves: Leaves<'_>, points: &[DVec3]) -> Result<Self, TreeError> {
        Self::build_from(leaves, Extents::Points(points))
    }

    /// Builds a tree as [`build`](Self::build), while `keep_going` returns true; `None` where it does
    /// not. It is called for every some thousand leaves.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree};
    ///
    /// let points = vec![DVec3::ZERO; 10_000];
    /// assert!(Tree::build_while(Leaves::Points, &points, &|| false)?.is_none());
    /// assert!(Tree::build_while(Leaves::Points, &points, &|| true)?.is_some());
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build).
    pub fn build_while(
        leaves: Leaves<'_>,
        points: &[DVec3],
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, TreeError> {
        Self::build_from_while(leaves, Extents::Points(points), keep_going)
    }

    /// Builds a tree over leaves on points at rest, swept points or balls.
    ///
    /// A tree without leaves is valid and overlaps nothing. The work is `O(n log n)`.
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build), [`TreeError::BadRadius`] and [`TreeError::WrongLength`].
    pub fn build_from(leaves: Leaves<'_>, extents: Extents<'_>) -> Result<Self, TreeError> {
        // Without an end the default tree is never returned.
        Ok(Self::build_from_while(leaves, extents, &|| true)?.unwrap_or_default())
    }

    fn build_from_while(
        leaves: Leaves<'_>,
        extents: Extents<'_>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, TreeError> {
        // Nothing is allocated before all input is checked.
        let count = leaves.validate(extents.len())?;
        extents.validate()?;

        // Arrange the leaves, then bound them as in a refit.
        let projections = Projections::new(&extents);
        let arrangement = Arrangement::new(leaves, count, &projections, keep_going);
        let Some(Arrangement { nodes, clusters, leaves }) = arrangement else { return Ok(None) };
        let (built_size, neighbors, origin) = (0.0, OnceLock::new(), Arc::default());
        let mut tree = Self { nodes, clusters, leaves, projections, built_size, neighbors, origin };
        tree.set_bounds();
        tree.built_size = tree.size();
        Ok(Some(tree))
    }

    /// Returns the number of leaves.
    #[must_use]
    pub const fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// Returns the number of points.
    #[must_use]
    pub const fn point_count(&self) -> usize {
        self.projections.len()
    }

    /// Returns the bound of all leaves; [`Dop::EMPTY`] without leaves.
    #[must_use]
    pub fn root(&self) -> Dop<S> {
        self.nodes.first().map_or(Dop::EMPTY, |root| root.bounds.union().to_dop())
    }

    /// Returns the bounds of every level, from the root to the single leaves, for pictures and
    /// statistics.
    ///
    /// The last level holds all leaves, at whatever depth their clusters are.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree};
    ///
    /// let points: Vec<DVec3> = (0..9).map(|i| DVec3::X * f64::from(i)).collect();
    /// let levels = Tree::build(Leaves::Points, &points)?.levels();
    /// // The root, its two clusters, nine leaves.
    /// assert_eq!(levels.iter().map(Vec::len).collect::<Vec<_>>(), [1, 2, 9]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    #[must_use]
    pub fn levels(&self) -> Vec<Vec<Dop<S>>> {
        if self.nodes.is_empty() {
            return vec![];
        }

        // Clusters have no children, so the last level of nodes ends the loop.
        let mut levels = vec![];
        let mut level = vec![(self.root(), ChildRef::node(0))];
        while !level.is_empty() {
            levels.push(level.iter().map(|(bound, _)| *bound).collect());
            level = level.into_iter().flat_map(|(_, child)| self.children(child)).collect();
        }
        levels.push(self.leaf_bounds());
        levels
    }

    /// Returns the children of a node with their bounds; nothing for a cluster.
    fn children(&self, child: ChildRef) -> Vec<(Dop<S>, ChildRef)> {
        let Child::Node(node) = child.get() else { return vec![] };
        let node = &self.nodes[node as usize];
        let mut children = Vec::with_capacity(4);
        for (lane, child) in node.children.into_iter().enumerate() {
            if child != ChildRef::NONE {
                children.push((node.bounds.lane(lane), child));
            }
        }
        children
    }

    /// Bounds all leaves, in tree order.
    fn leaf_bounds(&self) -> Vec<Dop<S>> {
        let mut leaf_dops = LeafDops::EMPTY;
        let mut bounds = Vec::with_capacity(self.leaves.len());
        for cluster in &self.clusters.list {
            self.clusters.bound_leaves(cluster, &self.projections, &mut leaf_dops);
            for i in 0..cluster.leaf_count as usize {
                bounds.push(leaf_dops.halves[i / 4].lane(i % 4));
            }
        }
        bounds
    }

    /// Returns the size on the heap in bytes.
    ///
    /// The first [`self_pairs`](Self::self_pairs) adds the adjacency of the leaves, some ten bytes
    /// per leaf of a closed surface, which is not counted.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node<S>>()
            + self.clusters.bytes()
            + self.leaves.capacity() * size_of::<u32>()
            + self.projections.bytes()
    }

    /// Returns the summed widths of all bounds, relative to those when the tree was built.
    ///
    /// Widths are along the widest direction of each bound, so 1 means as tight as at the build.
    /// Refits keep the arrangement of the build, so a large motion that separates the leaves of
    /// one node makes this grow.
    ///
    /// **Rebuild above 1.5**, a rule of thumb. A build can run on another thread, from a copy of the
    /// points, while this tree is still refitted.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree};
    ///
    /// // Twenty points on a line change places.
    /// let line: Vec<DVec3> = (0..20).map(|i| DVec3::X * f64::from(i)).collect();
    /// let shuffled: Vec<DVec3> = (0..20).map(|i| line[7 * i % 20]).collect();
    /// let mut tree = Tree::build(Leaves::Points, &line)?;
    /// assert_eq!(tree.looseness(), 1.0);
    ///
    /// tree.refit(&shuffled)?;
    /// assert!(tree.looseness() > 1.5);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    #[must_use]
    pub fn looseness(&self) -> f64 {
        if self.built_size > 0.0 { self.size() / self.built_size } else { 1.0 }
    }

    /// Sums the widths of all children of all nodes.
    fn size(&self) -> f64 {
        let mut size = 0.0;
        for node in &self.nodes {
            for width in node.bounds.widths() {
                size += f64::from(width);
            }
        }
        size
    }

    /// Returns true if the leaves of another tree have the same corners, in the same clusters; at once
    /// for a clone.
    pub(crate) fn has_arrangement_of(&self, other: &Self) -> bool {
        // Nodes follow from the number of leaves.
        Arc::ptr_eq(&self.origin, &other.origin)
            || (self.leaves == other.leaves && self.clusters == other.clusters)
    }

    /// Returns the adjacency of the clusters, found at the first call.
    pub(crate) fn neighbors(&self) -> &Neighbors {
        self.neighbors
            .get_or_init(|| Neighbors::find(&self.nodes, &self.clusters, self.point_count()))
    }

    /// Returns the caller's number of leaf `i` of a cluster, if the cluster has one.
    ///
    /// A margin as large as the range of f32 makes empty lanes overlap, too.
    #[inline(always)]
    pub(crate) fn leaf(&self, cluster: &Cluster, i: usize) -> Option<u32> {
        (i < cluster.leaf_count as usize).then(|| self.leaves[cluster.first_leaf as usize + i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points at rest have one row of nine numbers, balls have a row of lower and one of upper bounds.
    #[test]
    fn memory_counts_the_rows_of_all_points() {
        let centers: Vec<DVec3> = (0..500).map(|i| DVec3::X * f64::from(i)).collect();
        let balls = Extents::Balls { centers: &centers, radii: &[0.25; 500] };
        let at_rest = Tree::build(Leaves::Points, &centers).expect("points");
        let with_radii = Tree::build_from(Leaves::Points, balls).expect("balls");
        assert_eq!(with_radii.bytes() - at_rest.bytes(), 500 * 9 * 4);
        assert!(at_rest.bytes() > 500 * (9 * 4 + 4) + at_rest.clusters.bytes());
    }
}
