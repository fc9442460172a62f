//! Chosen methods, built structures, and the errors of detection.

use fixtures::shapes;
use glam::{DQuat, DVec3};
use kdop::Workspace;
use plan::{DetectionMethod, ForcedMethod, Plan, PlanParams, RespondParams, StructureKind};
use proximity::SurfaceTree;
use scene::{BodyId, BodyKind, CheckParams, PairId, Scene};
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
            assert!(pair.accuracy.bound <= tolerance, "{tolerance}: {pair:?}");
        }

        let exact = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
        assert_eq!(exact.len(), 2, "two pairs overlap");
        for report in &exact {
            let found = depth(&detection, report.pair.a, report.pair.b);
            let exact = report.max_depth().expect("they overlap");
            let is_within = found >= exact.lower - tolerance && found <= exact.upper + tolerance;
            assert!(is_within, "{tolerance}: {found} for {exact:?}");
        }
        assert!(depth(&detection, bone, first) > 0.0, "{tolerance}");
        assert!((depth(&detection, first, second) - 3.0).abs() <= tolerance, "{tolerance}");
    }
}

#[test]
fn one_frame_builds_nothing_but_trees() {
    let (mut scene, _) = three_of(5);
    for tolerance in [2.0, 0.1] {
        let plan = plan(&mut scene, &PlanParams::with_tolerance(tolerance));
        let kinds: Vec<_> = plan.structures().iter().map(|built| built.kind).collect();
        assert_eq!(kinds, [StructureKind::Tree; 3]);
        assert_eq!(plan.missing_structures(), []);
        assert!(plan.pairs().iter().all(|pair| pair.method == DetectionMethod::Exact), "{plan}");
    }
}

#[test]
fn many_frames_pay_for_coarse_surfaces() {
    let methods = |frames: u32| {
        let (mut scene, _) = three_of(5);
        let plan = plan(&mut scene, &PlanParams { frames, ..PlanParams::with_tolerance(0.5) });
        plan.pairs().iter().map(|pair| pair.method).collect::<Vec<_>>()
    };
    assert_eq!(methods(1), [DetectionMethod::Exact; 2]);
    assert_eq!(methods(100_000_000), [DetectionMethod::Coarse; 2]);
}

#[test]
fn a_larger_tolerance_is_predicted_cheaper_and_builds_less() {
    let (mut scene, _) = three_of(5);
    let plan = |scene: &mut Scene, tolerance| {
        plan(scene, &PlanParams { frames: 100_000_000, ..PlanParams::with_tolerance(tolerance) })
    };
    let (coarse, fine) = (plan(&mut scene, 2.0), plan(&mut scene, 0.2));
    let bytes = |plan: &Plan| plan.structures().iter().map(|built| built.bytes).sum::<usize>();
    assert!(bytes(&coarse) < bytes(&fine), "{} and {}", bytes(&coarse), bytes(&fine));
    let seconds = |plan: &Plan| plan.operations().seconds();
    assert!(seconds(&coarse) * 1.2 < seconds(&fine), "{coarse}\n{fine}");
}

/// The same pair, alone and beside a body far away: what caches hold in the small scene, they do not
/// in the large one.
#[test]
fn a_large_scene_is_predicted_dearer_and_decimated_sooner() {
    let [small, large] = [None, Some(6)].map(|halvings| {
        let rod = shapes::capsule(2.0, 30.0, 16).translated(DVec3::new(12.0, 3.0, 8.0));
        let size = DVec3::new(60.0, 60.0, 40.0);
        let muscle = shapes::plate(size, [1, 1]).translated(DVec3::Z * -20.0);
        let mut bodies = vec![("rod", rod), ("muscle", muscle)];
        if let Some(halvings) = halvings {
            let far = shapes::icosphere(30.0, halvings).translated(DVec3::X * 1e4);
            bodies.push(("far", far));
        }
        let mut scene = Scene::new();
        for (name, mesh) in bodies {
            let x = mesh.positions.clone();
            scene.add(name, BodyKind::Deformable, mesh.surface(), x).expect("a body");
        }

        // The same frame, and the least power of two of frames for which the rod is decimated.
        let mut made =
            |frames| plan(&mut scene, &PlanParams { frames, ..PlanParams::with_tolerance(2.0) });
        let cost = made(10).pairs()[0].cost;
        let is_coarse = |exponent: &u32| made(1 << exponent).pairs()[0].is_coarse[0];
        (cost, (4..20).find(is_coarse).expect("it pays at last"))
    });
    assert!(large.0 > 2.0 * small.0, "{small:?}, {large:?}");
    assert!(large.1 < small.1, "{small:?}, {large:?}");
}

