//! Trees of a surface in motion: refit for ever, built in each frame, or built anew where they have
//! become loose.

use std::time::Instant;

use fixtures::shapes;
use glam::{DQuat, DVec3};
use kdop::Workspace;
use kdop::{Leaves, Tree};

use crate::measure::as_f64;

/// Frames of each motion, which goes there and back.
const FRAMES: u32 = 40;

/// Looseness above which a tree is built anew, as in the crate `proximity`.
const MAX_LOOSENESS: f64 = 4.0;

/// Rounds of each motion: its time is the minimum.
const ROUNDS: u32 = 5;

/// Position of a point after a share of the motion.
type Motion = fn(DVec3, f64) -> DVec3;

/// Rule by which a tree is built anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Policy {
    Never,
    WhereLoose,
    Always,
}

/// Sums over the frames of a motion.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    seconds: f64,
    bound_tests: f64,
    builds: u32,
    max_looseness: f64,
}

/// Returns the table: motions of a muscle of 20,480 faces against a bone, by policy.
#[must_use]
pub fn table() -> String {
    let mut table = String::from(
        "| motion | trees | ms per frame | bound tests per frame | builds | looseness |\n|---|---|---|---|---|---|\n",
    );
    let motions: [(&str, Motion); 4] = [
        ("bend to a half circle", bend),
        ("twist by two turns", twist),
        ("roll up", roll),
        ("shear of layers", shuffle),
    ];
    for (name, motion) in motions {
        for policy in [Policy::Never, Policy::WhereLoose, Policy::Always] {
            // The quickest of some rounds counts.
            let mut best = Sums { seconds: f64::INFINITY, ..Sums::default() };
            for _ in 0..ROUNDS {
                let sums = run(motion, policy);
                if sums.seconds < best.seconds {
                    best = sums;
                }
            }

            let frames = f64::from(FRAMES);
            let policy = match policy {
                Policy::Never => "refit for ever",
                Policy::WhereLoose => "built where loose",
                Policy::Always => "built in each frame",
            };
            table += &format!(
                "| {name} | {policy} | {:.3} | {:.0} | {} | {:.2} |\n",
                1e3 * best.seconds / frames,
                best.bound_tests / frames,
                best.builds,
                best.max_looseness,
            );
        }
    }
    table
}

/// Follows a motion and finds the pairs with a bone in each frame.
fn run(motion: Motion, policy: Policy) -> Sums {
    let muscle = shapes::ellipsoid(DVec3::new(12.0, 8.0, 80.0), 5);
    let bone = shapes::capsule(6.0, 120.0, 48).translated(DVec3::X * 14.0);
    let bone_tree = Tree::build(Leaves::Triangles(&bone.faces), &bone.positions);
    let tree = Tree::build(Leaves::Triangles(&muscle.faces), &muscle.positions);
    let (Ok(bone_tree), Ok(mut tree)) = (bone_tree, tree) else { return Sums::default() };
    let mut workspace = Workspace::new();
    let mut sums = Sums::default();

    for frame in 0..FRAMES {
        // There and back.
        let phase = as_f64(frame as usize) / as_f64(FRAMES as usize);
        let share = 0.5 - 0.5 * (std::f64::consts::TAU * phase).cos();
        let x: Vec<DVec3> = muscle.positions.iter().map(|&p| motion(p, share)).collect();

        let start = Instant::now();
        let is_refit = policy != Policy::Always && tree.refit(&x).is_ok();
        sums.max_looseness = sums.max_looseness.max(tree.looseness());
        let is_loose = policy == Policy::WhereLoose && tree.looseness() > MAX_LOOSENESS;
        if (!is_refit || is_loose)
            && let Ok(built) = Tree::build(Leaves::Triangles(&muscle.faces), &x)
        {
            tree = built;
            sums.builds += 1;
        }
        let mut pairs = 0;
        tree.pairs(&bone_tree, 0.0, &mut workspace, |_, _| pairs += 1);
        sums.seconds += start.elapsed().as_secs_f64();
        let tests = usize::try_from(workspace.counters().bound_tests).unwrap_or(usize::MAX);
        sums.bound_tests += as_f64(tests);
    }
    sums
}

/// Bends the long axis to a circular arc.
fn bend(p: DVec3, share: f64) -> DVec3 {
    let curvature = share * std::f64::consts::PI / 160.0;
    if curvature <= 0.0 {
        return p;
    }
    let (angle, radius) = (curvature * p.z, 1.0 / curvature - p.y);
    DVec3::new(p.x, 1.0 / curvature - radius * angle.cos(), radius * angle.sin())
}

fn twist(p: DVec3, share: f64) -> DVec3 {
    let angle = 2.0 * std::f64::consts::TAU * share * p.z / 160.0;
    DQuat::from_rotation_z(angle) * p
}

/// Rolls the long axis up to a spiral of three turns.
fn roll(p: DVec3, share: f64) -> DVec3 {
    let angle = share * 3.0 * std::f64::consts::TAU * (p.z + 80.0) / 160.0;
    let length = (1.0 - share) * p.z;
    let radius = share * (10.0 + 2.0 * angle);
    DVec3::new(p.x, p.y + radius * angle.cos(), length + radius * angle.sin())
}

/// Moves alternating layers apart, so that neighbors of the first tree are none.
fn shuffle(p: DVec3, share: f64) -> DVec3 {
    let layer = (p.z / 2.0).floor().rem_euclid(2.0);
    p + DVec3::Y * 60.0 * share * layer
}
