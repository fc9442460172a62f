//! Pairs of leaves of two trees, one of which moves rigidly: neither is refit.
//!
//! A node is bounded on its way by its box at both ends of the way and by a bound on how far points
//! leave the chords between them. The projection of a turned box is that of its center, more or less
//! the half extents times the absolute components of the direction in the box's frame. Leaves are
//! bounded in the same way by their points, which are boxes of no size.

use std::convert::Infallible;

use glam::{DAffine3, DVec3};
use wide::{f32x4, f64x4};

use crate::cluster::{LeafDops, MAX_LEAVES};
use crate::directions::{direction, norm};
use crate::dop::{Dop, rounding_loss};
use crate::dop4::{ALL_PAIRS, Dop4, set_bits};
use crate::moved_node::MovedNode;
use crate::node::Child;
use crate::projections::to_nearest;
use crate::tree::DopTree;
use crate::workspace::{Counters, Workspace};

/// Rigid motion of the points of a tree, bounded by the chords of their ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidSweep {
    /// Rigid maps from the positions of the tree to those at the start and at the end of the way.
    pub ends: [DAffine3; 2],
    /// Point among the positions of the tree, from which the deviation is measured.
    pub center: DVec3,
    /// Maximum distance of the center's way from its chord, `>= 0`.
    pub deviation: f64,
    /// Addition to that distance per distance from the center, `>= 0`.
    pub deviation_per_length: f64,
    /// Margin within which leaves are close, `>= 0`.
    pub margin: f64,
}

/// Pairs of leaves of a moving tree and one at rest that may come close.
#[derive(Debug)]
pub struct MovingPairs<'a, const S: usize> {
    moving: &'a DopTree<S>,
    motion: Motion<S>,
    other: &'a DopTree<S>,
    /// Holds the pairs of clusters.
    workspace: &'a mut Workspace<S>,
}

impl<const S: usize> MovingPairs<'_, S> {
    /// Returns true if no leaves come close.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.workspace.cluster_pairs.is_empty()
    }

    /// Visits every pair of a leaf of the moving tree and one of the other that come within the
    /// margin of each other. No such pair is left out.
    pub fn visit(self, mut visit: impl FnMut(u32, u32)) {
        let Self { moving, motion, other, workspace } = self;
        let bound =
            |cluster, bounds: &mut LeafDops<S>| motion.bound_leaves(moving, cluster, bounds);
        let visit = |leaf, of_other| {
            visit(leaf, of_other);
            Ok::<_, Infallible>(())
        };
        let Ok(()) = moving.visit_leaf_pairs(other, workspace, bound, visit);
    }
}

