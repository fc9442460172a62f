//! Scenes state by state, each from the displacements of the one before.

use std::ops::ControlFlow;

use fixtures::shapes;
use glam::DVec3;
use resolve::{Conditions, ResolveParams, Resolver, Tie};
use scene::BodyKind;
use surface::progress::Progress;

use crate::scene_of;

/// A bone goes through where a sheet of tissue is at rest, beyond its middle: the sheet stays before it, as far as its
/// strain allows. The same state by itself has the sheet behind the bone, which is the shorter way.
#[test]
fn tissue_stays_on_its_side_of_a_bone_that_goes_on() {
    let sheet = shapes::plate(DVec3::new(60.0, 60.0, 2.0), [24, 24]);
    let bone = shapes::icosphere(5.0, 3);
    let bodies =
        [("bone", BodyKind::Rigid, bone.clone()), ("sheet", BodyKind::Deformable, sheet.clone())];
    let mut scene = scene_of(bodies);
    let [bone_id, sheet_id] = ["bone", "sheet"].map(|name| scene.find(name).expect("a body"));
    let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
    let mut walk = Resolver::new(params).expect("valid parameters");
    let mut continued = Vec::new();
    for step in 0..48 {
        let height = 6.0 - 0.25 * f64::from(step);
        let place = bone.clone().translated(height * DVec3::Z).positions;
        scene.move_body(bone_id, &place).expect("a place");
        scene.move_body(sheet_id, &sheet.positions).expect("its rest");
        let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert!(end.resolved, "at {height}: {:?}", end.broken_limits);
        let middle =
            scene.body(sheet_id).positions().iter().filter(|x| x.truncate().length() < 3.0);
        let is_before = middle.clone().all(|x| x.z < height);
        assert!(is_before || middle.clone().all(|x| x.z > height), "on one side at {height}");
        continued.push((end.is_continued, is_before));
    }
    assert_eq!(continued[0], (false, true));
    assert!(continued[1..37].iter().all(|&end| end == (true, true)), "{continued:?}");

    // Farther than its strain allows it begins anew, which is told.
    let anew = continued[1..].iter().position(|&end| end == (false, false));
    assert!(anew.is_some(), "{continued:?}");
}

/// A bone is pressed into a muscle and goes back, faster than contacts are known ahead: the muscle comes after it.
#[test]
fn tissue_comes_after_a_bone_that_goes_back() {
    let muscle = shapes::ellipsoid(DVec3::new(15.0, 12.0, 30.0), 3);
    let bone = shapes::ellipsoid(DVec3::new(5.0, 40.0, 5.0), 3);
    let bodies =
        [("bone", BodyKind::Rigid, bone.clone()), ("muscle", BodyKind::Deformable, muscle.clone())];
    for gap in [0.0, 0.1] {
        let mut scene = scene_of(bodies.clone());
        let [bone_id, muscle_id] = ["bone", "muscle"].map(|name| scene.find(name).expect("a body"));
        let params = ResolveParams { gap, ..ResolveParams::with_smoothing(6.0) };
        let mut walk = Resolver::new(params).expect("valid parameters");
        for depth in [1.0, 4.0, 7.0, 10.0, 7.0, 4.0, 1.0, -1.0] {
            let place = bone.clone().translated((20.0 - depth) * DVec3::X).positions;
            scene.move_body(bone_id, &place).expect("a place");
            scene.move_body(muscle_id, &muscle.positions).expect("its rest");
            let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
            assert!(end.resolved, "{depth} in: {:?}", end.remaining);
            let moved = end.bodies.iter().map(|change| change.max_displacement).fold(0.0, f64::max);
            assert!(moved <= 1.15 * f64::max(depth, 0.0) + 0.3, "{depth} in, {moved} out");
        }
    }
}

/// A bone that is pressed into a muscle of small faces goes back by most of its depth at once.
#[test]
fn tissue_comes_after_a_bone_that_goes_back_fast() {
    let muscle = shapes::ellipsoid(DVec3::new(15.0, 12.0, 30.0), 4);
    let bone = shapes::ellipsoid(DVec3::new(5.0, 40.0, 5.0), 4);
    let bodies =
        [("bone", BodyKind::Rigid, bone.clone()), ("muscle", BodyKind::Deformable, muscle.clone())];
    let mut scene = scene_of(bodies);
    let [bone_id, muscle_id] = ["bone", "muscle"].map(|name| scene.find(name).expect("a body"));
    let params = ResolveParams { gap: 0.1, ..ResolveParams::with_smoothing(6.0) };
    let mut walk = Resolver::new(params).expect("valid parameters");
    for depth in [8.0, 2.0, 0.5, 0.5, -1.0] {
        let place = bone.clone().translated((20.0 - depth) * DVec3::X).positions;
        scene.move_body(bone_id, &place).expect("a place");
        scene.move_body(muscle_id, &muscle.positions).expect("its rest");
        let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert!(end.resolved, "{depth} in: {:?}", end.remaining);
        let moved = end.bodies.iter().map(|change| change.max_displacement).fold(0.0, f64::max);
        assert!(moved <= 1.15 * f64::max(depth, 0.0) + 0.3, "{depth} in, {moved} out");
    }
}

