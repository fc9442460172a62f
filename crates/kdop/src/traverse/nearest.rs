//! Leaves by increasing distance from a point.
//!
//! Source: G. R. Hjaltason and H. Samet, "Distance Browsing in Spatial Databases", ACM TODS 24(2),
//! 1999: best-first search, with a priority queue of nodes and leaves by lower bounds of their
//! distances.

use glam::DVec3;
use wide::{f32x4, f64x4};

use crate::cluster::LeafDops;
use crate::directions::{norm, project};
use crate::dop::rounding_loss;
use crate::dop4::Dop4;
use crate::node::{Child, ChildRef};
use crate::projections::to_nearest;
use crate::queue::{Queue, QueueEntry, QueueItem};
use crate::tree::DopTree;
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits leaves by increasing lower bound of their distance from `point`, until that bound
    /// exceeds the smallest distance found.
    ///
    /// `within` limits the distances of interest; it may be infinite. `visit` takes a leaf and the
    /// lower bound of its distance, and returns the new limit: usually the smaller of the previous
    /// one and the exact distance of the leaf. A leaf whose bound equals the limit is still
    /// visited, so of equally near leaves the caller can choose the lowest number.
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
        mut within: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, f64) -> f64,
    ) {
        let Workspace { queue, counters, .. } = workspace;
        *counters = Counters::default();
        queue.clear();
        if self.nodes.is_empty() {
            return;
        }

        let distance = DistanceBound::new(self, point);
        queue.push(QueueEntry { bound: 0.0, item: QueueItem::Child(ChildRef::node(0)) });
        while let Some(QueueEntry { bound, item }) = queue.pop() {
            // Bounds ascend, so no later entry is within the limit either.
            if bound > within {
                break;
            }
            match item {
                QueueItem::Leaf(leaf) => {
                    counters.reported += 1;
                    within = visit(leaf, bound);
                }
                QueueItem::Child(child) => {
                    self.push_below(child, &distance, within, queue, counters);
                }
            }
        }
    }

    /// Visits leaves that may be within the smallest distance found, in an order that depends on the
    /// tree: as [`nearest`](Self::nearest), with bounds in single precision and without a queue.
    ///
    /// Several times as fast where `within` is little more than the smallest distance, as after a
    /// guess. It visits some more leaves elsewhere.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points = [DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0), DVec3::X * 9.0];
    /// let tree = Tree::build(Leaves::Points, &points)?;
    /// let from = DVec3::new(3.0, 3.0, 0.0);
    /// let mut best = (points[0].distance(from), 0);
    /// tree.nearest_unordered(from, best.0, &mut Workspace::default(), |leaf| {
    ///     let distance = points[leaf as usize].distance(from);
    ///     if (distance, leaf) < best {
    ///         best = (distance, leaf);
    ///     }
    ///     best.0
    /// });
    /// assert_eq!(best, (1.0, 1));
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn nearest_unordered(
        &self,
        point: DVec3,
        mut within: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        let Workspace { stack, counters, .. } = workspace;
        *counters = Counters::default();
        stack.clear();
        if self.nodes.is_empty() {
            return;
        }

        let distance = RoughBound::new(self, point);
        let to_box = distance.to_box();
        stack.push((0.0, ChildRef::node(0)));
        while let Some((bound, child)) = stack.pop() {
            if f64::from(bound) > within {
                continue;
            }
            match child.get() {
                Child::Node(node) => {
                    let node = &self.nodes[node as usize];
                    counters.bound_tests += 1;
                    let first = stack.len();
                    for (bound, child) in distance.to(&node.bounds).into_iter().zip(node.children) {
                        if child != ChildRef::NONE && f64::from(bound) <= within {
                            stack.push((bound, child));
                        }
                    }
                    // The nearest child is popped first, and shortens the search of the others.
                    sort_farthest_first(&mut stack[first..]);
                }
                Child::Cluster(cluster) => {
                    // A leaf costs about as much to visit as its bounds along all directions.
                    let cluster = self.clusters.get(cluster);
                    let boxes = self.clusters.leaf_boxes(cluster, &self.projections);
                    counters.clusters += 1;
                    counters.bound_tests += boxes.len() as u64;
                    for (h, half) in boxes.iter().enumerate() {
                        for (lane, bound) in to_box.to(half).into_iter().enumerate() {
                            let Some(leaf) = self.leaf(cluster, 4 * h + lane) else { break };
                            if f64::from(bound) <= within {
                                counters.reported += 1;
                                within = visit(leaf);
                            }
                        }
                    }
                }
                Child::None => {}
            }
        }
    }

    /// Pushes what is directly below a node or cluster, as far as it may be within the limit.
    #[inline(always)]
    fn push_below(
        &self,
        child: ChildRef,
        distance: &DistanceBound<S>,
        within: f64,
        queue: &mut Queue,
        counters: &mut Counters,
    ) {
        let mut push = |bound: f64, item: QueueItem| {
            if bound <= within {
                queue.push(QueueEntry { bound, item });
            }
        };
        match child.get() {
            Child::Node(node) => {
                let node = &self.nodes[node as usize];
                counters.bound_tests += 1;
                for (bound, child) in distance.to(&node.bounds).into_iter().zip(node.children) {
                    if child != ChildRef::NONE {
                        push(bound, QueueItem::Child(child));
                    }
                }
            }
            Child::Cluster(cluster) => {
                let cluster = self.clusters.get(cluster);
                let mut bounds = LeafDops::EMPTY;
                self.clusters.bound_leaves(cluster, &self.projections, &mut bounds);
                counters.clusters += 1;
                counters.bound_tests += bounds.halves.len() as u64;
                for (h, half) in bounds.halves.iter().enumerate() {
                    for (lane, bound) in distance.to(half).into_iter().enumerate() {
                        if let Some(leaf) = self.leaf(cluster, 4 * h + lane) {
                            push(bound, QueueItem::Leaf(leaf));
                        }
                    }
                }
            }
            Child::None => {}
        }
    }
}