impl<const S: usize> DopTree<S> {
    /// Finds where leaves of this tree on its way may come within the margin of leaves of the other,
    /// which is at rest.
    ///
    /// Returns `None` where leaves that may be close leave their chords by more than
    /// `max_deviation`: the way is to be divided.
    ///
    /// ```
    /// use glam::{DAffine3, DVec3};
    /// use kdop::{Leaves, RigidSweep, Tree, Workspace};
    ///
    /// // A point on an arm of 10 turns by a quarter about z, past a point on its arc.
    /// let arm = Tree::build(Leaves::Points, &[DVec3::X * 10.0])?;
    /// let near_arc = Tree::build(Leaves::Points, &[DVec3::new(7.07, 7.07, 0.0)])?;
    /// let angle = std::f64::consts::FRAC_PI_2;
    /// let sweep = RigidSweep {
    ///     ends: [0.0, angle].map(DAffine3::from_rotation_z),
    ///     center: DVec3::ZERO,
    ///     deviation: 0.0,
    ///     deviation_per_length: angle * angle / 8.0,
    ///     margin: 0.0,
    /// };
    /// let mut workspace = Workspace::default();
    /// assert!(arm.moving_pairs(&sweep, &near_arc, 1.0, &mut workspace).is_none());
    ///
    /// let mut found = 0;
    /// let near = arm.moving_pairs(&sweep, &near_arc, 4.0, &mut workspace);
    /// near.expect("chords near enough").visit(|_, _| found += 1);
    /// assert_eq!(found, 1);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn moving_pairs<'a>(
        &'a self,
        sweep: &RigidSweep,
        other: &'a Self,
        max_deviation: f64,
        workspace: &'a mut Workspace<S>,
    ) -> Option<MovingPairs<'a, S>> {
        let motion = Motion::new(self, sweep);
        let is_complete = self.gather_moving_clusters(&motion, other, max_deviation, workspace);
        is_complete.then_some(MovingPairs { moving: self, motion, other, workspace })
    }

    /// Lists the pairs of clusters that overlap; returns false at the first that deviates too much.
    fn gather_moving_clusters(
        &self,
        motion: &Motion<S>,
        other: &Self,
        max_deviation: f64,
        workspace: &mut Workspace<S>,
    ) -> bool {
        let Workspace { node_pairs, nodes, cluster_pairs, moved, counters, .. } = workspace;
        *counters = Counters::default();
        cluster_pairs.clear();
        node_pairs.clear();
        moved.reset_to(MovedNode { bounds: Dop4::EMPTY, deviation: [0.0; 4] });
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            node_pairs.push((0, 0));
        }

        while let Some((i, j)) = node_pairs.pop() {
            let b = &other.nodes[j as usize];
            let a = *moved.get_with(i, |node| motion.bound(&self.nodes[i as usize].bounds, node));
            counters.bound_tests += 1;

            for bit in set_bits(a.bounds.overlaps(&b.bounds, ALL_PAIRS)) {
                let (lane_a, lane_b) = (bit / 4, bit % 4);
                let child_a = self.nodes[i as usize].children[lane_a].get();

                // Depth first, a cluster that deviates too much is found after few tests.
                if matches!(child_a, Child::Cluster(_)) && a.deviation[lane_a] > max_deviation {
                    return false;
                }
                match (child_a, b.children[lane_b].get()) {
                    (Child::Node(x), Child::Node(y)) => node_pairs.push((x, y)),
                    (Child::Cluster(x), Child::Cluster(y)) => cluster_pairs.push((x, y)),
                    (Child::Cluster(x), Child::Node(y)) => {
                        let bound = a.bounds.splat(lane_a);
                        let found = |y| cluster_pairs.push((x, y));
                        counters.bound_tests += other.clusters_below(y, &bound, nodes, found);
                    }
                    (Child::Node(x), Child::Cluster(y)) => {
                        let bound = b.bounds.splat(lane_b);
                        nodes.clear();
                        nodes.push(x);
                        while let Some(node) = nodes.pop() {
                            let below = &self.nodes[node as usize];
                            let a = moved.get_with(node, |node| motion.bound(&below.bounds, node));
                            counters.bound_tests += 1;
                            let found = |x| cluster_pairs.push((x, y));
                            if !a.children_near(below, &bound, max_deviation, nodes, found) {
                                return false;
                            }
                        }
                    }
                    (Child::None, _) | (_, Child::None) => {}
                }
            }
        }
        true
    }
}

/// Directions as a moving tree sees them at both ends of its way.
#[derive(Debug)]
struct Motion<const S: usize> {
    /// Each direction in the frame of the tree.
    rows: [[DVec3; S]; 2],
    /// Projection of the origin of the tree's frame.
    offsets: [[f64; S]; 2],
    sweep: RigidSweep,
    /// Margin, with the rounding of stored bounds.
    margin: f64,
}

/// Coordinates beyond this are not distinguished: bounds then hold everything.
const MAX_COORDINATE: f64 = 1e30;

impl<const S: usize> Motion<S> {
    fn new(tree: &DopTree<S>, sweep: &RigidSweep) -> Self {
        let mut motion = Self {
            rows: [[DVec3::ZERO; S]; 2],
            offsets: [[0.0; S]; 2],
            sweep: *sweep,
            margin: f64::INFINITY,
        };
        for (end, map) in sweep.ends.iter().enumerate() {
            let to_tree = map.matrix3.transpose();
            for k in 0..S {
                motion.rows[end][k] = to_tree * direction::<S>(k);
                motion.offsets[end][k] = direction::<S>(k).dot(map.translation);
            }
        }

        // Sizes of all coordinates before and after the maps.
        let root = tree.root();
        let mut size = sweep.center.abs().element_sum();
        for k in 0..3 {
            size += f64::from(root.lo[k].abs().max(root.hi[k].abs()));
        }
        for map in &sweep.ends {
            size += map.translation.abs().element_sum();
        }
        let on_way = sweep.deviation + sweep.deviation_per_length * 2.0 * size + sweep.margin;
        let largest = 2.0 * size + on_way;

        // Stored bounds are rounded to single precision before the map and after it, and those of
        // the other tree once: each by half an ulp per coordinate. Four ulps of the sum of all sizes
        // are more than all three, and than the rounding of the map in double precision.
        if largest < MAX_COORDINATE {
            motion.margin = sweep.margin + 4.0 * rounding_loss(largest);
        } else {
            // Projections may be infinite, of which differences are no numbers.
            motion.offsets = [[0.0; S]; 2];
            motion.sweep.center = DVec3::ZERO;
            motion.sweep.deviation_per_length = 0.0;
            motion.sweep.deviation = f64::INFINITY;
        }
        motion
    }

