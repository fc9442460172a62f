//! Top-down construction: median splits along the widest axis, two per node.
//!
//! Source: J. T. Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies
//! of k-DOPs", IEEE TVCG 4(1), 1998, section 4 (top down, by the median of centroids), and the
//! 4-ary trees (their quadtrees) of J. Mezger et al., Journal of WSCG 11(1), 2003. Differs in the
//! size of the parts, which is rounded such that all nodes and clusters but the last few are full.

use std::ops::Range;

use crate::cluster::{Cluster, Clusters, MAX_LEAVES};
use crate::leaves::Leaves;
use crate::node::{ChildRef, Node};
use crate::packed::PackedDop;
use crate::projections::Projections;

/// Nodes and clusters over leaves; the bounds of the nodes are not set yet.
pub(crate) struct Arrangement<const S: usize> {
    /// Parents before children.
    pub(crate) nodes: Vec<Node<S>>,
    pub(crate) clusters: Clusters,
    /// Leaves in tree order, as numbered by the caller.
    pub(crate) leaves: Vec<u32>,
}

impl<const S: usize> Arrangement<S> {
    /// Arranges the first `count` leaves by their centroids, while `keep_going` returns true; `None`
    /// where it does not.
    pub(crate) fn new(
        leaves: Leaves<'_>,
        count: u32,
        projections: &Projections<S>,
        keep_going: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let centroids =
            (0..count).map(|leaf| centroid(projections, leaves.corners(leaf))).collect();

        // Nearly all clusters are full.
        let n = count as usize;
        let mut clusters = Clusters::default();
        clusters.list.reserve(n / MAX_LEAVES + n / (8 * MAX_LEAVES));

        let order = (0..count).collect();
        let mut builder = Builder {
            nodes: vec![],
            clusters,
            leaves,
            centroids,
            order,
            keys: vec![],
            keep_going,
            is_stopped: false,
        };
        if n > 0 {
            builder.add_node(0..n);
        }
        if builder.is_stopped {
            return None;
        }

        // The tree is kept for long, so spare capacity is returned.
        let Builder { mut nodes, mut clusters, order, .. } = builder;
        nodes.shrink_to_fit();
        clusters.list.shrink_to_fit();
        clusters.points.shrink_to_fit();
        Some(Self { nodes, clusters, leaves: order })
    }
}

/// Leaves below a node from which on the caller is polled: they take some hundred microseconds, far
/// more than a poll and far less than a caller waits for.
const POLLED_FROM: usize = 4096;

/// Partial arrangement.
struct Builder<'a, const S: usize> {
    nodes: Vec<Node<S>>,
    clusters: Clusters,
    leaves: Leaves<'a>,
    /// Six times the centroid of every leaf.
    ///
    /// Splits along the other directions leave parts whose bounds overlap more: pairs of trees then take
    /// up to a quarter more time.
    centroids: Vec<[f32; 3]>,
    /// All leaves; those of finished clusters are in tree order.
    order: Vec<u32>,
    /// Scratch of the splits: position of a leaf along an axis, then its number.
    keys: Vec<u64>,
    /// Returns false to end the build.
    keep_going: &'a dyn Fn() -> bool,
    is_stopped: bool,
}

