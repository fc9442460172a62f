//! Contacts of a scene's bodies by medial surfaces, beside the exact check and brute force.

use distance_field::{DistanceField, FieldMethod, FieldParams, NodeValues};
use fixtures::random::Random;
use fixtures::{Mesh, shapes};
use glam::{DQuat, DVec3};
use medial::{Ball, MedialError, MedialParams, MedialSurface};
use scene::{
    BodyId, BodyKind, CheckParams, FieldDetector, MedialContact, MedialDetector, MedialFeature,
    Progress, Scene, SceneError,
};
use surface::{Pose, RigidState};

fn muscle() -> Mesh {
    shapes::ellipsoid(DVec3::new(40.0, 16.0, 8.0), 4)
}

fn add(scene: &mut Scene, name: &str, kind: BodyKind, mesh: &Mesh) -> BodyId {
    scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body")
}

fn detector(scene: &Scene, id: BodyId, balls: usize, margin: f64) -> MedialDetector {
    let (body, params) = (scene.body(id), MedialParams::balls(balls));
    let (surface, x) = (body.surface(), body.checked_positions());
    MedialDetector::new(surface, x, margin, &params, Progress::none()).expect("a closed body")
}

/// Two bodies that overlap, and a third elsewhere, so that particles are numbered from there.
fn overlapping(shift: DVec3) -> (Scene, BodyId, BodyId) {
    let mut scene = Scene::new();
    let kind = BodyKind::Deformable;
    add(&mut scene, "elsewhere", kind, &shapes::cube(1.0).translated(DVec3::splat(500.0)));
    let a = add(&mut scene, "a", kind, &muscle().translated(shift));
    let b = add(&mut scene, "b", kind, &muscle().rotated(DVec3::Z, 0.2));
    (scene, a, b)
}

/// Asserts the identity of each contact at the scene's particles.
fn assert_consistent(contacts: &[MedialContact], scene: &Scene) {
    let x = scene.particle_positions();
    for MedialContact { contact, .. } in contacts {
        let error = contact.identity_error(|particle| x[particle as usize]);
        assert!(error < 1e-11, "identity {error}: {contact:?}");
    }
}

/// Beside exact detection, gaps outside and near the border are off by no more than the two bounds,
/// and with a margin of the bound no vertex inside is lost.
#[test]
fn gaps_agree_with_the_exact_check() {
    let (mut scene, a, b) = overlapping(DVec3::new(3.0, 2.0, 13.0));
    let generated = detector(&scene, b, 60, 0.0);
    let bound = generated.deviation().surface_to_medial.upper;
    let largest = generated.deviation().largest();
    assert!(largest < 0.8, "{largest}");
    let (surface, x) = (scene.body(b).surface(), scene.body(b).checked_positions());
    let balls = generated.medial().clone();
    let mut medial = MedialDetector::from_medial(surface, x, bound, balls).unwrap();
    let contacts = scene.medial_contacts(a, b, &mut medial).unwrap();
    assert_consistent(&contacts, &scene);

    let reports = scene.check(&CheckParams::without_measures(1.0), Progress::none()).unwrap();
    let [pair] = &reports[..] else { panic!("one pair") };
    let (mut worst, mut turned, mut inside) = (0.0_f64, 0.0_f64, 0);
    for near in &pair.a_against_b.near {
        let feature = MedialFeature::Vertex(near.vertex);
        let found = contacts.iter().find(|contact| contact.feature == feature);
        assert!(found.is_some() || near.gap > 0.0, "vertex {} at {}", near.vertex, near.gap);
        if let Some(MedialContact { contact, .. }) = found {
            inside += usize::from(near.gap < 0.0);
            worst = worst.max((contact.gap - near.gap).abs());
            turned = turned.max(contact.normal.angle_between(near.normal).to_degrees());
        }
    }
    assert!(inside > 20, "{inside}");
    assert!(worst <= largest, "{worst} beyond {largest}");
    assert!(turned < 30.0, "{turned}");
}

/// Balls of both bodies follow them, and meet where a translation of both leaves them.
#[test]
fn balls_follow_both_bodies() {
    let (mut scene, a, b) = overlapping(DVec3::new(3.0, 2.0, 14.0));
    let (mut of_a, mut of_b) = (detector(&scene, a, 20, 0.5), detector(&scene, b, 30, 0.5));
    let before = scene.medial_pair_contacts([a, b], [&mut of_a, &mut of_b]).unwrap();
    assert_consistent(&before, &scene);
    let shift = DVec3::new(100.0, -40.0, 7.0);
    for id in [a, b] {
        let moved: Vec<DVec3> = scene.body(id).positions().iter().map(|p| *p + shift).collect();
        scene.move_body(id, &moved).unwrap();
    }
    let after = scene.medial_pair_contacts([a, b], [&mut of_a, &mut of_b]).unwrap();
    assert_consistent(&after, &scene);
    let depth = |contacts: &[MedialContact]| {
        contacts.iter().map(|found| -found.contact.gap).fold(0.0, f64::max)
    };
    assert!(depth(&before) > 1.0, "{before:?}");
    assert!((depth(&before) - depth(&after)).abs() < 0.1, "{before:?} {after:?}");
}

