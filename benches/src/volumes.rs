//! Table of bounding volumes of 6, 14, 18 and 26 planes: memory, refits, pairs and candidates.

use std::fmt::Write as _;
use std::time::Duration;

use fixtures::muscle::{Muscle, Placement, scene};
use kdop::{DopTree, Leaves, Workspace};

use crate::measure::{as_f64, interleave};

/// Budget of each measurement.
const BUDGET: Duration = Duration::from_millis(200);

/// Returns the table, for two muscles in contact at an angle and along the axes, and the share of
/// candidates that 18 planes leave of those of boxes.
#[must_use]
pub fn table() -> String {
    let mut table = String::from(
        "k   faces  placement  bytes/face  refit us  pairs us  candidates  self candidates\n",
    );
    for faces in [6500, 80_000] {
        for placement in [Placement::Oblique, Placement::Aligned] {
            table += &row::<3>(faces, placement);
            table += &row::<7>(faces, placement);
            table += &row::<9>(faces, placement);
            table += &row::<13>(faces, placement);
        }
    }

    let shares: Vec<f64> = (0..12).map(|turn| share_of_boxes(Placement::Turned(turn))).collect();
    let min = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let max = shares.iter().copied().fold(0.0, f64::max);
    let mean = shares.iter().sum::<f64>() / as_f64(shares.len());
    // Writing into a string cannot fail.
    let _ = writeln!(
        table,
        "candidates of 18 planes over those of 6, contact turned in twelve ways:\n\
         min {min:.2}, mean {mean:.2}, max {max:.2}"
    );
    table
}

/// Measures volumes of `2 S` planes.
fn row<const S: usize>(faces: u32, placement: Placement) -> String {
    let scene = scene(faces, placement);
    let (mut a, mut b) = (build::<S>(&scene.a), build::<S>(&scene.b));
    let [refit] = interleave(BUDGET, [&mut || a.refit(&scene.a.states[1]).map_or(0, |()| 1)]);
    b.refit(&scene.b.states[1]).expect("finite points");

    let mut workspace = Workspace::new();
    let [traversal] = interleave(BUDGET, [&mut || pair_count(&a, &b, &mut workspace)]);
    let candidates = pair_count(&a, &b, &mut workspace);
    let mut self_candidates = 0;
    a.self_pairs(0.0, &mut workspace, |_, _| self_candidates += 1);

    let bytes = as_f64(a.bytes()) / as_f64(a.leaf_count());
    let (k, placement) = (2 * S, format!("{placement:?}"));
    let [refit, traversal] = [refit, traversal].map(|time| time * 1e-3);
    format!(
        "{k:<3} {faces:>6} {placement:<8} {bytes:>10.1} {refit:>9.1} {traversal:>9.1} {candidates:>11} {self_candidates:>8}\n"
    )
}

fn share_of_boxes(placement: Placement) -> f64 {
    let scene = scene(6500, placement);
    let boxes = pair_count(&build::<3>(&scene.a), &build(&scene.b), &mut Workspace::new());
    let dops = pair_count(&build::<9>(&scene.a), &build(&scene.b), &mut Workspace::new());
    as_f64(dops) / as_f64(boxes)
}

fn build<const S: usize>(muscle: &Muscle) -> DopTree<S> {
    DopTree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]).expect("a valid mesh")
}

fn pair_count<const S: usize>(
    a: &DopTree<S>,
    b: &DopTree<S>,
    workspace: &mut Workspace<S>,
) -> usize {
    let mut count = 0;
    a.pairs(b, 0.0, workspace, |_, _| count += 1);
    count
}
