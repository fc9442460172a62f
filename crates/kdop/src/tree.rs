//! The tree: quad nodes over clusters of leaves.

use std::sync::OnceLock;

use glam::DVec3;

use crate::cluster::{Cluster, LeafQuads};
use crate::dop::Dop;
use crate::error::TreeError;
use crate::extents::Extents;
use crate::leaves::{LIMIT, Leaves};
use crate::neighbours::Neighbours;
use crate::quad::Quad;
use crate::rows::Rows;

/// A quadtree of k-DOPs (`k = 2 S`) over leaves that the caller numbers.
///
/// Every node holds the bounds of its four children side by side. Below the nodes are clusters of
/// up to eight leaves; a leaf's own bound is computed from the projected points when a traversal
/// comes near it, so what is reported are always pairs of single leaves.
///
/// A tree is shared freely between threads; traversals write to a [`Workspace`](crate::Workspace).
#[derive(Clone, Debug)]
pub struct DopTree<const S: usize> {
    /// Parents before children.
    pub(crate) nodes: Vec<Node<S>>,
    pub(crate) clusters: Vec<Cluster>,
    /// The points of each cluster, without repetition.
    pub(crate) cluster_points: Vec<u32>,
    /// The caller's number of every leaf in tree order.
    pub(crate) leaves: Vec<u32>,
    pub(crate) rows: Rows<S>,
    /// Sum of the children's widths when the tree was built.
    pub(crate) built_size: f64,
    /// Found at the first traversal of the tree with itself.
    neighbours: OnceLock<Neighbours>,
}

/// A quadtree of 18-DOPs: the volume that pays best for muscles.
pub type Tree = DopTree<9>;

/// Four children and their bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<const S: usize> {
    pub(crate) quad: Quad<S>,
    pub(crate) children: [Child; 4],
}

/// Where a child is: the number of a node, or of a cluster with the highest bit set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Child(u32);

/// What a [`Child`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Below {
    Node(u32),
    Cluster(u32),
    Nothing,
}

impl Child {
    pub(crate) const NOTHING: Self = Self(u32::MAX);
    const CLUSTER: u32 = 1 << 31;

    pub(crate) const fn node(node: u32) -> Self {
        Self(node)
    }

    pub(crate) const fn cluster(cluster: u32) -> Self {
        Self(cluster | Self::CLUSTER)
    }

    #[inline(always)]
    pub(crate) const fn below(self) -> Below {
        if self.0 & Self::CLUSTER == 0 {
            Below::Node(self.0)
        } else if self.0 == u32::MAX {
            Below::Nothing
        } else {
            Below::Cluster(self.0 & !Self::CLUSTER)
        }
    }
}

impl<const S: usize> Default for DopTree<S> {
    /// Returns a tree without leaves, which overlaps nothing.
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            clusters: Vec::new(),
            cluster_points: Vec::new(),
            leaves: Vec::new(),
            rows: Rows::new(),
            built_size: 0.0,
            neighbours: OnceLock::new(),
        }
    }
}

impl<const S: usize> DopTree<S> {
    /// Builds a tree over leaves on points at rest (|P|).
    ///
    /// # Errors
    ///
    /// [`TreeError::PointOutOfRange`], [`TreeError::NonFinite`], or [`TreeError::TooMany`] before
    /// anything is allocated.
    pub fn build(leaves: Leaves<'_>, points: &[DVec3]) -> Result<Self, TreeError> {
        Self::build_from(leaves, Extents::points(points))
    }

