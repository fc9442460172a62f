//! Nodes of a 4-ary tree.

use crate::dop4::Dop4;

/// Four children and their bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<const S: usize> {
    pub(crate) bounds: Dop4<S>,
    pub(crate) children: [ChildRef; 4],
}

impl<const S: usize> Node<S> {
    pub(crate) const EMPTY: Self = Self { bounds: Dop4::EMPTY, children: [ChildRef::NONE; 4] };
}

/// Reference to a child in 32 bits: the number of a node, or of a cluster with the highest bit set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ChildRef(u32);

/// Decoded [`ChildRef`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    Node(u32),
    Cluster(u32),
    None,
}

impl ChildRef {
    pub(crate) const NONE: Self = Self(u32::MAX);
    const CLUSTER_BIT: u32 = 1 << 31;

    pub(crate) const fn node(node: u32) -> Self {
        Self(node)
    }

    pub(crate) const fn cluster(cluster: u32) -> Self {
        Self(cluster | Self::CLUSTER_BIT)
    }

    /// Decodes the reference.
    #[inline(always)]
    pub(crate) const fn get(self) -> Child {
        if self.0 & Self::CLUSTER_BIT == 0 {
            Child::Node(self.0)
        } else if self.0 == u32::MAX {
            Child::None
        } else {
            Child::Cluster(self.0 & !Self::CLUSTER_BIT)
        }
    }
}
