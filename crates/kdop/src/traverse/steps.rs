//! Pairs of leaves of two trees during a step in which all points move on straight lines.
//!
//! Both ends of the step are bounded apart, and not the ways between them: leaves that move side by
//! side stay as far apart in their bounds as they are, however far they go. Along a direction in
//! which one bound is above the other at both ends, it is so all the time, since the projections of
//! all points are linear in time. So a pair is left out where such a direction exists, and no pair
//! that meets is left out.

use wide::f32x4;

use crate::cluster::HALVES;
use crate::dop4::{Dop4, SplatDop, pairs_of_turns, set_bits};
use crate::node::Child;
use crate::tree::DopTree;
use crate::workspace::{Counters, LeafCache, Workspace};

/// Distances by which bounds are moved outward at both ends, per direction.
type Margins<const S: usize> = [[f32; S]; 2];

/// Bounds of one tree at the start and at the end of a step.
#[derive(Debug)]
pub struct StepTree<'a, const S: usize = 9> {
    ends: [&'a DopTree<S>; 2],
}

impl<const S: usize> Clone for StepTree<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<const S: usize> Copy for StepTree<'_, S> {}

impl<'a, const S: usize> StepTree<'a, S> {
    /// Returns the bounds of a step, by a tree that was refit to its start and a clone of it that
    /// was refit to its end; `None` for trees of other leaves or another arrangement.
    #[must_use]
    pub fn new(start: &'a DopTree<S>, end: &'a DopTree<S>) -> Option<Self> {
        start.has_arrangement_of(end).then_some(Self { ends: [start, end] })
    }

    /// Returns the bounds of leaves that rest.
    #[must_use]
    pub fn at_rest(tree: &'a DopTree<S>) -> Self {
        Self { ends: [tree; 2] }
    }

