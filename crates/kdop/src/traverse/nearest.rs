//! Leaves in order of how near they may be.
//!
//! Source: G. R. Hjaltason and H. Samet, "Distance Browsing in Spatial Databases", ACM TODS 24(2),
//! 1999: best first, with a queue of nodes and leaves by lower bounds of their distances.

use std::cmp::Ordering;

use glam::DVec3;

use crate::cluster::LeafQuads;
use crate::directions::{norm, project};
use crate::dop::rounding_loss;
use crate::quad::Quad;
use crate::tree::{Below, Child, DopTree};
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits leaves by increasing lower bound of their distance from `point`, until that bound
    /// exceeds the least distance found.
    ///
    /// `within` is a distance beyond which nothing matters; it may be infinite. `visit` is given a
    /// leaf and the bound of its distance, and returns the distance beyond which nothing matters
    /// from then on: usually the least of what it returned before and the exact distance of the
    /// leaf. A leaf at that very distance is still visited, so of equals the caller can choose the
    /// lowest number.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points = [DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0), DVec3::X * 9.0];
    /// let tree = Tree::build(Leaves::Points, &points)?;
    /// let from = DVec3::new(3.0, 3.0, 0.0);
    /// let mut best = (f64::INFINITY, u32::MAX);
    /// tree.nearest(from, f64::INFINITY, &mut Workspace::default(), |leaf, _| {
    ///     let distance = points[leaf as usize].distance(from);
    ///     if (distance, leaf) < best {
    ///         best = (distance, leaf);
    ///     }
    ///     best.0
    /// });
    /// assert_eq!(best, (1.0, 1));
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn nearest(
        &self,
        point: DVec3,
        within: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, f64) -> f64,
    ) {
        self.nearest_to_hull(&[point], within, workspace, visit);
    }

    /// As [`nearest`](Self::nearest), with distances from the convex hull of `points` (finite, at
    /// least one): a triangle's three corners, for instance.
    pub fn nearest_to_hull(
        &self,
        points: &[DVec3],
        within: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, f64) -> f64,
    ) {
        let Workspace { heap, counters, .. } = workspace;
        *counters = Counters::default();
        heap.clear();
        if self.nodes.is_empty() {
            return;
        }
        let target = Target::new(self, points);
        let mut within = within;
        heap.push(Entry { bound: 0.0, place: Place::Below(Child::node(0)) });
        while let Some(Entry { bound, place }) = heap.pop() {
            if bound > within {
                break;
            }
            let mut push = |bound: f64, place: Place| {
                if bound <= within {
                    heap.push(Entry { bound, place });
                }
            };
            match place {
                Place::Leaf(leaf) => {
                    counters.reported += 1;
                    within = visit(leaf, bound);
                }
                Place::Below(child) => match child.below() {
                    Below::Node(node) => {
                        let node = &self.nodes[node as usize];
                        counters.quad_tests += 1;
                        for (bound, child) in
                            target.distances(&node.quad).into_iter().zip(node.children)
                        {
                            if child != Child::NOTHING {
                                push(bound, Place::Below(child));
                            }
                        }
                    }
                    Below::Cluster(cluster) => {
                        let cluster = &self.clusters[cluster as usize];
                        let mut bounds = LeafQuads::EMPTY;
                        cluster.bound_leaves(&self.cluster_points, &self.rows, &mut bounds);
                        counters.clusters += 1;
                        counters.quad_tests += bounds.quads.len() as u64;
                        let bounds = bounds.quads.iter().flat_map(|quad| target.distances(quad));
                        for (i, bound) in bounds.enumerate() {
                            if let Some(leaf) = self.leaf(cluster, i) {
                                push(bound, Place::Leaf(leaf));
                            }
                        }
                    }
                    Below::Nothing => {}
                },
            }
        }
    }
}

/// Something to be visited, and how near it may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    bound: f64,
    place: Place,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    Below(Child),
    Leaf(u32),
}

impl Ord for Entry {
    /// The nearest is the greatest, since a heap gives its greatest first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then_with(|| other.place.cmp(&self.place))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

/// Distances are not told apart beyond this, so that their squares stay finite.
const FARTHEST: f64 = 1e150;

/// What distances are measured from.
struct Target<const S: usize> {
    lo: [f64; S],
    hi: [f64; S],
    /// What rounding may have added to a gap along each direction.
    loss: [f64; S],
}

impl<const S: usize> Target<S> {
    fn new(tree: &DopTree<S>, points: &[DVec3]) -> Self {
        let (mut lo, mut hi) = ([f64::INFINITY; S], [f64::NEG_INFINITY; S]);
        let mut magnitude = 0.0_f64;
        for &point in points {
            let at = project::<S>(point);
            lo = std::array::from_fn(|k| lo[k].min(at[k]));
            hi = std::array::from_fn(|k| hi[k].max(at[k]));
            let size = point.abs();
            magnitude = magnitude.max(size.x + size.y + size.z);
        }
        let root = tree.root();
        let loss = std::array::from_fn(|k| {
            let stored = f64::from(root.lo[k].abs().max(root.hi[k].abs()));
            rounding_loss(stored)
                + 8.0 * f64::EPSILON * (magnitude + stored.min(f64::from(f32::MAX)))
        });
        Self { lo, hi, loss }
    }

    /// Lower bounds of the distances from four bounds: the distance from the box, or the widest
    /// gap along another direction where that is more.
    #[inline(always)]
    fn distances(&self, quad: &Quad<S>) -> [f64; 4] {
        let mut in_box = [0.0; 4];
        let mut widest = [0.0_f64; 4];
        for k in 0..S {
            let per_length = 1.0 / norm::<S>(k).powi(2);
            let [lo, hi] = quad.interval(k);
            let (lo, hi) = (lo.to_array(), hi.to_array());
            for lane in 0..4 {
                // A bound beyond the range of f32 may stand for the largest number within it.
                let below = f64::from(lo[lane].min(f32::MAX)) - self.hi[k];
                let above = self.lo[k] - f64::from(hi[lane].max(-f32::MAX));
                let gap = (below.max(above) - self.loss[k]).clamp(0.0, FARTHEST);
                if k < 3 {
                    in_box[lane] += gap * gap;
                } else {
                    widest[lane] = widest[lane].max(gap * gap * per_length);
                }
            }
        }
        std::array::from_fn(|lane| {
            in_box[lane].max(widest[lane]).sqrt() * (1.0 - 8.0 * f64::EPSILON)
        })
    }
}
