//! Plans: what is chosen and built, and whether its errors are as stated.

use distance_field::Pose;
use fixtures::Mesh;
use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use plan::{
    Detection, DetectionMethod, ExclusionReason, Plan, PlanError, PlanParams, RespondParams,
    StructureKind,
};
use scene::Progress;
use scene::{BodyId, BodyKind, CheckParams, Scene};

/// Two soft balls and a bone, of radius 30, and how deep each pair overlaps:
/// the bone and the first by 2, the balls by 3, the bone and the second not.
fn three() -> (Scene, [BodyId; 3]) {
    three_of(4)
}

/// The same, each of so many halvings of an icosahedron's edges.
fn three_of(halvings: u32) -> (Scene, [BodyId; 3]) {
    let mut scene = Scene::new();
    let bodies = [
        ("bone", BodyKind::Rigid, DVec3::ZERO),
        ("first", BodyKind::Deformable, DVec3::X * 58.0),
        ("second", BodyKind::Deformable, DVec3::X * 115.0),
    ];
    let ids = bodies.map(|(name, kind, at)| {
        let Mesh { positions, .. } = &icosphere(30.0, halvings);
        let x = positions.iter().map(|p| *p + at).collect();
        scene.add(name, kind, icosphere(30.0, halvings).surface(), x).expect("a body")
    });
    (scene, ids)
}

fn depth(detection: &Detection, a: BodyId, b: BodyId) -> f64 {
    let pair = detection.pairs().iter().find(|pair| (pair.a, pair.b) == (a, b));
    pair.map_or(0.0, |pair| pair.max_depth)
}

#[test]
fn depths_are_within_every_tolerance() {
    for tolerance in [2.0, 1.0, 0.5, 0.1] {
        let (mut scene, [bone, first, second]) = three();
        let mut plan =
            Plan::new(&mut scene, &PlanParams::with_tolerance(tolerance)).expect("a plan");
        let mut detection = Detection::default();
        plan.detect(&mut scene, &mut detection).expect("a detection");
        for pair in plan.pairs() {
            assert!(pair.error_bound <= tolerance, "{tolerance}: {pair:?}");
        }
        let exact = scene.check(&CheckParams { margin: 0.0 }, Progress::none()).expect("a check");
        let mut compared = 0;
        for report in &exact {
            let found = depth(&detection, report.pair.a, report.pair.b);
            let error = (found - report.max_depth).abs();
            assert!(error <= tolerance, "{tolerance}: {found} for {}", report.max_depth);
            compared += 1;
        }
        assert_eq!(compared, 2, "two pairs overlap");
        assert!(depth(&detection, bone, first) > 0.0, "{tolerance}");
        assert!((depth(&detection, first, second) - 3.0).abs() <= tolerance, "{tolerance}");
    }
}

#[test]
fn one_bone_and_one_muscle_get_one_structure_each() {
    let (full, [_, _, second]) = three();
    let mut scene = Scene::new();
    for body in &full.bodies()[..second.index()] {
        let (surface, x) = (body.surface().clone(), body.positions().to_vec());
        scene.add(body.name(), body.kind(), surface, x).expect("a body");
    }
    let plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.5)).expect("a plan");
    let kinds: Vec<_> = plan.structures().iter().map(|built| built.kind).collect();
    assert_eq!(kinds, [StructureKind::Field, StructureKind::Reduced]);
    let [field, reduced] = plan.structures() else { panic!("two structures") };
    // Single-precision values, and no more than a small share beside them.
    assert!(field.bytes < 5 * field.size && field.bytes >= 4 * field.size, "{field:?}");
    let faces = scene.bodies()[1].surface().faces().len();
    assert!(reduced.size * 3 < faces, "{} of {faces} faces", reduced.size);
    assert_eq!(plan.pairs().len(), 1);
}

#[test]
fn a_coarser_plan_is_predicted_cheaper_and_builds_less() {
    let (mut scene, _) = three();
    let mut of =
        |tolerance| Plan::new(&mut scene, &PlanParams::with_tolerance(tolerance)).expect("a plan");
    let (coarse, fine) = (of(2.0), of(0.05));
    let bytes = |plan: &Plan| plan.structures().iter().map(|built| built.bytes).sum::<usize>();
    assert!(bytes(&coarse) * 2 < bytes(&fine), "{} and {}", bytes(&coarse), bytes(&fine));
    let cost = |plan: &Plan| plan.pairs().iter().map(|pair| pair.cost).sum::<f64>();
    let (coarse, fine) = (cost(&of(2.0)), cost(&of(0.05)));
    assert!(coarse * 5.0 < fine, "{coarse} and {fine}");
}

