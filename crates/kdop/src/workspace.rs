//! Scratch memory of the traversals, owned by the caller.

use crate::cluster::LeafDops;
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

/// Direct-mapped cache of the bounds of leaves, by cluster.
///
/// A traversal comes to clusters in the order of the tree, so those with close numbers are needed
/// at about the same time. The slot of a cluster is its number modulo the size of the cache.
#[derive(Clone, Debug)]
pub(crate) struct LeafCache<const S: usize> {
    /// Cluster in each slot.
    clusters: Vec<u32>,
    bounds: Vec<LeafDops<S>>,
}

impl<const S: usize> LeafCache<S> {
    /// Number of slots, a power of two.
    ///
    /// A cache takes a hundred kilobytes, so two fit any level-2 cache. With more, a traversal of a
    /// large tree with itself waits for memory; with fewer, it computes the same bounds again.
    const SLOTS: usize = 128;
    const NO_CLUSTER: u32 = u32::MAX;

    const fn new() -> Self {
        Self { clusters: Vec::new(), bounds: Vec::new() }
    }

    /// Empties all slots.
    pub(crate) fn reset(&mut self) {
        self.clusters.clear();
        self.clusters.resize(Self::SLOTS, Self::NO_CLUSTER);
        self.bounds.resize(Self::SLOTS, LeafDops::EMPTY);
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
        let slot = cluster as usize % Self::SLOTS;
        if self.clusters[slot] != cluster {
            self.compute(slot, tree, cluster, margin);
        }
        &self.bounds[slot]
    }

    /// Caches the bounds of the leaves of a cluster, without a margin. Another cache without one may
    /// have them: a copy takes a fraction of the time.
    #[inline(always)]
    pub(crate) fn load(&mut self, tree: &DopTree<S>, cluster: u32, other: &Self) {
        let slot = cluster as usize % Self::SLOTS;
        if self.clusters[slot] == cluster {
            return;
        }
        if other.clusters[slot] == cluster {
            self.clusters[slot] = cluster;
            self.bounds[slot] = other.bounds[slot];
        } else {
            self.compute(slot, tree, cluster, None);
        }
    }

    #[inline(never)]
    fn compute(&mut self, slot: usize, tree: &DopTree<S>, cluster: u32, margin: Option<&[f32; S]>) {
        self.clusters[slot] = cluster;
        let bounds = &mut self.bounds[slot];
        let cluster = tree.clusters.get(cluster);
        tree.clusters.bound_leaves(cluster, &tree.projections, bounds);
        if let Some(margin) = margin {
            bounds.widen(margin);
        }
    }
}
