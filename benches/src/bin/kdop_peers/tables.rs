//! Tables beyond the ratios: numbers of directions, memory, growth, threads, long motion.

use std::time::Duration;

use benches::ratio::{Ratio, Report, Timing, amount, interleave};
use fixtures::muscle::{Muscle, Placement, muscle, scene, twisted};
use kdop::{DopTree, Extents, Leaves, Tree, Workspace};

/// Time for each line.
const BUDGET: Duration = Duration::from_millis(200);

fn build<const S: usize>(muscle: &Muscle) -> DopTree<S> {
    DopTree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
}

fn time(mut side: impl FnMut() -> usize) -> Timing {
    let [timing] = interleave(BUDGET, [&mut side]);
    timing
}

fn pairs<const S: usize>(a: &DopTree<S>, b: &DopTree<S>, workspace: &mut Workspace<S>) -> usize {
    let mut count = 0;
    a.pairs(b, 0.0, workspace, |_, _| count += 1);
    count
}

/// Candidates, refits and pairs of every volume.
pub(crate) fn volumes() {
    println!("k   faces  lie      bytes/face  refit us  pairs us  candidates  self candidates");
    for faces in [6500, 80_000] {
        for placement in [Placement::Oblique, Placement::Aligned] {
            volume::<3>(faces, placement);
            volume::<7>(faces, placement);
            volume::<9>(faces, placement);
            volume::<13>(faces, placement);
        }
    }
    println!("candidates of 18 planes over those of 6, contact turned in twelve ways:");
    let shares: Vec<f64> = (0..12).map(|i| share_of_boxes(Placement::Turned(i))).collect();
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shares.iter().copied().fold(0.0, f64::max);
    let mean = shares.iter().sum::<f64>() / amount(shares.len());
    println!("least {least:.2}, mean {mean:.2}, most {most:.2}");
}

fn volume<const S: usize>(faces: u32, placement: Placement) {
    let scene = scene(faces, placement);
    let (mut a, mut b) = (build::<S>(&scene.a), build::<S>(&scene.b));
    let refit = time(|| a.refit(&scene.a.states[1]).map_or(0, |()| 1));
    b.refit(&scene.b.states[1]).expect("finite points");
    let mut workspace = Workspace::new();
    let traversal = time(|| pairs(&a, &b, &mut workspace));
    let found = pairs(&a, &b, &mut workspace);
    let mut own = 0;
    a.self_pairs(0.0, &mut workspace, |_, _| own += 1);
    let bytes = amount(a.bytes()) / amount(a.leaf_count());
    let (k, refit, traversal) = (2 * S, refit.least * 1e-3, traversal.least * 1e-3);
    let placement = format!("{placement:?}");
    println!(
        "{k:<3} {faces:>6} {placement:<8} {bytes:>10.1} {refit:>9.1} {traversal:>9.1} {found:>11} {own:>8}"
    );
}

fn share_of_boxes(placement: Placement) -> f64 {
    let scene = scene(6500, placement);
    let boxes = pairs(&build::<3>(&scene.a), &build(&scene.b), &mut Workspace::new());
    let dops = pairs(&build::<9>(&scene.a), &build(&scene.b), &mut Workspace::new());
    amount(dops) / amount(boxes)
}

/// Bytes a face, and a refit beside a plain sweep over as many bytes.
pub(crate) fn memory(report: &mut Report) {
    for (faces, name) in [(6500, "6.5k"), (80_000, "80k")] {
        let muscle = scene(faces, Placement::Oblique).a;
        let mut tree: Tree = build(&muscle);
        let leaves = amount(tree.leaf_count());
        let name_of = |what: &str| format!("{what} {name}");
        let bytes = amount(tree.bytes());
        report.add(&Ratio::new(&name_of("bytes a face"), bytes / leaves, 50.0, "B", 1.0));
        let mut plain = vec![1.0_f32; tree.bytes() / 4];
        let [refit, sweep] = interleave(
            BUDGET,
            [&mut || tree.refit(&muscle.states[1]).map_or(0, |()| 1), &mut || {
                plain.iter_mut().for_each(|x| *x = x.max(0.5) * 1.000_1);
                plain.len()
            }],
        );
        let (ours, theirs) = (refit.least / leaves, sweep.least / leaves);
        let unbounded = f64::INFINITY;
        let name = name_of("ns a face, refit / plain sweep of its bytes");
        report.add(&Ratio::new(&name, ours, theirs, "ns", unbounded));
    }
}

