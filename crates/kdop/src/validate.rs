//! Consistency check of a whole tree.

use crate::dop::Dop;
use crate::error::InvalidTree;
use crate::node::{Child, ChildRef};
use crate::tree::DopTree;

impl<const S: usize> DopTree<S> {
    /// Checks that every leaf is in the tree once, every child follows its only parent, and every
    /// bound is the exact union of what is below it.
    ///
    /// # Errors
    ///
    /// The first defect found.
    pub fn validate(&self) -> Result<(), InvalidTree> {
        self.check_clusters()?;
        self.check_children()?;
        for (node, content) in self.nodes.iter().enumerate() {
            for (child, below) in content.children.into_iter().enumerate() {
                if content.bounds.lane(child) != self.union_below(below) {
                    return Err(InvalidTree::Bound { node, child });
                }
            }
        }
        Ok(())
    }

    /// Checks that clusters stay within the lists, and that they hold every leaf once.
    fn check_clusters(&self) -> Result<(), InvalidTree> {
        let mut times = vec![0_usize; self.leaves.len()];
        for (cluster, content) in self.clusters.list.iter().enumerate() {
            // All positions must be within the lists that they refer to.
            let broken = InvalidTree::Cluster { cluster };
            let points = self.clusters.points.get(content.points()).ok_or(broken)?;
            let corners = content.corners[..content.leaf_count as usize].as_flattened();
            if !points.iter().all(|&point| (point as usize) < self.point_count())
                || !corners.iter().all(|&corner| (corner as usize) < points.len())
            {
                return Err(broken);
            }

            // Count how often every leaf occurs.
            for &leaf in self.leaves.get(content.leaves()).ok_or(broken)? {
                *times.get_mut(leaf as usize).ok_or(broken)? += 1;
            }
        }

        match times.iter().position(|&count| count != 1) {
            Some(leaf) => Err(InvalidTree::Leaf { leaf, times: times[leaf] }),
            None => Ok(()),
        }
    }

    /// Checks that every node but the root, and every cluster, is a child of one earlier node.
    fn check_children(&self) -> Result<(), InvalidTree> {
        // Nodes and clusters are numbered together, nodes first.
        let count = self.nodes.len() + self.clusters.list.len();
        let mut is_child = vec![false; count];
        for (node, content) in self.nodes.iter().enumerate() {
            for (child, below) in content.children.into_iter().enumerate() {
                let misplaced = InvalidTree::Child { node, child };
                let place = match below.get() {
                    Child::Node(below) if below as usize > node => below as usize,
                    Child::Node(_) => return Err(misplaced),
                    Child::Cluster(cluster) => self.nodes.len() + cluster as usize,
                    Child::None => continue,
                };
                match is_child.get_mut(place) {
                    Some(is_child) if !*is_child => *is_child = true,
                    _ => return Err(misplaced),
                }
            }
        }

        // Only the root, node 0, has no parent.
        let orphaned = is_child.iter().skip(1).any(|&is_child| !is_child);
        if orphaned { Err(InvalidTree::Child { node: 0, child: 0 }) } else { Ok(()) }
    }

    /// Computes the bound of a child from the points of all leaves below it, one by one.
    fn union_below(&self, child: ChildRef) -> Dop<S> {
        let mut union = Dop::EMPTY;
        match child.get() {
            Child::None => {}
            Child::Node(node) => {
                for child in self.nodes[node as usize].children {
                    union = union.union(&self.union_below(child));
                }
            }
            Child::Cluster(cluster) => {
                let cluster = self.clusters.get(cluster);
                for leaf in 0..cluster.leaf_count as usize {
                    for point in self.clusters.corners_of(cluster, leaf) {
                        union = union.union(&self.point_bound(point));
                    }
                }
            }
        }
        union
    }

    fn point_bound(&self, point: u32) -> Dop<S> {
        let (lo, hi) = (self.projections.lo(), self.projections.hi());
        Dop { lo: lo[point as usize], hi: hi[point as usize] }
    }
}
