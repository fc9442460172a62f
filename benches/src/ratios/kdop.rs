//! Trees of k-DOPs: build, refit, pairs, swept pairs and self pairs beside trees of boxes, and
//! their memory.

use std::error::Error;

use fixtures::muscle::{Muscle, Placement, scene};
use kdop::{Leaves, Tree, Workspace};
use parry3d::math::Vector;

use super::kdop_peers::{ParryTree, SweepTree, parry_points, sweep_points};
use crate::measure::{Report, as_f64};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 700;

/// Bounds on the ratios at one number of faces.
struct Allowed {
    build: f64,
    refit: f64,
    /// Refit over that of a bare sweep.
    sweep: f64,
    pairs: f64,
    swept: f64,
    self_pairs: f64,
    /// Pairs of muscles along the axes, where boxes fit best.
    aligned: f64,
}

const SMALL: Allowed = Allowed {
    build: 0.8,
    refit: 0.40,
    sweep: f64::INFINITY,
    pairs: 1.0,
    swept: 1.1,
    self_pairs: 0.40,
    aligned: 1.30,
};

const LARGE: Allowed = Allowed {
    build: 0.8,
    refit: 0.40,
    sweep: 0.75,
    pairs: 0.35,
    swept: 0.60,
    self_pairs: 0.50,
    aligned: 0.9,
};

/// Compares muscles of two sizes.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    for (faces, size, allowed) in [(6500, "6.5k", SMALL), (80_000, "80k", LARGE)] {
        // Muscles at an angle to the axes, in contact.
        let oblique = scene(faces, Placement::Oblique);
        build(report, size, &oblique.a, allowed.build);
        refit(report, size, &oblique.a, &allowed);

        let limits = PairLimits { time: allowed.pairs, candidates: 1.0 / 3.0 };
        let trees = [&oblique.a, &oblique.b].map(Trees::moved);
        pairs(report, &format!("pairs, oblique {size}"), trees, limits);
        let limits = PairLimits { time: allowed.swept, candidates: 1.0 };
        let trees = [&oblique.a, &oblique.b].map(Trees::swept);
        pairs(report, &format!("swept pairs {size}"), trees, limits);
        self_pairs(report, &format!("self, straight {size}"), &oblique.a, allowed.self_pairs);
        self_pairs(report, &format!("self, bent {size}"), &oblique.u, allowed.self_pairs);

        // Muscles along the axes: there, candidates of boxes are few.
        let aligned = scene(faces, Placement::Aligned);
        let limits = PairLimits { time: allowed.aligned, candidates: 1.0 };
        let trees = [&aligned.a, &aligned.b].map(Trees::moved);
        pairs(report, &format!("pairs, aligned {size}"), trees, limits);
        memory(report, size, &oblique.a);
    }
    Ok(())
}

/// A muscle's tree and that of `parry3d`, with the muscle's states in its precision.
struct Trees {
    ours: Tree,
    parry: ParryTree,
    states: [Vec<Vector>; 2],
}

impl Trees {
    fn new(muscle: &Muscle) -> Self {
        let states = [0, 1].map(|i| parry_points(&muscle.states[i]));
        let parry = ParryTree::build(&muscle.triangles, &states[0]);
        Self { ours: tree(muscle), parry, states }
    }

    /// Builds both trees and refits them to the second state.
    fn moved(muscle: &Muscle) -> Self {
        let mut trees = Self::new(muscle);
        trees.ours.refit(&muscle.states[1]).expect("finite");
        trees.parry.refit(&trees.states[1]);
        trees
    }

    /// Builds both trees and refits them to the way between the states.
    fn swept(muscle: &Muscle) -> Self {
        let mut trees = Self::new(muscle);
        trees.ours.refit_swept(&muscle.states[0], &muscle.states[1]).expect("finite");
        trees.parry.refit_swept([&trees.states[0], &trees.states[1]]);
        trees
    }
}

fn tree(muscle: &Muscle) -> Tree {
    Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
}

fn build(report: &mut Report, size: &str, muscle: &Muscle, allowed: f64) {
    let x = parry_points(&muscle.states[0]);
    let mut ours = || tree(muscle).leaf_count();
    let mut parry = || ParryTree::build(&muscle.triangles, &x).leaf_count();
    report.compare(&format!("build {size} / parry"), BUDGET, allowed, [&mut ours, &mut parry]);
}

