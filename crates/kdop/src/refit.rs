//! Refits: new projections, then one sweep over the nodes in reverse order.
//!
//! Source: J. Mezger et al., "Hierarchical Techniques in Collision Detection for Cloth Animation",
//! Journal of WSCG 11(1), 2003, section 4, and the linear sweep of bounding volume hierarchies
//! whose parents stand before their children. Differs in that the bound of a cluster is computed
//! from its points, each taken once, and not from the bounds of its leaves.

use glam::DVec3;

use crate::cluster::Clusters;
use crate::error::TreeError;
use crate::extents::{Extents, check_length};
use crate::node::{Child, Node};
use crate::packed::PackedDop;
use crate::projections::Projections;
use crate::tree::DopTree;

impl<const S: usize> DopTree<S> {
    /// Refits the bounds to leaves on points at rest (|P|).
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`] or [`TreeError::NonFinite`]; the tree is then unchanged.
    pub fn refit(&mut self, points: &[DVec3]) -> Result<(), TreeError> {
        self.refit_from(Extents::Points(points))
    }

    /// Refits the bounds to leaves whose points move on straight lines from `start` to `end`
    /// (|P| each).
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
    ///
    /// let mut hits = 0;
    /// wall.pairs(&ball, 0.0, &mut Workspace::default(), |_, _| hits += 1);
    /// assert_eq!(hits, 1, "on the way");
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn refit_swept(&mut self, start: &[DVec3], end: &[DVec3]) -> Result<(), TreeError> {
        self.refit_from(Extents::Swept { start, end })
    }

    /// Refits the bounds to leaves on points at rest, swept points or balls.
    ///
    /// Allocates only when a tree is refitted to something other than points at rest for the first
    /// time. The work is linear.
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`], [`TreeError::NonFinite`] or [`TreeError::BadRadius`]; the tree
    /// is then unchanged.
    pub fn refit_from(&mut self, extents: Extents<'_>) -> Result<(), TreeError> {
        // Nothing is changed before all input is checked.
        check_length(extents.len(), self.point_count())?;
        extents.validate()?;
        self.projections.fill(&extents);
        self.set_bounds();
        Ok(())
    }

    /// Refits the bounds as [`refit_from`](Self::refit_from) does, on the threads of the current
    /// pool.
    ///
    /// The bounds are the same to the bit. This pays above some fifty thousand leaves.
    ///
    /// # Errors
    ///
    /// Those of [`refit_from`](Self::refit_from); the tree is then unchanged.
    #[cfg(feature = "rayon")]
    pub fn par_refit_from(&mut self, extents: Extents<'_>) -> Result<(), TreeError> {
        check_length(extents.len(), self.point_count())?;
        extents.validate()?;
        self.projections.par_fill(&extents);
        let Self { nodes, clusters, projections, .. } = self;
        Sweep { clusters, projections }.par_set_all(nodes, 0);
        Ok(())
    }

    /// Sets the bounds of every node from the projections.
    pub(crate) fn set_bounds(&mut self) {
        let Self { nodes, clusters, projections, .. } = self;
        Sweep { clusters, projections }.set_all(nodes, 0);
    }
}

/// Reverse sweep: bounds of nodes from what is below them.
struct Sweep<'a, const S: usize> {
    clusters: &'a Clusters,
    projections: &'a Projections<S>,
}

impl<const S: usize> Sweep<'_, S> {
    /// Sets the bounds of a run of nodes that holds everything below them and begins at number
    /// `first`.
    fn set_all(&self, nodes: &mut [Node<S>], first: usize) {
        for i in (0..nodes.len()).rev() {
            self.set(nodes, i, first);
        }
    }

    /// Sets the bounds of a subtree as [`set_all`](Self::set_all) does, its branches in parallel.
    ///
    /// The nodes of every branch are a run, so the branches can be split off from the last.
    #[cfg(feature = "rayon")]
    fn par_set_all(&self, nodes: &mut [Node<S>], first: usize) {
        use rayon::prelude::*;
        /// Nodes per task: some ten microseconds of work.
        const PART: usize = 256;
        if nodes.len() <= PART {
            return self.set_all(nodes, first);
        }

        // Split the branches off from the last to the first.
        let mut branches = Vec::with_capacity(4);
        let children = nodes[0].children;
        let mut rest = &mut *nodes;
        for child in children.into_iter().rev() {
            if let Child::Node(node) = child.get() {
                let (before, branch) = rest.split_at_mut(node as usize - first);
                branches.push((branch, node as usize));
                rest = before;
            }
        }
        branches.into_par_iter().for_each(|(branch, first)| self.par_set_all(branch, first));

        // The first node holds all branches.
        self.set(nodes, 0, first);
    }

    /// Sets the bounds of one node, whose children are done.
    #[inline(always)]
    fn set(&self, nodes: &mut [Node<S>], i: usize, first: usize) {
        let children = nodes[i].children;
        let mut bounds = [PackedDop::EMPTY; 4];
        for (bound, child) in bounds.iter_mut().zip(children) {
            *bound = match child.get() {
                Child::Node(node) => nodes[node as usize - first].bounds.union(),
                Child::Cluster(cluster) => self.clusters.bound(cluster, self.projections),
                Child::None => PackedDop::EMPTY,
            };
        }
        nodes[i].bounds.set(&bounds);
    }
}
