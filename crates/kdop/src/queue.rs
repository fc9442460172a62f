//! Priority queue of best-first search.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::node::ChildRef;

/// Items by increasing lower bound of their distance.
pub(crate) type Queue = BinaryHeap<QueueEntry>;

/// Item to be visited, with a lower bound of its distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueueEntry {
    pub(crate) bound: f64,
    pub(crate) item: QueueItem,
}

/// Part of a tree, or a single leaf as numbered by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum QueueItem {
    Child(ChildRef),
    Leaf(u32),
}

impl Ord for QueueEntry {
    /// Orders the nearest last, since the heap pops its greatest entry first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then_with(|| other.item.cmp(&self.item))
    }
}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QueueEntry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for QueueEntry {}
