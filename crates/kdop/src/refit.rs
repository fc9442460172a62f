//! Refits: new projections, then one sweep from the last node to the first.
//!
//! Source: J. Mezger et al., "Hierarchical Techniques in Collision Detection for Cloth Animation",
//! Journal of WSCG 11(1), 2003, section 4, and the linear sweep of bounding volume hierarchies
//! whose parents stand before their children. Differs in what is written: a cluster's bound comes
//! straight from its points, each taken once, not from bounds of leaves.

use glam::DVec3;

use crate::cluster::Cluster;
use crate::dop::Dop;
use crate::error::{InvalidTree, TreeError};
use crate::extents::{Extents, check_length};
use crate::rows::{Packed, Rows};
use crate::tree::{Below, Child, DopTree, Node};

impl<const S: usize> DopTree<S> {
    /// Bounds the leaves anew, with their points at rest at `points` (|P|).
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`] or [`TreeError::NonFinite`]; the tree is then unchanged.
    pub fn refit(&mut self, points: &[DVec3]) -> Result<(), TreeError> {
        self.refit_from(Extents::points(points))
    }

    /// Bounds the leaves over a step: their points move straight from `before` to `after` (|P|).
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`] or [`TreeError::NonFinite`]; the tree is then unchanged.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let wall = Tree::build(Leaves::Points, &[DVec3::X * 5.0])?;
    /// let mut ball = Tree::build(Leaves::Points, &[DVec3::ZERO])?;
    /// ball.refit_swept(&[DVec3::ZERO], &[DVec3::X * 10.0])?;
    /// let mut met = 0;
    /// wall.pairs(&ball, 0.0, &mut Workspace::default(), |_, _| met += 1);
    /// assert_eq!(met, 1, "on the way");
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn refit_swept(&mut self, before: &[DVec3], after: &[DVec3]) -> Result<(), TreeError> {
        self.refit_from(Extents::swept(before, after))
    }

    /// Bounds the leaves anew over points, balls or boxes, at rest or moving.
    ///
    /// Nothing is allocated, except when a tree bounds other things than points at rest for the
    /// first time. The work is linear.
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`], [`TreeError::NonFinite`], [`TreeError::BadRadius`] or
    /// [`TreeError::InvertedBox`]; the tree is then unchanged.
    pub fn refit_from(&mut self, extents: Extents<'_>) -> Result<(), TreeError> {
        check_length(extents.len(), self.point_count())?;
        extents.check()?;
        self.rows.fill(&extents);
        self.sweep();
        Ok(())
    }

    /// As [`refit_from`](Self::refit_from), on the threads of the current pool. The bounds are the
    /// same to the bit. It pays from some fifty thousand leaves.
    ///
    /// # Errors
    ///
    /// Those of [`refit_from`](Self::refit_from); the tree is then unchanged.
    #[cfg(feature = "rayon")]
    pub fn par_refit_from(&mut self, extents: Extents<'_>) -> Result<(), TreeError> {
        check_length(extents.len(), self.point_count())?;
        extents.check()?;
        self.rows.par_fill(&extents);
        let (nodes, leaves) = self.nodes_and_leaves();
        leaves.par_sweep(nodes, 0);
        Ok(())
    }

    /// Sets every node's bounds, children first.
    pub(crate) fn sweep(&mut self) {
        let (nodes, leaves) = self.nodes_and_leaves();
        leaves.sweep(nodes, 0);
    }

    fn nodes_and_leaves(&mut self) -> (&mut [Node<S>], Clusters<'_, S>) {
        let Self { nodes, clusters, cluster_points, rows, .. } = self;
        (nodes, Clusters { clusters, cluster_points, rows })
    }

    /// Checks that the tree is whole: every leaf in it once, every child after its parent and of
    /// one parent, every bound the exact union of what lies below.
    ///
    /// # Errors
    ///
    /// The first defect found.
    pub fn validate(&self) -> Result<(), InvalidTree> {
        self.check_clusters()?;
        self.check_children()?;
        for (node, children) in self.nodes.iter().map(|node| node.children).enumerate() {
            for (child, below) in children.into_iter().enumerate() {
                let stored = self.nodes[node].quad.lane(child);
                if stored != self.union_below(below) {
                    return Err(InvalidTree::Bound { node, child });
                }
            }
        }
        Ok(())
    }

    fn check_clusters(&self) -> Result<(), InvalidTree> {
        let mut times = vec![0_usize; self.leaves.len()];
        for (cluster, held) in self.clusters.iter().enumerate() {
            let first = held.first_leaf as usize;
            let leaves = self.leaves.get(first..first + held.leaf_count as usize);
            let first = held.first_point as usize;
            let points = self.cluster_points.get(first..first + held.point_count as usize);
            let corners = held.corners[..held.leaf_count as usize].as_flattened();
            let inside = points.is_some_and(|points| {
                points.iter().all(|&p| (p as usize) < self.point_count())
                    && corners.iter().all(|&corner| (corner as usize) < points.len())
            });
            let Some(leaves) = leaves.filter(|_| inside) else {
                return Err(InvalidTree::Cluster { cluster });
            };
            for &leaf in leaves {
                match times.get_mut(leaf as usize) {
                    Some(count) => *count += 1,
                    None => return Err(InvalidTree::Cluster { cluster }),
                }
            }
        }
        match times.iter().position(|&count| count != 1) {
            Some(leaf) => Err(InvalidTree::Leaf { leaf, times: times[leaf] }),
            None => Ok(()),
        }
    }

    fn check_children(&self) -> Result<(), InvalidTree> {
        let mut seen = vec![false; self.nodes.len() + self.clusters.len()];
        for (node, children) in self.nodes.iter().map(|node| node.children).enumerate() {
            for (child, below) in children.into_iter().enumerate() {
                let place = match below.below() {
                    Below::Node(below) if below as usize > node => below as usize,
                    Below::Node(_) => return Err(InvalidTree::Child { node, child }),
                    Below::Cluster(cluster) => self.nodes.len() + cluster as usize,
                    Below::Nothing => continue,
                };
                match seen.get_mut(place) {
                    Some(seen) if !*seen => *seen = true,
                    _ => return Err(InvalidTree::Child { node, child }),
                }
            }
        }
        match seen.iter().skip(1).position(|seen| !seen) {
            Some(_) => Err(InvalidTree::Child { node: 0, child: 0 }),
            None => Ok(()),
        }
    }

    /// What a child's bound must be, from the points of all leaves below it, one by one.
    fn union_below(&self, child: Child) -> Dop<S> {
        match child.below() {
            Below::Nothing => Dop::EMPTY,
            Below::Node(node) => {
                let children = self.nodes[node as usize].children;
                children.iter().fold(Dop::EMPTY, |all, &c| all.union(&self.union_below(c)))
            }
            Below::Cluster(cluster) => {
                let cluster = &self.clusters[cluster as usize];
                let leaves = 0..cluster.leaf_count as usize;
                let points = leaves.flat_map(|i| cluster.corner_points(i, &self.cluster_points));
                points.fold(Dop::EMPTY, |all, p| all.union(&self.row(p as usize)))
            }
        }
    }

    fn row(&self, point: usize) -> Dop<S> {
        Dop { lo: self.rows.lo()[point], hi: self.rows.hi()[point] }
    }
}

/// What hangs below the nodes.
struct Clusters<'a, const S: usize> {
    clusters: &'a [Cluster],
    cluster_points: &'a [u32],
    rows: &'a Rows<S>,
}

impl<const S: usize> Clusters<'_, S> {
    /// Sets the bounds of nodes that are numbered from `first` on and hold all that is below them.
    fn sweep(&self, nodes: &mut [Node<S>], first: usize) {
        for i in (0..nodes.len()).rev() {
            self.set_bounds(nodes, i, first);
        }
    }

    /// As [`sweep`](Self::sweep): a subtree's nodes are a range, so the subtrees below the first
    /// node can be swept side by side.
    #[cfg(feature = "rayon")]
    fn par_sweep(&self, nodes: &mut [Node<S>], first: usize) {
        use rayon::prelude::*;
        /// Nodes of a task: some ten microseconds of work.
        const PART: usize = 256;
        if nodes.len() <= PART {
            return self.sweep(nodes, first);
        }
        let below = nodes[0].children.into_iter().filter_map(|child| match child.below() {
            Below::Node(node) => Some(node as usize - first),
            Below::Cluster(_) | Below::Nothing => None,
        });
        let mut parts = Vec::with_capacity(4);
        let mut rest = &mut *nodes;
        for start in below.collect::<Vec<_>>().into_iter().rev() {
            let (before, part) = rest.split_at_mut(start);
            parts.push((part, first + start));
            rest = before;
        }
        parts.into_par_iter().for_each(|(part, start)| self.par_sweep(part, start));
        self.set_bounds(nodes, 0, first);
    }

    #[inline(always)]
    fn set_bounds(&self, nodes: &mut [Node<S>], i: usize, first: usize) {
        let children = nodes[i].children;
        let mut bounds = [Packed::EMPTY; 4];
        for (bound, child) in bounds.iter_mut().zip(children) {
            *bound = match child.below() {
                Below::Node(node) => nodes[node as usize - first].quad.enclosing(),
                Below::Cluster(cluster) => {
                    self.clusters[cluster as usize].bound(self.cluster_points, self.rows)
                }
                Below::Nothing => Packed::EMPTY,
            };
        }
        nodes[i].quad.set(&bounds);
    }
}
