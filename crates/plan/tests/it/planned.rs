//! Chosen methods, built structures, and the errors of detection.

use glam::{DQuat, DVec3};
use plan::{DetectionMethod, ForcedMethod, Plan, PlanParams, RespondParams, StructureKind};
use scene::{BodyId, CheckParams, PairId, Scene};
use surface::Pose;
use surface::progress::Progress;

use crate::{depth, detect, plan, three, three_of};

#[test]
fn depths_are_within_every_tolerance() {
    for tolerance in [2.0, 1.0, 0.5, 0.1] {
        let (mut scene, [bone, first, second]) = three();
        let mut plan = plan(&mut scene, &PlanParams::with_tolerance(tolerance));
        let detection = detect(&mut plan, &mut scene);
        for pair in plan.pairs() {
            assert!(pair.error.value() <= tolerance, "{tolerance}: {pair:?}");
        }

        let exact = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
        assert_eq!(exact.len(), 2, "two pairs overlap");
        for report in &exact {
            let found = depth(&detection, report.pair.a, report.pair.b);
            let error = (found - report.max_vertex_depth).abs();
            assert!(error <= tolerance, "{tolerance}: {found} for {}", report.max_vertex_depth);
        }
        assert!(depth(&detection, bone, first) > 0.0, "{tolerance}");
        assert!((depth(&detection, first, second) - 3.0).abs() <= tolerance, "{tolerance}");
    }
}

#[test]
fn one_bone_and_one_muscle_get_what_their_pair_needs() {
    let (full, [_, _, second]) = three();
    let mut scene = Scene::new();
    for body in &full.bodies()[..second.index()] {
        let (surface, x) = (body.surface().clone(), body.positions().to_vec());
        scene.add(body.name(), body.kind(), surface, x).expect("a body");
    }
    let plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    let kinds: Vec<_> = plan.structures().iter().map(|built| built.kind).collect();
    assert_eq!(kinds, [StructureKind::Tree, StructureKind::Field, StructureKind::Reduced]);

    let [_, field, reduced] = plan.structures() else { panic!("three structures") };
    // Single-precision values, and no more than a small share beside them.
    assert!(field.bytes < 5 * field.size && field.bytes >= 4 * field.size, "{field:?}");
    let faces = scene.bodies()[1].surface().faces().len();
    assert!(reduced.size * 3 < faces, "{} of {faces} faces", reduced.size);
    assert_eq!(plan.pairs().len(), 1);
}

#[test]
fn a_coarser_plan_is_predicted_cheaper_and_builds_less() {
    let (mut scene, _) = three();
    let coarse = plan(&mut scene, &PlanParams::with_tolerance(2.0));
    let fine = plan(&mut scene, &PlanParams::with_tolerance(0.2));
    let bytes = |plan: &Plan| {
        let of_tolerance =
            plan.structures().iter().filter(|built| built.kind != StructureKind::Tree);
        of_tolerance.map(|built| built.bytes).sum::<usize>()
    };
    assert!(bytes(&coarse) * 2 < bytes(&fine), "{} and {}", bytes(&coarse), bytes(&fine));
    let cost = |plan: &Plan| plan.pairs().iter().map(|pair| pair.cost).sum::<f64>();
    assert!(cost(&coarse) * 1.2 < cost(&fine), "{} and {}", cost(&coarse), cost(&fine));
}

#[test]
fn costs_scale_with_the_machine_factor() {
    let (mut scene, _) = three();
    let params = PlanParams::with_tolerance(1.0);
    let reference = plan(&mut scene, &params);
    let scaled = PlanParams { machine_factor: 8.0, threads: 4, ..params };
    let scaled = plan(&mut scene, &scaled);
    for (scaled, pair) in scaled.pairs().iter().zip(reference.pairs()) {
        assert!((scaled.cost - 8.0 * pair.cost).abs() <= 1e-15 * scaled.cost, "{scaled:?}");
    }
    let [p, q] = [&scaled, &reference].map(|plan| plan.predicted_time().as_secs_f64());
    assert!((p / q - 2.0).abs() < 1e-3, "{p} and {q}");
}

#[test]
fn bodies_that_cannot_meet_get_no_structures() {
    let (mut scene, [bone, _, second]) = three();
    shift(&mut scene, second, DVec3::Y * 500.0);
    let plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    assert_eq!((plan.pairs().len(), plan.far_pair_count()), (1, 2), "{plan}");
    assert!(plan.structures().iter().all(|built| built.body != second), "{plan}");

    scene.pose_body(bone, &Pose::new(DQuat::IDENTITY, -DVec3::X * 500.0)).expect("a pose");
    let plan = crate::plan(&mut scene, &PlanParams::with_tolerance(0.5));
    assert!(plan.pairs().is_empty() && plan.structures().is_empty(), "{plan}");
    assert!(plan.to_string().contains("3 pairs farther apart"), "{plan}");
}

