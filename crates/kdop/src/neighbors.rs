//! Clusters whose leaves share points: fixed by the topology, found once.

use wide::u32x8;

use crate::cluster::{Cluster, Clusters, HALVES, MAX_LEAVES};
use crate::common_points::CommonPoints;
use crate::node::Node;

/// Adjacency of clusters in compressed sparse rows, with the leaves that share points.
///
/// The row of a cluster holds itself first, then later clusters.
#[derive(Clone, Debug)]
pub(crate) struct Neighbors {
    /// Start of each row, and the end of the last.
    first: Vec<u32>,
    /// Neighbors of each cluster, then [`LANES`] numbers of no cluster.
    clusters: Vec<u32>,
    /// Leaves that share points, per neighbor: the words of [`SharedPairs`], the first lowest.
    shared: Vec<u64>,
    /// Clusters with a point that more than [`MAX_LISTED`] clusters use.
    crowded: Vec<bool>,
    /// Points that all leaves of nodes and clusters have in common, where there is a crowded one.
    pub(crate) common: Option<CommonPoints>,
}

/// Maximum number of clusters at one point whose pairs are listed.
///
/// Pairs beyond it are compared when a traversal comes to them. A point of an ordinary mesh is used
/// by two to five clusters. The list grows with the square of that number, so a fan of a million
/// faces about one point must not be listed. Nor are its pairs compared, as far as all leaves of a
/// node have the point: [`CommonPoints`]. Time still grows with the square of the number of leaves
/// about several points in the same place.
const MAX_LISTED: usize = 64;

/// Neighbors compared at a time. Most clusters have fewer, so the loop is predicted well.
const LANES: usize = 8;

/// Pairs of leaves of two clusters that share a point.
///
/// One word per pair of halves, with bits as in [`Dop4::overlaps`](crate::dop4::Dop4::overlaps).
pub(crate) type SharedPairs = [u16; HALVES * HALVES];

impl Neighbors {
    /// Finds all neighbors of all clusters.
    pub(crate) fn find<const S: usize>(
        nodes: &[Node<S>],
        clusters: &Clusters,
        point_count: usize,
    ) -> Self {
        let users = PointUsers::find(clusters, point_count);
        let crowded = vec![false; clusters.list.len()];
        let (first, listed, shared, common) = (vec![0], vec![], vec![], None);
        let mut found = Self { first, clusters: listed, shared, crowded, common };

        for (a, cluster) in (0..).zip(&clusters.list) {
            // The row of a cluster begins with itself.
            let row = found.clusters.len();
            found.neighbor(row, a);

            // Every later cluster with a common point is a neighbor, unless too many have it.
            for &point in clusters.points_of(cluster) {
                let users = users.of_point(point);
                if users.len() > MAX_LISTED {
                    found.crowded[a as usize] = true;
                    continue;
                }
                // Users stand in the order of the clusters: the cluster itself, then later ones.
                let mut own = 0;
                for user in users.iter().filter(|user| user.cluster >= a) {
                    if user.cluster == a {
                        own = user.leaves;
                    }
                    let neighbor = found.neighbor(row, user.cluster);
                    found.shared[neighbor] |= pairs_of(own, user.leaves);
                }
            }

            let end = u32::try_from(found.clusters.len());
            found.first.push(end.expect("fewer than 2^32 pairs of clusters with a common point"));
        }

        if found.crowded.contains(&true) {
            found.common = Some(CommonPoints::find(nodes, clusters));
        }

        // Rows are read in whole registers, also the last.
        found.clusters.extend([u32::MAX; LANES]);
        found
    }

    /// Returns the position of a cluster in the last row, which begins at `row`; appends it if it
    /// is new.
    fn neighbor(&mut self, row: usize, cluster: u32) -> usize {
        if let Some(i) = self.clusters[row..].iter().position(|&neighbor| neighbor == cluster) {
            return row + i;
        }
        self.clusters.push(cluster);
        self.shared.push(0);
        self.clusters.len() - 1
    }

    /// Returns the listed pairs of leaves of clusters `a <= b` that share a point.
    #[inline(always)]
    pub(crate) fn shared(&self, a: u32, b: u32) -> SharedPairs {
        let end = self.first[a as usize + 1] as usize;
        let mut start = self.first[a as usize] as usize;
        while start < end {
            let Some(clusters) = self.clusters[start..].first_chunk::<LANES>() else { break };
            // A register may extend into the next row, whose hits do not count.
            let in_row = (1_u32 << (end - start).min(LANES)) - 1;
            let hits = u32x8::new(*clusters).simd_eq(u32x8::splat(b)).to_bitmask() & in_row;
            if hits != 0 {
                return words(self.shared[start + hits.trailing_zeros() as usize]);
            }
            start += LANES;
        }
        [0; HALVES * HALVES]
    }

