//! Scenes state by state, each from the displacements of the one before.

use fixtures::shapes;
use glam::DVec3;
use resolve::{ResolveParams, Resolver};
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
