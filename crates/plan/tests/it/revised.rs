//! Choices anew during a run: by the work of the present state, with what is built.

use std::ops::ControlFlow;

use fixtures::shapes::{ellipsoid, icosphere};
use glam::DVec3;
use plan::{DetectionMethod, ForcedMethod, Plan, PlanParams, StructureKind};
use scene::{BodyKind, CheckParams, PairId, Scene};
use surface::progress::Progress;

use crate::{depth, detect, plan, three_of};

#[test]
fn bodies_that_have_come_into_contact_get_coarse_surfaces() {
    // The soft balls are planned where they are apart, and then overlap by 3.
    let (mut scene, [_, first, second]) = three_of(5);
    let place = |scene: &mut Scene, at: [f64; 2]| {
        for (id, x) in [first, second].into_iter().zip(at) {
            let ball = icosphere(30.0, 5).translated(DVec3::X * x);
            scene.move_body(id, &ball.positions).expect("a move");
        }
    };
    let (apart, together) = ([62.0, 124.0], [58.0, 115.0]);
    place(&mut scene, apart);
    let frames = 3000;
    let params = PlanParams { frames, max_displacement: 20.0, ..PlanParams::with_tolerance(2.0) };
    let mut plan = plan(&mut scene, &params);
    let pair = PairId::new(first, second);
    let method = |plan: &Plan| plan.pairs().iter().find(|p| p.pair == pair).map(|p| p.is_coarse);
    assert_eq!(method(&plan), Some([false; 2]), "{plan}");

    place(&mut scene, together);
    for _ in 0..10 {
        detect(&mut plan, &mut scene);
    }
    assert!(plan.revise(&mut scene, Progress::none()).expect("a choice"), "{plan}");
    assert_eq!(method(&plan), Some([true; 2]), "{plan}");
    assert_eq!(plan.params().frames, frames - 10);
    let found = detect(&mut plan, &mut scene);
    assert!((depth(&found, first, second) - 3.0).abs() <= 2.0, "{found:?}");

    // Nothing has changed since, and what is built is kept.
    let before = format!("{:?}", plan.structures());
    assert!(!plan.revise(&mut scene, Progress::none()).expect("a choice"), "{plan}");
    assert_eq!(format!("{:?}", plan.structures()), before);
    assert_eq!(detect(&mut plan, &mut scene), found);

    // An interrupted choice leaves the plan as it is.
    let stop = |_: f64| ControlFlow::Break(());
    place(&mut scene, apart);
    assert!(plan.revise(&mut scene, Progress::new(&stop)).is_err());
    place(&mut scene, together);
    assert_eq!(detect(&mut plan, &mut scene), found);
}

#[test]
fn coarse_surfaces_of_deformed_bodies_are_built_again() {
    let mesh = ellipsoid(DVec3::new(10.0, 10.0, 40.0), 5);
    let other = mesh.clone().translated(DVec3::X * 19.0);
    let mut scene = Scene::new();
    let mut add = |name, mesh: &fixtures::Mesh| {
        let x = mesh.positions.clone();
        scene.add(name, BodyKind::Deformable, mesh.surface(), x).expect("a body")
    };
    let pair = PairId::new(add("a", &mesh), add("b", &other));
    let forced = [ForcedMethod { pair, method: DetectionMethod::Coarse }];
    let params = PlanParams { frames: 1000, ..PlanParams::with_tolerance(0.5) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");

    // A wave along the whole of both bodies.
    let wave = |p: &DVec3| *p + DVec3::X * 1.5 * (0.4 * p.z).sin();
    for (id, mesh) in [(pair.a, &mesh), (pair.b, &other)] {
        let x: Vec<DVec3> = mesh.positions.iter().map(wave).collect();
        scene.move_body(id, &x).expect("a move");
    }
    let before = detect(&mut plan, &mut scene);
    assert_eq!(before.pair(pair).map(|found| found.method), Some(DetectionMethod::Exact));
    assert!(plan.revise(&mut scene, Progress::none()).expect("a choice"), "{plan}");

    let after = detect(&mut plan, &mut scene);
    let found = after.pair(pair).expect("they overlap");
    assert_eq!(found.method, DetectionMethod::Coarse, "{plan}");
    let count = plan.structures().iter().filter(|s| s.kind == StructureKind::Coarse).count();
    assert_eq!(count, 2, "{plan}");
    let check = CheckParams { depth_tolerance: Some(1e-3), ..CheckParams::new(0.0) };
    let exact = scene.check(&check, Progress::none()).expect("a check");
    let exact = exact[0].max_depth().expect("they overlap");
    assert!((found.max_depth - exact.lower).abs() <= 0.501, "{found:?}, {exact:?}");
}
