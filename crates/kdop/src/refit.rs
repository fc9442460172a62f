//! Refits: new projections, then one sweep over the nodes in reverse order.
//!
//! Source: J. Mezger et al., "Hierarchical Techniques in Collision Detection for Cloth Animation",
//! Journal of WSCG 11(1), 2003, section 4, and the linear sweep of bounding volume hierarchies
//! whose parents stand before their children. Differs in that the bound of a cluster is computed
//! from its points, each taken once, and not from the bounds of its leaves.

use glam::DVec3;

use crate::error::TreeError;
use crate::extents::{Extents, check_length};
use crate::node::Child;
use crate::packed::PackedDop;
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

    /// Sets the bounds of every node from the projections, children first.
    pub(crate) fn set_bounds(&mut self) {
        let Self { nodes, clusters, projections, .. } = self;
        for i in (0..nodes.len()).rev() {
            let children = nodes[i].children;
            let mut bounds = [PackedDop::EMPTY; 4];
            for (bound, child) in bounds.iter_mut().zip(children) {
                *bound = match child.get() {
                    Child::Node(node) => nodes[node as usize].bounds.union(),
                    Child::Cluster(cluster) => clusters.bound(cluster, projections),
                    Child::None => PackedDop::EMPTY,
                };
            }
            nodes[i].bounds.set(&bounds);
        }
    }
}
