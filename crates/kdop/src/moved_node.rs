//! Nodes of a tree that moves, bounded over their way.

use crate::dop4::{Dop4, SplatDop, set_bits};
use crate::node::{Child, Node};

/// Node of a moving tree, over its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovedNode<const S: usize> {
    pub(crate) bounds: Dop4<S>,
    /// Maximum distance of the points of each child from the chords of their ways.
    pub(crate) deviation: [f64; 4],
}

impl<const S: usize> MovedNode<S> {
    /// Finds the children of a node that overlap a bound: nodes go on the stack. Returns false at a
    /// cluster that deviates too much.
    #[inline(always)]
    pub(crate) fn children_near(
        &self,
        node: &Node<S>,
        bound: &SplatDop<S>,
        max_deviation: f64,
        nodes: &mut Vec<u32>,
        mut found: impl FnMut(u32),
    ) -> bool {
        for lane in set_bits(self.bounds.overlaps_one(bound)) {
            match node.children[lane].get() {
                Child::Node(child) => nodes.push(child),
                Child::Cluster(_) if self.deviation[lane] > max_deviation => return false,
                Child::Cluster(cluster) => found(cluster),
                Child::None => {}
            }
        }
        true
    }
}