impl<const S: usize> Builder<'_, S> {
    /// Adds a node over a range of leaves and everything below it, parents first.
    ///
    /// A half that fits a full subtree is not halved again. A node near the root then has two or
    /// three children, and the many at the bottom have four.
    fn add_node(&mut self, range: Range<usize>) -> ChildRef {
        let id = as_u32(self.nodes.len());
        self.nodes.push(Node::EMPTY);
        if range.len() >= POLLED_FROM {
            self.is_stopped = !(self.keep_going)();
        }

        // Halve twice for up to four children.
        let full = full_subtree(range.len() - 1);
        let mut used = 0;
        for half in self.halves(range) {
            if self.is_stopped {
                break;
            }
            let parts = if half.len() > full { self.halves(half) } else { [half, 0..0] };
            for part in parts {
                if !part.is_empty() && !self.is_stopped {
                    let child = self.add_child(part);
                    self.nodes[id as usize].children[used] = child;
                    used += 1;
                }
            }
        }
        ChildRef::node(id)
    }

    fn add_child(&mut self, range: Range<usize>) -> ChildRef {
        if range.len() > MAX_LEAVES { self.add_node(range) } else { self.add_cluster(range) }
    }

    /// Splits a range in two; one that fits a cluster is left whole.
    fn halves(&mut self, range: Range<usize>) -> [Range<usize>; 2] {
        if range.len() <= MAX_LEAVES {
            return [range.clone(), range.end..range.end];
        }
        let middle = range.start + left_size(range.len());
        self.split(range.clone(), middle);
        [range.start..middle, middle..range.end]
    }

    /// Reorders a range such that the leaves before `middle` lie before those after it, along the
    /// axis in which the range is widest. Ties are broken by number.
    fn split(&mut self, range: Range<usize>, middle: usize) {
        // Keys compare by position along the axis, then by number.
        let k = self.widest_axis(range.clone());
        let order = &mut self.order[range.clone()];

        self.keys.clear();
        self.keys.extend(order.iter().map(|&leaf| {
            let position = ascending_bits(self.centroids[leaf as usize][k]);
            u64::from(position) << 32 | u64::from(leaf)
        }));
        self.keys.select_nth_unstable(middle - range.start);

        for (leaf, &key) in order.iter_mut().zip(&self.keys) {
            *leaf = low_half(key);
        }
    }

    fn widest_axis(&self, range: Range<usize>) -> usize {
        let mut bound = PackedDop::EMPTY;
        for &leaf in &self.order[range] {
            let centroid = &self.centroids[leaf as usize];
            bound.include(centroid, centroid);
        }
        bound.to_dop::<3>().widest().0
    }

    /// Adds a cluster over at most [`MAX_LEAVES`] leaves.
    fn add_cluster(&mut self, range: Range<usize>) -> ChildRef {
        // Four leaves are bounded together, so they should lie together.
        if range.len() > 4 {
            self.split(range.clone(), range.start + 4);
        }

        // List every point once, and refer to it by its position in that list.
        let points = &mut self.clusters.points;
        let first_point = points.len();
        let mut corners = [[0; 3]; MAX_LEAVES];
        for (&leaf, corners) in self.order[range.clone()].iter().zip(&mut corners) {
            *corners =
                self.leaves.corners(leaf).map(|point| local_point(points, first_point, point));
        }

        let id = as_u32(self.clusters.list.len());
        self.clusters.list.push(Cluster {
            first_leaf: as_u32(range.start),
            first_point: as_u32(first_point),
            leaf_count: as_u8(range.len()),
            point_count: as_u8(points.len() - first_point),
            corners,
        });
        ChildRef::cluster(id)
    }
}

/// Returns the position of a point among those of the cluster that began at `first`; appends it
/// if it is new.
fn local_point(points: &mut Vec<u32>, first: usize, point: u32) -> u8 {
    if let Some(position) = points[first..].iter().position(|&p| p == point) {
        return as_u8(position);
    }
    points.push(point);
    as_u8(points.len() - 1 - first)
}

/// Computes six times the centroid of a leaf's bounds.
fn centroid<const S: usize>(projections: &Projections<S>, corners: [u32; 3]) -> [f32; 3] {
    let (lo, hi) = (projections.lo(), projections.hi());
    let [a, b, c] = corners.map(|p| (&lo[p as usize], &hi[p as usize]));

    [0, 1, 2].map(|k| (a.0[k] + a.1[k]) + (b.0[k] + b.1[k]) + (c.0[k] + c.1[k]))
}

/// Returns how many of `n > MAX_LEAVES` leaves go left.
///
/// This is half of them, rounded to a multiple of the largest full subtree that is at most a
/// quarter, so the imbalance stays below an eighth.
const fn left_size(n: usize) -> usize {
    let unit = full_subtree(n / 4);
    (n / 2 + unit / 2) / unit * unit
}

/// Returns the number of leaves of the largest full subtree with at most `n`; of one cluster where
/// `n` is less.
const fn full_subtree(n: usize) -> usize {
    let mut size = MAX_LEAVES;
    while 4 * size <= n {
        size *= 4;
    }
    size
}

/// Maps floats to integers of the same order.
fn ascending_bits(x: f32) -> u32 {
    // Bits of positive floats ascend, those of negative ones descend: all of these are flipped.
    let bits = x.to_bits();
    let is_negative = bits >> 31;
    bits ^ (is_negative.wrapping_neg() | 1 << 31)
}

#[expect(clippy::cast_possible_truncation, reason = "the low half is the number of the leaf")]
const fn low_half(key: u64) -> u32 {
    key as u32
}

#[expect(clippy::cast_possible_truncation, reason = "counts are checked before the build")]
const fn as_u32(i: usize) -> u32 {
    i as u32
}

#[expect(clippy::cast_possible_truncation, reason = "a cluster has at most 24 corners")]
const fn as_u8(i: usize) -> u8 {
    i as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_leave_full_subtrees() {
        for n in MAX_LEAVES + 1..5000 {
            let left = left_size(n);
            assert!(left > 0 && left < n, "{left} of {n}");
            assert_eq!(left % MAX_LEAVES, 0, "full clusters on the left of {n}");
            assert!(
                n < 4 * MAX_LEAVES || left * 8 >= n * 3 - 8 && left * 8 <= n * 5 + 8,
                "{left} of {n}"
            );
        }
    }

    #[test]
    fn ascending_bits_keep_the_order() {
        let sorted = [f32::NEG_INFINITY, -2.0, -1e-40, 0.0, 1e-40, 3.0, f32::INFINITY];
        assert!(sorted.windows(2).all(|pair| ascending_bits(pair[0]) < ascending_bits(pair[1])));
    }
}