#[test]
fn what_cannot_meet_builds_nothing() {
    let (mut scene, [bone, first, second]) = three();
    let need = PlanParams { max_displacement: 5.0, ..PlanParams::with_tolerance(0.5) };
    let mut plan = Plan::new(&mut scene, &need).expect("a plan");
    let excluded_pairs = plan.excluded_pairs();
    assert_eq!(excluded_pairs.len(), 1);
    assert_eq!((excluded_pairs[0].a, excluded_pairs[0].b), (bone, second));
    // The balls' surfaces are 55 apart.
    let ExclusionReason::FarApart { distance } = excluded_pairs[0].reason else {
        panic!("{excluded_pairs:?}")
    };
    assert!((50.0..=55.0).contains(&distance), "{distance}");

    let mut detection = Detection::default();
    plan.detect(&mut scene, &mut detection).expect("a detection");
    assert_eq!(detection.out_of_range(), []);
    let moved: Vec<DVec3> =
        scene.body(second).positions().iter().map(|p| *p - DVec3::X * 5.5).collect();
    scene.move_body(second, &moved).expect("a move");
    plan.detect(&mut scene, &mut detection).expect("a detection");
    assert_eq!(detection.out_of_range(), [second]);

    let none = PlanParams { max_displacement: 0.0, ..PlanParams::with_tolerance(0.5) };
    let away: Vec<DVec3> =
        scene.body(first).positions().iter().map(|p| *p + DVec3::Y * 500.0).collect();
    scene.move_body(first, &away).expect("a move");
    let plan = Plan::new(&mut scene, &none).expect("a plan");
    assert!(plan.pairs().is_empty() && plan.structures().is_empty(), "{plan}");
    assert!(plan.to_string().contains("no tree: no pair needs it"), "{plan}");
}

#[test]
fn bones_follow_their_pose() {
    let (mut scene, [bone, first, _]) = three();
    let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.5)).expect("a plan");
    let mut detection = Detection::default();
    // Turned about its middle, a ball stays where it is; moved by 4, it is 6 deep.
    let pose = Pose::new(DQuat::from_rotation_z(1.0), DVec3::X * 4.0);
    scene.pose_body(bone, &pose).expect("a pose");
    plan.detect(&mut scene, &mut detection).expect("a detection");
    assert!((depth(&detection, bone, first) - 6.0).abs() <= 0.5);

    let x = scene.body(bone).positions().to_vec();
    scene.move_body(bone, &x).expect("a move");
    let refused = plan.detect(&mut scene, &mut detection);
    assert_eq!(refused, Err(PlanError::NoPose { name: "bone".into() }));
}

#[test]
fn a_budget_that_is_too_small_gives_up_accuracy_and_says_so() {
    let (mut scene, _) = three();
    // No machine keeps to this, so that all is given up that may be.
    let budget = Some(std::time::Duration::from_nanos(1));
    let need = PlanParams { budget, ..PlanParams::with_tolerance(0.3) };
    let plan = Plan::new(&mut scene, &need).expect("a plan");
    assert!(plan.tolerance() > 0.3, "{plan}");
    assert!(plan.to_string().contains("given up for the budget: 0.3"), "{plan}");
    assert!(!plan.keeps_budget() && plan.to_string().contains("over the budget"), "{plan}");
    let unhurried = PlanParams { budget: Some(std::time::Duration::from_secs(60)), ..need };
    let plan = Plan::new(&mut scene, &unhurried).expect("a plan");
    assert!(plan.keeps_budget() && plan.tolerance() <= 0.3, "{plan}");
}

#[test]
fn methods_can_be_forced_where_they_can_serve() {
    let (mut scene, [bone, first, second]) = three();
    let need = PlanParams::with_tolerance(0.5);
    let forced = [(first, bone, DetectionMethod::Surfaces)];
    let mut plan = Plan::with_forced(&mut scene, &need, &forced).expect("a plan");
    assert_eq!(plan.pairs()[0].method, DetectionMethod::Surfaces);
    let mut detection = Detection::default();
    plan.detect(&mut scene, &mut detection).expect("a detection");
    assert!((depth(&detection, bone, first) - 2.0).abs() <= 0.5);

    let refused = Plan::with_forced(&mut scene, &need, &[(first, second, DetectionMethod::Field)]);
    let error = refused.expect_err("no bone");
    assert!(error.to_string().contains("\"first\" and \"second\""), "{error}");
}

