//! Which leaves share points: fixed by the topology, found once.

use crate::cluster::{CLUSTER, Cluster, QUADS};
use crate::tree::DopTree;
use wide::u32x8;

/// For every cluster, the clusters that share points with it (itself first, then later ones), and
/// which of their leaves do.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    /// Where the entries of each cluster begin; one more than there are clusters.
    first: Vec<u32>,
    /// The neighbours of each cluster, then [`LANES`] numbers of no cluster.
    clusters: Vec<u32>,
    /// For each neighbour, which leaves share points.
    shared: Vec<Shared>,
    /// Clusters with a point that too many others use to list them all.
    crowded: Vec<bool>,
    /// Clusters whose leaves are one piece.
    connected: Vec<bool>,
}

/// Clusters that may use one point before pairs of them are no longer listed but compared when they
/// are met. A point of an ordinary mesh has two to five; the list grows with the square, so a fan of
/// a million faces about one point must not be listed.
const CROWD: usize = 64;

/// Neighbours compared at a time: more than most clusters have, so that there is no loop to guess
/// the end of.
const LANES: usize = 8;

/// Pairs of leaves of two clusters that share a point, one bit each as in
/// [`Quad::overlaps`](crate::quad::Quad::overlaps), for each pair of quads.
pub(crate) type Shared = [u16; QUADS * QUADS];

impl Neighbours {
    /// Finds all neighbours of a tree's clusters.
    pub(crate) fn of<const S: usize>(tree: &DopTree<S>) -> Self {
        let users = Users::of(tree);
        let crowded = vec![false; tree.clusters.len()];
        let mut found =
            Self { first: vec![0], clusters: vec![], shared: vec![], crowded, connected: vec![] };
        for (a, cluster) in (0..).zip(&tree.clusters) {
            let start = found.clusters.len();
            found.clusters.push(a);
            found.shared.push([0; QUADS * QUADS]);
            for (place, &point) in (0_u8..).zip(cluster.points(&tree.cluster_points)) {
                let own = leaves_with(cluster, place);
                let users = users.of_point(point);
                if users.len() > CROWD {
                    found.crowded[a as usize] = true;
                    continue;
                }
                for &(b, other) in users.iter().filter(|(b, _)| *b >= a) {
                    let known = found.clusters[start..].iter().position(|&known| known == b);
                    let at = known.map_or(found.clusters.len(), |at| start + at);
                    if known.is_none() {
                        found.clusters.push(b);
                        found.shared.push([0; QUADS * QUADS]);
                    }
                    add_pairs(&mut found.shared[at], own, other);
                }
            }
            let own = &found.shared[start];
            found.connected.push(are_connected(own, cluster.leaf_count as usize));
            let end = u32::try_from(found.clusters.len());
            found.first.push(end.expect("at most a crowd for each of fewer than 2^26 clusters"));
        }
        found.clusters.extend([u32::MAX; LANES]);
        found
    }

    /// Pairs of leaves of clusters `a <= b` that are known to share a point.
    #[inline(always)]
    pub(crate) fn shared(&self, a: u32, b: u32) -> Shared {
        self.place(a, b).map_or([0; QUADS * QUADS], |place| self.shared[place])
    }

    /// Whether clusters `a <= b` are known to share a point.
    pub(crate) fn are_listed(&self, a: u32, b: u32) -> bool {
        self.place(a, b).is_some()
    }

    /// Whether a cluster's leaves are one piece, as far as is known.
    pub(crate) fn is_connected(&self, cluster: u32) -> bool {
        self.connected[cluster as usize]
    }

    #[inline(always)]
    fn place(&self, a: u32, b: u32) -> Option<usize> {
        let end = self.first[a as usize + 1] as usize;
        let mut start = self.first[a as usize] as usize;
        while start < end {
            let clusters = self.clusters[start..].first_chunk::<LANES>()?;
            let within = (1_u32 << (end - start).min(LANES)) - 1;
            let hits = u32x8::new(*clusters).simd_eq(u32x8::splat(b)).to_bitmask() & within;
            if hits != 0 {
                return Some(start + hits.trailing_zeros() as usize);
            }
            start += LANES;
        }
        None
    }

    /// Whether leaves of two clusters may share points that are not listed.
    #[inline(always)]
    pub(crate) fn are_crowded(&self, a: u32, b: u32) -> bool {
        self.crowded[a as usize] && self.crowded[b as usize]
    }
}

/// Which clusters use each point, and which of their leaves do.
struct Users {
    first: Vec<u32>,
    users: Vec<(u32, u8)>,
}

impl Users {
    /// Sorts the clusters' points by number, counting first.
    fn of<const S: usize>(tree: &DopTree<S>) -> Self {
        let mut first = vec![0_u32; tree.point_count() + 1];
        for &point in &tree.cluster_points {
            first[point as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut users = vec![(0, 0); tree.cluster_points.len()];
        for (id, cluster) in (0..).zip(&tree.clusters) {
            for (place, &point) in (0_u8..).zip(cluster.points(&tree.cluster_points)) {
                let next = &mut next[point as usize];
                users[*next as usize] = (id, leaves_with(cluster, place));
                *next += 1;
            }
        }
        Self { first, users }
    }

    fn of_point(&self, point: u32) -> &[(u32, u8)] {
        let range = self.first[point as usize]..self.first[point as usize + 1];
        &self.users[range.start as usize..range.end as usize]
    }
}

/// Leaves of a cluster that use its point at `place`, a bit each.
fn leaves_with(cluster: &Cluster, place: u8) -> u8 {
    const { assert!(CLUSTER == 8, "a bit for each leaf") };
    let leaves = cluster.corners[..cluster.leaf_count as usize].iter().enumerate();
    leaves.filter(|(_, corners)| corners.contains(&place)).fold(0, |bits, (i, _)| bits | 1 << i)
}

/// Adds every pair of a leaf of one set and a leaf of the other.
fn add_pairs(shared: &mut Shared, a: u8, b: u8) {
    for i in (0..CLUSTER).filter(|i| a >> i & 1 == 1) {
        for j in (0..CLUSTER).filter(|j| b >> j & 1 == 1) {
            shared[i / 4 * QUADS + j / 4] |= 1 << (i % 4 * 4 + j % 4);
        }
    }
}

/// Whether leaves, of which each pair that shares a point has its bit, are one piece.
fn are_connected(shared: &Shared, leaves: usize) -> bool {
    let linked = |i: usize, j: usize| shared[i / 4 * QUADS + j / 4] >> (i % 4 * 4 + j % 4) & 1;
    let mut reached = 1_u32;
    for _ in 1..leaves {
        for i in 0..leaves {
            if reached >> i & 1 == 1 {
                reached |= (0..leaves).fold(0, |bits, j| bits | u32::from(linked(i, j)) << j);
            }
        }
    }
    reached.count_ones() as usize == leaves
}
