//! Contacts of bodies by their medial surfaces, beside brute force over all primitives and planted
//! answers.

use fixtures::random::Random;
use fixtures::shapes;
use glam::{DMat3, DVec3};
use kdop::Workspace;
use medial::{
    Ball, MedialContact, MedialDetector, MedialError, MedialFeature, MedialParams, MedialScratch,
    MedialSurface, PrimitiveBall, pair_foot,
};
use surface::progress::Progress;
use surface::{Pseudonormals, SurfaceError};

use crate::support::{
    Detected, assert_consistent, brute_force_distance, number, small_muscle, vector,
};

/// Contacts of the vertices of `a` with the balls of `b`.
fn vertex_contacts(a: &Detected, b: &Detected) -> Vec<MedialContact> {
    b.detector.vertex_contacts(&a.body(), &b.body(), &mut MedialScratch::default())
}

fn pair_contacts(a: &Detected, b: &Detected) -> Vec<MedialContact> {
    a.detector.pair_contacts(&a.body(), &b.detector, &b.body(), &mut MedialScratch::default())
}

/// Two muscles that overlap, with numbers of particles that follow others.
fn overlapping(balls: [usize; 2], margins: [f64; 2]) -> [Detected; 2] {
    let lifted = small_muscle().translated(DVec3::new(3.0, 2.0, 14.0));
    let turned = small_muscle().rotated(DVec3::Z, 0.2);
    let first = u32::try_from(lifted.positions.len()).expect("few vertices");
    let a = Detected::new(&lifted, balls[0], margins[0], 8);
    let b = Detected::new(&turned, balls[1], margins[1], 8 + first);
    [a, b]
}

/// No vertex is lost, none is invented, and every gap is that of the balls, or that of the surface
/// where it extends beyond them.
#[test]
fn vertices_meet_what_brute_force_meets() {
    let margin = 0.6;
    let [mut a, b] = overlapping([12, 40], [0.0, margin]);
    let deviation = *b.detector.deviation();
    let mut random = Random(1);
    let mut met = 0;
    for _ in 0..20 {
        let turned = small_muscle()
            .rotated(DVec3::new(1.0, 0.3, 0.0), number(&mut random, 0.0, 0.5))
            .translated(vector(&mut random, 15.0));
        a.move_to(&turned.positions);
        let contacts = vertex_contacts(&a, &b);
        assert_consistent(&contacts, &[&a, &b]);

        let mut contacts = contacts.iter().peekable();
        for (vertex, &p) in (0_u32..).zip(&turned.positions) {
            let distance = brute_force_distance(b.detector.medial(), p);
            let feature = MedialFeature::Vertex(vertex);
            match contacts.next_if(|contact| contact.feature == feature) {
                Some(MedialContact { contact, .. }) => {
                    assert!(distance <= margin + 1e-9, "vertex {vertex} at {distance} is invented");
                    let beyond = distance - contact.gap;
                    let narrower = deviation.surface_to_medial.upper;
                    assert!((-1e-9..=narrower).contains(&beyond), "{distance} {contact:?}");
                    // The contact acts on the surface near the ball, not across the muscle.
                    let is_near = contact.offset <= deviation.largest();
                    assert!(is_near || distance < -2.0, "{contact:?}");
                    met += 1;
                }
                None => assert!(distance > margin - 1e-9, "vertex {vertex} at {distance} is lost"),
            }
        }
        assert!(contacts.next().is_none(), "in the order of the vertices");
    }
    assert!(met > 100, "{met}");
}

/// Pairs of primitives beside all of them: the deepest overlap is found exactly, and each contact is
/// one of the pairs, at a vertex near it.
#[test]
fn balls_meet_what_brute_force_meets() {
    let margin = 0.5;
    let [mut a, b] = overlapping([24, 30], [margin, 0.0]);
    let deviations = a.detector.deviation().largest() + b.detector.deviation().largest();
    let mut random = Random(2);
    let (mut met, mut free) = (0, 0);
    for _ in 0..60 {
        let moved = small_muscle().translated(vector(&mut random, 26.0));
        a.move_to(&moved.positions);
        let contacts = pair_contacts(&a, &b);
        assert_consistent(&contacts, &[&a, &b]);

        let (of_a, of_b) = (a.detector.medial(), b.detector.medial());
        let least = least_distance(of_a, of_b);
        if least > margin {
            assert!(contacts.is_empty(), "{least} {contacts:?}");
            free += 1;
            continue;
        }
        let found = contacts.iter().map(|found| found.contact.gap).fold(f64::INFINITY, f64::min);
        assert!(least - found > -1e-9, "{least} {found}");
        // Deep in each other, the surfaces under the vertices extend farther.
        assert!(least - found < deviations || least < -3.0, "{least} {found}");

        let mut last = None;
        for MedialContact { contact, ball, feature } in &contacts {
            let MedialFeature::Ball(other) = feature else { panic!("{feature:?}") };
            let other = ball_of(of_a, other);
            let distance = ball_of(of_b, ball).distance(other.center) - other.radius;
            assert!(contact.gap <= distance + 1e-9 && distance <= margin + 1e-9, "{contact:?}");
            let vertex = contact.stencil.terms()[0].particle;
            assert!(last < Some(vertex), "ascending, each vertex once");
            last = Some(vertex);
        }
        met += 1;
    }
    assert!(met > 5 && free > 5, "{met} met, {free} free");
}

