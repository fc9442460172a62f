//! Trees of k-DOPs: build, refit, pairs, swept pairs and self pairs beside trees of boxes (a plain
//! one, and with the feature `peers` that of `parry3d`), and their memory.

use std::error::Error;

use fixtures::muscle::{Muscle, MuscleScene, Placement, scene};
use kdop::{Leaves, Tree, Workspace};

#[cfg(feature = "peers")]
use super::kdop_peers::{ParryTree, SweepTree, sweep_points};
use super::other_tree::OtherTree;
use super::plain_boxes::PlainTree;
use crate::measure::{Report, as_f64};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 700;

/// Bounds on the ratios to a tree of boxes at one number of faces.
struct Allowed {
    build: f64,
    refit: f64,
    pairs: f64,
    swept: f64,
    self_pairs: f64,
    /// Pairs of muscles along the axes, where boxes fit best.
    aligned: f64,
}

/// Bounds beside [`PlainTree`] at 6,500 and 80,000 faces.
const PLAIN: [Allowed; 2] = [
    Allowed { build: 0.7, refit: 0.9, pairs: 0.45, swept: 0.65, self_pairs: 0.3, aligned: 0.95 },
    Allowed { build: 0.7, refit: 0.9, pairs: 0.15, swept: 0.45, self_pairs: 0.3, aligned: 1.0 },
];

/// Bounds beside `parry3d`.
#[cfg(feature = "peers")]
const PARRY: [Allowed; 2] = [
    Allowed { build: 0.8, refit: 0.40, pairs: 1.0, swept: 1.1, self_pairs: 0.40, aligned: 1.30 },
    Allowed { build: 0.8, refit: 0.40, pairs: 0.35, swept: 0.60, self_pairs: 0.50, aligned: 0.9 },
];

/// Bounds on the refit over a bare sweep by `obvhs`.
#[cfg(feature = "peers")]
const SWEEP: [f64; 2] = [f64::INFINITY, 0.75];

/// Bound on candidates of muscles at an angle to the axes, over those of boxes.
const CANDIDATES: f64 = 1.0 / 3.0;

/// Muscles of one size.
struct Muscles {
    size: &'static str,
    /// At an angle to the axes, in contact.
    oblique: MuscleScene,
    /// Along the axes: there, candidates of boxes are few.
    aligned: MuscleScene,
}

/// Compares muscles of two sizes.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    for (number, (faces, size)) in [(6500, "6.5k"), (80_000, "80k")].into_iter().enumerate() {
        let [oblique, aligned] =
            [Placement::Oblique, Placement::Aligned].map(|placement| scene(faces, placement));
        let muscles = Muscles { size, oblique, aligned };
        beside::<PlainTree>(report, &muscles, &PLAIN[number]);
        candidates(report, &muscles);
        #[cfg(feature = "peers")]
        {
            beside::<ParryTree>(report, &muscles, &PARRY[number]);
            bare_sweep(report, size, &muscles.oblique.a, SWEEP[number]);
        }
        memory(report, size, &muscles.oblique.a);
    }
    Ok(())
}

/// Compares times with those of another tree.
fn beside<T: OtherTree>(report: &mut Report, muscles: &Muscles, allowed: &Allowed) {
    let Muscles { size, oblique, aligned } = muscles;
    build::<T>(report, size, &oblique.a, allowed.build);
    refit::<T>(report, size, &oblique.a, allowed.refit);
    for (name, scene, state, allowed) in [
        ("pairs, oblique", oblique, Trees::<T>::moved as fn(&Muscle) -> Trees<T>, allowed.pairs),
        ("swept pairs", oblique, Trees::swept, allowed.swept),
        ("pairs, aligned", aligned, Trees::moved, allowed.aligned),
    ] {
        let name = format!("{name} {size} / {}", T::NAME);
        pairs(report, &name, [&scene.a, &scene.b].map(state), allowed);
    }
    for (name, muscle) in [("straight", &oblique.a), ("bent", &oblique.u)] {
        let name = format!("self, {name} {size} / {}", T::NAME);
        self_pairs(report, &name, Trees::<T>::moved(muscle), allowed.self_pairs);
    }
}

/// Compares numbers of candidates with those of boxes, which are the same in any tree.
fn candidates(report: &mut Report, muscles: &Muscles) {
    let Muscles { size, oblique, aligned } = muscles;
    for (name, scene, state, allowed) in [
        ("pairs, oblique", oblique, Trees::moved as fn(&Muscle) -> Trees<PlainTree>, CANDIDATES),
        ("swept pairs", oblique, Trees::swept, 1.0),
        ("pairs, aligned", aligned, Trees::moved, 1.0),
    ] {
        let [mut a, b] = [&scene.a, &scene.b].map(state);
        let counts = [a.pair_count(&b), a.other.pairs(&b.other, &mut Vec::new())];
        report.ratio(format!("{name} {size}, candidates"), counts.map(as_f64), "", allowed);
    }
    for (name, muscle) in [("straight", &oblique.a), ("bent", &oblique.u)] {
        let mut trees = Trees::<PlainTree>::moved(muscle);
        let counts = [trees.self_pair_count(), trees.other.self_pairs(&mut Vec::new())];
        report.ratio(format!("self, {name} {size}, candidates"), counts.map(as_f64), "", 1.0);
    }
}