#[test]
fn costs_scale_with_the_machine_factor() {
    let (mut scene, _) = three();
    let params = PlanParams { frames: 1_000_000, ..PlanParams::with_tolerance(1.0) };
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
    let exact = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
    let exact = exact.iter().find(|report| report.pair == PairId::new(bone, second));
    let exact = exact.and_then(|report| report.max_depth()).expect("they overlap");
    let found = detection.pair(PairId::new(bone, second)).expect("they overlap");
    assert_eq!(found.method, DetectionMethod::Exact);
    assert!(exact.lower > 2.5, "{exact:?}");
    assert!(found.depth.lower <= exact.upper && found.depth.upper >= exact.lower, "{found:?}");
    assert!(depth(&detection, bone, first) > 0.0, "planned pairs are detected as well");
}

#[test]
fn fields_follow_the_poses_of_bones() {
    let (mut scene, [bone, first, _]) = three();
    let forced = [ForcedMethod { pair: PairId::new(bone, first), method: DetectionMethod::Field }];
    let params = PlanParams::with_tolerance(0.5);
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    // Turned about its middle, a ball stays where it is; moved by 4, it is 6 deep.
    let pose = Pose::new(DQuat::from_rotation_z(1.0), DVec3::X * 4.0);
    scene.pose_body(bone, &pose).expect("a pose");
    let detection = detect(&mut plan, &mut scene);
    assert!((depth(&detection, bone, first) - 6.0).abs() <= 0.5);
}

#[test]
fn methods_can_be_forced() {
    let (mut scene, [bone, first, _]) = three();
    let params = PlanParams::with_tolerance(0.5);
    for method in [DetectionMethod::Exact, DetectionMethod::Coarse, DetectionMethod::Field] {
        let forced = [ForcedMethod { pair: PairId::new(first, bone), method }];
        let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let mut plan = plan.expect("a plan");
        assert_eq!(plan.pairs()[0].method, method);
        let detection = detect(&mut plan, &mut scene);
        assert!((depth(&detection, bone, first) - 2.0).abs() <= 0.5);
    }
}

#[test]
fn balls_serve_where_they_are_forced() {
    let (mut scene, [bone, first, second]) = three_of(2);
    let forced = [bone, second].map(|other| ForcedMethod {
        pair: PairId::new(first, other),
        method: DetectionMethod::Balls,
    });
    let params = PlanParams { max_displacement: f64::INFINITY, ..PlanParams::with_tolerance(1.5) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    let built = |body: BodyId| {
        let of_body = plan.structures().iter().filter(|built| built.body == body);
        of_body.map(|built| built.kind).collect::<Vec<_>>()
    };
    assert_eq!(built(bone), [StructureKind::Tree]);
    assert_eq!(built(first), [StructureKind::Tree, StructureKind::Medial]);
    for balls in plan.structures().iter().filter(|built| built.kind == StructureKind::Medial) {
        let bound = balls.accuracy.bound;
        assert!(bound > 0.0 && bound <= params.tolerance, "{balls:?}");
    }

    for shift_by in [DVec3::ZERO, DVec3::X] {
        for id in [first, second] {
            shift(&mut scene, id, -shift_by);
        }
        let detection = detect(&mut plan, &mut scene);
        for pair in plan.pairs().iter().filter(|pair| pair.method == DetectionMethod::Balls) {
            assert!(pair.accuracy.bound > 0.0 && !pair.accuracy.is_proved, "{pair:?}");
            let true_depth = if pair.pair.contains(bone) { 2.0 + shift_by.x } else { 3.0 };
            let error = (depth(&detection, pair.pair.a, pair.pair.b) - true_depth).abs();
            // Faces of this sphere are 0.5 inside of it, and vertices are apart.
            assert!(error <= params.tolerance + 0.5, "{error}: {pair:?}");
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
            let params = PlanParams { frames: 1_000_000, ..PlanParams::with_tolerance(0.3) };
            let mut plan = plan(&mut scene, &params);
            (plan.to_string(), detect(&mut plan, &mut scene))
        })
    };
    let one = run(1);
    assert!(!one.1.pairs().is_empty());
    assert!(one == run(7));
}

fn shift(scene: &mut Scene, id: BodyId, by: DVec3) {
    let x: Vec<DVec3> = scene.body(id).positions().iter().map(|&p| p + by).collect();
    scene.move_body(id, &x).expect("finite positions");
}

#[test]
fn fields_are_as_fine_as_the_tolerance_asks() {
    let (mut scene, [bone, first, _]) = three();
    let forced = [ForcedMethod { pair: PairId::new(bone, first), method: DetectionMethod::Field }];
    for tolerance in [2.0, 1.0, 0.5] {
        let params = PlanParams::with_tolerance(tolerance);
        let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let plan = plan.expect("a plan");
        let mut fields = plan.structures().iter().filter(|s| s.kind == StructureKind::Field);
        let accuracy = fields.next().expect("a field").accuracy;
        assert!(accuracy.is_proved && accuracy.bound <= tolerance, "{tolerance}: {accuracy:?}");
        assert!(accuracy.bound > 0.9 * tolerance, "{tolerance}: finer than asked: {accuracy:?}");
        assert!(accuracy.measured_error.is_some_and(|error| error <= accuracy.bound));
        assert!(plan.pairs()[0].accuracy.bound <= tolerance, "{plan}");
    }
}