fn least_distance(a: &MedialSurface, b: &MedialSurface) -> f64 {
    let mut least = f64::INFINITY;
    for (i, _) in (0_u32..).zip(a.primitives()) {
        for (j, _) in (0_u32..).zip(b.primitives()) {
            let foot = pair_foot(&a.primitive_balls(i), &b.primitive_balls(j));
            least = least.min(foot.distance);
        }
    }
    least
}

fn ball_of(medial: &MedialSurface, on: &PrimitiveBall) -> Ball {
    Ball::interpolate(&medial.primitive_balls(on.primitive), on.weights)
}

/// Two long capsules that cross each other at right angles between their vertices.
#[test]
fn capsules_that_cross_between_vertices_meet() {
    let mesh = shapes::capsule(5.0, 60.0, 24);
    let bounds = mesh.bounds();
    let axis = (bounds.sides() / bounds.sides().max_element()).round();
    let across = if axis == DVec3::X { DVec3::Y } else { DVec3::X };
    let up = axis.cross(across);
    let mesh = mesh.translated(-bounds.center());
    let turn = DMat3::from_axis_angle(up, std::f64::consts::FRAC_PI_2);
    let turned = mesh.clone().mapped(|p| turn * p);

    let capsule = |along: DVec3| {
        let ends = [-30.0, 30.0].map(|x| Ball::new(x * along, 5.0));
        MedialSurface::new(ends.to_vec(), vec![[0, 1]], vec![]).unwrap()
    };
    let mut a = Detected::from_medial(&mesh, capsule(axis), 0.0, 0);
    let b = Detected::from_medial(&turned, capsule(across), 0.0, 10_000);
    for depth in [0.5, 2.0, 4.0] {
        let lifted: Vec<DVec3> = mesh.positions.iter().map(|p| *p + (10.0 - depth) * up).collect();
        a.move_to(&lifted);
        let contacts = pair_contacts(&a, &b);
        assert_consistent(&contacts, &[&a, &b]);
        let [found] = &contacts[..] else { panic!("one pair of primitives: {contacts:?}") };
        assert!((found.contact.gap + depth).abs() < 1e-3, "{depth} {found:?}");
        assert!(found.contact.normal.dot(up) > 1.0 - 1e-6, "{found:?}");
    }
}

/// A rigid body is the anchor of its contacts, on whichever side it is.
#[test]
fn rigid_bodies_are_anchors() {
    let bone = shapes::icosphere(6.0, 2).translated(DVec3::new(0.0, 0.0, 13.0));
    let mut bone = Detected::new(&bone, 6, 0.0, 0);
    bone.is_rigid = true;
    let muscle = Detected::new(&small_muscle(), 24, 0.0, 1000);
    let on_muscle = vertex_contacts(&bone, &muscle);
    let on_bone = vertex_contacts(&muscle, &bone);
    assert_consistent(&on_muscle, &[&muscle]);
    assert_consistent(&on_bone, &[&muscle]);
    assert!(!on_muscle.is_empty() && !on_bone.is_empty(), "they overlap");
    for found in on_muscle.iter().chain(&on_bone) {
        assert!(found.contact.anchor.is_some(), "{found:?}");
        // The normal is that of the bone, which is above.
        assert!(found.contact.normal.z < 0.0, "{found:?}");
    }
}

/// In the edge of a groove a vertex has a contact with each side, if requested.
#[test]
fn grooves_have_two_sides() {
    let ridge = |x: f64| [-20.0, 20.0].map(|y| Ball::new(DVec3::new(x, y, 0.0), 6.0));
    let balls = [ridge(-5.0), ridge(5.0)].concat();
    let medial = MedialSurface::new(balls, vec![[0, 1], [2, 3]], vec![]).unwrap();
    let body = shapes::ellipsoid(DVec3::new(11.0, 26.0, 6.0), 4);
    let mut body = Detected::from_medial(&body, medial, 0.0, 0);

    let pin = shapes::tetrahedron(2.0);
    let lowest = (0..4).min_by(|&i, &j| pin.positions[i].z.total_cmp(&pin.positions[j].z)).unwrap();
    let tip = DVec3::new(0.0, 0.0, 2.9);
    let shift = tip - pin.positions[lowest];
    let ball = MedialSurface::new(vec![Ball::new(tip, 0.1)], vec![], vec![]).unwrap();
    let pin = Detected::from_medial(&pin.translated(shift), ball, 0.0, 10_000);
    let lowest = MedialFeature::Vertex(u32::try_from(lowest).unwrap());

    body.detector = body.detector.with_max_contacts(2);
    let mut contacts = vertex_contacts(&pin, &body);
    contacts.retain(|contact| contact.feature == lowest);
    let [left, right] = &contacts[..] else { panic!("{contacts:?}") };
    assert!(left.contact.normal.x * right.contact.normal.x < 0.0, "{contacts:?}");

    body.detector = body.detector.with_max_contacts(1);
    let contacts = vertex_contacts(&pin, &body);
    assert_eq!(contacts.iter().filter(|contact| contact.feature == lowest).count(), 1);
}