    /// Returns true if leaves of two clusters may share points that are not listed.
    #[inline(always)]
    pub(crate) fn are_crowded(&self, a: u32, b: u32) -> bool {
        self.crowded[a as usize] && self.crowded[b as usize]
    }
}

/// Clusters that use each point, in compressed sparse rows.
struct PointUsers {
    first: Vec<u32>,
    users: Vec<PointUser>,
}

/// Cluster that uses a point, and those of its leaves that do, one bit per leaf.
#[derive(Clone, Copy, Default)]
struct PointUser {
    cluster: u32,
    leaves: u8,
}

impl PointUsers {
    /// Sorts the points of all clusters by number (counting sort).
    fn find(clusters: &Clusters, point_count: usize) -> Self {
        // Count the users of every point, then accumulate the counts to starts of rows.
        let mut first = vec![0_u32; point_count + 1];
        for &point in &clusters.points {
            first[point as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }

        // Fill the rows in the order of the clusters.
        let mut next = first.clone();
        let mut users = vec![PointUser::default(); clusters.points.len()];
        for (id, cluster) in (0..).zip(&clusters.list) {
            let leaves = leaves_of_points(cluster);
            for (&point, leaves) in clusters.points_of(cluster).iter().zip(leaves) {
                let next = &mut next[point as usize];
                users[*next as usize] = PointUser { cluster: id, leaves };
                *next += 1;
            }
        }
        Self { first, users }
    }

    fn of_point(&self, point: u32) -> &[PointUser] {
        let (start, end) = (self.first[point as usize], self.first[point as usize + 1]);
        &self.users[start as usize..end as usize]
    }
}

/// Returns the leaves of a cluster that use each of its points, one bit per leaf.
fn leaves_of_points(cluster: &Cluster) -> [u8; 3 * MAX_LEAVES] {
    const { assert!(MAX_LEAVES == 8, "a bit for each leaf") };
    let mut bits = [0; 3 * MAX_LEAVES];
    for (leaf, corners) in cluster.corners[..cluster.leaf_count as usize].iter().enumerate() {
        for &corner in corners {
            bits[corner as usize] |= 1 << leaf;
        }
    }
    bits
}

/// Returns every pair of a leaf of one set and a leaf of the other.
///
/// A pair of leaf `i` and leaf `j` has bit `32 (i / 4) + 16 (j / 4) + 4 (i % 4) + j % 4`. The bits of
/// both leaves add up, so that the product of two sets has all pairs, none of them twice.
const fn pairs_of(a: u8, b: u8) -> u64 {
    spread(a & 0b1111, a >> 4, 3, 32) * spread(b & 0b1111, b >> 4, 0, 16)
}

/// Moves bit `i` of the low half up by `step · i`, and those of the high half by `half` more.
const fn spread(low: u8, high: u8, step: u32, half: u32) -> u64 {
    spread_half(low, step) | spread_half(high, step) << half
}

const fn spread_half(bits: u8, step: u32) -> u64 {
    let bits = bits as u64;
    bits & 1 | (bits & 2) << step | (bits & 4) << (2 * step) | (bits & 8) << (3 * step)
}

/// Splits pairs into the words of [`SharedPairs`].
#[expect(clippy::cast_possible_truncation, reason = "each word is the lowest that is left")]
#[inline(always)]
const fn words(pairs: u64) -> SharedPairs {
    const { assert!(HALVES * HALVES == 4, "four words") };
    [pairs as u16, (pairs >> 16) as u16, (pairs >> 32) as u16, (pairs >> 48) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_those_of_single_leaves() {
        for (a, b) in [(0, 255), (1, 1), (0b1010_0110, 0b0101_1001), (255, 255), (128, 16)] {
            let mut expected: SharedPairs = [0; HALVES * HALVES];
            for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
                if a >> i & 1 == 1 && b >> j & 1 == 1 {
                    expected[i / 4 * HALVES + j / 4] |= 1 << (4 * (i % 4) + j % 4);
                }
            }
            assert_eq!(words(pairs_of(a, b)), expected, "{a:b} {b:b}");
        }
    }
}
