//! Coarse surfaces of bodies that move and deform: bounds hold, and pairs fall back where they are
//! exceeded.

use fixtures::shapes;
use glam::{DQuat, DVec3};
use plan::{DetectionMethod, ForcedMethod, Plan, PlanParams, StructureKind};
use scene::{BodyKind, CheckParams, PairId, Scene};
use surface::progress::Progress;

use crate::{depth, detect, plan, three};

const TOLERANCE: f64 = 0.5;

#[test]
fn a_deformed_body_is_detected_exactly_until_it_is_itself_again() {
    // Two fine ellipsoids, side by side, 1 deep.
    let mesh = shapes::ellipsoid(DVec3::new(10.0, 10.0, 40.0), 5);
    let other = mesh.clone().translated(DVec3::X * 19.0);
    let mut scene = Scene::new();
    let mut add = |name, mesh: &fixtures::Mesh| {
        let x = mesh.positions.clone();
        scene.add(name, BodyKind::Deformable, mesh.surface(), x).expect("a body")
    };
    let pair = PairId::new(add("a", &mesh), add("b", &other));
    let forced = [ForcedMethod { pair, method: DetectionMethod::Coarse }];
    let params = PlanParams::with_tolerance(TOLERANCE);
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");

    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7);
    let moved = |p: DVec3| turn * p + DVec3::new(30.0, -5.0, 2.0);
    // Away from the contact the first body thickens by 1.5, which is no rigid motion of the whole;
    // but coarse faces stay near what they stand for.
    let bulge = |p: DVec3| if p.x < -5.0 { p + DVec3::X * 0.3 * (p.x + 5.0) } else { p };
    // A bend by 12°: the ends move by 2, four times the tolerance, but each face nearly as it is.
    let bend = |p: DVec3| p - DVec3::X * p.z * p.z / (2.0 * 380.0);
    // A wave along the whole of it, which vertices that were left out follow and faces do not.
    let wave = |p: DVec3| p + DVec3::X * 1.5 * (0.4 * p.z).sin();
    for (name, map, method) in [
        ("rest", &(|p: DVec3| p) as &dyn Fn(DVec3) -> DVec3, DetectionMethod::Coarse),
        ("turned", &moved, DetectionMethod::Coarse),
        ("thicker", &bulge, DetectionMethod::Coarse),
        ("bent", &bend, DetectionMethod::Coarse),
        ("wave of one", &wave, DetectionMethod::Coarse),
        ("wave", &wave, DetectionMethod::Exact),
        ("turned again", &moved, DetectionMethod::Coarse),
    ] {
        let is_moved = name.starts_with("turned") || name == "wave";
        let a: Vec<DVec3> = mesh.positions.iter().map(|&p| map(p)).collect();
        let b: Vec<DVec3> =
            other.positions.iter().map(|&p| if is_moved { map(p) } else { p }).collect();
        scene.move_body(pair.a, &a).expect("a move");
        scene.move_body(pair.b, &b).expect("a move");

        let detection = detect(&mut plan, &mut scene);
        let found = detection.pair(pair).expect("they overlap");
        assert_eq!(found.method, method, "{name}");
        let params = CheckParams { depth_tolerance: Some(1e-3), ..CheckParams::new(0.0) };
        let exact = scene.check(&params, Progress::none()).expect("a check");
        let exact = exact[0].max_depth().expect("they overlap");
        let is_within = (found.max_depth - exact.lower).abs() <= TOLERANCE + 1e-3;
        assert!(is_within, "{name}: {found:?}, {exact:?}");
        let holds = found.depth.lower <= exact.upper && found.depth.upper >= exact.lower;
        assert!(holds, "{name}: {found:?}, {exact:?}");
    }
}