/// Sorts the children of a node by their bounds, from the largest.
///
/// A function of its own, so that sorting is compiled once per crate and not for each `visit`.
#[inline]
fn sort_farthest_first(children: &mut [(f32, ChildRef)]) {
    children.sort_unstable_by(|p, q| q.0.total_cmp(&p.0));
}

/// Distances are not distinguished beyond this, so that their squares stay finite.
const MAX_DISTANCE: f64 = 1e150;

/// Lower bound of the distance from a point to a k-DOP.
struct DistanceBound<const S: usize> {
    /// The point, projected.
    at: [f64; S],
    /// Bound on the rounding error of a gap along each direction.
    rounding: [f64; S],
}

impl<const S: usize> DistanceBound<S> {
    fn new(tree: &DopTree<S>, point: DVec3) -> Self {
        let size = point.abs();
        let magnitude = size.x + size.y + size.z;
        let root = tree.root();
        let rounding = std::array::from_fn(|k| {
            let stored = f64::from(root.lo[k].abs().max(root.hi[k].abs()));
            rounding_loss(stored)
                + 8.0 * f64::EPSILON * (magnitude + stored.min(f64::from(f32::MAX)))
        });
        Self { at: project(point), rounding }
    }

    /// Computes the distance to the box, or the widest gap along another direction where that is
    /// more, for each of four k-DOPs.
    #[inline(always)]
    fn to(&self, bounds: &Dop4<S>) -> [f64; 4] {
        let (mut in_box, mut widest) = (f64x4::ZERO, f64x4::ZERO);
        for k in 0..S {
            // A bound beyond the range of f32 may stand for the largest number within it.
            let lo = in_f64(bounds.lower(k).fast_min(f32x4::splat(f32::MAX)));
            let hi = in_f64(bounds.upper(k).fast_max(f32x4::splat(-f32::MAX)));
            let at = f64x4::splat(self.at[k]);
            let gap = (lo - at).fast_max(at - hi) - f64x4::splat(self.rounding[k]);
            let gap = gap.fast_max(f64x4::ZERO).fast_min(f64x4::splat(MAX_DISTANCE));
            if k < 3 {
                in_box += gap * gap;
            } else {
                let per_length = 1.0 / norm::<S>(k).powi(2);
                widest = widest.fast_max(gap * gap * f64x4::splat(per_length));
            }
        }
        let distance = in_box.fast_max(widest).sqrt();
        (distance * f64x4::splat(1.0 - 8.0 * f64::EPSILON)).to_array()
    }
}

