//! Scratch memory of the traversals, owned by the caller.

use crate::cluster::LeafQuads;
use crate::traverse::nearest::Entry;
use crate::tree::DopTree;
use std::collections::BinaryHeap;

/// Room for a traversal: one for each thread, reused between calls, for any trees of one `S`.
///
/// Holds nothing between calls but memory and the counters of the last one.
#[derive(Clone, Debug)]
pub struct Workspace<const S: usize = 9> {
    pub(crate) node_pairs: Vec<(u32, u32)>,
    pub(crate) nodes: Vec<u32>,
    pub(crate) cluster_pairs: Vec<(u32, u32)>,
    pub(crate) a: LeafCache<S>,
    pub(crate) b: LeafCache<S>,
    pub(crate) heap: BinaryHeap<Entry>,
    pub(crate) counters: Counters,
}

/// What the last traversal did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counters {
    /// Tests of four bounds against four, or against one.
    pub quad_tests: u64,
    /// Clusters, or pairs of clusters, whose leaves were looked at.
    pub clusters: u64,
    /// Leaves, or pairs of leaves, reported.
    pub reported: u64,
}

impl<const S: usize> Workspace<S> {
    /// An empty workspace; it grows with the first traversals.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            node_pairs: Vec::new(),
            nodes: Vec::new(),
            cluster_pairs: Vec::new(),
            a: LeafCache::new(),
            b: LeafCache::new(),
            heap: BinaryHeap::new(),
            counters: Counters { quad_tests: 0, clusters: 0, reported: 0 },
        }
    }

    /// What the last traversal did.
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

/// Bounds of the leaves of the clusters that one traversal has touched.
#[derive(Clone, Debug)]
pub(crate) struct LeafCache<const S: usize> {
    /// Where each cluster's bounds are, [`LeafCache::ABSENT`] where they are not.
    slots: Vec<u32>,
    touched: Vec<u32>,
    /// Kept between calls: as many as were ever touched at once.
    bounds: Vec<LeafQuads<S>>,
}

impl<const S: usize> LeafCache<S> {
    const ABSENT: u32 = u32::MAX;

    const fn new() -> Self {
        Self { slots: Vec::new(), touched: Vec::new(), bounds: Vec::new() }
    }

    /// Forgets everything and makes room for `clusters`.
    pub(crate) fn reset(&mut self, clusters: usize) {
        for &cluster in &self.touched {
            self.slots[cluster as usize] = Self::ABSENT;
        }
        self.touched.clear();
        if self.slots.len() < clusters {
            self.slots.resize(clusters, Self::ABSENT);
        }
    }

    /// Position of a cluster's bounds, computed (and widened) at the first call.
    #[inline(always)]
    pub(crate) fn slot(
        &mut self,
        tree: &DopTree<S>,
        cluster: u32,
        margin: Option<&[f32; S]>,
    ) -> usize {
        let slot = self.slots[cluster as usize];
        if slot != Self::ABSENT {
            return slot as usize;
        }
        self.compute(tree, cluster, margin)
    }

    fn compute(&mut self, tree: &DopTree<S>, cluster: u32, margin: Option<&[f32; S]>) -> usize {
        let slot = self.touched.len();
        self.slots[cluster as usize] =
            u32::try_from(slot).expect("a tree has fewer clusters than 32-bit numbers");
        self.touched.push(cluster);
        if self.bounds.len() == slot {
            self.bounds.push(LeafQuads::EMPTY);
        }
        let bounds = &mut self.bounds[slot];
        tree.clusters[cluster as usize].bound_leaves(&tree.cluster_points, &tree.rows, bounds);
        if let Some(margin) = margin {
            bounds.widen(margin);
        }
        slot
    }

    #[inline(always)]
    pub(crate) fn get(&self, slot: usize) -> &LeafQuads<S> {
        &self.bounds[slot]
    }
}