#[test]
fn of_two_coarse_surfaces_the_one_stays_that_saves_most_faces() {
    // A body of 20,480 faces beside one of 1,280, as they are compared.
    let [large, small] = [5, 3].map(|level| shapes::ellipsoid(DVec3::new(10.0, 10.0, 40.0), level));
    let small = small.translated(DVec3::X * 19.0);
    let mut scene = Scene::new();
    let mut add = |name, mesh: &fixtures::Mesh| {
        let x = mesh.positions.clone();
        scene.add(name, BodyKind::Deformable, mesh.surface(), x).expect("a body")
    };
    let pair = PairId::new(add("large", &large), add("small", &small));
    let forced = [ForcedMethod { pair, method: DetectionMethod::Coarse }];
    let params = PlanParams { frames: 100, ..PlanParams::with_tolerance(TOLERANCE) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");

    // A wave along the large one: its coarse surface deviates more, but not too much by itself.
    let wave = |p: &DVec3| *p + DVec3::X * 0.15 * (0.4 * p.z).sin();
    let waved: Vec<DVec3> = large.positions.iter().map(wave).collect();
    scene.move_body(pair.a, &waved).expect("a move");
    let [large, small] = coarse_vertices(&plan);
    let whole = number(scene.body(pair.b).positions().len());
    assert!(small < whole, "{small}, {whole}");
    assert!(compares(&mut plan, &mut scene, large + whole));

    // A revised plan builds the surface anew that deviates, and compares both coarse ones.
    assert!(plan.revise(&mut scene, Progress::none()).expect("a revision"));
    let [anew, same] = coarse_vertices(&plan);
    assert!((anew - large).abs() > 10.0 && (same - small).abs() < 0.5, "{anew}, {same}, {large}");
    assert!(compares(&mut plan, &mut scene, anew + same));
}

#[test]
fn a_body_that_deforms_is_whole_instead_of_all_that_it_meets() {
    // One between two others that it meets, and one far away.
    let mesh = shapes::ellipsoid(DVec3::new(10.0, 10.0, 40.0), 4);
    let mut scene = Scene::new();
    let bodies = [("middle", 0.0), ("left", -19.0), ("right", 19.0), ("far", 500.0)];
    let [middle, left, right, far] = bodies.map(|(name, x)| {
        let positions = mesh.clone().translated(DVec3::X * x).positions;
        scene.add(name, BodyKind::Deformable, mesh.surface(), positions).expect("a body")
    });
    let pairs = [left, right, far].map(|other| PairId::new(middle, other));
    let forced = pairs.map(|pair| ForcedMethod { pair, method: DetectionMethod::Coarse });
    let params = PlanParams { frames: 100, ..PlanParams::with_tolerance(TOLERANCE) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    let has_tree =
        |scene: &Scene| [middle, left, right, far].map(|id| scene.body(id).tree().is_some());

    // A wave along the first: no coarse surface can stand for it beside another.
    let wave = |p: &DVec3| *p + DVec3::X * 0.6 * (0.4 * p.z).sin();
    let waved: Vec<DVec3> = mesh.positions.iter().map(wave).collect();
    scene.move_body(middle, &waved).expect("a move");
    for id in [left, right, far] {
        let x = scene.body(id).positions().to_vec();
        scene.move_body(id, &x).expect("a move");
    }
    let detection = detect(&mut plan, &mut scene);
    assert_eq!(has_tree(&scene), [true, false, false, false]);
    assert_eq!(detection.pairs().len(), 2);

    // Where none is near, none is whole.
    let away: Vec<DVec3> = waved.iter().map(|p| *p + DVec3::Y * 300.0).collect();
    scene.move_body(middle, &away).expect("a move");
    let detection = detect(&mut plan, &mut scene);
    assert_eq!(has_tree(&scene), [false; 4]);
    assert!(detection.pairs().is_empty(), "{detection:?}");
}

/// Plans for many frames have finer surfaces for bodies that bend, which then stand for these.
#[test]
fn a_bent_body_is_compared_by_a_finer_surface_before_it_is_whole() {
    let mesh = shapes::ellipsoid(DVec3::new(10.0, 10.0, 40.0), 4);
    let mut scene = Scene::new();
    let [a, b] = [("bent", 0.0), ("straight", 19.0)].map(|(name, x)| {
        let positions = mesh.clone().translated(DVec3::X * x).positions;
        scene.add(name, BodyKind::Deformable, mesh.surface(), positions).expect("a body")
    });
    let forced = [ForcedMethod { pair: PairId::new(a, b), method: DetectionMethod::Coarse }];
    let params = PlanParams { frames: 10_000, ..PlanParams::with_tolerance(TOLERANCE) };
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");
    let coarsest: f64 = coarse_vertices(&plan).iter().sum();
    assert!(compares(&mut plan, &mut scene, coarsest));

    // The finer ones have more vertices than the coarsest, fewer than all, and the right depth.
    let wave = |p: &DVec3| *p + DVec3::X * 0.2 * (0.4 * p.z).cos();
    let waved: Vec<DVec3> = mesh.positions.iter().map(wave).collect();
    scene.move_body(a, &waved).expect("a move");
    let unmoved = scene.body(b).positions().to_vec();
    scene.move_body(b, &unmoved).expect("a move");
    let detection = detect(&mut plan, &mut scene);
    assert_eq!([a, b].map(|id| scene.body(id).tree().is_some()), [false; 2]);
    let compared = plan.pairs()[0].operations.listed_vertices;
    assert!(compared > coarsest + 50.0, "{compared}, {coarsest}");
    let found = detection.pair(forced[0].pair).expect("they overlap");
    let params = CheckParams { depth_tolerance: Some(1e-3), ..CheckParams::new(0.0) };
    let exact = scene.check(&params, Progress::none()).expect("a check");
    let exact = exact[0].max_depth().expect("they overlap");
    assert!((found.max_depth - exact.lower).abs() <= TOLERANCE + 1e-3, "{found:?}, {exact:?}");
    assert!(found.depth.lower <= exact.upper && found.depth.upper >= exact.lower, "{found:?}");

    // Straight again, the coarsest does.
    scene.move_body(a, &mesh.positions).expect("a move");
    let straight = detect(&mut plan, &mut scene);
    assert_eq!(
        straight.pair(forced[0].pair).map(|found| found.method),
        Some(DetectionMethod::Coarse)
    );
    let compared_after = plan.pairs()[0].operations.listed_vertices;
    assert!(compared_after < compared, "{compared_after}, {compared}");
}

#[test]
fn a_vertex_that_coarse_surfaces_left_out_is_seen_where_it_juts_out() {
    // Two balls, 1 apart.
    let ball = shapes::icosphere(30.0, 4);
    let mut scene = Scene::new();
    let [a, b] = [0.0, 61.0].map(|x| {
        let positions = ball.clone().translated(DVec3::X * x).positions;
        let name = format!("at {x}");
        scene.add(name, BodyKind::Deformable, ball.surface(), positions).expect("a body")
    });
    let pair = PairId::new(a, b);
    let forced = [ForcedMethod { pair, method: DetectionMethod::Coarse }];
    let params = PlanParams::with_tolerance(TOLERANCE);
    let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
    let mut plan = plan.expect("a plan");

    // Each vertex near the other ball is pulled out by 3, wherever coarse faces are.
    let near = (0..ball.positions.len()).filter(|&vertex| ball.positions[vertex].x > 29.6);
    let mut pulled = 0;
    for vertex in near {
        let mut x = ball.positions.clone();
        x[vertex] *= 1.1;
        scene.move_body(a, &x).expect("a move");
        let detection = detect(&mut plan, &mut scene);
        let found = detection.pair(pair).expect("they overlap");
        let depth = 30.0 - x[vertex].distance(DVec3::X * 61.0);
        assert!((found.max_depth - depth).abs() <= TOLERANCE, "{found:?}, {depth}");
        pulled += 1;
    }
    assert!(pulled >= 10, "{pulled}");
}

/// Pairs that were near when the plan was made.
#[test]
fn a_pair_that_is_ignored_later_is_in_no_result() {
    let (mut scene, [bone, first, second]) = three();
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    assert!(depth(&detect(&mut plan, &mut scene), bone, first) > 1.0);
    scene.ignore(bone, first);
    let detection = detect(&mut plan, &mut scene);
    let pairs: Vec<PairId> = detection.pairs().iter().map(|found| found.pair).collect();
    assert_eq!(pairs, [PairId::new(first, second)]);
}

/// Returns true if a frame compares so many vertices of the first pair.
fn compares(plan: &mut Plan, scene: &mut Scene, vertices: f64) -> bool {
    detect(plan, scene);
    let compared = plan.pairs()[0].operations.listed_vertices;
    (compared - vertices).abs() < 0.5
}

/// Returns the numbers of vertices of two closed coarse surfaces.
fn coarse_vertices(plan: &Plan) -> [f64; 2] {
    let coarse = plan.structures().iter().filter(|of_body| of_body.kind == StructureKind::Coarse);
    let vertices: Vec<f64> = coarse.map(|of_body| number(of_body.size / 2 + 2)).collect();
    [vertices[0], vertices[1]]
}

fn number(count: usize) -> f64 {
    f64::from(u32::try_from(count).expect("a small count"))
}
