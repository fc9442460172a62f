//! Frames under a budget: order, bounds of what is left out, and the same bits in every run.

use std::time::Duration;

use fixtures::shapes::icosphere;
use glam::DVec3;
use plan::{Detection, FrameBudget, Plan, PlanParams};
use scene::{BodyId, BodyKind, CheckParams, PairId, Scene};
use surface::progress::Progress;

use crate::plan;

/// Builds a row of soft balls of radius 10 that overlap by 0.5, 1, 1.5, ....
fn row(count: u32) -> (Scene, Vec<BodyId>) {
    let mut scene = Scene::new();
    let (mut ids, mut at) = (Vec::new(), 0.0);
    for number in 0..count {
        let ball = icosphere(10.0, 3).translated(DVec3::X * at);
        let name = number.to_string();
        let id = scene.add(name, BodyKind::Deformable, ball.surface(), ball.positions);
        ids.push(id.expect("a ball"));
        at += 20.0 - 0.5 * f64::from(number + 1);
    }
    (scene, ids)
}

fn detect_within(plan: &mut Plan, scene: &mut Scene, mut budget: FrameBudget<'_>) -> Detection {
    let mut detection = Detection::default();
    plan.detect_within(scene, &mut budget, &mut detection).expect("a detection");
    detection
}

/// Moves a body along x.
fn shift(scene: &mut Scene, id: BodyId, by: f64) {
    let x: Vec<DVec3> = scene.body(id).positions().iter().map(|p| *p + by * DVec3::X).collect();
    scene.move_body(id, &x).expect("a move");
}

#[test]
fn an_unlimited_budget_detects_what_a_frame_does() {
    let (mut scene, _) = row(6);
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    let whole = crate::detect(&mut plan, &mut scene);
    let operations = FrameBudget::Operations(Duration::from_secs(3600));
    assert_eq!(detect_within(&mut plan, &mut scene, operations), whole);
}

#[test]
fn no_budget_leaves_out_all_pairs_with_bounds_on_their_depths() {
    let (mut scene, _) = row(6);
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    let detection = detect_within(&mut plan, &mut scene, FrameBudget::Operations(Duration::ZERO));
    assert!(detection.pairs().is_empty() && detection.contacts().is_empty());
    assert_eq!(detection.left_out().len(), plan.pairs().len());
    assert_bounds_hold(&mut scene, &detection, 0.5);
}

/// Checks that no pair that was left out is deeper than its bound, and that bounds fall.
#[track_caller]
fn assert_bounds_hold(scene: &mut Scene, detection: &Detection, least: f64) {
    let exact = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
    for left_out in detection.left_out() {
        let report = exact.iter().find(|report| report.pair == left_out.pair);
        let depth = report.and_then(|report| report.max_depth()).map_or(0.0, |depth| depth.lower);
        assert!(depth <= left_out.upper, "{depth}: {left_out:?}");
    }
    let uppers: Vec<f64> = detection.left_out().iter().map(|left_out| left_out.upper).collect();
    assert!(uppers.is_sorted_by(|p, q| p >= q), "{uppers:?}");
    assert!(uppers.iter().all(|&upper| upper >= least), "{uppers:?}");
}

#[test]
fn a_clock_ends_a_frame_after_the_pair_under_way() {
    // Each reading is one millisecond later: before the first pair, and after each.
    let (mut scene, ids) = row(6);
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.1));
    crate::detect(&mut plan, &mut scene);
    let frame = |plan: &mut Plan, scene: &mut Scene, pairs: u64| {
        let mut time = Duration::ZERO;
        let mut now = || {
            time += Duration::from_millis(1);
            time
        };
        let limit = Duration::from_millis(pairs);
        detect_within(plan, scene, FrameBudget::Clock { limit, now: &mut now })
    };

    // All are known after one frame; then the deepest two come first.
    frame(&mut plan, &mut scene, 100);
    let detection = frame(&mut plan, &mut scene, 2);
    let deepest = [PairId::new(ids[3], ids[4]), PairId::new(ids[4], ids[5])];
    assert_eq!(detection.pairs().iter().map(|found| found.pair).collect::<Vec<_>>(), deepest);
    assert_eq!(detection.left_out().len(), 3);
    assert_bounds_hold(&mut scene, &detection, 0.0);
    assert!(plan.pairs().iter().all(|pair| pair.measured_seconds == Some(1e-3)));

    // What has moved may be deeper now: it comes first.
    shift(&mut scene, ids[0], 3.0);
    let detection = frame(&mut plan, &mut scene, 1);
    assert_eq!(detection.pairs()[0].pair, PairId::new(ids[0], ids[1]));
    assert!(detection.pairs()[0].max_depth > 2.0);

    // Bounds of what is left out grow with the motion of both bodies, frame after frame.
    for _ in 0..5 {
        shift(&mut scene, ids[2], 0.4);
        let detection = frame(&mut plan, &mut scene, 0);
        assert_bounds_hold(&mut scene, &detection, 0.0);
    }
}