/// A detector that follows has the balls of one whose balls were moved by hand; a translation does
/// not increase its error.
#[test]
fn balls_follow_the_body() {
    let rest = small_muscle();
    let mut body = Detected::new(&rest, 40, 0.5, 0);
    let error = |body: &mut Detected| {
        let (surface, x) = (body.tree.surface(), body.tree.positions());
        body.detector.measure(surface, x).unwrap().rms
    };
    let error_at_rest = error(&mut body);
    let mut by_hand = body.detector.medial().clone();
    let links = body.detector.links().clone();

    let shift = DVec3::new(100.0, -40.0, 7.0);
    let moved = rest.clone().translated(shift);
    body.move_to(&moved.positions);
    links.follow(&mut by_hand, body.tree.positions()).unwrap();
    assert_eq!(body.detector.medial(), &by_hand);
    assert!(error(&mut body) <= 1.05 * error_at_rest);

    let short = rest.scaled(DVec3::new(0.8, 1.118, 1.118)).translated(shift);
    body.move_to(&short.positions);
    links.follow(&mut by_hand, body.tree.positions()).unwrap();
    assert_eq!(body.detector.medial(), &by_hand);
    let rms = error(&mut body);
    assert!(rms < 0.5, "{rms}");
    body.detector.follow(body.tree.positions()).unwrap();
    assert_eq!(body.detector.medial(), &by_hand, "a body at rest is not refitted again");
}

#[test]
fn invalid_input_is_refused_by_name() {
    let mesh = small_muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let params = MedialParams::balls(20);
    for margin in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = MedialDetector::new(&surface, x, margin, &params, Progress::none());
        let error = refused.expect_err("a margin out of range");
        assert!(matches!(error, MedialError::Parameter { name: "margin", .. }), "{error}");
    }

    let mut body = Detected::new(&mesh, 20, 0.0, 0);
    let cube = shapes::cube(1.0);
    let other = cube.surface();
    let error = body.detector.follow(other.positions(&cube.positions).unwrap()).unwrap_err();
    let expected = SurfaceError::PositionCount { expected: mesh.positions.len(), got: 8 };
    assert_eq!(error, MedialError::Surface(expected));
}

/// Balls that select vertices and a surface that measures them: the contacts of brute force over
/// the surface, but for those that the bound allows to be lost.
#[test]
fn surfaces_measure_what_balls_select() {
    let (margin, max_gap) = (1.5, 0.3);
    let [mut a, mut b] = overlapping([12, 40], [0.0, margin]);
    let squeezed = small_muscle().rotated(DVec3::Z, 0.2).scaled(DVec3::new(1.1, 0.9, 0.9));
    b.move_to(&squeezed.positions);
    let surface = squeezed.surface();
    let mut scratch = MedialScratch::default();
    let bound = b.detector.surface_bound(&surface, 0.01, &mut scratch).expect("its body");
    let deviation =
        *b.detector.measure(&surface, surface.positions(&squeezed.positions).unwrap()).unwrap();
    let exact = deviation.surface_to_medial;
    assert!(exact.lower <= bound && bound < 2.0 * exact.upper, "{bound} {exact:?}");
    let within = b.detector.surface_bound(&surface, 2.0 * bound, &mut scratch);
    assert_eq!(within, Ok(2.0 * bound), "within it");

    let mut random = Random(5);
    let (mut met, mut contacts) = (0, Vec::new());
    for _ in 0..20 {
        let turned = small_muscle()
            .rotated(DVec3::new(1.0, 0.3, 0.0), number(&mut random, 0.0, 0.5))
            .translated(vector(&mut random, 15.0));
        a.move_to(&turned.positions);
        contacts.clear();
        let scratch = &mut MedialScratch::default();
        b.detector.near_vertices(&a.body(), &b.body(), max_gap, scratch, &mut contacts);

        let normals = Pseudonormals::new(&surface, surface.positions(&squeezed.positions).unwrap());
        let mut found = contacts.iter().peekable();
        for (vertex, &p) in (8_u32..).zip(&turned.positions) {
            let closest = b.tree.closest_point(p, f64::INFINITY, None, &mut Workspace::default());
            let closest = closest.expect("a surface");
            let gap = normals.signed_distance(&surface, p, closest.face, &closest.foot);
            match found.next_if(|near| near.vertex + 8 == vertex) {
                Some(near) => {
                    assert!((near.gap - gap).abs() < 1e-9 && gap <= max_gap, "{gap} {near:?}");
                    met += 1;
                }
                None => assert!(gap > max_gap.min(margin - bound), "vertex {vertex} at {gap} lost"),
            }
        }
        assert!(found.next().is_none());
    }
    assert!(met > 500, "{met}");
}
