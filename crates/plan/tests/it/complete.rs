//! Overlaps that no vertex and no edge of the soft body shows: detected by every method, with
//! their depth within the pair's bound.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use plan::{DetectionMethod, ForcedMethod, PairState, Plan, PlanParams, RespondParams};
use scene::{BodyKind, CheckParams, DepthBracket, PairId, Scene};
use surface::progress::Progress;

use crate::{depth, detect, three_of};

const TOLERANCES: [f64; 6] = [2.0, 1.0, 0.5, 0.2, 0.1, 0.01];

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

/// Brackets the depth of both surfaces by exact detection, without a plan.
fn exact_depth(scene: &mut Scene) -> DepthBracket {
    let ids: Vec<_> = scene.ids().collect();
    exact_depth_of(scene, PairId::new(ids[0], ids[1]))
}

fn exact_depth_of(scene: &mut Scene, pair: PairId) -> DepthBracket {
    let params = CheckParams { depth_tolerance: Some(1e-4), ..CheckParams::new(0.0) };
    let pairs = scene.check(&params, Progress::none()).expect("a check");
    let found = pairs.iter().find(|report| report.pair == pair);
    found.and_then(|report| report.max_depth()).unwrap_or_default()
}

/// Returns the plan of a scene by a forced method, or of free choice for many frames.
fn plan(scene: &mut Scene, pair: PairId, method: Option<DetectionMethod>, tolerance: f64) -> Plan {
    let forced: Vec<_> = method.map(|method| ForcedMethod { pair, method }).into_iter().collect();
    let params = PlanParams { frames: 1_000_000, ..PlanParams::with_tolerance(tolerance) };
    Plan::with_forced(scene, &params, &forced, Progress::none()).expect("a plan")
}

/// Checks that a pair's depth is within its bound, by some methods and at some tolerances.
#[track_caller]
fn assert_within_bound(
    [bone, muscle]: [&Mesh; 2],
    planted: [f64; 2],
    methods: &[Option<DetectionMethod>],
    tolerances: &[f64],
) {
    let (mut scene, pair) = scene(bone, muscle);
    let exact = exact_depth(&mut scene);
    let is_planted = exact.lower >= planted[0] && exact.upper <= planted[1];
    assert!(is_planted, "{exact:?}, {planted:?} planted");

    for &tolerance in tolerances {
        for &method in methods {
            let mut plan = plan(&mut scene, pair, method, tolerance);
            let planned = &plan.pairs()[0];
            let (accuracy, label) = (planned.accuracy, format!("{method:?} at {tolerance}"));
            if method.is_none() {
                assert!(accuracy.is_proved && accuracy.bound <= tolerance, "{label}: {accuracy:?}");
            }

            let detection = detect(&mut plan, &mut scene);
            let found = detection.pair(pair).expect(&label);
            if method == Some(DetectionMethod::Balls) {
                assert_ne!(found.state, PairState::Apart, "{label}: {found:?}");
                assert!(found.depth.upper >= exact.lower, "{label}: {found:?}");
                let error = (found.max_depth - exact.lower).abs();
                assert!(error <= accuracy.bound, "{label}: {found:?}, {exact:?}, {accuracy:?}");
                continue;
            }
            assert!(found.is_overlapping(), "{label}: {found:?}");
            let holds = found.depth.lower <= exact.upper && found.depth.upper >= exact.lower;
            assert!(holds, "{label}: {found:?}, {exact:?}");
            let bound = accuracy.bound + 1e-4;
            assert!((found.max_depth - exact.lower).abs() <= bound, "{label}: {found:?} {exact:?}");
            assert!(found.depth.upper - found.depth.lower <= 2.0 * bound, "{label}: {found:?}");
        }
    }
}

const ALL: [Option<DetectionMethod>; 5] = [
    None,
    Some(DetectionMethod::Exact),
    Some(DetectionMethod::Coarse),
    Some(DetectionMethod::Field),
    Some(DetectionMethod::Balls),
];