#[test]
fn balls_serve_where_they_are_forced() {
    let (mut scene, [bone, first, second]) = three_of(2);
    let forced = [(bone, first, DetectionMethod::Medial), (second, first, DetectionMethod::Medial)];
    let need = PlanParams::with_tolerance(1.5);
    let mut plan = Plan::with_forced(&mut scene, &need, &forced).expect("a plan");
    let built = |body: BodyId| {
        let of_body = plan.structures().iter().filter(|built| built.body == body);
        of_body.map(|built| built.kind).collect::<Vec<_>>()
    };
    // The bone has its tree for the balls and its field for the second ball.
    assert_eq!(built(bone), [StructureKind::Tree, StructureKind::Field]);
    assert_eq!(built(first), [StructureKind::Tree, StructureKind::Medial]);
    let mut detection = Detection::default();
    for shift in [DVec3::ZERO, DVec3::X] {
        for id in [first, second] {
            let x: Vec<_> = scene.body(id).positions().iter().map(|p| *p - shift).collect();
            scene.move_body(id, &x).expect("a move");
        }
        plan.detect(&mut scene, &mut detection).expect("a detection");
        for pair in plan.pairs().iter().filter(|pair| pair.method == DetectionMethod::Medial) {
            assert!(pair.error_bound > 0.0 && pair.error_bound <= need.tolerance, "{pair:?}");
            let true_depth = if pair.a == bone { 2.0 + shift.x } else { 3.0 };
            let error = (depth(&detection, pair.a, pair.b) - true_depth).abs();
            // Faces of this sphere are 0.5 inside of it, and vertices are apart.
            assert!(error <= pair.error_bound + 0.5, "{error}: {pair:?}");
        }
    }

    let (mut scene, [bone, ..]) = three();
    let mesh = icosphere(5.0, 2);
    let other = scene.add("other", BodyKind::Rigid, mesh.surface(), mesh.positions);
    let both = [(bone, other.expect("a body"), DetectionMethod::Medial)];
    let error = Plan::with_forced(&mut scene, &need, &both).expect_err("no balls");
    assert!(error.to_string().contains("both are rigid"), "{error}");
}

#[test]
fn responses_part_what_overlaps() {
    let (mut scene, [bone, first, second]) = three();
    let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.1)).expect("a plan");
    let mut detection = Detection::default();
    for _ in 0..20 {
        plan.detect(&mut scene, &mut detection).expect("a detection");
        plan.respond(&mut scene, &detection, &RespondParams::default()).expect("a response");
    }
    plan.detect(&mut scene, &mut detection).expect("a detection");
    for [a, b] in [[bone, first], [first, second]] {
        assert!(depth(&detection, a, b) < 0.2, "{}", depth(&detection, a, b));
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let detect = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let (mut scene, _) = three();
            let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.3)).expect("a plan");
            let mut detection = Detection::default();
            plan.detect(&mut scene, &mut detection).expect("a detection");
            detection
        })
    };
    let one = detect(1);
    assert!(!one.contacts().is_empty());
    assert!(one == detect(2) && one == detect(7));
}

#[test]
fn needs_that_mean_nothing_are_refused_by_name() {
    let (mut scene, _) = three();
    let good = PlanParams::with_tolerance(0.5);
    let bad = [
        ("tolerance", PlanParams { tolerance: 0.0, ..good }),
        ("tolerance", PlanParams { tolerance: f64::NAN, ..good }),
        ("margin", PlanParams { margin: -1.0, ..good }),
        ("margin", PlanParams { margin: f64::INFINITY, ..good }),
        ("max_displacement", PlanParams { max_displacement: f64::NAN, ..good }),
        ("max_displacement", PlanParams { max_displacement: -0.5, ..good }),
        ("machine_factor", PlanParams { machine_factor: 0.0, ..good }),
        ("threads", PlanParams { threads: 0, ..good }),
    ];
    for (name, need) in bad {
        let error = Plan::new(&mut scene, &need).expect_err("a need that means nothing");
        assert!(error.to_string().contains(name), "{error}");
    }
    let mut plan = Plan::new(&mut scene, &good).expect("a plan");
    let refused = plan.detect(&mut Scene::new(), &mut Detection::default());
    assert_eq!(refused, Err(PlanError::OtherScene));
}
