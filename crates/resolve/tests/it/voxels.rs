//! Bodies of blocks, as a segmented image has them: corners stand side by side, tops are level.

use fixtures::labels;
use glam::DVec3;
use resolve::{Resolution, ResolveParams, resolve};
use scene::BodyKind;
use surface::progress::Progress;

use crate::scene_of;

/// Resolves a limb of blocks whose bone is turned about its middle.
fn turned(axis: DVec3, turns: f64) -> Resolution {
    let [bone, one, other] = labels::limb(0);
    let middle = bone.bounds().center();
    let bone = bone.translated(-middle).rotated(axis, turns).translated(middle);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, bone),
        ("one", BodyKind::Deformable, one),
        ("other", BodyKind::Deformable, other),
    ]);
    let params = ResolveParams { gap: 0.02, ..ResolveParams::with_smoothing(6.0) };
    resolve(&mut scene, &params, Progress::none()).expect("a resolution")
}

/// About the second axis, tops are level with each other: pushed by their nearest ways out, corners go in and out for 30
/// to 40 rounds, or to the end.
#[test]
fn corners_that_stand_side_by_side_come_apart() {
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
        for turns in [0.003, 0.01, -0.005] {
            let resolution = turned(axis.normalize(), turns);
            assert!(resolution.resolved, "{axis}, {turns}: {:?}", resolution.remaining);
            let rounds = resolution.rounds.len();
            assert!(rounds <= 10, "{axis}, {turns}: {rounds} rounds");
        }
    }
}
