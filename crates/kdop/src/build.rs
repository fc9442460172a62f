//! Arranging leaves: median splits along the widest direction, two to a node.
//!
//! Source: J. T. Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies
//! of k-DOPs", IEEE TVCG 4(1), 1998, section 4 (top down, by the median of centroids), and the
//! quadtrees of J. Mezger et al., Journal of WSCG 11(1), 2003. Differs in the size of the parts,
//! which is rounded so that all nodes and clusters but the last few are full.

use crate::cluster::{CLUSTER, Cluster};
use crate::directions::norm;
use crate::dop::Dop;
use crate::leaves::Leaves;
use crate::quad::Quad;
use crate::rows::{MAX_GROUPS, Rows, groups, load};
use crate::tree::{Child, DopTree, Node};
use wide::f32x4;

/// Fills nodes and clusters of a tree whose rows are set; bounds are left to a sweep.
pub(crate) fn arrange<const S: usize>(tree: &mut DopTree<S>, leaves: Leaves<'_>, count: u32) {
    let n = count as usize;
    let centroids = (0..count).map(|leaf| centroid(&tree.rows, leaves.corners(leaf))).collect();
    let mut builder =
        Builder { tree, leaves, centroids, order: (0..count).collect(), keys: vec![] };
    builder.tree.clusters.reserve(n / CLUSTER + n / (8 * CLUSTER));
    if n > 0 {
        builder.node(0..n);
    }
    builder.tree.leaves = builder.order;
    builder.tree.nodes.shrink_to_fit();
    builder.tree.clusters.shrink_to_fit();
    builder.tree.cluster_points.shrink_to_fit();
}

type Range = std::ops::Range<usize>;

struct Builder<'a, const S: usize> {
    tree: &'a mut DopTree<S>,
    leaves: Leaves<'a>,
    /// Six times the projected centroid of every leaf.
    centroids: Vec<[f32; S]>,
    /// Leaves in tree order, as far as it is known.
    order: Vec<u32>,
    /// Room for the splits: where a leaf lies along a direction, and its number.
    keys: Vec<u64>,
}

impl<const S: usize> Builder<'_, S> {
    /// Makes a node of a range of leaves and all that hangs below; parents come first.
    ///
    /// A half that fits a full subtree is not halved again: a node near the root then has two or
    /// three children, and the many at the bottom have four.
    fn node(&mut self, range: Range) -> Child {
        let id = index(self.tree.nodes.len());
        self.tree.nodes.push(Node { quad: Quad::EMPTY, children: [Child::NOTHING; 4] });
        let full = full_subtree(range.len() - 1);
        let mut used = 0;
        for half in self.halves(range) {
            let parts = if half.len() > full { self.halves(half) } else { [half, 0..0] };
            for part in parts {
                if !part.is_empty() {
                    let child = self.child(part);
                    self.tree.nodes[id as usize].children[used] = child;
                    used += 1;
                }
            }
        }
        Child::node(id)
    }

    fn child(&mut self, range: Range) -> Child {
        if range.len() > CLUSTER { self.node(range) } else { self.cluster(range) }
    }

    /// The two parts of a range; one that fits a cluster is left whole.
    fn halves(&mut self, range: Range) -> [Range; 2] {
        if range.len() <= CLUSTER {
            return [range.clone(), range.end..range.end];
        }
        let middle = range.start + left_size(range.len());
        self.split(range.clone(), middle);
        [range.start..middle, middle..range.end]
    }

    /// Reorders a range so that the leaves before `middle` lie before those after it, along the
    /// direction in which the range is widest; of leaves that lie level the lower number is first.
    fn split(&mut self, range: Range, middle: usize) {
        let k = self.widest(range.clone());
        self.keys.clear();
        let order = &mut self.order[range.clone()];
        self.keys.extend(order.iter().map(|&leaf| {
            u64::from(ascending(self.centroids[leaf as usize][k])) << 32 | u64::from(leaf)
        }));
        self.keys.select_nth_unstable(middle - range.start);
        for (leaf, &key) in order.iter_mut().zip(&self.keys) {
            *leaf = low_half(key);
        }
    }

    fn widest(&self, range: Range) -> usize {
        let mut lo = [f32x4::splat(f32::INFINITY); MAX_GROUPS];
        let mut hi = [f32x4::splat(f32::NEG_INFINITY); MAX_GROUPS];
        for &leaf in &self.order[range] {
            let row = &self.centroids[leaf as usize];
            for g in 0..groups::<S>() {
                lo[g] = lo[g].fast_min(load(row, g));
                hi[g] = hi[g].fast_max(load(row, g));
            }
        }
        crate::rows::Packed { lo, hi }.to_dop::<S>().widest().0
    }

    /// Makes a cluster of at most [`CLUSTER`] leaves.
    fn cluster(&mut self, range: Range) -> Child {
        if range.len() > 4 {
            self.split(range.clone(), range.start + 4);
        }
        let id = index(self.tree.clusters.len());
        let points = &mut self.tree.cluster_points;
        let first_point = points.len();
        let mut corners = [[0; 3]; CLUSTER];
        for (leaf, corners) in self.order[range.clone()].iter().zip(&mut corners) {
            *corners = self.leaves.corners(*leaf).map(|point| local(points, first_point, point));
        }
        self.tree.clusters.push(Cluster {
            first_leaf: index(range.start),
            first_point: index(first_point),
            leaf_count: small(range.len()),
            point_count: small(points.len() - first_point),
            corners,
        });
        Child::cluster(id)
    }
}

