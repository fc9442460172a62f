//! Leaves that meet a bound, or a ray along an axis.

use glam::DVec3;
use wide::f32x4;

use crate::cluster::LeafDops;
use crate::directions::{Axis, direction};
use crate::dop::Dop;
use crate::dop4::{Dop4, SplatDop, set_bits};
use crate::node::Child;
use crate::tree::DopTree;
use crate::workspace::{Counters, Workspace};

impl<const S: usize> DopTree<S> {
    /// Visits every leaf whose bound overlaps the given one.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Dop18, Leaves, Tree, Workspace};
    ///
    /// let tree = Tree::build(Leaves::Points, &[DVec3::ZERO, DVec3::X * 3.0])?;
    /// let mut near = Vec::new();
    /// let around = Dop18::from_points(&[DVec3::X * 2.0]).inflated(1.5);
    /// tree.query(&around, &mut Workspace::default(), |leaf| near.push(leaf));
    /// assert_eq!(near, [1]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn query(&self, bound: &Dop<S>, workspace: &mut Workspace<S>, visit: impl FnMut(u32)) {
        let bound = SplatDop::new(bound);
        self.visit_where(|bounds| bounds.overlaps_one(&bound), |_, _| true, workspace, visit);
    }

    /// Visits the leaves that [`query`](Self::query) does, but descends only where `wanted` holds
    /// for the lower and upper corner of the axis-aligned box around all that is below.
    ///
    /// `wanted` has to hold for a box if it holds for any part of it. It is called for groups of
    /// up to eight leaves, not for single ones.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree, Workspace};
    ///
    /// let points: Vec<DVec3> = (0..100).map(|k| DVec3::X * f64::from(k)).collect();
    /// let tree = Tree::build(Leaves::Points, &points)?;
    /// let mut found = Vec::new();
    /// let left = |[lower, _]: [DVec3; 2]| lower.x < 30.0;
    /// tree.query_where(&tree.root(), left, &mut Workspace::default(), |leaf| found.push(leaf));
    /// assert!((0..30).all(|leaf| found.contains(&leaf)) && found.len() < 40);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    pub fn query_where(
        &self,
        bound: &Dop<S>,
        mut wanted: impl FnMut([DVec3; 2]) -> bool,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32),
    ) {
        let bound = SplatDop::new(bound);
        let wanted = |bounds: &Dop4<S>, lane: usize| wanted(bounds.lane_box(lane));
        self.visit_where(|bounds| bounds.overlaps_one(&bound), wanted, workspace, visit);
    }

    /// Visits every leaf whose bound meets the ray from `origin` along `axis`.
    ///
    /// The crossings of the ray with these leaves decide by their parity whether `origin` is inside
    /// a closed surface. The ray is unbounded ahead, so 13 of the 18 comparisons with an 18-DOP are
    /// needed.
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
        visit: impl FnMut(u32),
    ) {
        let ray = Ray::new(origin, axis);
        self.visit_where(|bounds| ray.hits(bounds), |_, _| true, workspace, visit);
    }

    /// Descends into the lanes that `test` returns and that are wanted.
    fn visit_where(
        &self,
        test: impl Fn(&Dop4<S>) -> u32,
        mut wanted: impl FnMut(&Dop4<S>, usize) -> bool,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32),
    ) {
        let Workspace { nodes: stack, counters, .. } = workspace;
        *counters = Counters::default();
        stack.clear();
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            counters.bound_tests += 1;
            for lane in set_bits(test(&node.bounds)) {
                if !wanted(&node.bounds, lane) {
                    continue;
                }
                match node.children[lane].get() {
                    Child::Node(below) => stack.push(below),
                    Child::Cluster(cluster) => {
                        self.visit_leaves_where(cluster, &test, counters, &mut visit);
                    }
                    Child::None => {}
                }
            }
        }
    }

    /// Visits the leaves of a cluster that `test` returns.
    fn visit_leaves_where(
        &self,
        cluster: u32,
        test: impl Fn(&Dop4<S>) -> u32,
        counters: &mut Counters,
        visit: &mut impl FnMut(u32),
    ) {
        let cluster = self.clusters.get(cluster);
        let mut bounds = LeafDops::EMPTY;
        self.clusters.bound_leaves(cluster, &self.projections, &mut bounds);
        counters.clusters += 1;

        for (h, half) in bounds.halves.iter().enumerate() {
            counters.bound_tests += 1;
            for lane in set_bits(test(half)) {
                if let Some(leaf) = self.leaf(cluster, 4 * h + lane) {
                    counters.reported += 1;
                    visit(leaf);
                }
            }
        }
    }
}

/// Ray along an axis, as the comparisons with a k-DOP that can fail.
struct Ray<const S: usize> {
    lower_bounds: Comparisons<S>,
    upper_bounds: Comparisons<S>,
}

/// Values to compare with the bounds along some of the directions.
#[derive(Clone, Copy)]
struct Comparisons<const S: usize> {
    list: [(usize, f32x4); S],
    count: usize,
}

impl<const S: usize> Comparisons<S> {
    const NONE: Self = Self { list: [(0, f32x4::ZERO); S], count: 0 };

    fn push(&mut self, k: usize, value: f32) {
        self.list[self.count] = (k, f32x4::splat(value));
        self.count += 1;
    }
}

impl<const S: usize> Ray<S> {
    fn new(origin: DVec3, axis: Axis) -> Self {
        let start = Dop::<S>::from_points(&[origin]);
        let mut ray = Self { lower_bounds: Comparisons::NONE, upper_bounds: Comparisons::NONE };
        for k in 0..S {
            // Where the ray goes up along a direction, lower bounds may be anywhere.
            let along = direction::<S>(k)[axis as usize];
            if along <= 0.0 && start.hi[k] < f32::INFINITY {
                ray.lower_bounds.push(k, start.hi[k]);
            }
            if along >= 0.0 && start.lo[k] > f32::NEG_INFINITY {
                ray.upper_bounds.push(k, start.lo[k]);
            }
        }
        ray
    }

    /// Tests four bounds: bit `i` is set where lane `i` meets the ray.
    fn hits(&self, bounds: &Dop4<S>) -> u32 {
        // All lanes hit until a comparison fails.
        let mut hit = f32x4::splat(0.0).simd_le(f32x4::splat(0.0));
        for &(k, value) in &self.lower_bounds.list[..self.lower_bounds.count] {
            hit &= bounds.lower(k).simd_le(value);
        }
        if !hit.any() {
            return 0;
        }
        for &(k, value) in &self.upper_bounds.list[..self.upper_bounds.count] {
            hit &= value.simd_le(bounds.upper(k));
        }
        hit.to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_leaves_thirteen_comparisons() {
        let ray = Ray::<9>::new(DVec3::ZERO, Axis::X);
        assert_eq!(ray.lower_bounds.count + ray.upper_bounds.count, 13);
    }
}