/// A ball goes through where a plate is at rest and beyond, also where it is clear of the plate at rest: the plate stays
/// before it, until its limits let it go, which is told.
#[test]
fn tissue_stays_before_a_bone_that_is_beyond_its_rest() {
    let plate = shapes::plate(DVec3::new(20.0, 20.0, 2.0), [8, 8]);
    let ball = shapes::icosphere(3.0, 3);
    let bodies =
        [("ball", BodyKind::Rigid, ball.clone()), ("plate", BodyKind::Deformable, plate.clone())];
    let mut scene = scene_of(bodies);
    let [ball_id, plate_id] = ["ball", "plate"].map(|name| scene.find(name).expect("a body"));
    let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(8.0) };
    let mut walk = Resolver::new(params).expect("valid parameters");
    let (mut was_before, mut anew, mut clear_before) = (true, 0, 0);
    for step in 0..33 {
        let height = -8.0 + 0.5 * f64::from(step);
        let place = ball.clone().translated(height * DVec3::Z).positions;
        scene.move_body(ball_id, &place).expect("a place");
        scene.move_body(plate_id, &plate.positions).expect("its rest");
        let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert!(end.resolved, "at {height}: {:?}", end.broken_limits);
        let middle =
            scene.body(plate_id).positions().iter().filter(|x| x.truncate().length() < 2.0);
        let is_before = middle.clone().all(|x| x.z > height);
        if was_before && !is_before {
            assert!(!end.is_continued, "through at {height}, and not told");
            anew += 1;
        }
        clear_before += usize::from(is_before && height > 4.0);
        was_before = is_before;
    }
    assert_eq!(anew, 1, "the plate is let go once");
    assert!(
        clear_before >= 3,
        "before the ball in {clear_before} states that are clear of its rest"
    );
}

/// Cartilage is near a bone in the first state, and farther from it than its tie reaches in the next ones, in which
/// another bone presses it: what was tied at first stays, also where a call is interrupted between.
#[test]
fn ties_hold_what_they_held_in_the_first_state() {
    let bone = shapes::plate(DVec3::new(30.0, 30.0, 4.0), [9, 9]).translated(-2.0 * DVec3::Z);
    let cartilage = shapes::plate(DVec3::new(20.0, 20.0, 1.0), [20, 20]);
    let cartilage = cartilage.translated(0.6 * DVec3::Z);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, bone),
        ("cartilage", BodyKind::Deformable, cartilage.clone()),
        ("ball", BodyKind::Rigid, shapes::icosphere(4.0, 3).translated(20.0 * DVec3::Z)),
    ]);
    let ids: Vec<_> = scene.ids().collect();
    let ties = vec![Tie { bodies: [ids[1], ids[0]], distance: 0.2 }];
    let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(4.0) };
    let conditions = Conditions { ties, ..Conditions::default() };
    let mut walk = Resolver::new(params).expect("parameters").with_conditions(conditions);
    for (up, ball_height) in [(0.0, 20.0), (0.5, 5.8), (1.0, 6.2)] {
        let lifted: Vec<DVec3> = cartilage.positions.iter().map(|x| *x + up * DVec3::Z).collect();
        let ball = shapes::icosphere(4.0, 3).translated(ball_height * DVec3::Z);
        scene.move_body(ids[1], &lifted).expect("a place");
        scene.move_body(ids[2], &ball.positions).expect("a place");
        if up > 0.0 {
            let stop = |_| ControlFlow::Break(());
            walk.resolve(&mut scene, Progress::new(&stop)).expect_err("an interruption");
        }
        let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert_eq!((end.ties[0].tied, end.ties[0].crossing), (21 * 21, 0), "{up}");

        // It is torn off by the motion, which ties do not undo.
        let apart = end.ties[0].max_distance;
        assert!((apart - 0.1 - up).abs() < 1e-3, "{up}: {apart}");
        assert_eq!(end.resolved, up == 0.0, "{up}: {:?}", end.remaining);
        assert!(end.remaining.is_empty() && end.broken_limits.is_empty() && end.gap.holds());
        let lower = |x: &&DVec3| x.z < 0.3 + up;
        let held = scene.body(ids[1]).positions().iter().filter(lower);
        assert!(held.clone().count() >= 21 * 21, "{up}");
        assert!(held.clone().all(|x| (x.z - 0.1 - up).abs() < 0.02), "{up}");
    }

    // Sunk in the bone, it comes out.
    let sunk: Vec<DVec3> = cartilage.positions.iter().map(|x| *x - 0.4 * DVec3::Z).collect();
    scene.move_body(ids[1], &sunk).expect("a place");
    let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(end.resolved && end.ties[0].tied == 0, "{:?} {:?}", end.ties, end.remaining);
    assert_eq!(end.ties[0].crossing, 21 * 21);

    // Where it is back at the bone, what was tied at first is so again.
    scene.move_body(ids[1], &cartilage.positions).expect("a place");
    let end = walk.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(end.resolved && end.ties[0].crossing == 0, "{:?} {:?}", end.ties, end.remaining);
    assert_eq!(end.ties[0].tied, 21 * 21);
}
