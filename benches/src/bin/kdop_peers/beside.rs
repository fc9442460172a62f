//! The table of ratios: build, refit, pairs, swept pairs and self pairs beside peers.

use std::time::Duration;

use benches::ratio::{Ratio, Report, Timing, amount, interleave};
use fixtures::muscle::{Muscle, MuscleScene, Placement, scene};
use kdop::{Leaves, Tree, Workspace};

use crate::peers::{double, single, sweep};

/// Time for each comparison.
const BUDGET: Duration = Duration::from_millis(700);

/// What is allowed of the ratios at 6.5k and at 80k faces.
struct Allowed {
    build: f64,
    refit: f64,
    sweep: Option<f64>,
    pairs: f64,
    swept: f64,
    own: f64,
    aligned: f64,
}

/// Compares at both sizes.
pub(crate) fn compare(report: &mut Report) {
    let small = Allowed {
        build: 0.8,
        refit: 0.45,
        sweep: None,
        pairs: 1.0,
        swept: 1.1,
        own: 0.45,
        aligned: 1.3,
    };
    let large = Allowed {
        build: 0.8,
        refit: 0.40,
        sweep: Some(0.75),
        pairs: 0.35,
        swept: 0.60,
        own: 0.70,
        aligned: 1.3,
    };
    for (faces, name, allowed) in [(6500, "6.5k", small), (80_000, "80k", large)] {
        let oblique = scene(faces, Placement::Oblique);
        build(report, name, &oblique.a, allowed.build);
        refit(report, name, &oblique.a, &allowed);
        pairs(report, &format!("pairs, oblique {name}"), &oblique, allowed.pairs, Some(1.0 / 3.0));
        swept(report, name, &oblique, allowed.swept);
        own(report, &format!("self, straight {name}"), &oblique.a, allowed.own);
        own(report, &format!("self, bent {name}"), &oblique.u, allowed.own);
        let aligned = scene(faces, Placement::Aligned);
        pairs(report, &format!("pairs, aligned {name}"), &aligned, allowed.aligned, None);
    }
}

fn tree(muscle: &Muscle) -> Tree {
    Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
}

fn singles(muscle: &Muscle) -> (single::Tree, [Vec<parry3d::math::Vector>; 2]) {
    let states = [0, 1].map(|i| single::vertices(&muscle.states[i]));
    (single::Tree::build(&muscle.triangles, &states[0]), states)
}

fn doubles(muscle: &Muscle) -> (double::Tree, [Vec<parry3d_f64::math::Vector>; 2]) {
    let states = [0, 1].map(|i| double::vertices(&muscle.states[i]));
    (double::Tree::build(&muscle.triangles, &states[0]), states)
}

/// The faster of several ways.
fn fastest<const N: usize>(ways: [Timing; N]) -> Timing {
    ways.into_iter().min_by(|a, b| a.least.total_cmp(&b.least)).expect("at least one way")
}

fn build(report: &mut Report, name: &str, muscle: &Muscle, allowed: f64) {
    let x = &muscle.states[0];
    let (x32, x64) = (single::vertices(x), double::vertices(x));
    let t = &muscle.triangles;
    let [ours, p32, p64] = interleave(
        BUDGET,
        [
            &mut || tree(muscle).leaf_count(),
            &mut || single::Tree::build(t, &x32).bvh.leaf_count() as usize,
            &mut || double::Tree::build(t, &x64).bvh.leaf_count() as usize,
        ],
    );
    report.add(&Ratio::of_times(
        &format!("build {name} / parry"),
        ours,
        fastest([p32, p64]),
        allowed,
    ));
}

fn refit(report: &mut Report, name: &str, muscle: &Muscle, allowed: &Allowed) {
    let mut ours = tree(muscle);
    let (mut p32, x32) = singles(muscle);
    let (mut q32, _) = singles(muscle);
    let (mut p64, x64) = doubles(muscle);
    let xs = [0, 1].map(|i| sweep::vertices(&muscle.states[i]));
    let mut bare = sweep::Tree::build(&muscle.triangles, &xs[0]);
    let mut turns = [0_usize; 5];
    let [a, b, c, d, e] = &mut turns;
    let next = |turn: &mut usize| {
        *turn ^= 1;
        *turn
    };
    let [ours, in_place, ordered, in_double, bare] = interleave(
        BUDGET,
        [
            &mut || ours.refit(&muscle.states[next(a)]).map_or(0, |()| 1),
            &mut || p32.refit_in_place(&x32[next(b)]),
            &mut || q32.refit(&x32[next(c)]),
            &mut || p64.refit_in_place(&x64[next(d)]),
            &mut || bare.refit(&xs[next(e)]),
        ],
    );
    let parry = fastest([in_place, ordered, in_double]);
    report.add(&Ratio::of_times(&format!("refit {name} / parry"), ours, parry, allowed.refit));
    let bound = allowed.sweep.unwrap_or(f64::INFINITY);
    report.add(&Ratio::of_times(&format!("refit {name} / obvhs' bare sweep"), ours, bare, bound));
}

