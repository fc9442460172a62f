//! Overlaps that no vertex and no edge of the soft body shows: detected by every method, with
//! their depth within the pair's error.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use plan::{DetectionMethod, ForcedMethod, Plan, PlanParams, RespondParams};
use scene::{BodyKind, CheckParams, PairId, Scene};
use surface::progress::Progress;

use crate::{depth, detect};

const TOLERANCES: [f64; 5] = [2.0, 1.0, 0.5, 0.2, 0.1];

/// Builds a scene of a bone and a muscle.
fn scene(bone: &Mesh, muscle: &Mesh) -> (Scene, PairId) {
    let mut scene = Scene::new();
    let mut add = |name, kind, mesh: &Mesh| {
        scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body")
    };
    let pair = PairId::new(
        add("bone", BodyKind::Rigid, bone),
        add("muscle", BodyKind::Deformable, muscle),
    );
    (scene, pair)
}

/// Returns the depth of the deepest vertex of either body, as detection finds it.
fn exact_depth(scene: &mut Scene) -> f64 {
    let pairs =
        scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    pairs.first().map_or(0.0, |pair| pair.max_vertex_depth)
}

/// Checks that a pair's depth is within its error, by either method and at all tolerances.
#[track_caller]
fn assert_within_error(bone: &Mesh, muscle: &Mesh, planted: f64) {
    for tolerance in TOLERANCES {
        for method in [DetectionMethod::Field, DetectionMethod::Surfaces] {
            let (mut scene, pair) = scene(bone, muscle);
            let exact = exact_depth(&mut scene);
            assert!((exact - planted).abs() < 0.05, "{exact} deep, {planted} planted");

            let forced = [ForcedMethod { pair, method }];
            let params = PlanParams::with_tolerance(tolerance);
            let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
            let mut plan = plan.expect("a plan");
            let detection = detect(&mut plan, &mut scene);
            let found = depth(&detection, pair.a, pair.b);
            let error = plan.pairs()[0].error.value();
            assert!(error <= tolerance, "{error} at {tolerance}");
            assert!(detection.pairs()[0].overlaps, "{method} at {tolerance}");
            assert!(
                (found - exact).abs() <= error,
                "{method} at {tolerance}: {found} instead of {exact}, error {error}"
            );
        }
    }
}

/// Builds a rod along z of a radius, whose lower end is at `height`, beside the edge across the
/// flat side of a muscle.
fn rod(radius: f64, height: f64) -> Mesh {
    let rod = shapes::capsule(radius, 30.0, 16);
    let lowest = rod.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    rod.translated(DVec3::new(12.0, 3.0, height - lowest))
}

/// A muscle of 12 faces, 60 by 60 by 40, with its upper side at z = 0.
fn flat_muscle() -> Mesh {
    shapes::plate(DVec3::new(60.0, 60.0, 40.0), [1, 1]).translated(DVec3::Z * -20.0)
}

#[test]
fn a_rod_in_the_flat_side_of_a_muscle() {
    assert_within_error(&rod(2.0, -8.0), &flat_muscle(), 8.0);
}

#[test]
fn a_spike_in_an_ellipsoid() {
    // Its tip is 6 below the outermost point of the ellipsoid.
    let muscle = shapes::ellipsoid(DVec3::new(20.0, 20.0, 40.0), 4);
    let spike = shapes::ellipsoid(DVec3::new(1.0, 1.0, 15.0), 2);
    let spike = spike.rotated(DVec3::Y, 0.25).translated(DVec3::X * (15.0 + 20.0 - 6.0));
    assert_within_error(&spike, &muscle, 6.0);
}

#[test]
fn a_bone_wholly_inside_a_muscle() {
    // Nothing crosses: the bone's vertices are 20 to 26 below the surface.
    let bone = shapes::icosphere(3.0, 2).translated(DVec3::X * 1.0);
    let muscle = shapes::icosphere(25.0, 4);
    let mut scene = scene(&bone, &muscle).0;
    let planted = exact_depth(&mut scene);
    assert!((22.0..25.0).contains(&planted), "{planted}");
    assert_within_error(&bone, &muscle, planted);
}

#[test]
fn a_muscle_wholly_inside_a_bone() {
    let bone = shapes::icosphere(25.0, 4);
    let muscle = shapes::icosphere(3.0, 2).translated(DVec3::X * 1.0);
    let mut scene = scene(&bone, &muscle).0;
    let planted = exact_depth(&mut scene);
    assert_within_error(&bone, &muscle, planted);
}

#[test]
fn responses_leave_nothing_that_detection_does_not_show() {
    let (mut scene, pair) = scene(&rod(2.0, -2.0), &flat_muscle());
    let params = PlanParams::with_tolerance(0.2);
    let mut plan = Plan::new(&mut scene, &params, Progress::none()).expect("a plan");
    assert_eq!(plan.pairs()[0].method, DetectionMethod::Field);
    for _ in 0..100 {
        let detection = detect(&mut plan, &mut scene);
        plan.respond(&mut scene, &detection, &RespondParams::default()).expect("a response");
    }
    let left = exact_depth(&mut scene);
    let detection = detect(&mut plan, &mut scene);
    let found = depth(&detection, pair.a, pair.b);
    assert!((left - found).abs() <= params.tolerance, "{found} found, {left} left");
    assert!(left <= params.tolerance, "{left} left");
}