/// Methods by surfaces, which take no field and no balls to build.
const SURFACES: [Option<DetectionMethod>; 3] =
    [None, Some(DetectionMethod::Exact), Some(DetectionMethod::Coarse)];

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
    let bodies = [&rod(2.0, -8.0), &flat_muscle()];
    assert_within_bound(bodies, [7.999, 8.001], &ALL[..4], &[2.0, 0.5, 0.1]);
    assert_within_bound(bodies, [7.999, 8.001], &SURFACES, &[0.01]);
}

#[test]
fn two_rods_in_one_face() {
    // The polygon around both parts of the face that are inside holds much that is outside, farther
    // from the rods than these are deep.
    let mut bone = rod(2.0, -1.0);
    let other = bone.clone().translated(DVec3::new(4.0, -14.0, 0.0));
    let first = u32::try_from(bone.positions.len()).expect("a small mesh");
    bone.positions.extend(other.positions);
    bone.faces.extend(other.faces.iter().map(|face| face.map(|corner| corner + first)));
    assert_within_bound([&bone, &flat_muscle()], [0.999, 1.001], &SURFACES[..2], &TOLERANCES[2..]);
}

#[test]
fn a_spike_in_an_ellipsoid() {
    // Its tip is 6 below the outermost point of the ellipsoid, at several places and resolutions.
    for (resolution, places) in [(2, 8_u8), (3, 8), (4, 4), (5, 2)] {
        let muscle = shapes::ellipsoid(DVec3::new(20.0, 20.0, 40.0), resolution);
        for place in 0..places {
            let angle = std::f64::consts::TAU * (f64::from(place) + 0.3) / f64::from(places);
            let spike = shapes::ellipsoid(DVec3::new(15.0, 1.0, 1.0), 2);
            let spike = spike.translated(DVec3::X * (15.0 + 20.0 - 6.0)).rotated(DVec3::Z, angle);
            let bodies = [&spike, &muscle];
            let tolerances =
                [TOLERANCES[usize::from(place % 3)], TOLERANCES[usize::from(3 + place % 2)]];
            assert_within_bound(bodies, [4.5, 6.1], &SURFACES, &tolerances);
        }
    }
}

#[test]
fn a_spike_in_an_ellipsoid_by_all_methods() {
    let muscle = shapes::ellipsoid(DVec3::new(20.0, 20.0, 40.0), 4);
    let spike = shapes::ellipsoid(DVec3::new(15.0, 1.0, 1.0), 2);
    let spike = spike.translated(DVec3::X * 29.0).rotated(DVec3::Z, 0.25);
    let bodies = [&spike, &muscle];
    assert_within_bound(bodies, [5.5, 6.1], &ALL, &[2.0]);
    assert_within_bound(bodies, [5.5, 6.1], &ALL[3..], &[0.1]);
    assert_within_bound(bodies, [5.5, 6.1], &ALL[3..4], &[1.0, 0.5, 0.2]);
}

#[test]
fn a_plate_thinner_than_the_spacing_of_a_field() {
    // A scapula of 0.3 in the middle of a muscle: the muscle's surface is nowhere inside it, and
    // its own points are as deep as the muscle is thick.
    let bone = shapes::plate(DVec3::new(10.0, 10.0, 0.3), [3, 3]).rotated(DVec3::X, 0.3);
    let muscle = flat_muscle().translated(DVec3::Z * 16.0);
    assert_within_bound([&bone, &muscle], [16.0, 20.001], &ALL[..4], &TOLERANCES[..5]);
}

#[test]
fn a_bone_wholly_inside_a_muscle() {
    // Nothing crosses: the bone's points are 20 to 26 below the surface.
    let bone = shapes::icosphere(3.0, 2).translated(DVec3::X * 1.0);
    let muscle = shapes::icosphere(25.0, 4);
    assert_within_bound([&bone, &muscle], [22.0, 25.0], &ALL, &[2.0, 0.5]);
}

#[test]
fn a_muscle_wholly_inside_a_bone() {
    let bone = shapes::icosphere(25.0, 4);
    let muscle = shapes::icosphere(3.0, 2).translated(DVec3::X * 1.0);
    assert_within_bound([&bone, &muscle], [22.0, 25.0], &ALL, &[2.0, 0.5]);
}