/// Cost a face from a thousand to a million faces: what a tree costs should grow with its size.
pub(crate) fn growth() {
    println!("faces     build ns/face  refit ns/face  self ns/face");
    let mut logs = [vec![], vec![], vec![]];
    for faces in [1000, 10_000, 100_000, 1_000_000] {
        let muscle = muscle(faces, 0, |p| p);
        let mut tree: Tree = build(&muscle);
        let leaves = amount(tree.leaf_count());
        let mut workspace = Workspace::new();
        let times = [
            time(|| build::<9>(&muscle).leaf_count()),
            time(|| tree.refit(&muscle.states[1]).map_or(0, |()| 1)),
            time(|| {
                let mut count = 0;
                tree.self_pairs(0.0, &mut workspace, |_, _| count += 1);
                count
            }),
        ];
        let [b, r, s] = times.map(|timing| timing.least / leaves);
        println!("{leaves:<9} {b:>13.1} {r:>14.2} {s:>13.1}");
        for (logs, timing) in logs.iter_mut().zip(times) {
            logs.push((leaves.log10(), timing.least.log10()));
        }
    }
    let [b, r, s] = logs.map(|points| slope(&points));
    println!("slope     {b:>13.2} {r:>14.2} {s:>13.2}");
}

/// Of the line of least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = amount(points.len());
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Two threads beside one.
pub(crate) fn threads() {
    let scene = scene(80_000, Placement::Oblique);
    let (mut a, b): (Tree, Tree) = (build(&scene.a), build(&scene.b));
    let mut plain = a.clone();
    let mut workspace = Workspace::new();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
    let x = &scene.a.states[1];
    let [one, two] = interleave(
        BUDGET * 4,
        [&mut || plain.refit(x).map_or(0, |()| 1), &mut || {
            pool.install(|| a.par_refit_from(Extents::Points(x))).map_or(0, |()| 1)
        }],
    );
    println!("two threads over one, 80k: refit {:.2}", two.least / one.least);
    let [one, two] = interleave(
        BUDGET * 4,
        [&mut || pairs(&a, &b, &mut workspace), &mut || {
            pool.install(|| a.par_pairs(&b, 0.0)).len()
        }],
    );
    println!("two threads over one, 80k: pairs {:.2}", two.least / one.least);
    let mut out = Vec::new();
    let [one, two] = interleave(
        BUDGET * 4,
        [
            &mut || {
                out.clear();
                a.self_pairs(0.0, &mut workspace, |i, j| out.push((i, j)));
                out.len()
            },
            &mut || pool.install(|| a.par_self_pairs(0.0)).len(),
        ],
    );
    println!("two threads over one, 80k: self pairs {:.2}", two.least / one.least);
}

/// A thousand frames of a muscle that twists by a third of a turn and back beside a still one:
/// looseness, and the cost of a traversal beside that of a tree built anew.
pub(crate) fn motion() {
    const FRAMES: u32 = 1000;
    let scene = scene(6500, Placement::Aligned);
    let (mut tree, still): (Tree, Tree) = (build(&scene.a), build(&scene.b));
    let (leaves, rest) = (Leaves::Triangles(&scene.a.triangles), &scene.a.states[0]);
    let (mut workspace, mut other) = (Workspace::new(), Workspace::new());
    println!("frame  twist deg  looseness  pairs us, refit / built anew  candidates of both");
    for frame in 0..=FRAMES {
        let way = f64::from(frame) / f64::from(FRAMES);
        let turns = (1.0 - (2.0 * way - 1.0).abs()) / 3.0;
        let points = twisted(rest, turns);
        tree.refit(&points).expect("finite points");
        if frame % (FRAMES / 10) != 0 {
            continue;
        }
        let anew = Tree::build(leaves, &points).expect("a valid mesh");
        let [refit, built] = interleave(
            BUDGET / 4,
            [&mut || pairs(&tree, &still, &mut workspace), &mut || {
                pairs(&anew, &still, &mut other)
            }],
        );
        let counts = [&tree, &anew].map(|tree| pairs(tree, &still, &mut workspace));
        let (degrees, looseness) = (360.0 * turns, tree.looseness());
        let (refit, built) = (refit.least * 1e-3, built.least * 1e-3);
        println!(
            "{frame:>5}  {degrees:>9.0}  {looseness:>9.3}  {refit:>9.1} / {built:<9.1} {counts:?}"
        );
    }
}