#[test]
fn pairs_that_come_near_are_detected_though_they_were_not_planned() {
    let (mut scene, [bone, first, second]) = three();
    let params = PlanParams { max_displacement: 5.0, ..PlanParams::with_tolerance(0.5) };
    let mut plan = plan(&mut scene, &params);
    assert_eq!((plan.pairs().len(), plan.far_pair_count()), (2, 1), "{plan}");
    assert_eq!(detect(&mut plan, &mut scene).out_of_range(), []);

    // The second ball goes round the first, until it is as deep in the bone as check says.
    shift(&mut scene, second, DVec3::new(-115.0, 57.0, 0.0));
    let detection = detect(&mut plan, &mut scene);
    assert_eq!(detection.out_of_range(), [second]);
    let exact =
        scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    let exact = exact.iter().find(|report| report.pair == PairId::new(bone, second));
    let exact = exact.expect("they overlap").max_vertex_depth;
    assert!(exact > 2.5, "{exact}");
    assert_eq!(depth(&detection, bone, second).to_bits(), exact.to_bits());
    assert!(depth(&detection, bone, first) > 0.0, "planned pairs are detected as well");
}

#[test]
fn fields_follow_the_poses_of_bones() {
    let (mut scene, [bone, first, _]) = three();
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    // Turned about its middle, a ball stays where it is; moved by 4, it is 6 deep.
    let pose = Pose::new(DQuat::from_rotation_z(1.0), DVec3::X * 4.0);
    scene.pose_body(bone, &pose).expect("a pose");
    let detection = detect(&mut plan, &mut scene);
    assert!((depth(&detection, bone, first) - 6.0).abs() <= 0.5);
}

#[test]
fn a_budget_that_is_too_small_costs_accuracy() {
    let (mut scene, _) = three();
    // No machine keeps to this: all tolerances are tried.
    let budget = Some(std::time::Duration::from_nanos(1));
    let hasty = PlanParams { budget, ..PlanParams::with_tolerance(0.3) };
    let coarse = plan(&mut scene, &hasty);
    assert!(coarse.tolerance() > 0.3 && !coarse.is_within_budget(), "{coarse}");
    let text = coarse.to_string();
    assert!(text.contains("(0.3 exceeds the budget)"), "{text}");
    assert!(text.contains("per frame predicted, over the budget"), "{text}");

    let unhurried = PlanParams { budget: Some(std::time::Duration::from_secs(60)), ..hasty };
    let plan = plan(&mut scene, &unhurried);
    assert!(plan.is_within_budget() && plan.tolerance() <= 0.3, "{plan}");
    assert!(!plan.to_string().contains("budget"), "{plan}");
}

#[test]
fn methods_can_be_forced() {
    let (mut scene, [bone, first, _]) = three();
    let params = PlanParams::with_tolerance(0.5);
    let forced =
        [ForcedMethod { pair: PairId::new(first, bone), method: DetectionMethod::Surfaces }];
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    assert_eq!(plan.pairs()[0].method, DetectionMethod::Surfaces);
    let detection = detect(&mut plan, &mut scene);
    assert!((depth(&detection, bone, first) - 2.0).abs() <= 0.5);
}

#[test]
fn balls_serve_where_they_are_forced() {
    let (mut scene, [bone, first, second]) = three_of(2);
    let forced = [bone, second].map(|other| ForcedMethod {
        pair: PairId::new(first, other),
        method: DetectionMethod::Medial,
    });
    let params = PlanParams { max_displacement: f64::INFINITY, ..PlanParams::with_tolerance(1.5) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    let built = |body: BodyId| {
        let of_body = plan.structures().iter().filter(|built| built.body == body);
        of_body.map(|built| built.kind).collect::<Vec<_>>()
    };
    // The bone has its tree for the balls and its field for the second ball.
    assert_eq!(built(bone), [StructureKind::Tree, StructureKind::Field]);
    assert_eq!(built(first), [StructureKind::Tree, StructureKind::Medial]);

    for shift_by in [DVec3::ZERO, DVec3::X] {
        for id in [first, second] {
            shift(&mut scene, id, -shift_by);
        }
        let detection = detect(&mut plan, &mut scene);
        for pair in plan.pairs().iter().filter(|pair| pair.method == DetectionMethod::Medial) {
            assert!(pair.error.value() > 0.0, "{pair:?}");
            assert!(pair.error.value() <= params.tolerance, "{pair:?}");
            let true_depth = if pair.pair.contains(bone) { 2.0 + shift_by.x } else { 3.0 };
            let error = (depth(&detection, pair.pair.a, pair.pair.b) - true_depth).abs();
            // Faces of this sphere are 0.5 inside of it, and vertices are apart.
            assert!(error <= pair.error.value() + 0.5, "{error}: {pair:?}");
        }
    }
}

#[test]
fn responses_separate_overlaps() {
    let (mut scene, [bone, first, second]) = three();
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.1));
    for _ in 0..20 {
        let detection = detect(&mut plan, &mut scene);
        plan.respond(&mut scene, &detection, &RespondParams::default()).expect("a response");
    }
    let detection = detect(&mut plan, &mut scene);
    for [a, b] in [[bone, first], [first, second]] {
        assert!(depth(&detection, a, b) < 0.2, "{}", depth(&detection, a, b));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let (mut scene, _) = three();
            // A budget that the predicted time of one thread exceeds.
            let budget = Some(std::time::Duration::from_micros(1));
            let params = PlanParams { budget, ..PlanParams::with_tolerance(0.3) };
            let mut plan = plan(&mut scene, &params);
            (plan.tolerance(), detect(&mut plan, &mut scene))
        })
    };
    let one = run(1);
    assert!(!one.1.pairs().is_empty());
    assert!(one == run(2) && one == run(7));
}

fn shift(scene: &mut Scene, id: BodyId, by: DVec3) {
    let x: Vec<DVec3> = scene.body(id).positions().iter().map(|&p| p + by).collect();
    scene.move_body(id, &x).expect("finite positions");
}