/// Position of a point among those of the cluster that began at `first`; added where it is new.
fn local(points: &mut Vec<u32>, first: usize, point: u32) -> u8 {
    let known = points[first..].iter().position(|&p| p == point);
    small(known.unwrap_or_else(|| {
        points.push(point);
        points.len() - 1 - first
    }))
}

/// Six times the centroid of a leaf's bounds, projected.
fn centroid<const S: usize>(rows: &Rows<S>, corners: [u32; 3]) -> [f32; S] {
    let (lo, hi) = (rows.lo(), rows.hi());
    let [a, b, c] = corners.map(|p| p as usize);
    std::array::from_fn(|k| lo[a][k] + hi[a][k] + (lo[b][k] + hi[b][k]) + (lo[c][k] + hi[c][k]))
}

/// How many of `n > CLUSTER` leaves go left: half, rounded to a whole number of the largest full
/// subtrees that are at most a quarter, so the imbalance stays below an eighth.
const fn left_size(n: usize) -> usize {
    let unit = full_subtree(n / 4);
    (n / 2 + unit / 2) / unit * unit
}

/// Leaves of the largest full subtree, or cluster, of at most `n`; of one cluster where `n` is less.
const fn full_subtree(n: usize) -> usize {
    let mut size = CLUSTER;
    while 4 * size <= n {
        size *= 4;
    }
    size
}

/// Maps floats to integers of the same order.
fn ascending(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

#[expect(clippy::cast_possible_truncation, reason = "the low half is what is wanted")]
const fn low_half(key: u64) -> u32 {
    key as u32
}

#[expect(clippy::cast_possible_truncation, reason = "counts are checked when a build begins")]
const fn index(i: usize) -> u32 {
    i as u32
}

#[expect(clippy::cast_possible_truncation, reason = "a cluster has at most 24 corners")]
const fn small(i: usize) -> u8 {
    i as u8
}

impl<const S: usize> Dop<S> {
    /// The direction of greatest extent, the first of equals, and that extent as a length.
    pub(crate) fn widest(&self) -> (usize, f64) {
        let mut best = (0, 0.0);
        for k in 0..S {
            let width = (f64::from(self.hi[k]) - f64::from(self.lo[k])) / norm::<S>(k);
            if width > best.1 {
                best = (k, width);
            }
        }
        best
    }

    /// The greatest extent, as a length; 0 for nothing, and where it is beyond f32.
    pub(crate) fn width(&self) -> f64 {
        let width = self.widest().1;
        if width.is_finite() { width } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_leave_full_subtrees() {
        for n in CLUSTER + 1..5000 {
            let left = left_size(n);
            assert!(left > 0 && left < n, "{left} of {n}");
            assert_eq!(left % CLUSTER, 0, "full clusters on the left of {n}");
            assert!(
                n < 4 * CLUSTER || left * 8 >= n * 3 - 8 && left * 8 <= n * 5 + 8,
                "{left} of {n}"
            );
        }
    }

    #[test]
    fn ascending_keeps_the_order() {
        let sorted = [f32::NEG_INFINITY, -2.0, -1e-40, 0.0, 1e-40, 3.0, f32::INFINITY];
        assert!(sorted.windows(2).all(|pair| ascending(pair[0]) < ascending(pair[1])));
    }
}
