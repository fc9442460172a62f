//! Points that all leaves below a node, or of a cluster, have in common.

use crate::cluster::Clusters;
use crate::node::{Child, Node};

/// Points common to all leaves of each node and of each cluster.
///
/// Of two nodes with a common point, every pair of leaves shares it: a fan about one point is
/// left out as a whole, where its pairs would be compared one by one.
#[derive(Clone, Debug)]
pub(crate) struct CommonPoints {
    nodes: Vec<Points>,
    clusters: Vec<Points>,
}

/// At most three points, in any order; the others are [`NONE`].
type Points = [u32; 3];

/// Number of no point: fewer are built.
const NONE: u32 = u32::MAX;

impl CommonPoints {
    /// Finds the common points; parents stand before their children.
    pub(crate) fn find<const S: usize>(nodes: &[Node<S>], clusters: &Clusters) -> Self {
        let mut of_clusters = Vec::with_capacity(clusters.list.len());
        for cluster in &clusters.list {
            let leaves = 0..cluster.leaf_count as usize;
            let corners = leaves.map(|leaf| clusters.corners_of(cluster, leaf));
            of_clusters.push(corners.reduce(common).unwrap_or([NONE; 3]));
        }

        // Children first, so that each node has theirs.
        let mut found = Self { nodes: vec![[NONE; 3]; nodes.len()], clusters: of_clusters };
        for (number, node) in nodes.iter().enumerate().rev() {
            let children = node.children.iter().filter_map(|child| found.of(child.get()));
            let points = children.reduce(common).unwrap_or([NONE; 3]);
            found.nodes[number] = points;
        }
        found
    }

    /// Returns true if all leaves of `a` share a point with all leaves of `b`.
    pub(crate) fn share(&self, a: Child, b: Child) -> bool {
        let (a, b) = (self.of(a).unwrap_or([NONE; 3]), self.of(b).unwrap_or([NONE; 3]));
        common(a, b) != [NONE; 3]
    }

    fn of(&self, child: Child) -> Option<Points> {
        match child {
            Child::Node(node) => Some(self.nodes[node as usize]),
            Child::Cluster(cluster) => Some(self.clusters[cluster as usize]),
            Child::None => None,
        }
    }
}

/// Returns the points of `a` that are among `b`.
fn common(a: Points, b: Points) -> Points {
    a.map(|point| if b.contains(&point) { point } else { NONE })
}
