//! Refused parameters, methods and scenes, and interruption.

use std::time::Duration;

use fixtures::Mesh;
use fixtures::shapes::icosphere;
use glam::DVec3;
use plan::{
    Detection, DetectionMethod, ForcedMethod, FrameBudget, Plan, PlanError, PlanParams,
    RespondParams,
};
use scene::{BodyKind, PairId, Scene, SceneError};
use surface::SimplexSurface;
use surface::progress::Progress;

use crate::{plan, three};

#[test]
fn parameters_out_of_range_are_named() {
    let (mut scene, _) = three();
    let good = PlanParams::with_tolerance(0.5);
    for (expected, params) in [
        ("tolerance", PlanParams { tolerance: 0.0, ..good }),
        ("tolerance", PlanParams { tolerance: f64::NAN, ..good }),
        ("margin", PlanParams { margin: -1.0, ..good }),
        ("margin", PlanParams { margin: f64::INFINITY, ..good }),
        ("max_displacement", PlanParams { max_displacement: f64::NAN, ..good }),
        ("max_displacement", PlanParams { max_displacement: -0.5, ..good }),
        ("machine_factor", PlanParams { machine_factor: 0.0, ..good }),
        ("frames", PlanParams { frames: 0, ..good }),
        ("threads", PlanParams { threads: 0, ..good }),
    ] {
        let refused = Plan::new(&mut scene, &params, Progress::none());
        let Err(PlanError::Parameter(error)) = refused else { panic!("{refused:?}") };
        assert_eq!(error.name, expected);
    }
}

#[test]
fn forced_methods_that_do_not_suit_their_pair_are_refused() {
    let (mut scene, [bone, first, second]) = three();
    let mesh = icosphere(5.0, 2);
    let other = scene.add("other", BodyKind::Rigid, mesh.surface(), mesh.positions);
    let other = other.expect("a body");
    let params = PlanParams::with_tolerance(1.5);
    for (a, b, method, message) in [
        (
            first,
            second,
            DetectionMethod::Field,
            "method field does not suit \"first\" and \"second\"",
        ),
        (bone, other, DetectionMethod::Balls, "both bodies are rigid"),
    ] {
        let forced = [ForcedMethod { pair: PairId::new(a, b), method }];
        let refused = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let error = refused.expect_err("a refusal").to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_body_is_not_planned_with_itself_nor_with_one_of_another_scene() {
    let (mut scene, [bone, ..]) = three();
    let mut larger = Scene::new();
    for number in 0..4 {
        let mesh = icosphere(1.0, 0);
        let name = number.to_string();
        larger.add(&name, BodyKind::Rigid, mesh.surface(), mesh.positions).expect("a body");
    }
    let stranger = larger.ids().last().expect("four bodies");
    for (other, expected) in [
        (bone, SceneError::Itself { name: "bone".into() }),
        (stranger, SceneError::NoSuchBody { index: 3, count: 3 }),
    ] {
        let pair = PairId::new(bone, other);
        let forced = [ForcedMethod { pair, method: DetectionMethod::Exact }];
        let params = PlanParams::with_tolerance(0.5);
        let refused = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        assert_eq!(refused.expect_err("a refusal"), PlanError::Scene(expected));
    }
}

#[test]
fn lengths_and_factors_at_the_ends_of_their_range_are_planned() {
    let (mut scene, _) = three();
    let good = PlanParams::with_tolerance(0.5);
    for params in [
        PlanParams::with_tolerance(f64::MAX),
        PlanParams { margin: f64::MAX, ..good },
        PlanParams { machine_factor: 1e300, ..good },
        PlanParams { max_displacement: f64::INFINITY, ..good },
    ] {
        let plan = Plan::new(&mut scene, &params, Progress::none()).expect("a plan");
        assert!(plan.predicted_time() > Duration::ZERO, "{params:?}");
    }
}

#[test]
fn bones_without_a_pose_are_refused() {
    let (mut scene, [bone, first, _]) = three();
    let forced = [ForcedMethod { pair: PairId::new(bone, first), method: DetectionMethod::Field }];
    let params = PlanParams::with_tolerance(0.5);
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    let x = scene.body(bone).positions().to_vec();
    scene.move_body(bone, &x).expect("a move");
    let refused = plan.detect(&mut scene, &mut Detection::default());
    assert_eq!(refused, Err(PlanError::NoPose { name: "bone".into() }));
}

#[test]
fn scenes_with_other_bodies_are_refused() {
    let (mut scene, _) = three();
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    let mesh = icosphere(5.0, 2);
    scene.add("other", BodyKind::Rigid, mesh.surface(), mesh.positions).expect("a body");
    let refused = plan.detect(&mut scene, &mut Detection::default());
    assert_eq!(refused, Err(PlanError::OtherScene));
}

/// Bodies of the same names and numbers of vertices may still be others: as bone instead of muscle, larger, or
/// with a hole.
#[test]
fn scenes_with_other_bodies_of_the_same_names_are_refused() {
    let ball = icosphere(10.0, 3);
    let open = Mesh { faces: ball.faces[1..].to_vec(), ..ball.clone() };
    let scene_of = |kind, mesh: &Mesh| {
        let mut scene = Scene::new();
        for (name, kind, x) in [("muscle", BodyKind::Deformable, 18.0), ("bone", kind, 0.0)] {
            let mesh = mesh.clone().translated(DVec3::X * x);
            scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
        }
        scene
    };

    let larger = ball.clone().scaled(DVec3::splat(1.01));
    for (kind, others) in [
        (BodyKind::Rigid, vec![(BodyKind::Deformable, &ball), (BodyKind::Rigid, &larger)]),
        (BodyKind::Deformable, vec![(BodyKind::Open, &ball), (BodyKind::Deformable, &open)]),
    ] {
        let mut scene = scene_of(kind, &ball);
        let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
        for mut like in [scene.clone(), scene_of(kind, &ball)] {
            plan.detect(&mut like, &mut Detection::default()).expect("the same bodies");
        }
        for (kind, mesh) in others {
            let refused = plan.detect(&mut scene_of(kind, mesh), &mut Detection::default());
            assert_eq!(refused, Err(PlanError::OtherScene), "{kind:?}");
        }
    }
}

/// The center of a polygon is no vertex of its own: what a response moves would not hold of the polygons.
#[test]
fn soft_polygons_are_not_moved_as_triangles() {
    let ball = icosphere(10.0, 2);
    let simplex = SimplexSurface::dual_of(&ball.surface()).expect("closed");
    let centroids = (0..ball.faces.len()).map(|face| ball.centroid(face));
    let x: Vec<DVec3> = centroids.map(|x| x + DVec3::X * 18.0).collect();
    for kind in [BodyKind::Deformable, BodyKind::Rigid] {
        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions.clone());
        bone.expect("a bone");
        scene.add_simplex("muscle", kind, simplex.clone(), &x).expect("polygons");
        let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.1));
        let mut detection = Detection::default();
        plan.detect(&mut scene, &mut detection).expect("a detection");
        let moved = plan.respond(&mut scene, &detection, &RespondParams::default());
        let refused = PlanError::Polygons { name: "muscle".into() };
        assert_eq!(moved.err(), (kind == BodyKind::Deformable).then_some(refused));
    }
}

