//! Leaves that one bound, or one ray along an axis, meets.

use std::convert::Infallible;
use std::ops::ControlFlow;

use glam::DVec3;
use wide::f32x4;

use super::unbroken;
use crate::cluster::LeafQuads;
use crate::directions::Axis;
use crate::dop::Dop;
use crate::quad::{Quad, Splat};
use crate::tree::{Below, DopTree};
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits every leaf whose bound overlaps the given one.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Dop18, Leaves, Tree, Workspace};
    ///
    /// let tree = Tree::build(Leaves::Points, &[DVec3::ZERO, DVec3::X * 3.0])?;
    /// let mut met = Vec::new();
    /// let around = Dop18::from_points(&[DVec3::X * 2.0]).inflated(1.5);
    /// tree.query(&around, &mut Workspace::default(), |leaf| met.push(leaf));
    /// assert_eq!(met, [1]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn query(&self, bound: &Dop<S>, workspace: &mut Workspace<S>, mut visit: impl FnMut(u32)) {
        unbroken(self.try_query(bound, workspace, |leaf| {
            visit(leaf);
            ControlFlow::<Infallible>::Continue(())
        }));
    }

    /// As [`query`](Self::query), but ends as soon as a visit breaks.
    pub fn try_query<B>(
        &self,
        bound: &Dop<S>,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let bound = Splat::new(bound);
        self.walk(|quad| quad.overlaps_one(&bound), |_| true, workspace, visit)
    }

    /// As [`query`](Self::query), but descends only where `wanted` holds of the axis-aligned box,
    /// as its lowest and highest corner, around all that is below.
    ///
    /// `wanted` has to hold of a box if it holds of any part of it. It is asked about groups of up
    /// to eight leaves, not about single ones.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points: Vec<DVec3> = (0..100).map(|k| DVec3::X * f64::from(k)).collect();
    /// let tree = Tree::build(Leaves::Points, &points)?;
    /// let mut met = Vec::new();
    /// let left = |[lo, _]: [DVec3; 2]| lo.x < 30.0;
    /// tree.query_where(&tree.root(), left, &mut Workspace::default(), |leaf| met.push(leaf));
    /// assert!((0..30).all(|leaf| met.contains(&leaf)) && met.len() < 40);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn query_where(
        &self,
        bound: &Dop<S>,
        wanted: impl FnMut([DVec3; 2]) -> bool,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32),
    ) {
        let bound = Splat::new(bound);
        unbroken(self.walk(
            |quad| quad.overlaps_one(&bound),
            wanted,
            workspace,
            |leaf| {
                visit(leaf);
                ControlFlow::<Infallible>::Continue(())
            },
        ));
    }

    /// Visits every leaf whose bound meets the half-infinite ray from `origin` along `axis`.
    ///
    /// Counting the crossings among them tells whether `origin` is inside a closed surface. A ray
    /// is unbounded ahead, so of the 18 comparisons with an 18-DOP only 13 are made.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Axis, Leaves, Tree, Workspace};
    ///
    /// let tree = Tree::build(Leaves::Points, &[DVec3::X, -DVec3::X])?;
    /// let mut ahead = Vec::new();
    /// tree.ray(DVec3::ZERO, Axis::X, &mut Workspace::default(), |leaf| ahead.push(leaf));
    /// assert_eq!(ahead, [0]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn ray(
        &self,
        origin: DVec3,
        axis: Axis,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32),
    ) {
        let ray = Ray::new(&Dop::from_ray(origin, axis));
        unbroken(self.walk(
            |quad| ray.hits(quad),
            |_| true,
            workspace,
            |leaf| {
                visit(leaf);
                ControlFlow::<Infallible>::Continue(())
            },
        ));
    }

    /// Descends where `test` finds lanes to descend into whose boxes are wanted.
    fn walk<B>(
        &self,
        test: impl Fn(&Quad<S>) -> u32,
        mut wanted: impl FnMut([DVec3; 2]) -> bool,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let Workspace { nodes: stack, counters, .. } = workspace;
        *counters = Counters::default();
        stack.clear();
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            counters.quad_tests += 1;
            for lane in lanes(test(&node.quad)) {
                if !wanted(node.quad.lane_box(lane)) {
                    continue;
                }
                match node.children[lane].below() {
                    Below::Node(below) => stack.push(below),
                    Below::Cluster(below) => {
                        self.walk_leaves(below, &test, counters, &mut visit)?;
                    }
                    Below::Nothing => {}
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn walk_leaves<B>(
        &self,
        cluster: u32,
        test: impl Fn(&Quad<S>) -> u32,
        counters: &mut Counters,
        visit: &mut impl FnMut(u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let cluster = &self.clusters[cluster as usize];
        let mut bounds = LeafQuads::EMPTY;
        cluster.bound_leaves(&self.cluster_points, &self.rows, &mut bounds);
        counters.clusters += 1;
        for (h, quad) in bounds.quads.iter().enumerate() {
            counters.quad_tests += 1;
            for lane in lanes(test(quad)) {
                if let Some(leaf) = self.leaf(cluster, 4 * h + lane) {
                    counters.reported += 1;
                    visit(leaf)?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

fn lanes(mut hits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (hits != 0).then(|| hits.trailing_zeros() as usize)?;
        hits &= hits - 1;
        Some(lane)
    })
}

/// A bound that is open on some sides, as the comparisons that can fail.
struct Ray<const S: usize> {
    /// `value <= hi` along a direction, for the first `uppers`.
    upper: [(usize, f32x4); S],
    uppers: usize,
    /// `lo <= value` along a direction, for the first `lowers`.
    lower: [(usize, f32x4); S],
    lowers: usize,
}

impl<const S: usize> Ray<S> {
    fn new(bound: &Dop<S>) -> Self {
        let none = [(0, f32x4::splat(0.0)); S];
        let mut ray = Self { upper: none, uppers: 0, lower: none, lowers: 0 };
        for k in 0..S {
            if bound.lo[k] > f32::NEG_INFINITY {
                ray.upper[ray.uppers] = (k, f32x4::splat(bound.lo[k]));
                ray.uppers += 1;
            }
            if bound.hi[k] < f32::INFINITY {
                ray.lower[ray.lowers] = (k, f32x4::splat(bound.hi[k]));
                ray.lowers += 1;
            }
        }
        ray
    }

    fn hits(&self, quad: &Quad<S>) -> u32 {
        let mut hit = f32x4::splat(0.0).simd_le(f32x4::splat(0.0));
        for &(k, value) in &self.lower[..self.lowers] {
            hit &= quad.interval(k)[0].simd_le(value);
        }
        if !hit.any() {
            return 0;
        }
        for &(k, value) in &self.upper[..self.uppers] {
            hit &= value.simd_le(quad.interval(k)[1]);
        }
        hit.to_bitmask()
    }
}