fn ball_field(radius: f64, padding: f64, truncation: Option<f64>) -> DistanceField {
    let mesh = shapes::icosphere(radius, 4);
    let surface = mesh.surface();
    // Exact as far out as the balls' centers are.
    let node_values = NodeValues::QuasiInterpolating;
    let method = FieldMethod::ExactBand { band: 20.0, node_values };
    let params = FieldParams { padding, method, truncation, ..FieldParams::new(0.5) };
    let x = surface.positions(&mesh.positions).expect("finite");
    DistanceField::build(&surface, x, &params, Progress::none()).expect("a field")
}

/// The smallest gap of the contacts with a round bone, beside all balls and dense samples between them.
#[test]
fn bones_meet_what_dense_samples_meet() {
    let (bone, margin) = (6.0, 0.3);
    let field = FieldDetector::new(ball_field(bone, 9.0, None), margin).unwrap();
    let mut scene = Scene::new();
    add(&mut scene, "elsewhere", BodyKind::Rigid, &shapes::cube(1.0).translated(DVec3::X * 900.0));
    let id = add(&mut scene, "muscle", BodyKind::Deformable, &muscle());
    let mut medial = detector(&scene, id, 24, 0.0);
    // Of the field's values, and of the round bone's faces.
    let tolerance = 0.05 + field.field().grid().spacing() / 20.0;
    let mut random = Random(3);
    let mut met = 0;
    for _ in 0..40 {
        let direction = DVec3::from_array([0; 3].map(|_| 2.0 * random.unit() - 1.0));
        let at = direction * DVec3::new(40.0, 20.0, 16.0);
        let turn = DQuat::from_axis_angle(DVec3::Y, random.unit());
        let state = RigidState::at_rest(Pose::new(turn, at));
        let contacts = scene.medial_field_contacts(id, &mut medial, &field, &state).unwrap();
        assert_consistent(&contacts, &scene);
        // In the middle of the bone its field has a tip.
        let balls = medial.medial().balls();
        if balls.iter().any(|ball| ball.center.distance(at) < 2.0) {
            continue;
        }
        let lowest = lowest_gap(medial.medial(), at, bone, margin + tolerance);
        if lowest > margin + tolerance {
            assert!(contacts.is_empty(), "{lowest} {contacts:?}");
        } else if lowest < margin - tolerance {
            // The surface may extend beyond the balls.
            let gap = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
            assert!(gap <= lowest + tolerance, "{lowest} {contacts:?}");
            met += 1;
        }
    }
    assert!(met > 10, "{met}");
}

/// The smallest gap of the balls, and of those between balls with gaps above `limit`.
fn lowest_gap(medial: &MedialSurface, at: DVec3, bone: f64, limit: f64) -> f64 {
    let gap = |ball: &Ball| ball.distance(at) - bone;
    let mut lowest = medial.balls().iter().map(gap).fold(f64::INFINITY, f64::min);
    for (primitive, _) in (0_u32..).zip(medial.primitives()) {
        let balls = medial.primitive_balls(primitive);
        if balls.iter().any(|ball| gap(ball) <= limit) {
            continue;
        }
        for i in 0..=20_u8 {
            for j in 0..=20 - i {
                let [b, c] = [i, j].map(|k| f64::from(k) / 20.0);
                lowest = lowest.min(gap(&Ball::interpolate(&balls, [1.0 - b - c, b, c])));
            }
        }
    }
    lowest
}

/// Where the field does not hold the distance of a ball, that is reported, not estimated.
#[test]
fn a_field_that_ends_too_early_is_refused() {
    let mut scene = Scene::new();
    let id = add(&mut scene, "muscle", BodyKind::Deformable, &muscle());
    let mut medial = detector(&scene, id, 24, 0.0);
    for (padding, truncation) in [(2.0, None), (9.0, Some(4.0))] {
        let field = FieldDetector::new(ball_field(6.0, padding, truncation), 0.0).unwrap();
        let at = |z: f64| RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::new(0.0, 0.0, z)));
        let near = scene.medial_field_contacts(id, &mut medial, &field, &at(13.5)).unwrap_err();
        let SceneError::Medial { name, source } = &near else { panic!("{near}") };
        assert!(name == "muscle" && matches!(source, MedialError::DistanceRange { .. }), "{near}");
        let far = scene.medial_field_contacts(id, &mut medial, &field, &at(40.0));
        assert_eq!(far, Ok(Vec::new()));
    }
}

#[test]
fn errors_name_the_body() {
    let (mut scene, a, b) = overlapping(DVec3::Z);
    let mut of_b = detector(&scene, b, 20, 0.0);
    let itself = SceneError::Itself { name: "b".to_owned() };
    assert_eq!(scene.medial_contacts(b, b, &mut of_b), Err(itself));

    let mut other = Scene::new();
    let none = other.medial_contacts(a, b, &mut of_b).unwrap_err();
    assert_eq!(none, SceneError::NoSuchBody { index: 1, count: 0 });
    for name in ["x", "y", "z"] {
        add(&mut other, name, BodyKind::Deformable, &shapes::cube(1.0));
    }
    let error = other.medial_contacts(a, b, &mut of_b).unwrap_err();
    let SceneError::Medial { name, source } = &error else { panic!("{error}") };
    assert!(name == "z" && matches!(source, MedialError::Surface(_)), "{error}");
}
