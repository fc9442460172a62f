//! A generated knee, turned by some degrees: thin cartilage and menisci between two bones that leave less room
//! on one side than they are thick.

use fixtures::knee::knee;
use resolve::{Resolution, ResolveParams};
use scene::{BodyKind, CheckParams, Scene};
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

const DEGREE: f64 = 1.0 / 360.0;

fn turned(turns: f64) -> Scene {
    scene_of(knee(turns).into_iter().map(|body| {
        let kind = if body.is_rigid { BodyKind::Rigid } else { BodyKind::Deformable };
        (body.name, kind, body.mesh)
    }))
}

#[test]
fn a_knee_at_rest_is_free() {
    let reports =
        turned(0.0).check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    assert!(reports.iter().all(|report| !report.overlaps), "{:?}", reports.len());
}

/// Turns the femur, and resolves; checks that all bodies stay within their limits. Returns the
/// numbers of overlapping pairs before and after.
#[expect(clippy::print_stdout, reason = "the test reports its measurements")]
fn resolve_turned(degrees: f64) -> ([usize; 2], Resolution) {
    let mut scene = turned(degrees * DEGREE);
    let params = ResolveParams { gap: 0.05, max_rounds: 30, ..PARAMS };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("a resolution");
    let mut strain: f64 = 0.0;
    for change in &resolution.bodies {
        let volume = change.volume_ratio.expect("closed");
        assert!((volume - 1.0).abs() <= 0.01, "{volume}");
        assert_eq!((change.flipped_faces, change.self_crossings[1]), (0, 0), "{:?}", change.body);
        strain = strain.max(change.strain);
    }

    println!("measured: knee turned by {degrees}°: strain | {strain:.3} | 1");
    let before = resolution.before.iter().filter(|report| report.overlaps).count();
    let after = resolution.remaining.len();
    println!(
        "measured: knee turned by {degrees}°: overlapping pairs, of {before} | {after} | {before}"
    );
    for left in &resolution.remaining {
        println!("{:?}: {:?}, {}", scene.names(left.pair), left.depth, left.obstacle);
    }
    for short in &resolution.gap.short {
        println!("{:?}: {:?}, {}", scene.names(short.pair), short.distance, short.obstacle);
    }
    println!("{:?}", resolution.broken_limits);
    ([before, after], resolution)
}

#[test]
fn a_knee_turned_by_three_degrees_comes_free() {
    let ([before, after], resolution) = resolve_turned(3.0);
    assert!(before >= 2 && after == 0, "{before}, {after}");
    assert!(resolution.resolved, "{:?}", resolution.gap);
}

#[test]
fn a_knee_without_room_names_what_is_left() {
    let ([before, after], resolution) = resolve_turned(12.0);
    assert!(before >= 3 && after <= before, "{before}, {after}");
    assert!(!resolution.resolved && !resolution.gap.short.is_empty());
}
