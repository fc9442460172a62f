//! Contacts by medial surfaces against brute force over all primitives, exact
//! detection, and planted answers.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use distance_field::{DistanceField, FieldMethod, FieldParams, NodeValues, Pose};
use fixtures::{Mesh, shapes};
use glam::{DQuat, DVec3};
use medial::{Ball, MedialError, MedialParams, MedialSurface, pair_foot, slab_foot};
use scene::Progress;
use scene::{
    BodyId, BodyKind, CheckParams, FieldDetector, MedialContact, MedialDetector, MedialFeature,
    NoInside, Scene, SceneError,
};
use surface::RigidState;
use surface::SurfaceError;

fn number(u: &mut Unstructured<'_>, from: f64, to: f64) -> Result<f64> {
    Ok(from + (to - from) * f64::from(u.int_in_range(0_u16..=u16::MAX)?) / 65535.0)
}

fn vector(u: &mut Unstructured<'_>, size: f64) -> Result<DVec3> {
    Ok(DVec3::new(number(u, -size, size)?, number(u, -size, size)?, number(u, -size, size)?))
}

fn muscle() -> Mesh {
    shapes::ellipsoid(DVec3::new(40.0, 16.0, 8.0), 4)
}

fn add(scene: &mut Scene, name: &str, kind: BodyKind, mesh: &Mesh) -> BodyId {
    scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body")
}

fn detector(scene: &Scene, body: BodyId, balls: usize, margin: f64) -> MedialDetector {
    MedialDetector::new(scene, body, margin, &MedialParams::balls(balls), |_| {})
        .expect("a closed body")
}

/// Two bodies that overlap, and a third elsewhere, so that particles are numbered
/// on.
fn overlapping(shift: DVec3) -> (Scene, BodyId, BodyId) {
    let mut scene = Scene::new();
    let kind = BodyKind::Deformable;
    add(&mut scene, "elsewhere", kind, &shapes::cube(1.0).translated(DVec3::splat(500.0)));
    let a = add(&mut scene, "a", kind, &muscle().translated(shift));
    let b = add(&mut scene, "b", kind, &muscle().rotated(DVec3::Z, 0.2));
    (scene, a, b)
}