/// A muscle's tree and another, with the muscle's states in the precision of the latter.
struct Trees<T: OtherTree> {
    ours: Tree,
    other: T,
    states: [Vec<T::Point>; 2],
}

impl<T: OtherTree> Trees<T> {
    fn new(muscle: &Muscle) -> Self {
        let states = [0, 1].map(|i| T::points(&muscle.states[i]));
        let other = T::build(&muscle.triangles, &states[0]);
        Self { ours: tree(muscle), other, states }
    }

    /// Builds both trees and refits them to the second state.
    fn moved(muscle: &Muscle) -> Self {
        let mut trees = Self::new(muscle);
        trees.ours.refit(&muscle.states[1]).expect("finite");
        trees.other.refit(&trees.states[1]);
        trees
    }

    /// Builds both trees and refits them to the way between the states.
    fn swept(muscle: &Muscle) -> Self {
        let mut trees = Self::new(muscle);
        trees.ours.refit_swept(&muscle.states[0], &muscle.states[1]).expect("finite");
        trees.other.refit_swept([&trees.states[0], &trees.states[1]]);
        trees
    }

    fn pair_count(&self, other: &Self) -> usize {
        let mut count = 0;
        self.ours.pairs(&other.ours, 0.0, &mut Workspace::new(), |_, _| count += 1);
        count
    }

    fn self_pair_count(&self) -> usize {
        let mut count = 0;
        self.ours.self_pairs(0.0, &mut Workspace::new(), |_, _| count += 1);
        count
    }
}

fn tree(muscle: &Muscle) -> Tree {
    Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
}

fn build<T: OtherTree>(report: &mut Report, size: &str, muscle: &Muscle, allowed: f64) {
    let x = T::points(&muscle.states[0]);
    let mut ours = || tree(muscle).leaf_count();
    let mut other = || T::build(&muscle.triangles, &x).leaf_count();
    let name = format!("build {size} / {}", T::NAME);
    report.compare(&name, BUDGET, allowed, [&mut ours, &mut other]);
}

fn refit<T: OtherTree>(report: &mut Report, size: &str, muscle: &Muscle, allowed: f64) {
    // Two ways of the other tree to refit, of which the faster counts.
    let Trees { mut ours, other: mut in_place, states } = Trees::<T>::new(muscle);
    let mut ordered = Trees::<T>::new(muscle).other;

    // Each side alternates between the two states.
    let mut turns = [0_usize; 3];
    let [a, b, c] = &mut turns;
    let [ours, in_place, ordered] = report.interleave(
        &format!("refit {size}"),
        BUDGET,
        [
            ("ours", &mut || ours.refit(&muscle.states[flip(a)]).map_or(0, |()| 1)),
            (T::NAME, &mut || in_place.refit_in_place(&states[flip(b)])),
            ("the same, reordered", &mut || ordered.refit(&states[flip(c)])),
        ],
    );
    let other = in_place.min(ordered);
    report.times(format!("refit {size} / {}", T::NAME), [ours, other], allowed);
}

/// Compares a refit with a bare sweep over boxes.
#[cfg(feature = "peers")]
fn bare_sweep(report: &mut Report, size: &str, muscle: &Muscle, allowed: f64) {
    let mut ours = tree(muscle);
    let states = [0, 1].map(|i| sweep_points(&muscle.states[i]));
    let mut bare = SweepTree::build(&muscle.triangles, &states[0]);

    let (mut turn, mut other_turn) = (0_usize, 0_usize);
    let mut refit = || ours.refit(&muscle.states[flip(&mut turn)]).map_or(0, |()| 1);
    let mut sweep = || bare.refit(&states[flip(&mut other_turn)]);
    let name = format!("refit {size} / obvhs' bare sweep");
    report.compare(&name, BUDGET, allowed, [&mut refit, &mut sweep]);
}

const fn flip(turn: &mut usize) -> usize {
    *turn ^= 1;
    *turn
}

fn pairs<T: OtherTree>(report: &mut Report, name: &str, trees: [Trees<T>; 2], allowed: f64) {
    // Lists and workspace are reused, so that neither side allocates after its first call.
    let [mut a, b] = trees;
    let mut workspace = Workspace::new();
    let (mut out, mut other_out) = (Vec::new(), Vec::new());
    let mut ours = || {
        out.clear();
        a.ours.pairs(&b.ours, 0.0, &mut workspace, |i, j| out.push((i, j)));
        out.len()
    };
    let mut other = || a.other.pairs(&b.other, &mut other_out);
    report.compare(name, BUDGET, allowed, [&mut ours, &mut other]);
}

/// Compares self pairs that share no vertex.
fn self_pairs<T: OtherTree>(report: &mut Report, name: &str, trees: Trees<T>, allowed: f64) {
    let Trees { ours, mut other, .. } = trees;
    let mut workspace = Workspace::new();
    let (mut out, mut other_out) = (Vec::new(), Vec::new());
    let mut ours = || {
        out.clear();
        ours.self_pairs(0.0, &mut workspace, |i, j| out.push((i, j)));
        out.len()
    };
    report.compare(name, BUDGET, allowed, [&mut ours, &mut || other.self_pairs(&mut other_out)]);
}

fn memory(report: &mut Report, size: &str, muscle: &Muscle) {
    let tree = tree(muscle);
    let bytes = as_f64(tree.bytes()) / as_f64(tree.leaf_count());
    report.ratio(format!("bytes per face {size}"), [bytes, 50.0], "B", 1.0);
}