/// A bracket on a depth is no narrower than coordinates are exact: what cannot be proved is not planned.
#[test]
fn tolerances_below_the_rounding_of_coordinates_are_refused() {
    for at in [0.0, 1e3, 1e6] {
        let mut scene = Scene::new();
        for (name, kind, x) in
            [("bone", BodyKind::Rigid, 0.0), ("muscle", BodyKind::Deformable, 18.0)]
        {
            let ball = icosphere(10.0, 3).rotated(DVec3::ONE, 0.01 * x);
            let ball = ball.translated(DVec3::new(at + x, at, 0.0));
            scene.add(name, kind, ball.surface(), ball.positions).expect("a body");
        }
        let largest = at + 28.0;
        for tolerance in [1e-14 * largest, 1e-16 * largest, f64::MIN_POSITIVE] {
            let params = PlanParams::with_tolerance(tolerance);
            let refused = Plan::new(&mut scene, &params, Progress::none());
            let Err(PlanError::Parameter(error)) = refused else { panic!("{refused:?}") };
            assert_eq!((error.name, error.value), ("tolerance", tolerance));
        }

        let tolerance = 1e-13 * largest;
        let mut plan = plan(&mut scene, &PlanParams::with_tolerance(tolerance));
        let mut detection = Detection::default();
        plan.detect(&mut scene, &mut detection).expect("a detection");
        let [found] = detection.pairs() else { panic!("one pair") };
        assert!(found.depth.upper - found.depth.lower <= 2.0 * plan.pairs()[0].accuracy.bound);
    }
}

/// Bodies that meet where the tolerance is below the rounding of distances; those far from all others
/// are no matter.
#[test]
fn frames_in_which_rounding_exceeds_the_tolerance_are_refused() {
    let balls = [icosphere(1.0, 1), icosphere(1.0, 1).translated(1.5 * DVec3::X)];
    let mut scene = Scene::new();
    let mut ids = Vec::new();
    for (number, ball) in balls.iter().enumerate() {
        let (surface, x) = (ball.surface(), ball.positions.clone());
        ids.push(scene.add(number.to_string(), BodyKind::Deformable, surface, x).expect("a ball"));
    }
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(1e-3));
    let mut detection = Detection::default();
    let (mut budget, far) = (FrameBudget::Operations(Duration::from_secs(3600)), 1e12 * DVec3::X);
    for (number, is_refused) in [(0, false), (1, true)] {
        let x: Vec<DVec3> = balls[number].positions.iter().map(|p| *p + far).collect();
        scene.move_body(ids[number], &x).expect("a move");
        for found in [
            plan.detect(&mut scene, &mut detection),
            plan.detect_within(&mut scene, &mut budget, &mut detection),
        ] {
            let name = match found {
                Err(PlanError::Parameter(error)) => Some(error.name),
                other => other.map(|()| None).expect("no other error"),
            };
            assert_eq!(name, is_refused.then_some("tolerance"));
        }
    }
}