    /// Returns the tree at the start of the step.
    #[must_use]
    pub fn start(&self) -> &'a DopTree<S> {
        self.ends[0]
    }

    /// Visits every pair of a leaf of this tree and one of the other that may come within `margin`
    /// (a length, `>= 0`) of each other during the step.
    ///
    /// No pair that does is left out. The order of visits depends on the trees alone.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, StepTree, Tree, Workspace};
    ///
    /// let x0 = [DVec3::ZERO, DVec3::X * 3.0];
    /// let x1 = x0.map(|x| x + DVec3::X * 100.0);
    /// let start = Tree::build(Leaves::Points, &x0[..1])?;
    /// let mut end = start.clone();
    /// end.refit(&x1[..1])?;
    /// let other_start = Tree::build(Leaves::Points, &x0[1..])?;
    /// let mut other_end = other_start.clone();
    /// other_end.refit(&x1[1..])?;
    ///
    /// // Side by side on the same way, they never meet, but the first meets a point at rest.
    /// let first = StepTree::new(&start, &end).ok_or("one arrangement")?;
    /// let second = StepTree::new(&other_start, &other_end).ok_or("one arrangement")?;
    /// let mut workspace = Workspace::default();
    /// first.pairs(&second, 0.0, &mut workspace, |_, _| panic!("they are 3 apart"));
    /// let mut met = 0;
    /// first.pairs(&StepTree::at_rest(&other_start), 0.0, &mut workspace, |_, _| met += 1);
    /// assert_eq!(met, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pairs(
        &self,
        other: &Self,
        margin: f64,
        workspace: &mut Workspace<S>,
        visit: impl FnMut(u32, u32),
    ) {
        let [start, end] = self.ends;
        let margins = start.widening(margin).zip(end.widening(margin)).map(<[_; 2]>::from);
        self.gather_cluster_pairs(other, margins.as_ref(), workspace);
        self.visit_leaf_pairs(other, margins.as_ref(), workspace, visit);
    }

    /// Lists the pairs of clusters that may meet, by descent from the roots.
    fn gather_cluster_pairs(
        &self,
        other: &Self,
        margins: Option<&Margins<S>>,
        workspace: &mut Workspace<S>,
    ) {
        let Workspace { node_pairs, nodes, cluster_pairs, counters, .. } = workspace;
        *counters = Counters::default();
        cluster_pairs.clear();
        node_pairs.clear();
        if !self.start().nodes.is_empty() && !other.start().nodes.is_empty() {
            node_pairs.push((0, 0));
        }

        while let Some((i, j)) = node_pairs.pop() {
            let widened;
            let a = match margins {
                Some(margins) => {
                    widened = self.widened(i, margins);
                    widened.each_ref()
                }
                None => self.bounds(i),
            };
            let b = other.bounds(j);
            let children_a = &self.start().nodes[i as usize].children;
            let children_b = &other.start().nodes[j as usize].children;
            counters.bound_tests += 1;

            for bit in set_bits(meet(a, b)) {
                let (lane_a, lane_b) = (bit / 4, bit % 4);
                match (children_a[lane_a].get(), children_b[lane_b].get()) {
                    (Child::Node(x), Child::Node(y)) => node_pairs.push((x, y)),
                    (Child::Cluster(x), Child::Cluster(y)) => cluster_pairs.push((x, y)),
                    // One side has no more nodes: descend the other alone.
                    (Child::Cluster(x), Child::Node(y)) => {
                        let bound = [a[0].splat(lane_a), a[1].splat(lane_a)];
                        let found = |y| cluster_pairs.push((x, y));
                        counters.bound_tests += other.clusters_below(y, None, &bound, nodes, found);
                    }
                    (Child::Node(x), Child::Cluster(y)) => {
                        let bound = [b[0].splat(lane_b), b[1].splat(lane_b)];
                        let found = |x| cluster_pairs.push((x, y));
                        counters.bound_tests +=
                            self.clusters_below(x, margins, &bound, nodes, found);
                    }
                    (Child::None, _) | (_, Child::None) => {}
                }
            }
        }
    }

    /// Returns the bounds of the children of a node at both ends.
    #[inline(always)]
    fn bounds(&self, node: u32) -> [&Dop4<S>; 2] {
        let [start, end] = self.ends;
        [&start.nodes[node as usize].bounds, &end.nodes[node as usize].bounds]
    }

    /// Returns the bounds of the children of a node at both ends, moved outward.
    #[inline(always)]
    fn widened(&self, node: u32, margins: &Margins<S>) -> [Dop4<S>; 2] {
        let [start, end] = self.bounds(node);
        [start.widened(&margins[0]), end.widened(&margins[1])]
    }

    /// Finds the clusters below a node that may meet one bound; returns the number of tests.
    fn clusters_below(
        &self,
        node: u32,
        margins: Option<&Margins<S>>,
        bound: &[SplatDop<S>; 2],
        stack: &mut Vec<u32>,
        mut found: impl FnMut(u32),
    ) -> u64 {
        let mut tests = 0;
        stack.clear();
        stack.push(node);
        while let Some(node) = stack.pop() {
            tests += 1;
            let widened;
            let bounds = match margins {
                Some(margins) => {
                    widened = self.widened(node, margins);
                    widened.each_ref()
                }
                None => self.bounds(node),
            };
            for lane in set_bits(meet_one(bounds, bound)) {
                match self.start().nodes[node as usize].children[lane].get() {
                    Child::Node(below) => stack.push(below),
                    Child::Cluster(cluster) => found(cluster),
                    Child::None => {}
                }
            }
        }
        tests
    }

    /// Tests the leaves of every pair of clusters listed.
    fn visit_leaf_pairs(
        &self,
        other: &Self,
        margins: Option<&Margins<S>>,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32),
    ) {
        let Workspace { cluster_pairs, step_leaves, counters, .. } = workspace;
        step_leaves.iter_mut().for_each(LeafCache::reset);
        let [a_start, a_end, b_start, b_end] = step_leaves;
        let (margin_at_start, margin_at_end) = margins.map(|[start, end]| (start, end)).unzip();
        for &(a, b) in &*cluster_pairs {
            counters.clusters += 1;
            let bounds_a = [
                a_start.get(self.ends[0], a, margin_at_start),
                a_end.get(self.ends[1], a, margin_at_end),
            ];
            let bounds_b = [b_start.get(other.ends[0], b, None), b_end.get(other.ends[1], b, None)];
            let (a, b) = (self.start().clusters.get(a), other.start().clusters.get(b));

            // Unions of four leaves reject most halves before sixteen pairs are tested.
            for h in 0..HALVES * HALVES {
                let (half_a, half_b) = (h / HALVES, h % HALVES);
                let ([a0, a1], [b0, b1]) = (bounds_a, bounds_b);
                let (union, union_end) = (&a0.unions[half_a], &a1.unions[half_a]);
                if !union.meets::<S>(union_end, &b0.unions[half_b], &b1.unions[half_b]) {
                    continue;
                }
                let halves_a = [&a0.halves[half_a], &a1.halves[half_a]];
                let hits = meet(halves_a, [&b0.halves[half_b], &b1.halves[half_b]]);
                counters.bound_tests += 1;
                for bit in set_bits(hits) {
                    let leaf_a = self.start().leaf(a, 4 * half_a + bit / 4);
                    let leaf_b = other.start().leaf(b, 4 * half_b + bit % 4);
                    if let (Some(leaf_a), Some(leaf_b)) = (leaf_a, leaf_b) {
                        counters.reported += 1;
                        visit(leaf_a, leaf_b);
                    }
                }
            }
        }
    }
}

/// Tests four bounds against four, as [`Dop4::overlaps`], over a step.
#[inline(always)]
fn meet<const S: usize>(a: [&Dop4<S>; 2], b: [&Dop4<S>; 2]) -> u32 {
    let turns = |k: usize| {
        [
            Dop4::turned_meet::<0>(a, b, k),
            Dop4::turned_meet::<1>(a, b, k),
            Dop4::turned_meet::<2>(a, b, k),
            Dop4::turned_meet::<3>(a, b, k),
        ]
    };
    let both = |[a, b, c, d]: [f32x4; 4], [e, f, g, h]: [f32x4; 4]| [a & e, b & f, c & g, d & h];

    // Most bounds that do not meet are apart along one of the axes.
    let mut all = both(both(turns(0), turns(1)), turns(2));
    if S > 3 {
        if !(all[0] | all[1] | all[2] | all[3]).any() {
            return 0;
        }
        for k in 3..S {
            all = both(all, turns(k));
        }
    }
    pairs_of_turns(all)
}

/// Tests four bounds against one, as [`Dop4::overlaps_one`], over a step.
#[inline(always)]
fn meet_one<const S: usize>(four: [&Dop4<S>; 2], one: &[SplatDop<S>; 2]) -> u32 {
    let mut hit = Dop4::lanes_meet(four, one, 0);
    for k in 1..S {
        hit &= Dop4::lanes_meet(four, one, k);
    }
    hit.to_bitmask()
}