/// Every identity that a producer of contacts promises.
fn assert_sound(contacts: &[MedialContact], scene: &Scene) {
    let x = scene.particle_positions();
    for MedialContact { contact, ball, .. } in contacts {
        let error = contact.identity_error(|particle| x[particle as usize]);
        assert!(error < 1e-11, "identity {error}: {contact:?}");
        assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        assert!(contact.offset >= 0.0, "{contact:?}");
        let sum: f64 = contact.stencil.terms().iter().map(|term| term.weight).sum();
        let expected = if contact.anchor.is_some() { sum.signum() } else { 0.0 };
        assert!((sum - expected).abs() < 1e-14, "{contact:?}");
        assert!((ball.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{ball:?}");
    }
}

/// The least distance of a point over all primitives.
fn brute(medial: &MedialSurface, p: DVec3) -> f64 {
    let all = medial.primitives().iter().map(|balls| balls.map(|b| medial.balls()[b as usize]));
    all.map(|balls| slab_foot(p, &balls).distance).fold(f64::INFINITY, f64::min)
}

/// No vertex is missed, none is invented, and every gap is that of the balls, or
/// what the surface reaches beyond them.
#[test]
fn vertices_meet_what_brute_force_meets() {
    let (mut scene, a, b) = overlapping(DVec3::ZERO);
    let mut medial = detector(&scene, b, 40, 0.6);
    let narrower = medial.deviation().surface_to_medial.upper;
    let mut met = 0;
    arbtest(|u| {
        let turned = muscle().rotated(DVec3::new(1.0, 0.3, 0.0), number(u, 0.0, 0.5)?);
        let moved = turned.translated(vector(u, 15.0)?);
        scene.move_body(a, &moved.positions).expect("finite");
        let contacts = scene.medial_contacts(a, &mut medial).expect("an answer");
        assert_sound(&contacts, &scene);
        let mut contacts = contacts.iter().peekable();
        for (vertex, &p) in (0_u32..).zip(&moved.positions) {
            let distance = brute(medial.medial(), p);
            let feature = MedialFeature::Vertex(vertex);
            match contacts.next_if(|contact| contact.feature == feature) {
                Some(MedialContact { contact, .. }) => {
                    assert!(distance <= 0.6 + 1e-9, "vertex {vertex} at {distance} is invented");
                    let beyond = distance - contact.gap;
                    assert!((-1e-9..=narrower).contains(&beyond), "{distance} {contact:?}");
                    // The surface is held where the balls are, not across the muscle.
                    let wider = medial.deviation().largest();
                    assert!(contact.offset <= wider || distance < -2.0, "{contact:?}");
                    met += 1;
                }
                None => assert!(distance > 0.6 - 1e-9, "vertex {vertex} at {distance} is lost"),
            }
        }
        assert!(contacts.next().is_none(), "in the order of the vertices");
        Ok(())
    })
    .budget_ms(1000);
    assert!(met > 100, "{met}");
}

/// Beside exact detection, gaps outside and near the border are off by no more
/// than the two bounds, and with a margin of the bound no vertex inside is missed.
#[test]
fn gaps_agree_with_the_exact_check() {
    let (mut scene, a, b) = overlapping(DVec3::new(3.0, 2.0, 13.0));
    let mut medial = detector(&scene, b, 60, 0.0);
    let bound = medial.deviation().surface_to_medial.upper;
    let largest = medial.deviation().largest();
    assert!(largest < 0.8, "{largest}");
    medial = MedialDetector::from_surface(&scene, b, bound, medial.medial().clone()).unwrap();
    let contacts = scene.medial_contacts(a, &mut medial).unwrap();
    let reports = scene.check(&CheckParams { margin: 1.0 }, Progress::none()).unwrap();
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

/// Pairs of primitives beside all of them: the deepest overlap is found exactly,
/// and each contact is one of the pairs, at a vertex near it.
#[test]
fn balls_meet_what_brute_force_meets() {
    let (mut scene, a, b) = overlapping(DVec3::new(0.0, 0.0, 20.0));
    let mut of_a = detector(&scene, a, 24, 0.5);
    let mut of_b = detector(&scene, b, 30, 0.0);
    let (mut met, mut free) = (0, 0);
    arbtest(|u| {
        let moved = muscle().translated(vector(u, 26.0)?);
        scene.move_body(a, &moved.positions).expect("finite");
        let contacts = scene.medial_pair_contacts(&mut of_a, &mut of_b).expect("an answer");
        assert_sound(&contacts, &scene);
        let (ma, mb) = (of_a.medial(), of_b.medial());
        let balls = |medial: &MedialSurface, k: usize| {
            medial.primitives()[k].map(|ball| medial.balls()[ball as usize])
        };
        let all = (0..ma.primitives().len()).flat_map(|i| {
            (0..mb.primitives().len()).map(move |j| pair_foot(&balls(ma, i), &balls(mb, j)))
        });
        let least = all.map(|foot| foot.distance).fold(f64::INFINITY, f64::min);
        let found = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
        if least > 0.5 {
            assert!(contacts.is_empty(), "{least} {contacts:?}");
            free += 1;
            return Ok(());
        }
        let narrower = of_a.deviation().largest() + of_b.deviation().largest();
        assert!(least - found > -1e-9, "{least} {found}");
        // Deep in each other, the surfaces under the vertices reach farther.
        assert!(least - found < narrower || least < -3.0, "{least} {found}");
        let mut last = None;
        for MedialContact { contact, ball, feature } in &contacts {
            let MedialFeature::Ball(other) = feature else { panic!("{feature:?}") };
            let at = |medial: &MedialSurface, on: &scene::PrimitiveBall| {
                Ball::interpolate(&balls(medial, on.primitive as usize), on.weights)
            };
            let distance = at(mb, ball).distance(at(ma, other).center) - at(ma, other).radius;
            assert!(contact.gap <= distance + 1e-9 && distance <= 0.5 + 1e-9, "{contact:?}");
            let vertex = contact.stencil.terms()[0].particle;
            assert!(last < Some(vertex), "ascending, each vertex once");
            last = Some(vertex);
        }
        met += 1;
        Ok(())
    })
    .budget_ms(1000);
    assert!(met > 5 && free > 5, "{met} met, {free} free");
}

/// Two long capsules that cross each other at right angles between their vertices.
#[test]
fn what_vertices_miss_balls_meet() {
    let capsule = |along: DVec3| -> MedialSurface {
        let ends = [-30.0, 30.0].map(|x| Ball::new(x * along, 5.0));
        MedialSurface::new(ends.to_vec(), vec![[0, 1]], vec![]).unwrap()
    };
    let mut scene = Scene::new();
    let mesh = shapes::capsule(5.0, 60.0, 24);
    let bounds = mesh.bounds();
    let (low, high) = (bounds.min, bounds.max);
    let axis = ((high - low) / (high - low).max_element()).round();
    let mesh = mesh.translated(-low.midpoint(high));
    let across = if axis == DVec3::X { DVec3::Y } else { DVec3::X };
    let kind = BodyKind::Deformable;
    let turned = mesh.clone().mapped(|p| DQuat::from_rotation_arc(axis, across).mul_vec3(p));
    let a = add(&mut scene, "a", kind, &mesh);
    let b = add(&mut scene, "b", kind, &turned);
    let mut of_a = MedialDetector::from_surface(&scene, a, 0.0, capsule(axis)).unwrap();
    let mut of_b = MedialDetector::from_surface(&scene, b, 0.0, capsule(across)).unwrap();
    let up = axis.cross(across);
    for depth in [0.5, 2.0, 4.0] {
        let lifted: Vec<DVec3> = mesh.positions.iter().map(|p| *p + (10.0 - depth) * up).collect();
        scene.move_body(a, &lifted).unwrap();
        let contacts = scene.medial_pair_contacts(&mut of_a, &mut of_b).unwrap();
        assert_sound(&contacts, &scene);
        let [found] = &contacts[..] else { panic!("one pair of primitives: {contacts:?}") };
        assert!((found.contact.gap + depth).abs() < 1e-3, "{depth} {found:?}");
        assert!(found.contact.normal.dot(up) > 1.0 - 1e-6, "{found:?}");
    }
}

fn ball_field(radius: f64, padding: f64, truncation: Option<f64>) -> DistanceField {
    let mesh = shapes::icosphere(radius, 4);
    let surface = mesh.surface();
    // Exact as far out as the balls' centers are.
    let node_values = NodeValues::QuasiInterpolating;
    let method = FieldMethod::ExactBand { band: 20.0, relax: false, node_values };
    let params = FieldParams { padding, method, truncation, ..FieldParams::new(0.5) };
    let x = surface.positions(&mesh.positions).expect("finite");
    DistanceField::build(&surface, x, &params, Progress::none()).expect("a field")
}

/// Balls and slabs over a round bone, of which the distance is known, beside dense
/// sampling of every primitive.
#[test]
fn bones_meet_what_brute_force_meets() {
    let (bone, margin) = (6.0, 0.3);
    let field = ball_field(bone, 9.0, None);
    let mut scene = Scene::new();
    add(&mut scene, "elsewhere", BodyKind::Rigid, &shapes::cube(1.0).translated(DVec3::X * 900.0));
    let id = add(&mut scene, "muscle", BodyKind::Deformable, &muscle());
    let mut medial = detector(&scene, id, 24, 0.0);
    let touch = FieldDetector::new(field.clone(), margin).unwrap();
    // Of the field's values, and of the round bone's faces.
    let tolerance = 0.05 + touch.field().grid().spacing() / 20.0;
    let (mut balls, mut between) = (0, 0);
    arbtest(|u| {
        let at = vector(u, 1.0)? * DVec3::new(40.0, 20.0, 16.0);
        let turn = DQuat::from_axis_angle(DVec3::Y, number(u, -1.0, 1.0)?);
        let state = RigidState::at_rest(Pose::new(turn, at));
        let contacts = scene.medial_field_contacts(&mut medial, &touch, &state).expect("told");
        assert_sound(&contacts, &scene);
        let medial = medial.medial();
        let gap = |ball: Ball| ball.center.distance(at) - bone - ball.radius;
        for (number, &ball) in (0_u32..).zip(medial.balls()) {
            let found = contacts.iter().find(|found| {
                let k = found.ball.weights.iter().position(|&w| w >= 1.0);
                k.is_some_and(|k| medial.primitives()[found.ball.primitive as usize][k] == number)
            });
            match found {
                Some(found) => {
                    let error = (found.contact.gap - gap(ball)).max(0.0);
                    // In the midst of the bone, where its field has a tip.
                    let is_tip = ball.center.distance(at) < 2.0;
                    assert!(error <= tolerance || is_tip, "{error} {ball:?} {found:?}");
                    let away = (ball.center - at).normalize();
                    assert!(is_tip || found.contact.normal.dot(away) > 0.99, "{away} {found:?}");
                    balls += 1;
                }
                None => assert!(gap(ball) > margin - tolerance, "ball {number} {}", gap(ball)),
            }
        }
        for (number, corners) in (0_u32..).zip(medial.primitives()) {
            let corners = corners.map(|ball| medial.balls()[ball as usize]);
            let is_out = corners.iter().all(|&ball| gap(ball) > margin + tolerance);
            let lowest = weights().map(|w| gap(Ball::interpolate(&corners, w)));
            let lowest = lowest.fold(f64::INFINITY, f64::min);
            let found = contacts.iter().find(|found| found.ball.primitive == number);
            if is_out && lowest < margin - tolerance {
                let found = found.unwrap_or_else(|| panic!("primitive {number} at {lowest}"));
                assert!(found.contact.gap <= lowest + tolerance, "{lowest} {found:?}");
                between += 1;
            }
        }
        Ok(())
    })
    .budget_ms(1500);
    assert!(balls > 5 && between > 5, "{balls} balls, {between} between");
}

/// Weights of a grid over a triangle.
fn weights() -> impl Iterator<Item = [f64; 3]> {
    (0..=40_u8)
        .flat_map(|i| (0..=40 - i).map(move |j| (f64::from(i) / 40.0, f64::from(j) / 40.0)))
        .map(|(a, b)| [1.0 - a - b, a, b])
}

/// Where the field does not tell how far a ball is, that is said, not guessed.
#[test]
fn a_field_that_ends_too_early_is_refused() {
    let mut scene = Scene::new();
    let id = add(&mut scene, "muscle", BodyKind::Deformable, &muscle());
    let mut medial = detector(&scene, id, 24, 0.0);
    for (padding, truncate) in [(2.0, None), (9.0, Some(4.0))] {
        let field = ball_field(6.0, padding, truncate);
        let touch = FieldDetector::new(field.clone(), 0.0).unwrap();
        let state = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::new(0.0, 0.0, 13.5)));
        let error = scene.medial_field_contacts(&mut medial, &touch, &state).unwrap_err();
        let SceneError::FieldRange { name, known, needed } = &error else { panic!("{error}") };
        assert!(name == "muscle" && known < needed, "{error}");
        let far = RigidState::at_rest(Pose::new(DQuat::IDENTITY, DVec3::new(0.0, 0.0, 40.0)));
        assert_eq!(scene.medial_field_contacts(&mut medial, &touch, &far), Ok(Vec::new()));
    }
}

/// A detector that follows has the balls of one whose balls were moved by hand, and
/// meets what brute force meets over those; from a translation it gets no worse.
#[test]
fn balls_follow_the_body() {
    let (mut scene, a, b) = overlapping(DVec3::new(3.0, 2.0, 14.0));
    let mut medial = detector(&scene, b, 40, 0.5);
    let at_rest = medial.measure(&scene).unwrap().rms;
    let shift = DVec3::new(100.0, -40.0, 7.0);
    for id in [a, b] {
        let moved: Vec<DVec3> = scene.body(id).positions().iter().map(|p| *p + shift).collect();
        scene.move_body(id, &moved).unwrap();
    }
    let mut by_hand = medial.medial().clone();
    let surface = scene.body(b).surface().clone();
    let moved = surface.positions(scene.body(b).positions()).unwrap();
    medial.links().follow(&mut by_hand, moved).unwrap();
    let found = scene.medial_contacts(a, &mut medial).unwrap();
    assert_eq!(medial.medial(), &by_hand);
    let vertices = (0_u32..).zip(scene.body(a).positions());
    let within = vertices.filter(|(_, p)| brute(&by_hand, **p) <= 0.5);
    let expected: Vec<_> = within.map(|(vertex, _)| MedialFeature::Vertex(vertex)).collect();
    assert_eq!(found.iter().map(|found| found.feature).collect::<Vec<_>>(), expected);
    assert!(expected.len() > 10, "{}", expected.len());
    let rms = medial.measure(&scene).unwrap().rms;
    assert!(rms <= 1.05 * at_rest, "{rms} after {at_rest}");

    let short: Vec<DVec3> = scene
        .body(b)
        .positions()
        .iter()
        .map(|p| shift + (*p - shift) * DVec3::new(0.8, 1.118, 1.118))
        .collect();
    medial.links().follow(&mut by_hand, surface.positions(&short).unwrap()).unwrap();
    scene.move_body(b, &short).unwrap();
    medial.follow(&scene).unwrap();
    assert_eq!(medial.medial(), &by_hand);
    let rms = medial.measure(&scene).unwrap().rms;
    assert!(rms < 0.5, "{rms}");
    medial.follow(&scene).unwrap();
    assert_eq!(medial.medial(), &by_hand, "a body at rest is not refitted again");
}

/// A bone is the anchor of its contacts, on whichever side it is.
#[test]
fn rigid_bodies_are_anchors() {
    let mut scene = Scene::new();
    let bone = shapes::icosphere(6.0, 2).translated(DVec3::new(0.0, 0.0, 13.0));
    let bone = add(&mut scene, "bone", BodyKind::Rigid, &bone);
    let id = add(&mut scene, "muscle", BodyKind::Deformable, &muscle());
    let mut of_muscle = detector(&scene, id, 24, 0.0);
    let mut of_bone = detector(&scene, bone, 6, 0.0);
    let on_muscle = scene.medial_contacts(bone, &mut of_muscle).unwrap();
    let on_bone = scene.medial_contacts(id, &mut of_bone).unwrap();
    assert_sound(&on_muscle, &scene);
    assert_sound(&on_bone, &scene);
    assert!(!on_muscle.is_empty() && !on_bone.is_empty(), "they overlap");
    let muscle = scene.body(id).particles();
    for found in on_muscle.iter().chain(&on_bone) {
        assert!(found.contact.anchor.is_some(), "{found:?}");
        // The normal is that of the bone, which is above.
        assert!(found.contact.normal.z < 0.0, "{found:?}");
        let terms = found.contact.stencil.terms();
        assert!(terms.iter().all(|term| muscle.contains(&term.particle)), "{found:?}");
    }
}

/// In the edge of a groove a vertex has a contact with each side, if asked for.
#[test]
fn grooves_have_two_sides() {
    let roof = |x: f64| {
        let ends = [-20.0, 20.0].map(|y| Ball::new(DVec3::new(x, y, 0.0), 6.0));
        (ends, x)
    };
    let balls: Vec<Ball> = [-5.0, 5.0].into_iter().flat_map(|x| roof(x).0).collect();
    let medial = MedialSurface::new(balls, vec![[0, 1], [2, 3]], vec![]).unwrap();
    let mut scene = Scene::new();
    let kind = BodyKind::Deformable;
    let body = shapes::ellipsoid(DVec3::new(11.0, 26.0, 6.0), 4);
    let body = add(&mut scene, "body", kind, &body);
    let pin = shapes::tetrahedron(2.0);
    let top =
        pin.positions.iter().copied().fold(DVec3::INFINITY, |a, b| if b.z < a.z { b } else { a });
    let pin = pin.translated(DVec3::new(0.0, 0.0, 2.9) - top);
    let pin = add(&mut scene, "pin", kind, &pin);
    let one = MedialDetector::from_surface(&scene, body, 0.0, medial).unwrap();
    let mut two = one.with_max_contacts(2);
    let mut contacts = scene.medial_contacts(pin, &mut two).unwrap();
    let tip = |p: &DVec3| p.distance(DVec3::new(0.0, 0.0, 2.9)) < 1e-9;
    let lowest = scene.body(pin).positions().iter().position(tip).unwrap();
    let lowest = MedialFeature::Vertex(u32::try_from(lowest).unwrap());
    contacts.retain(|contact| contact.feature == lowest);
    let [left, right] = &contacts[..] else { panic!("{contacts:?}") };
    assert!(left.contact.normal.x * right.contact.normal.x < 0.0, "{contacts:?}");
    let mut one = two.with_max_contacts(1);
    let contacts = scene.medial_contacts(pin, &mut one).unwrap();
    assert_eq!(contacts.iter().filter(|contact| contact.feature == lowest).count(), 1);
}

#[test]
fn what_is_wrong_is_named() {
    let (mut scene, a, b) = overlapping(DVec3::Z);
    let params = MedialParams::balls(20);
    let new = |scene: &Scene, body, margin, params: &MedialParams| {
        MedialDetector::new(scene, body, margin, params, |_| {})
    };
    assert_eq!(new(&scene, a, -1.0, &params).unwrap_err(), SceneError::Margin { margin: -1.0 });
    assert!(new(&scene, a, f64::NAN, &params).is_err());
    let none = new(&Scene::new(), a, 0.0, &params).unwrap_err();
    assert_eq!(none, SceneError::NoSuchBody { index: 1, count: 0 });
    let many = new(&scene, a, 0.0, &MedialParams::balls(100_000)).unwrap_err();
    let SceneError::Medial { name, source } = &many else { panic!("{many}") };
    assert!(name == "a" && matches!(source, MedialError::TooManyBalls { .. }), "{many}");

    let open = add(&mut scene, "open", BodyKind::Open, &muscle());
    let source = NoInside::DeclaredOpen;
    let name = "open".to_owned();
    assert_eq!(new(&scene, open, 0.0, &params).unwrap_err(), SceneError::NoInside { name, source });
    let mut torn = muscle();
    torn.faces.truncate(torn.faces.len() - 1);
    let torn = add(&mut scene, "torn", BodyKind::Deformable, &torn);
    let error = new(&scene, torn, 0.0, &params).unwrap_err();
    let SceneError::Medial { source: MedialError::Surface(source), .. } = &error else {
        panic!("{error}")
    };
    assert!(matches!(source, SurfaceError::Open { .. }), "{error}");

    let mut of_b = detector(&scene, b, 20, 0.0);
    let itself = SceneError::Itself { name: "b".to_owned() };
    assert_eq!(scene.medial_contacts(b, &mut of_b), Err(itself));
    let mut other = Scene::new();
    for name in ["x", "y", "z"] {
        add(&mut other, name, BodyKind::Deformable, &shapes::cube(1.0));
    }
    let error = other.medial_contacts(a, &mut of_b).unwrap_err();
    assert!(matches!(error, SceneError::Medial { .. }), "{error}");
}

#[test]
fn no_thread_count_changes_a_bit() {
    let answer = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let (mut scene, a, b) = overlapping(DVec3::new(3.0, 2.0, 14.0));
            let c =
                add(&mut scene, "c", BodyKind::Deformable, &muscle().translated(DVec3::Y * 20.0));
            let mut of_b = detector(&scene, b, 30, 0.5);
            let mut of_c = detector(&scene, c, 20, 0.5);
            let mut found = scene.medial_contacts_of(&[a, c, a], &mut of_b).expect("an answer");
            found.push(scene.medial_pair_contacts(&mut of_b, &mut of_c).expect("an answer"));
            (of_b.medial().clone(), of_b.links().clone(), found)
        })
    };
    let one = answer(1);
    assert!(one.2.iter().all(|contacts| contacts.len() > 3), "{:?}", one.2);
    assert_eq!(one.2[0], one.2[2]);
    assert_eq!(one, answer(2));
    assert_eq!(one, answer(7));
}