    /// Builds a tree over leaves on points, balls or boxes, at rest or moving.
    ///
    /// No leaves make a valid tree that overlaps nothing. The work is `O(n log n)`.
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build), and [`TreeError::BadRadius`], [`TreeError::InvertedBox`] or
    /// [`TreeError::WrongLength`].
    pub fn build_from(leaves: Leaves<'_>, extents: Extents<'_>) -> Result<Self, TreeError> {
        let count = leaves.check(extents.len())?;
        extents.check()?;
        let mut tree = Self::default();
        tree.rows.fill(&extents);
        crate::build::arrange(&mut tree, leaves, count);
        tree.sweep();
        tree.built_size = tree.size();
        Ok(tree)
    }

    /// How many leaves it bounds.
    #[must_use]
    pub const fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// How many points its leaves are made of.
    #[must_use]
    pub const fn point_count(&self) -> usize {
        self.rows.len()
    }

    /// The bound of everything; [`Dop::EMPTY`] without leaves.
    #[must_use]
    pub fn root(&self) -> Dop<S> {
        self.nodes.first().map_or(Dop::EMPTY, |root| root.quad.enclosing().to_dop())
    }

    /// The bounds of every level, from the root to the single leaves: for pictures and statistics.
    ///
    /// Leaves that hang higher than others stand in the last level alone.
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
        let mut levels = vec![];
        let mut row: Vec<(Dop<S>, Child)> =
            self.nodes.first().map(|_| (self.root(), Child::node(0))).into_iter().collect();
        while !row.is_empty() {
            levels.push(row.iter().map(|(bound, _)| *bound).collect());
            row = row.into_iter().flat_map(|(_, child)| self.children(child)).collect();
        }
        if !self.clusters.is_empty() {
            levels.push(self.leaf_bounds());
        }
        levels
    }

    /// The children of a node, and their bounds.
    fn children(&self, child: Child) -> Vec<(Dop<S>, Child)> {
        let Below::Node(node) = child.below() else { return vec![] };
        let node = &self.nodes[node as usize];
        let children = node.children.into_iter().enumerate();
        let present = children.filter(|(_, child)| *child != Child::NOTHING);
        present.map(|(lane, child)| (node.quad.lane(lane), child)).collect()
    }

    /// Bounds of all leaves in tree order.
    fn leaf_bounds(&self) -> Vec<Dop<S>> {
        let mut quads = LeafQuads::EMPTY;
        let mut bounds = Vec::with_capacity(self.leaves.len());
        for cluster in &self.clusters {
            cluster.bound_leaves(&self.cluster_points, &self.rows, &mut quads);
            let lane = |i: usize| quads.quads[i / 4].lane(i % 4);
            bounds.extend((0..cluster.leaf_count as usize).map(lane));
        }
        bounds
    }

    /// Bytes it occupies on the heap, without what the first traversal of the tree with itself adds:
    /// which leaves share points, some ten bytes a leaf of a closed surface.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node<S>>()
            + self.clusters.capacity() * size_of::<Cluster>()
            + (self.cluster_points.capacity() + self.leaves.capacity()) * size_of::<u32>()
            + self.rows.bytes()
    }

    /// How loose the bounds have become: the summed widths of all nodes over those when built.
    ///
    /// Widths are along the widest direction of each child, so 1 means as tight as then. Refits
    /// keep the arrangement of the build; a large motion that brings distant leaves of one node
    /// apart makes it grow. A muscle twisted by 120° reaches 1.02 and is traversed about as fast as
    /// a tree built anew; a surface that tears or changes its topology goes far beyond.
    ///
    /// **Rebuild above 1.5**, a rule of thumb: a build takes as long as some thirty refits, so it
    /// pays within a second of frames. It can run on another thread, from a copy of the points,
    /// while this tree is still refitted.
    #[must_use]
    pub fn looseness(&self) -> f64 {
        if self.built_size > 0.0 { self.size() / self.built_size } else { 1.0 }
    }

    /// Which leaves share points.
    pub(crate) fn neighbours(&self) -> &Neighbours {
        self.neighbours.get_or_init(|| Neighbours::of(self))
    }

    /// Sum of the widths of all children of all nodes.
    fn size(&self) -> f64 {
        let widths = |node: &Node<S>| (0..4).map(|lane| node.quad.lane(lane).width()).sum::<f64>();
        self.nodes.iter().map(widths).sum()
    }

    /// Number of leaves and of points that a tree must stay below.
    pub const LIMIT: usize = LIMIT;
}