#[test]
fn a_pair_that_is_ignored_later_is_not_left_out() {
    let (mut scene, ids) = row(3);
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.5));
    scene.ignore(ids[0], ids[1]);
    for budget in [Duration::ZERO, Duration::from_secs(3600)] {
        let detection = detect_within(&mut plan, &mut scene, FrameBudget::Operations(budget));
        let found = detection.pairs().iter().map(|found| found.pair);
        let left_out = detection.left_out().iter().map(|left_out| left_out.pair);
        let pairs: Vec<PairId> = found.chain(left_out).collect();
        assert_eq!(pairs, [PairId::new(ids[1], ids[2])], "{budget:?}");
    }
}

/// A frame in which a pair is ignored says nothing of its depth in a scene in which it is not.
#[test]
fn a_pair_that_is_ignored_in_a_clone_keeps_its_bound() {
    let (mut scene, ids) = row(2);
    let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.1));
    let mut ignoring = scene.clone();
    ignoring.ignore(ids[0], ids[1]);
    for budget in [3600, 0] {
        let budget = FrameBudget::Operations(Duration::from_secs(budget));
        detect_within(&mut plan, &mut scene, budget);
        assert!(crate::detect(&mut plan, &mut ignoring).pairs().is_empty());
    }
    shift(&mut scene, ids[1], -1.0);
    let nothing = FrameBudget::Operations(Duration::ZERO);
    let detection = detect_within(&mut plan, &mut scene, nothing);
    assert_eq!(detection.left_out().len(), 1);
    assert_bounds_hold(&mut scene, &detection, 1.4);
}

/// Frames under a budget count as others, and so do the operations of the pairs that they detect.
#[test]
fn frames_under_a_budget_are_counted() {
    let (mut scene, ids) = row(3);
    let params = PlanParams { frames: 100, ..PlanParams::with_tolerance(0.5) };
    let [mut whole, mut within] = [plan(&mut scene, &params), plan(&mut scene, &params)];
    shift(&mut scene, ids[2], -1.5);
    for (frames, budget) in [(2, 3600), (3, 0)] {
        let predicted = within.operations();
        for _ in 0..frames {
            let budget = FrameBudget::Operations(Duration::from_secs(budget));
            detect_within(&mut within, &mut scene, budget);
        }
        match budget {
            0 => assert_eq!(within.operations(), predicted),
            _ => {
                crate::detect(&mut whole, &mut scene);
                crate::detect(&mut whole, &mut scene);
                assert_eq!(within.operations(), whole.operations());
            }
        }
    }
    within.revise(&mut scene, Progress::none()).expect("a choice");
    assert_eq!(within.params().frames, 95);
}

/// A way is not lost in the sum of a far longer one.
#[test]
fn bounds_hold_for_bodies_that_went_far_and_came_back() {
    let (mut scene, ids) = row(2);
    let params = PlanParams { max_displacement: f64::INFINITY, ..PlanParams::with_tolerance(0.1) };
    let mut plan = plan(&mut scene, &params);
    let home = scene.body(ids[1]).positions().to_vec();
    let all = Duration::from_secs(3600);
    for (at, budget) in [(1e20, all), (10.0, all), (0.0, Duration::ZERO)] {
        let x: Vec<DVec3> = home.iter().map(|p| *p + at * DVec3::X).collect();
        scene.move_body(ids[1], &x).expect("a move");
        let detection = detect_within(&mut plan, &mut scene, FrameBudget::Operations(budget));
        assert_bounds_hold(&mut scene, &detection, 0.4);
        assert_eq!(detection.left_out().len(), usize::from(budget.is_zero()));
    }
}

#[test]
fn a_budget_in_operations_gives_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let (mut scene, ids) = row(8);
            let mut plan = plan(&mut scene, &PlanParams::with_tolerance(0.1));
            let mut frames = Vec::new();
            for _ in 0..6 {
                shift(&mut scene, ids[3], 0.3);
                let limit = plan.operations().seconds() / 3.0 + 1e-4;
                let budget = FrameBudget::Operations(Duration::from_secs_f64(limit));
                frames.push(detect_within(&mut plan, &mut scene, budget));
            }
            frames
        })
    };
    let one = run(1);
    assert!(one.iter().all(|frame| !frame.pairs().is_empty() && !frame.left_out().is_empty()));
    assert!(one == run(2) && one == run(7));
}
