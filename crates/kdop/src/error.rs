//! Errors of building, refitting and validating a tree.

/// Input that [`DopTree::build`](crate::DopTree::build) or a refit rejects.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeError {
    /// A leaf refers to a point that does not exist.
    #[error("leaf {leaf} refers to point {point}, but there are {points} points")]
    PointOutOfRange {
        /// Number of the leaf.
        leaf: usize,
        /// Index that the leaf holds.
        point: u32,
        /// Number of points.
        points: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {point} has a coordinate that is not finite")]
    NonFinite {
        /// The first such point.
        point: usize,
    },
    /// A radius is negative, infinite or not a number.
    #[error("the radius of point {point} is {radius}; it must be finite and at least 0")]
    BadRadius {
        /// The first such point.
        point: usize,
        /// Its radius.
        radius: f64,
    },
    /// A list of points or radii is longer or shorter than the tree has points.
    #[error("{given} values for {expected} points")]
    WrongLength {
        /// Number of points of the tree, or length of the other list.
        expected: usize,
        /// Length of the list.
        given: usize,
    },
    /// There are more leaves or points than 32-bit references can hold.
    #[error("{count} leaves or points; a tree holds fewer than {limit}")]
    TooMany {
        /// Number of leaves or points.
        count: usize,
        /// Upper limit, exclusive.
        limit: usize,
    },
}

/// Defect that [`DopTree::validate`](crate::DopTree::validate) found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidTree {
    /// The stored bound of a child is not the union of what is below it.
    #[error("node {node} does not bound its child {child} tightly")]
    Bound {
        /// The node.
        node: usize,
        /// Position of the child, 0 to 3.
        child: usize,
    },
    /// A leaf is in no cluster or in more than one.
    #[error("leaf {leaf} is in {times} clusters instead of one")]
    Leaf {
        /// Number of the leaf.
        leaf: usize,
        /// Number of clusters that hold it.
        times: usize,
    },
    /// A child precedes its parent, or two parents share it.
    #[error("child {child} of node {node} precedes it or has another parent")]
    Child {
        /// The node.
        node: usize,
        /// Position of the child, 0 to 3.
        child: usize,
    },
    /// A cluster refers to points or leaves that do not exist.
    #[error("cluster {cluster} refers to points or leaves that do not exist")]
    Cluster {
        /// The cluster.
        cluster: usize,
    },
}