#[test]
fn structures_follow_whatever_scene_is_detected() {
    // Another scene of the same bodies, of which the first is elsewhere: as many moves, other
    // positions.
    let scene_at = |shift: f64| {
        let (mut scene, [bone, first, second]) = three();
        scene.pose_body(bone, &Pose::new(DQuat::IDENTITY, DVec3::X * shift)).expect("rigid");
        let x: Vec<DVec3> = scene.body(second).positions().iter().map(|p| *p + DVec3::X).collect();
        scene.move_body(second, &x).expect("a move");
        (scene, [bone, first, second])
    };
    for method in [DetectionMethod::Exact, DetectionMethod::Coarse] {
        let (mut scene, [bone, first, _]) = scene_at(-5.0);
        let forced = [ForcedMethod { pair: PairId::new(bone, first), method }];
        let params = PlanParams::with_tolerance(1.0);
        let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let mut plan = plan.expect("a plan");
        assert!(depth(&detect(&mut plan, &mut scene), bone, first) < 1.0);

        let (mut moved, _) = scene_at(4.0);
        assert!((depth(&detect(&mut plan, &mut moved), bone, first) - 6.0).abs() <= 1.0);
        assert!(depth(&detect(&mut plan, &mut scene), bone, first) < 1.0);
    }
}

#[test]
fn a_body_that_has_come_back_is_detected_where_it_is() {
    let (mut scene, [bone, first, second]) = three();
    let params = PlanParams { max_displacement: 1.0, ..PlanParams::with_tolerance(0.1) };
    let mut plan = plan(&mut scene, &params);
    let start = scene.body(second).positions().to_vec();
    for (shift, expected) in [(0.0, 0.0), (-60.0, 5.0), (0.0, 0.0), (-61.0, 6.0)] {
        let x: Vec<DVec3> = start.iter().map(|p| *p + DVec3::X * shift).collect();
        scene.move_body(second, &x).expect("a move");
        let detection = detect(&mut plan, &mut scene);
        let found = depth(&detection, bone, second);
        assert!((found - expected).abs() < 0.2, "{shift}: {found}");
        assert_eq!(detection.out_of_range().contains(&second), shift < 0.0, "{shift}");
        assert!((depth(&detection, bone, first) - 2.0).abs() < 0.2);
    }
}

/// A field is as fine as the tolerance needs: contacts of vertices and edges with a bone are as deep
/// as these are, within the proved bound.
#[test]
fn contacts_of_fields_are_within_the_tolerance() {
    let (mut scene, [bone, first, _]) = three();
    let pair = PairId::new(bone, first);
    let forced = [ForcedMethod { pair, method: DetectionMethod::Field }];
    let full =
        SurfaceTree::new(scene.body(bone).surface().clone(), scene.body(bone).positions().to_vec());
    let (full, mut workspace) = (full.expect("a tree"), Workspace::default());
    for tolerance in [2.0, 1.0] {
        let params = PlanParams::with_tolerance(tolerance);
        let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let mut plan = plan.expect("a plan");
        let planned = plan.pairs().iter().find(|planned| planned.pair == pair).expect("a pair");
        let accuracy = planned.accuracy;
        assert!(accuracy.is_proved && accuracy.bound <= tolerance, "{tolerance}: {accuracy:?}");

        let detection = detect(&mut plan, &mut scene);
        let found = detection.pair(pair).expect("they overlap");
        let (mut compared, particles) = (0, scene.particle_positions());
        for contact in &detection.contacts()[found.contacts.clone()] {
            // Vertices of the bone are against points of the muscle; others have negative weights.
            if contact.stencil.terms().iter().any(|term| term.weight > 0.0) {
                continue;
            }
            let mut point = DVec3::ZERO;
            for term in contact.stencil.terms() {
                point -= term.weight * particles[term.particle as usize];
            }
            let closest = full.closest_point(point, f64::INFINITY, None, &mut workspace);
            let distance = closest.expect("a face").distance;
            let side = if full.contains(point, &mut workspace) { -1.0 } else { 1.0 };
            let error = (contact.gap - side * distance).abs();
            assert!(error <= tolerance, "{tolerance}: {contact:?} is off by {error}");
            compared += 1;
        }
        assert!(compared > 10, "{tolerance}: {compared} contacts");
    }
}
