//! Scratch memory of the traversals, owned by the caller.

use crate::cluster::LeafDops;
use crate::moved_node::MovedNode;
use crate::node::ChildRef;
use crate::queue::Queue;
use crate::tree::DopTree;

/// Scratch memory of traversals: one per thread, reused between calls, for any trees of one `S`.
///
/// Holds nothing between calls but memory and the counters of the last traversal.
#[derive(Clone, Debug)]
pub struct Workspace<const S: usize = 9> {
    pub(crate) node_pairs: Vec<(u32, u32)>,
    pub(crate) nodes: Vec<u32>,
    pub(crate) cluster_pairs: Vec<(u32, u32)>,
    pub(crate) a: LeafCache<S>,
    pub(crate) b: LeafCache<S>,
    /// Leaves of two trees, each at the start and at the end of a step.
    pub(crate) step_leaves: [LeafCache<S>; 4],
    /// Nodes of a tree that moves, where they move.
    pub(crate) moved: SlotCache<MovedNode<S>>,
    pub(crate) queue: Queue,
    /// Parts of a tree with lower bounds of their distances.
    pub(crate) stack: Vec<(f32, ChildRef)>,
    pub(crate) counters: Counters,
}

/// Operation counts of the last traversal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Tests of four bounds against four, or against one.
    pub bound_tests: u64,
    /// Clusters, or pairs of clusters, whose leaves were tested.
    pub clusters: u64,
    /// Leaves, or pairs of leaves, reported.
    pub reported: u64,
}

impl<const S: usize> Workspace<S> {
    /// Creates an empty workspace; it grows with the first traversals.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            node_pairs: Vec::new(),
            nodes: Vec::new(),
            cluster_pairs: Vec::new(),
            a: LeafCache::new(),
            b: LeafCache::new(),
            step_leaves: [const { LeafCache::new() }; 4],
            moved: SlotCache::new(),
            queue: Queue::new(),
            stack: Vec::new(),
            counters: Counters { bound_tests: 0, clusters: 0, reported: 0 },
        }
    }

    /// Returns the operation counts of the last traversal.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }
}

impl<const S: usize> Default for Workspace<S> {
    fn default() -> Self {
        Self::new()
    }
}

/// Direct-mapped cache of what is computed per node or cluster of a tree.
///
/// A traversal comes to nodes and clusters in the order of the tree, so those with close numbers are
/// needed at about the same time. The slot of each is its number modulo the size of the cache.
#[derive(Clone, Debug)]
pub(crate) struct SlotCache<T> {
    /// Number of the node or cluster in each slot.
    keys: Vec<u32>,
    values: Vec<T>,
}

/// Cache of the bounds of leaves, by cluster.
pub(crate) type LeafCache<const S: usize> = SlotCache<LeafDops<S>>;

impl<T: Copy> SlotCache<T> {
    /// Number of slots, a power of two.
    ///
    /// A cache takes a hundred kilobytes, so two fit any level-2 cache. With more, a traversal of a
    /// large tree with itself waits for memory; with fewer, it computes the same bounds again.
    const SLOTS: usize = 128;
    const NO_KEY: u32 = u32::MAX;

    pub(crate) const fn new() -> Self {
        Self { keys: Vec::new(), values: Vec::new() }
    }

    /// Empties all slots.
    pub(crate) fn reset_to(&mut self, empty: T) {
        self.keys.clear();
        self.keys.resize(Self::SLOTS, Self::NO_KEY);
        self.values.resize(Self::SLOTS, empty);
    }

    /// Returns the value of a number, which `compute` overwrites if it is not cached.
    #[inline(always)]
    pub(crate) fn get_with(&mut self, key: u32, compute: impl FnOnce(&mut T)) -> &T {
        let slot = key as usize % Self::SLOTS;
        if self.keys[slot] != key {
            self.keys[slot] = key;
            compute(&mut self.values[slot]);
        }
        &self.values[slot]
    }
}

impl<const S: usize> LeafCache<S> {
    /// Empties all slots.
    pub(crate) fn reset(&mut self) {
        self.reset_to(LeafDops::EMPTY);
    }

    /// Returns the bounds of the leaves of a cluster, widened by the margin; computes them if they
    /// are not cached.
    #[inline(always)]
    pub(crate) fn get(
        &mut self,
        tree: &DopTree<S>,
        cluster: u32,
        margin: Option<&[f32; S]>,
    ) -> &LeafDops<S> {
        self.get_with(cluster, |bounds| compute(bounds, tree, cluster, margin))
    }

    /// Caches the bounds of the leaves of a cluster, without a margin. Another cache without one may
    /// have them: a copy takes a fraction of the time.
    #[inline(always)]
    pub(crate) fn load(&mut self, tree: &DopTree<S>, cluster: u32, other: &Self) {
        let slot = cluster as usize % Self::SLOTS;
        let is_known = other.keys[slot] == cluster;
        self.get_with(cluster, |bounds| {
            if is_known {
                *bounds = other.values[slot];
            } else {
                compute(bounds, tree, cluster, None);
            }
        });
    }
}

#[inline(never)]
fn compute<const S: usize>(
    bounds: &mut LeafDops<S>,
    tree: &DopTree<S>,
    cluster: u32,
    margin: Option<&[f32; S]>,
) {
    let cluster = tree.clusters.get(cluster);
    tree.clusters.bound_leaves(cluster, &tree.projections, bounds);
    if let Some(margin) = margin {
        bounds.widen(margin);
    }
}