#[test]
fn two_sheets() {
    // Crossing plates of 1 and 0.6: no vertex of either is inside the other, and no point is
    // deeper than half a thickness or so.
    let bone = shapes::plate(DVec3::new(40.0, 30.0, 1.0), [4, 3]);
    let muscle = shapes::plate(DVec3::new(30.0, 40.0, 0.6), [1, 1]).rotated(DVec3::X, 1.3);
    assert_within_bound([&bone, &muscle], [0.4, 0.52], &ALL[..4], &[0.3, 0.1, 0.01]);
}

#[test]
fn nothing_deeper_than_the_tolerance_is_apart() {
    // A rod at rising depths: never apart above the tolerance, by any method but balls, and never
    // undecided in a free plan.
    for tolerance in TOLERANCES {
        for share in [0.3, 0.9, 1.05, 2.0] {
            let depth = share * tolerance;
            let (mut scene, pair) = scene(&rod(2.0, -depth), &flat_muscle());
            for method in SURFACES {
                let mut plan = plan(&mut scene, pair, method, tolerance);
                let detection = detect(&mut plan, &mut scene);
                let state = detection.pair(pair).map_or(PairState::Apart, |found| found.state);
                assert!(state != PairState::Apart || depth <= tolerance, "{method:?}: {depth}");
                assert!(!matches!(state, PairState::Undecided { .. }), "{method:?}: {state:?}");
            }
        }
    }
}

#[test]
fn a_thin_muscle_deep_in_a_bone() {
    // The bone is nowhere deep in the muscle, which is all that balls see.
    let muscle = shapes::plate(DVec3::new(60.0, 60.0, 2.0), [30, 30]);
    assert_within_bound([&shapes::icosphere(10.0, 4), &muscle], [8.9, 9.0], &ALL, &[1.0, 0.5]);
}

#[test]
fn balls_that_see_nothing_are_undecided() {
    // The rod enters the face beside all vertices of the muscle, and has no ball in the way of its
    // own vertices only if these are asked: moved away, the boxes alone decide.
    let (mut scene, pair) = scene(&shapes::icosphere(5.0, 3), &shapes::icosphere(25.0, 3));
    let mut plan = plan(&mut scene, pair, Some(DetectionMethod::Balls), 0.5);
    let shift = |scene: &mut Scene, by: f64| {
        let ball = shapes::icosphere(25.0, 3).translated(DVec3::splat(by));
        scene.move_body(pair.b, &ball.positions).expect("a move");
    };

    // Boxes that overlap by a corner, far from the balls.
    shift(&mut scene, 27.0);
    let detection = detect(&mut plan, &mut scene);
    let Some(found) = detection.pair(pair) else { panic!("{detection:?}") };
    assert_eq!(found.state, PairState::Undecided { upper: found.depth.upper });
    assert!(found.depth.upper > 0.5 && found.depth.upper < 5.0, "{found:?}");
    shift(&mut scene, 31.0);
    assert!(detect(&mut plan, &mut scene).pairs().is_empty());
}

#[test]
fn responses_leave_nothing_that_detection_does_not_show() {
    let (mut scene, pair) = scene(&rod(2.0, -2.0), &flat_muscle());
    let mut plan = plan(&mut scene, pair, Some(DetectionMethod::Field), 0.2);
    for _ in 0..100 {
        let detection = detect(&mut plan, &mut scene);
        plan.respond(&mut scene, &detection, &RespondParams::default()).expect("a response");
    }
    let left = exact_depth(&mut scene).lower;
    let detection = detect(&mut plan, &mut scene);
    let found = depth(&detection, pair.a, pair.b);
    assert!((left - found).abs() <= 0.2, "{found} found, {left} left");
    assert!(left <= 0.2, "{left} left");
}