/// Lower bound of the distance from a point to a k-DOP, in single precision.
struct RoughBound<const S: usize> {
    /// The point, projected.
    at: [f32; S],
    /// Bound on the rounding error of a gap along each direction.
    rounding: [f32; S],
}

impl<const S: usize> RoughBound<S> {
    fn new(tree: &DopTree<S>, point: DVec3) -> Self {
        let exact = project::<S>(point);
        let root = tree.root();
        Self {
            // A point beyond the range of f32 is farther than one at the end of it.
            at: exact.map(|at| to_nearest(at).clamp(-f32::MAX, f32::MAX)),
            // The stored bound, the point and their difference are rounded to single precision.
            rounding: std::array::from_fn(|k| {
                let stored = f64::from(root.lo[k].abs().max(root.hi[k].abs()));
                let rounding = 4.0 * (rounding_loss(stored) + rounding_loss(exact[k].abs()));
                to_nearest(rounding + SQUARE_UNDERFLOW)
            }),
        }
    }

    /// Returns the bound of the distance to boxes.
    fn to_box(&self) -> RoughBound<3> {
        let axes = |row: &[f32; S]| std::array::from_fn(|k| row[k]);
        RoughBound { at: axes(&self.at), rounding: axes(&self.rounding) }
    }

    /// Computes the distance to the box, or the widest gap along another direction where that is
    /// more, for each of four k-DOPs.
    #[inline(always)]
    fn to(&self, bounds: &Dop4<S>) -> [f32; 4] {
        let (mut in_box, mut widest) = (f32x4::ZERO, f32x4::ZERO);
        for k in 0..S {
            // A bound beyond the range of f32 may stand for the largest number within it.
            let lo = bounds.lower(k).fast_min(f32x4::splat(f32::MAX));
            let hi = bounds.upper(k).fast_max(f32x4::splat(-f32::MAX));
            let at = f32x4::splat(self.at[k]);
            let gap = (lo - at).fast_max(at - hi) - f32x4::splat(self.rounding[k]);
            let gap = gap.fast_max(f32x4::ZERO).fast_min(f32x4::splat(MAX_ROUGH_DISTANCE));
            if k < 3 {
                in_box += gap * gap;
            } else {
                let per_length = to_nearest(1.0 / norm::<S>(k).powi(2));
                widest = widest.fast_max(gap * gap * f32x4::splat(per_length));
            }
        }
        let distance = in_box.fast_max(widest).sqrt();
        (distance * f32x4::splat(1.0 - 8.0 * f32::EPSILON)).to_array()
    }
}

/// Allowance of gaps for the underflow of their squares in single precision: 2⁻⁷⁴,
/// rounded up.
///
/// A square that underflows is off by up to 2⁻¹⁵⁰, and by half as much again where it is scaled by
/// the direction. A gap that is 2⁻⁷⁴ smaller has a square that is smaller by more.
const SQUARE_UNDERFLOW: f64 = 5.3e-23;

/// Distances in single precision are not distinguished beyond this, so that their squares stay
/// finite.
const MAX_ROUGH_DISTANCE: f32 = 1e18;

/// Converts single precision to double, exactly.
#[inline(always)]
fn in_f64(row: f32x4) -> f64x4 {
    f64x4::new(row.to_array().map(f64::from))
}
