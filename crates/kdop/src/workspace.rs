//! Scratch memory of the traversals, owned by the caller.

use crate::cluster::LeafQuads;
use crate::traverse::cones::Normals;
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
    pub(crate) normals: Vec<Normals>,
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
            normals: Vec::new(),
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

/// Bounds of the leaves of clusters that a traversal has touched lately.
///
/// A traversal meets clusters in the order of the tree, so those with close numbers are wanted at
/// about the same time, and a cluster's place is its number modulo the size of the cache.
#[derive(Clone, Debug)]
pub(crate) struct LeafCache<const S: usize> {
    /// The cluster in each place.
    clusters: Vec<u32>,
    bounds: Vec<LeafQuads<S>>,
}

impl<const S: usize> LeafCache<S> {
    /// Places: a power of two. A hundred kilobytes, so that two fit any level-2 cache; with more
    /// a traversal of a large tree with itself waits for memory, with fewer it computes the same
    /// bounds again.
    const PLACES: usize = 128;
    const NOTHING: u32 = u32::MAX;

    const fn new() -> Self {
        Self { clusters: Vec::new(), bounds: Vec::new() }
    }

    /// Forgets everything.
    pub(crate) fn reset(&mut self) {
        self.clusters.clear();
        self.clusters.resize(Self::PLACES, Self::NOTHING);
        self.bounds.resize(Self::PLACES, LeafQuads::EMPTY);
    }

    /// A cluster's bounds, widened by the margin; computed where they are not at hand.
    #[inline(always)]
    pub(crate) fn get(
        &mut self,
        tree: &DopTree<S>,
        cluster: u32,
        margin: Option<&[f32; S]>,
    ) -> &LeafQuads<S> {
        let place = cluster as usize % Self::PLACES;
        if self.clusters[place] != cluster {
            self.compute(place, tree, cluster, margin);
        }
        &self.bounds[place]
    }

    #[inline(never)]
    fn compute(
        &mut self,
        place: usize,
        tree: &DopTree<S>,
        cluster: u32,
        margin: Option<&[f32; S]>,
    ) {
        self.clusters[place] = cluster;
        let bounds = &mut self.bounds[place];
        tree.clusters[cluster as usize].bound_leaves(&tree.cluster_points, &tree.rows, bounds);
        if let Some(margin) = margin {
            bounds.widen(margin);
        }
    }
}