#[test]
fn brackets_of_coarse_surfaces_hold_what_these_have_lost() {
    // Coarse balls lie inside the full ones: they overlap by less, up to the deviation of both.
    let params = PlanParams::with_tolerance(2.0);
    let (mut scene, [_, first, second]) = three_of(5);
    let pair = PairId::new(first, second);
    let forced = [ForcedMethod { pair, method: DetectionMethod::Coarse }];
    let mut plan =
        Plan::with_forced(&mut scene, &params, &forced, Progress::none()).expect("a plan");
    for turn in 0..24_u8 {
        // The second ball goes around the first, 3 deep.
        let angle = 0.26 * f64::from(turn);
        let center = DVec3::X * 58.0 + 57.0 * DVec3::new(angle.cos(), angle.sin(), 0.1 * angle);
        let center = DVec3::X * 58.0 + 57.0 * (center - DVec3::X * 58.0).normalize();
        let ball = shapes::icosphere(30.0, 5).translated(center);
        scene.move_body(second, &ball.positions).expect("a move");

        let exact = exact_depth_of(&mut scene, pair);
        let detection = detect(&mut plan, &mut scene);
        let found = detection.pair(pair).expect("they overlap");
        let holds = found.depth.lower <= exact.upper && found.depth.upper >= exact.lower;
        assert!(holds && found.method == DetectionMethod::Coarse, "{found:?}, {exact:?}");
    }
}

#[test]
fn brackets_of_flat_surfaces_hold_a_bump_that_is_lost() {
    // A block in one face of a muscle, 3 deep everywhere but for a bump of 0.3 below, which its
    // coarse surface has no vertex for. Declared open, it is all that has a depth.
    let block = shapes::plate(DVec3::new(8.0, 8.0, 10.0), [8, 8]).translated(DVec3::Z * 2.0);
    let block = block.mapped(|p| {
        let is_bump = p.z < 0.0 && p.truncate().length() < 0.1;
        DVec3::X * 20.0 + if is_bump { p - 0.3 * DVec3::Z } else { p }
    });
    let muscle = flat_muscle();
    let mut scene = Scene::new();
    let mut add = |name, kind, mesh: &Mesh| {
        scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body")
    };
    let pair = PairId::new(
        add("block", BodyKind::Open, &block),
        add("muscle", BodyKind::Deformable, &muscle),
    );
    let exact = exact_depth_of(&mut scene, pair);
    assert!((exact.lower - 3.3).abs() < 1e-3, "{exact:?}");

    let mut plan = plan(&mut scene, pair, Some(DetectionMethod::Coarse), 2.0);
    let detection = detect(&mut plan, &mut scene);
    let found = detection.pair(pair).expect("they overlap");
    let deepest = -found.min_gap.expect("vertices inside");
    assert!((deepest - 3.0).abs() < 1e-6, "the bump is lost: {found:?}");
    assert!((found.max_depth - exact.lower).abs() <= 2.0, "{found:?}");
    assert!(found.depth.lower <= exact.upper && found.depth.upper >= exact.lower, "{found:?}");
}

#[test]
fn gaps_by_a_field_are_those_of_vertices() {
    // Edges of the bar run through the middle of the ball, with both ends far outside.
    let (ball, bar) = (shapes::icosphere(10.0, 3), DVec3::new(60.0, 3.0, 3.0));
    let (mut scene, pair) = scene(&ball, &shapes::plate(bar, [1, 1]));
    let gaps = [DetectionMethod::Exact, DetectionMethod::Field].map(|method| {
        let mut plan = plan(&mut scene, pair, Some(method), 0.5);
        let bound = plan.pairs()[0].accuracy.bound;
        let detection = detect(&mut plan, &mut scene);
        let found = detection.pair(pair).expect("they overlap");
        assert_eq!(found.method, method);
        let deepest = found.contacts.clone().map(|i| detection.contacts()[i].gap);
        let deepest = deepest.fold(f64::INFINITY, f64::min);
        (found.min_gap.expect("vertices of the ball are in the bar"), deepest, bound)
    });
    let [(exact, ..), (gap, deepest, bound)] = gaps;
    assert!((gap - exact).abs() <= bound, "{gap} for {exact}, within {bound}");
    assert!(deepest < -8.0 && gap > -2.0, "{deepest} of an edge, {gap} of a vertex");
}