    /// Bounds the children of a node on their way.
    #[inline(always)]
    fn bound(&self, bounds: &Dop4<S>, moved: &mut MovedNode<S>) {
        let max = f32x4::splat(f32::MAX);
        let finite = |row: f32x4| in_f64(row.fast_min(max).fast_max(-max));
        let lower = [0, 1, 2].map(|k| finite(bounds.lower(k)));
        let upper = [0, 1, 2].map(|k| finite(bounds.upper(k)));
        *moved = self.bound_boxes(lower, upper);
    }

    /// Bounds four boxes on their way.
    #[inline(always)]
    fn bound_boxes(&self, lower: [f64x4; 3], upper: [f64x4; 3]) -> MovedNode<S> {
        let half = f64x4::splat(0.5);
        let centers: [f64x4; 3] = std::array::from_fn(|k| half * (lower[k] + upper[k]));
        let extents: [f64x4; 3] = std::array::from_fn(|k| half * (upper[k] - lower[k]));

        // The farthest corner of a box leaves its chord the most.
        let mut squared = f64x4::ZERO;
        for (k, center) in self.sweep.center.to_array().into_iter().enumerate() {
            let farthest = (centers[k] - f64x4::splat(center)).abs() + extents[k];
            squared += farthest * farthest;
        }
        let per_length = self.sweep.deviation_per_length * (1.0 + 8.0 * f64::EPSILON);
        let deviation =
            f64x4::splat(self.sweep.deviation) + f64x4::splat(per_length) * squared.sqrt();
        let outward = deviation + f64x4::splat(self.margin);

        // Both ends of the way, then outward.
        let (mut lo, mut hi) = ([f32x4::ZERO; S], [f32x4::ZERO; S]);
        for k in 0..S {
            let outward = outward * f64x4::splat(norm::<S>(k));
            let (mut least, mut most) = (f64x4::splat(f64::INFINITY), f64x4::splat(-f64::INFINITY));
            for end in 0..2 {
                let row = self.rows[end][k].to_array();
                let (mut at, mut extent) = (f64x4::splat(self.offsets[end][k]), f64x4::ZERO);
                for axis in 0..3 {
                    at += f64x4::splat(row[axis]) * centers[axis];
                    extent += f64x4::splat(row[axis].abs()) * extents[axis];
                }
                least = least.fast_min(at - extent);
                most = most.fast_max(at + extent);
            }
            lo[k] = in_f32(least - outward);
            hi[k] = in_f32(most + outward);
        }
        MovedNode { bounds: Dop4::from_rows(lo, hi), deviation: deviation.to_array() }
    }

    /// Bounds the leaves of a cluster on their way, by their points.
    fn bound_leaves(&self, tree: &DopTree<S>, cluster: u32, bounds: &mut LeafDops<S>) {
        let cluster = tree.clusters.get(cluster);
        let (lo, hi) = (tree.projections.lo(), tree.projections.hi());
        let points = tree.clusters.points_of(cluster);

        // Four points at a time; the last stands for those that are missing.
        let mut moved = [Dop::EMPTY; 3 * MAX_LEAVES];
        for (moved, points) in moved.chunks_mut(4).zip(points.chunks(4)) {
            let rows = |rows: &[[f32; S]]| {
                [0, 1, 2].map(|k| {
                    let lanes: [f64; 4] = std::array::from_fn(|lane| {
                        let point = points[lane.min(points.len() - 1)];
                        f64::from(rows[point as usize][k].clamp(-f32::MAX, f32::MAX))
                    });
                    f64x4::new(lanes)
                })
            };
            let four = self.bound_boxes(rows(lo), rows(hi));
            for (lane, moved) in moved.iter_mut().enumerate() {
                *moved = four.bounds.lane(lane);
            }
        }
        cluster.bound_leaves(bounds, |corner| {
            let Dop { lo, hi } = &moved[corner as usize];
            [lo, hi]
        });
    }
}

/// Converts single precision to double, exactly.
#[inline(always)]
fn in_f64(row: f32x4) -> f64x4 {
    f64x4::new(row.to_array().map(f64::from))
}

#[inline(always)]
fn in_f32(row: f64x4) -> f32x4 {
    f32x4::new(row.to_array().map(to_nearest))
}
