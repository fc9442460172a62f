//! Parameters far from those of any body: a tiny smoothing length, and files that round more than the
//! gap.

use fixtures::shapes;
use glam::DVec3;
use resolve::{
    BodyStiffness, Conditions, Resolution, ResolveError, ResolveParams, Resolver, WrittenPrecision,
};
use scene::{BodyKind, Scene};
use surface::SimplexSurface;
use surface::progress::Progress;

use crate::gap::brute_distance;
use crate::scene_of;

/// Builds a bone and a muscle 1.4 deep in each other, about a place.
fn two_balls(at: DVec3) -> Scene {
    let ball = shapes::icosphere(10.0, 2);
    let muscle = ball.clone().rotated(DVec3::Z, 0.1).translated(at + DVec3::X * 18.6);
    let bone = ball.translated(at);
    scene_of([("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)])
}

/// Builds two muscles 1.4 deep in each other.
fn two_soft_balls() -> Scene {
    let ball = shapes::icosphere(10.0, 2);
    let muscle = ball.clone().rotated(DVec3::Z, 0.1).translated(DVec3::X * 18.6);
    scene_of([("other", BodyKind::Deformable, ball), ("muscle", BodyKind::Deformable, muscle)])
}

#[test]
fn a_tiny_smoothing_length_damages_nothing() {
    for smoothing in [1e-2, 1e-6, 1e-13] {
        let mut scene = two_balls(DVec3::ZERO);
        let params = ResolveParams::with_smoothing(smoothing);
        // A depth to a hundredth of such a length would be what takes time.
        let params = ResolveParams { max_rounds: 6, tolerance: 1e-3, ..params };
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        let resolution = resolution.expect("a resolution");

        // Each round goes as far as a quarter of the length: there is a long way to go.
        assert!(!resolution.resolved && resolution.remaining.len() == 1, "{smoothing}");
        let change = &resolution.bodies[1];
        assert!(change.max_displacement <= 6.0 * 0.25 * smoothing, "{smoothing}: {change:?}");
        assert_eq!((change.flipped_faces, change.self_crossings), (0, [0, 0]), "{smoothing}");
        assert!(scene.body(change.body).positions().iter().all(|x| x.is_finite()), "{smoothing}");
    }
}

#[test]
fn a_smoothing_length_below_rounding_is_refused() {
    for smoothing in [1e-15, 1e-100, 1e-300] {
        let params = ResolveParams::with_smoothing(smoothing);
        let resolution = resolve::resolve(&mut two_balls(DVec3::ZERO), &params, Progress::none());
        let Err(ResolveError::Parameter(error)) = resolution else { panic!("{resolution:?}") };
        assert_eq!((error.name, error.value), ("smoothing", smoothing));
    }
}

/// Resolves two balls of which the muscle has a stiffness.
fn resolved_with_stiffness(factor: f64) -> Result<Resolution, ResolveError> {
    let mut scene = two_soft_balls();
    let body = scene.find("muscle").expect("a body");
    let stiffnesses = vec![BodyStiffness { body, factor }];
    let conditions = Conditions { stiffnesses, ..Conditions::default() };
    let resolver = Resolver::new(crate::PARAMS).expect("parameters");
    resolver.with_conditions(conditions).resolve(&mut scene, Progress::none())
}

#[test]
fn a_stiffness_out_of_range_is_refused() {
    for given in [1e140, 1e300, 1e-160, 1e-300, 1.1e9, 0.9e-9, 0.0, -1.0, f64::INFINITY] {
        let resolution = resolved_with_stiffness(given);
        let expected = ResolveError::Stiffness { name: "muscle".to_owned(), factor: given };
        assert_eq!(resolution, Err(expected), "{given:e}");
    }
    assert!(matches!(resolved_with_stiffness(f64::NAN), Err(ResolveError::Stiffness { .. })));
    let error = resolved_with_stiffness(1e140).expect_err("a refusal");
    let expected = "the stiffness of 'muscle' is 1e140, but must be from 1e-9 to 1e9";
    assert_eq!(error.to_string(), expected);
}

/// At the ends of the range one of both bodies takes all of the overlap.
#[test]
fn the_ends_of_the_range_of_stiffness_resolve() {
    let factors = BodyStiffness::FACTORS;
    for (factor, yielding) in [(*factors.start(), 1), (*factors.end(), 0)] {
        let resolution = resolved_with_stiffness(factor).expect("a resolution");
        assert!(resolution.resolved, "{factor:e}: {resolution:?}");
        let displacement = |body: usize| resolution.bodies[body].max_displacement;
        let (moved, kept) = (displacement(yielding), displacement(1 - yielding));
        assert!(moved > 1.0 && kept < 1e-3, "{factor:e}: {moved} {kept}");
    }
}

/// Single precision has steps of 1/16 at a million: more than the gap.
#[test]
fn a_gap_holds_in_a_file_that_rounds_more_than_that() {
    let mut scene = two_balls(DVec3::splat(1e6));
    let gap = 0.02;
    let params = ResolveParams { gap, precision: WrittenPrecision::Single, ..crate::PARAMS };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none());
    let resolution = resolution.expect("a resolution");
    let [bone, muscle] = ["bone", "muscle"].map(|name| scene.find(name).expect("a body"));
    let written = |x: &DVec3| x.as_vec3().as_dvec3();
    assert!(scene.body(muscle).positions().iter().all(|x| written(x) == *x), "as in the file");
    assert_eq!(resolution.bodies[1].flipped_faces, 0, "{:?}", resolution.broken_limits);

    let rounded: Vec<DVec3> = scene.body(bone).positions().iter().map(written).collect();
    scene.move_body(bone, &rounded).expect("finite positions");
    let distance = brute_distance(&scene, bone, muscle);
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.remaining);
    assert!(distance >= gap && distance < 0.5, "{distance}");
}

/// The center of a polygon is no vertex of its own: a gap of the triangles would not hold of the polygons.
#[test]
fn soft_polygons_are_refused_by_name() {
    let ball = shapes::icosphere(10.0, 2);
    let simplex = SimplexSurface::dual_of(&ball.surface()).expect("closed");
    let centroids = (0..ball.faces.len()).map(|face| ball.centroid(face));
    let x: Vec<DVec3> = centroids.map(|x| x + DVec3::X * 18.6).collect();
    for (kind, other) in
        [(BodyKind::Deformable, BodyKind::Rigid), (BodyKind::Rigid, BodyKind::Deformable)]
    {
        let mut scene = Scene::new();
        scene.add_simplex("polygons", kind, simplex.clone(), &x).expect("polygons");
        scene.add("ball", other, ball.surface(), ball.positions.clone()).expect("a ball");
        let before = scene.body(scene.find("polygons").expect("a body")).positions().to_vec();
        let resolution = resolve::resolve(&mut scene, &crate::PARAMS, Progress::none());
        if kind == BodyKind::Rigid {
            assert!(resolution.expect("a resolution").resolved);
        } else {
            let refused = ResolveError::Polygons { name: "polygons".into() };
            assert_eq!(resolution.err(), Some(refused));
        }
        assert_eq!(scene.body(scene.find("polygons").expect("a body")).positions(), before);
    }
}
