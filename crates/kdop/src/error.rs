//! Why a tree is refused, or found damaged.

/// What [`DopTree::build`](crate::DopTree::build) and the refits refuse, and where.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeError {
    /// A leaf refers to a point that does not exist.
    #[error("leaf {leaf} refers to point {point}, but there are {points} points")]
    PointOutOfRange {
        /// Number of the leaf.
        leaf: usize,
        /// The index it holds.
        point: u32,
        /// How many points there are.
        points: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} is not finite")]
    NonFinite {
        /// The first such point; for boxes, the first such box.
        point: usize,
    },
    /// A radius, or the amount of an inflation, is negative, infinite or not a number.
    #[error("the radius of point {point} is {radius}")]
    BadRadius {
        /// The first such point; 0 for an inflation.
        point: usize,
        /// Its radius.
        radius: f64,
    },
    /// A box whose lower corner lies above its upper one.
    #[error("box {point} has its lower corner above its upper one")]
    InvertedBox {
        /// The first such box.
        point: usize,
    },
    /// A list of points or radii is longer or shorter than the tree has points.
    #[error("{given} values for {expected} points")]
    WrongLength {
        /// Points of the tree, or of the other list.
        expected: usize,
        /// Length of the list.
        given: usize,
    },
    /// More leaves or points than 32-bit numbers can tell apart.
    #[error("{count} leaves or points; a tree holds fewer than {limit}")]
    TooMany {
        /// How many there are.
        count: usize,
        /// What a tree can hold.
        limit: usize,
    },
}

/// What [`DopTree::validate`](crate::DopTree::validate) found wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidTree {
    /// A node's stored bound of a child is not the union of what hangs below.
    #[error("node {node} does not bound its child {child} tightly")]
    Bound {
        /// The node.
        node: usize,
        /// Which of its four children.
        child: usize,
    },
    /// A leaf hangs from no cluster or from more than one.
    #[error("leaf {leaf} is referred to {times} times")]
    Leaf {
        /// Number of the leaf.
        leaf: usize,
        /// Clusters that hold it.
        times: usize,
    },
    /// A child stands before its parent, or two parents share it.
    #[error("node {node} has a misplaced child {child}")]
    Child {
        /// The node.
        node: usize,
        /// Which of its four children.
        child: usize,
    },
    /// A cluster refers to points or leaves that do not exist.
    #[error("cluster {cluster} refers beyond the tree's points or leaves")]
    Cluster {
        /// The cluster.
        cluster: usize,
    },
}