fn refit(report: &mut Report, size: &str, muscle: &Muscle, allowed: &Allowed) {
    // Two ways of parry's to refit, of which the faster counts, and a bare sweep.
    let Trees { mut ours, parry: mut in_place, states } = Trees::new(muscle);
    let mut ordered = Trees::new(muscle).parry;
    let bare_states = [0, 1].map(|i| sweep_points(&muscle.states[i]));
    let mut bare = SweepTree::build(&muscle.triangles, &bare_states[0]);

    // Each side alternates between the two states.
    let mut turns = [0_usize; 4];
    let [a, b, c, d] = &mut turns;
    let [ours, in_place, ordered, bare] = report.interleave(
        &format!("refit {size}"),
        BUDGET,
        [
            ("ours", &mut || ours.refit(&muscle.states[flip(a)]).map_or(0, |()| 1)),
            ("parry, in place", &mut || in_place.refit_in_place(&states[flip(b)])),
            ("parry, reordered", &mut || ordered.refit(&states[flip(c)])),
            ("obvhs' bare sweep", &mut || bare.refit(&bare_states[flip(d)])),
        ],
    );
    let parry = in_place.min(ordered);
    report.times(format!("refit {size} / parry"), [ours, parry], allowed.refit);
    report.times(format!("refit {size} / obvhs' bare sweep"), [ours, bare], allowed.sweep);
}

const fn flip(turn: &mut usize) -> usize {
    *turn ^= 1;
    *turn
}

/// Bounds on a traversal beside that of `parry3d`.
struct PairLimits {
    time: f64,
    candidates: f64,
}

/// Traversal that collects candidates, and returns their number.
type Traversal<'a> = &'a mut dyn FnMut(&mut Vec<(u32, u32)>) -> usize;

fn pairs(report: &mut Report, name: &str, [a, b]: [Trees; 2], limits: PairLimits) {
    // Lists and workspace are reused, so that neither side allocates after its first call.
    let mut workspace = Workspace::new();
    let mut ours = |out: &mut Vec<(u32, u32)>| {
        out.clear();
        a.ours.pairs(&b.ours, 0.0, &mut workspace, |i, j| out.push((i, j)));
        out.len()
    };
    let mut parry = |out: &mut Vec<(u32, u32)>| a.parry.pairs(&b.parry, out);
    traversals(report, name, [&mut ours, &mut parry], limits);
}

/// Compares self pairs that share no vertex.
fn self_pairs(report: &mut Report, name: &str, muscle: &Muscle, allowed: f64) {
    let Trees { ours, mut parry, .. } = Trees::moved(muscle);
    let mut workspace = Workspace::new();
    let mut ours = |out: &mut Vec<(u32, u32)>| {
        out.clear();
        ours.self_pairs(0.0, &mut workspace, |i, j| out.push((i, j)));
        out.len()
    };
    let mut parry = |out: &mut Vec<(u32, u32)>| parry.self_pairs(out);
    let limits = PairLimits { time: allowed, candidates: 1.0 };
    traversals(report, name, [&mut ours, &mut parry], limits);
}

/// Compares times and numbers of candidates.
fn traversals(
    report: &mut Report,
    name: &str,
    [ours, parry]: [Traversal<'_>; 2],
    limits: PairLimits,
) {
    let (mut out, mut parry_out) = (Vec::new(), Vec::new());
    report.compare(
        &format!("{name} / parry"),
        BUDGET,
        limits.time,
        [&mut || ours(&mut out), &mut || parry(&mut parry_out)],
    );
    let counts = [out.len(), parry_out.len()].map(as_f64);
    report.ratio(format!("{name}, candidates"), counts, "", limits.candidates);
}

fn memory(report: &mut Report, size: &str, muscle: &Muscle) {
    let tree = tree(muscle);
    let bytes = as_f64(tree.bytes()) / as_f64(tree.leaf_count());
    report.ratio(format!("bytes per face {size}"), [bytes, 50.0], "B", 1.0);
}