fn pairs(report: &mut Report, name: &str, scene: &MuscleScene, allowed: f64, fewer: Option<f64>) {
    let [mut a, mut b] = [tree(&scene.a), tree(&scene.b)];
    a.refit(&scene.a.states[1]).expect("finite");
    b.refit(&scene.b.states[1]).expect("finite");
    let ((mut a32, xa32), (mut b32, xb32)) = (singles(&scene.a), singles(&scene.b));
    let ((mut a64, xa64), (mut b64, xb64)) = (doubles(&scene.a), doubles(&scene.b));
    a32.refit(&xa32[1]);
    b32.refit(&xb32[1]);
    a64.refit(&xa64[1]);
    b64.refit(&xb64[1]);
    time_pairs(report, name, [&a, &b], [&a32, &b32], [&a64, &b64], (allowed, fewer));
}

fn swept(report: &mut Report, name: &str, scene: &MuscleScene, allowed: f64) {
    let [mut a, mut b] = [tree(&scene.a), tree(&scene.b)];
    a.refit_swept(&scene.a.states[0], &scene.a.states[1]).expect("finite");
    b.refit_swept(&scene.b.states[0], &scene.b.states[1]).expect("finite");
    let ((mut a32, xa32), (mut b32, xb32)) = (singles(&scene.a), singles(&scene.b));
    let ((mut a64, xa64), (mut b64, xb64)) = (doubles(&scene.a), doubles(&scene.b));
    a32.refit_swept(&xa32[0], &xa32[1]);
    b32.refit_swept(&xb32[0], &xb32[1]);
    a64.refit_swept(&xa64[0], &xa64[1]);
    b64.refit_swept(&xb64[0], &xb64[1]);
    let name = format!("swept pairs {name}");
    time_pairs(report, &name, [&a, &b], [&a32, &b32], [&a64, &b64], (allowed, None));
}

fn time_pairs(
    report: &mut Report,
    name: &str,
    [a, b]: [&Tree; 2],
    [a32, b32]: [&single::Tree; 2],
    [a64, b64]: [&double::Tree; 2],
    (allowed, fewer): (f64, Option<f64>),
) {
    let mut workspace = Workspace::new();
    let (mut out, mut out32, mut out64) = (vec![], vec![], vec![]);
    let [ours, p32, p64] = interleave(
        BUDGET,
        [
            &mut || {
                out.clear();
                a.pairs(b, 0.0, &mut workspace, |i, j| out.push((i, j)));
                out.len()
            },
            &mut || a32.pairs(b32, &mut out32),
            &mut || a64.pairs(b64, &mut out64),
        ],
    );
    report.add(&Ratio::of_times(&format!("{name} / parry"), ours, fastest([p32, p64]), allowed));
    let (ours, theirs) = (amount(out.len()), amount(out64.len()));
    let allowed = fewer.unwrap_or(1.0);
    report.add(&Ratio::new(&format!("{name}, candidates"), ours, theirs, "", allowed));
}

fn own(report: &mut Report, name: &str, muscle: &Muscle, allowed: f64) {
    let mut ours = tree(muscle);
    ours.refit(&muscle.states[1]).expect("finite");
    let (mut p32, x32) = singles(muscle);
    let (mut p64, x64) = doubles(muscle);
    p32.refit(&x32[1]);
    p64.refit(&x64[1]);
    let mut workspace = Workspace::new();
    let (mut out, mut out32, mut out64) = (vec![], vec![], vec![]);
    let [time, t32, t64] = interleave(
        BUDGET,
        [
            &mut || {
                out.clear();
                ours.self_pairs(0.0, &mut workspace, |i, j| out.push((i, j)));
                out.len()
            },
            &mut || p32.self_pairs(&mut out32),
            &mut || p64.self_pairs(&mut out64),
        ],
    );
    report.add(&Ratio::of_times(&format!("{name} / parry"), time, fastest([t32, t64]), allowed));
    let (ours, theirs) = (amount(out.len()), amount(out64.len()));
    report.add(&Ratio::new(&format!("{name}, candidates"), ours, theirs, "", 1.0));
}
