//! Table of bounding volumes of 6, 14, 18 and 26 planes: memory, refits, pairs and candidates.

use fixtures::muscle::{Muscle, Placement, scene};
use kdop::{DopTree, Leaves, Workspace};

use crate::measure::{as_f64, interleave};

/// Budget of each measurement \[ms\].
const BUDGET: u64 = 200;

/// Returns the table, for two muscles in contact at an angle and along the axes.
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
    table
}

/// Measures volumes of `2 S` planes.
fn row<const S: usize>(faces: u32, placement: Placement) -> String {
    // Built at rest, refitted to contact.
    let scene = scene(faces, placement);
    let (mut a, mut b) = (build::<S>(&scene.a), build::<S>(&scene.b));
    let mut refit_a = || a.refit(&scene.a.states[1]).map_or(0, |()| 1);
    let [refit] = interleave(BUDGET, [("refit", &mut refit_a)]);
    b.refit(&scene.b.states[1]).expect("finite points");

    // Candidates of the pair, and of one muscle with itself.
    let mut workspace = Workspace::new();
    let mut count_pairs = || pair_count(&a, &b, &mut workspace);
    let [traversal] = interleave(BUDGET, [("pairs", &mut count_pairs)]);
    let candidates = pair_count(&a, &b, &mut workspace);
    let mut self_candidates = 0;
    a.self_pairs(0.0, &mut workspace, |_, _| self_candidates += 1);

    let bytes = as_f64(a.bytes()) / as_f64(a.leaf_count());
    let (k, placement) = (2 * S, format!("{placement:?}"));
    let (refit, traversal) = (refit * 1e-3, traversal * 1e-3);
    format!(
        "{k:<3} {faces:>6} {placement:<8} {bytes:>10.1} {refit:>9.1} {traversal:>9.1} {candidates:>11} {self_candidates:>8}\n"
    )
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
