//! Contacts carried from frame to frame: walking against a search of every
//! face, sticking against detection, states.

use glam::{DQuat, DVec3};
use response::{
    ContactState, GapMeasure, Margins, PermanentContacts, ResponseError, RigidMotion,
    SurfaceCarrier, walk_to_foot,
};
use surface::{Contact, Stencil, TriangleSurface, closest_on_triangle};

use crate::common::{self, contact, number, on_plane, term, vector};

/// A sphere of radius 10 as a surface of latitudes and longitudes.
fn ball() -> (TriangleSurface, Vec<DVec3>) {
    let (rings, around) = (9_u32, 16_u32);
    let mut x = vec![DVec3::Z * 10.0];
    for ring in 1..=rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings + 1);
        for k in 0..around {
            let turn = std::f64::consts::TAU * f64::from(k) / f64::from(around);
            let (sin, cos) = polar.sin_cos();
            x.push(10.0 * DVec3::new(sin * turn.cos(), sin * turn.sin(), cos));
        }
    }
    x.push(DVec3::Z * -10.0);
    let last = rings * around + 1;
    let at = |ring: u32, k: u32| 1 + ring * around + k % around;
    let mut faces = Vec::new();
    for k in 0..around {
        faces.push([0, at(0, k), at(0, k + 1)]);
        faces.push([last, at(rings - 1, k + 1), at(rings - 1, k)]);
        for ring in 0..rings - 1 {
            faces.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            faces.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
    }
    (TriangleSurface::new(x.len(), faces).expect("valid"), x)
}

/// Distance to the closest of all faces.
fn by_brute_force(surface: &TriangleSurface, x: &[DVec3], p: DVec3) -> f64 {
    let corners = |face: &[u32; 3]| face.map(|k| x[k as usize]);
    let distances =
        surface.faces().iter().map(|f| closest_on_triangle(p, corners(f)).point.distance(p));
    distances.fold(f64::INFINITY, f64::min)
}

#[test]
fn walking_finds_the_closest_face_of_a_ball_from_any_face_that_it_is_over() {
    let (surface, x) = ball();
    let on = surface.positions(&x).unwrap();
    let face_count = u32::try_from(surface.faces().len()).unwrap();
    fixtures::generate::cases(21, 1000, |u| {
        // Outside, where a convex surface has one closest point.
        let p = common::unit(u)? * number(u, 10.0, 14.0)?;
        let start = u.int_in_range(0..=face_count - 1)?;
        let [a, b, c] = on.corners(surface.faces()[start as usize]);
        if (b - a).cross(c - a).dot(p - a) <= 0.0 {
            return Ok(());
        }
        let foot = walk_to_foot(&surface, on, start, p).expect("the face exists");
        let closest = by_brute_force(&surface, &x, p);
        assert!(
            (foot.height - closest).abs() < 1e-12,
            "{} from {start}, not {closest}",
            foot.height
        );
        let corners = surface.faces()[foot.face as usize];
        let point: DVec3 = (0..3).map(|k| foot.barycentric[k] * x[corners[k] as usize]).sum();
        assert!((point - foot.point).length() < 1e-12);
        assert!((p - foot.point - foot.height * foot.normal).length() < 1e-12);
        Ok(())
    });
    assert_eq!(walk_to_foot(&surface, on, face_count, DVec3::ZERO), None);
}

#[test]
fn points_that_are_not_finite_have_no_foot() {
    let (surface, x) = ball();
    let positions = surface.positions(&x).unwrap();
    assert!(walk_to_foot(&surface, positions, 0, DVec3::X).is_some());
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(walk_to_foot(&surface, positions, 0, DVec3::new(0.0, bad, 1.0)).is_none());
    }
    assert!(walk_to_foot(&surface, positions, u32::MAX, DVec3::X).is_none());
}

#[test]
fn a_particle_that_slides_round_a_ball_is_followed_inside_and_out() {
    let (surface, x) = ball();
    let on = surface.positions(&x).unwrap();
    let margins = Margins::new(0.0, 0.5).unwrap();
    let mut p = vec![DVec3::X * 10.3];
    let anchored =
        Contact { anchor: Some(surface::Anchor::default()), ..on_plane(0, p[0], DVec3::X) };
    let mut permanent =
        PermanentContacts::new(&[anchored], &p, GapMeasure::AlongNormal, margins).unwrap();
    let motion = RigidMotion { spin: DVec3::Z, ..RigidMotion::default() };
    for step in 0..400 {
        let turn = 0.03 * f64::from(step);
        let distance = 10.0 + 0.9 * (0.7 * turn).sin();
        p[0] =
            DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(0.4 * turn) * DVec3::X * distance;
        permanent.slide(&p, &surface, on, SurfaceCarrier::Rigid(motion)).unwrap();
        let contact = permanent.contacts()[0];
        let closest = by_brute_force(&surface, &x, p[0]);
        assert!(
            (contact.gap.abs() - closest).abs() < 1e-12,
            "step {step}: {} {closest}",
            contact.gap
        );
        assert!(contact.identity_error(|k| p[k as usize]) < 1e-12);
        let expected = ContactState::of(contact.gap, margins);
        assert_eq!(permanent.states(), [expected]);
        // Well inside or outside of all faces, whose middles are 0.3 below 10.
        if distance < 9.6 {
            assert_eq!(expected, ContactState::Collision);
        }
        if distance > 10.55 {
            assert_eq!(expected, ContactState::Left);
        }
        let anchor = contact.anchor.unwrap();
        assert!((anchor.velocity - DVec3::Z.cross(anchor.point)).length() < 1e-12);
    }
}

#[test]
fn sliding_over_particles_writes_their_stencil() {
    let (surface, lower) = ball();
    let mut x = vec![DVec3::new(0.0, 0.0, 10.5), DVec3::new(20.0, 0.0, 0.0)];
    x.extend(&lower);
    let first = 2;
    let corners = surface.faces()[0].map(|k| k + first);
    let start = contact(Stencil::vertex_face(0, corners, [1.0, 0.0, 0.0]), DVec3::Z, 0.5);
    let margins = Margins::new(0.1, 1.0).unwrap();
    let mut permanent =
        PermanentContacts::new(&[start], &x, GapMeasure::AlongNormal, margins).unwrap();
    for step in 1..60 {
        let turn = 0.05 * f64::from(step);
        x[0] = 10.2 * DVec3::new(turn.sin(), 0.0, turn.cos());
        let on = surface.positions(&x[2..]).unwrap();
        permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first }).unwrap();
        let contact = permanent.contacts()[0];
        assert!(contact.identity_error(|k| x[k as usize]) < 1e-12);
        let closest = by_brute_force(&surface, &lower, x[0]);
        assert!((contact.gap - closest).abs() < 1e-12, "step {step}");
        assert!(contact.stencil.terms()[1..].iter().all(|t| t.particle >= first));
    }
    assert_eq!(permanent.states(), [ContactState::Proximity]);
    for first in [3, u32::MAX] {
        let refused = permanent.slide(
            &x,
            &surface,
            surface.positions(&x[2..]).unwrap(),
            SurfaceCarrier::Particles { first },
        );
        assert!(matches!(refused, Err(ResponseError::ParticleOutOfRange { contact: 0, .. })));
    }
    x[0] *= 2.0;
    let on = surface.positions(&x[2..]).unwrap();
    permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first }).unwrap();
    assert_eq!(permanent.states(), [ContactState::Left]);
    assert_eq!(permanent.drop_left(), 1);
    assert!(permanent.contacts().is_empty());
}

#[test]
fn sticking_contacts_turn_with_what_carries_them() {
    fixtures::generate::cases(22, 1000, |u| {
        let mut x = vec![
            DVec3::new(0.3, 0.2, 0.4),
            DVec3::ZERO,
            DVec3::X * 2.0,
            DVec3::Y * 2.0,
            DVec3::new(-1.0, 0.5, 1.5),
            DVec3::new(1.0, 0.5, 1.5),
            DVec3::new(0.0, -1.0, 1.0),
            DVec3::new(0.0, 2.0, 1.0),
        ];
        let on_face = contact(Stencil::vertex_face(0, [1, 2, 3], [0.75, 0.15, 0.1]), DVec3::Z, 0.4);
        let edges = Stencil::edge_edge([4, 5], 0.5, [6, 7], 0.5);
        let on_edge = contact(edges, DVec3::Z, 0.5);
        let margins = Margins::new(0.0, 1.0).expect("in range");
        let mut permanent =
            PermanentContacts::new(&[on_face, on_edge], &x, GapMeasure::AlongNormal, margins)
                .expect("valid");
        let turn = DQuat::from_rotation_x(number(u, -3.0, 3.0)?)
            * DQuat::from_rotation_z(number(u, -3.0, 3.0)?);
        let shift = vector(u, 5.0)?;
        for x in &mut x {
            *x = turn * *x + shift;
        }
        permanent.stick(&x).expect("finite");
        let contacts = permanent.contacts();
        for (contact, gap) in contacts.iter().zip([0.4, 0.5]) {
            assert!((contact.normal - turn * DVec3::Z).length() < 1e-12, "{}", contact.normal);
            assert!((contact.gap - gap).abs() < 1e-12, "{}", contact.gap);
            assert!(contact.identity_error(|k| x[k as usize]) < 1e-12);
        }
        // P pushed through along the normal: the sign follows.
        x[0] -= turn * DVec3::Z;
        permanent.stick(&x).expect("finite");
        assert!((permanent.contacts()[0].gap + 0.6).abs() < 1e-12);
        assert_eq!(permanent.states(), [ContactState::Collision, ContactState::Proximity]);
        Ok(())
    });
}

#[test]
fn medial_contacts_go_by_the_length() {
    let mut x = vec![DVec3::Z * 7.0, DVec3::ZERO];
    let stencil = Stencil::new(&[term(0, -1.0), term(1, 1.0)]).unwrap();
    let medial = Contact { offset: 5.0, ..contact(stencil, DVec3::Z, 2.0) };
    let margins = Margins::new(0.0, 3.0).unwrap();
    let mut permanent = PermanentContacts::new(&[medial], &x, GapMeasure::Length, margins).unwrap();
    assert_eq!(permanent.states(), [ContactState::Proximity]);
    x[0] = DVec3::new(0.0, 4.0, 0.0);
    permanent.stick(&x).unwrap();
    assert_eq!(permanent.states(), [ContactState::Collision]);
    assert_eq!((permanent.contacts()[0].gap, permanent.contacts()[0].normal), (-1.0, DVec3::Y));
    // On the very axis the normal stays what it was.
    x[0] = DVec3::ZERO;
    permanent.stick(&x).unwrap();
    assert_eq!((permanent.contacts()[0].gap, permanent.contacts()[0].normal), (-5.0, DVec3::Y));
    x[0] = DVec3::X * -9.0;
    permanent.stick(&x).unwrap();
    assert_eq!(permanent.states(), [ContactState::Left]);
}

#[test]
fn edges_that_slide_keep_to_their_closest_points() {
    let mut x = vec![
        DVec3::X * -2.0,
        DVec3::X * 2.0,
        DVec3::new(0.0, -2.0, -1.0),
        DVec3::new(0.0, 2.0, -1.0),
    ];
    let edges = contact(Stencil::edge_edge([0, 1], 0.5, [2, 3], 0.5), DVec3::Z, 1.0);
    let margins = Margins::new(0.0, 3.0).unwrap();
    let mut permanent =
        PermanentContacts::new(&[edges], &x, GapMeasure::AlongNormal, margins).unwrap();
    let (surface, on) = ball();
    for (shift, gap) in [(0.5, 1.0), (1.5, -0.2)] {
        x[0] = DVec3::new(shift - 2.0, shift / 2.0, gap - 1.0);
        x[1] = DVec3::new(shift + 2.0, shift / 2.0, gap - 1.0);
        let on = surface.positions(&on).unwrap();
        permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first: 0 }).unwrap();
        let contact = permanent.contacts()[0];
        assert!((contact.gap - gap).abs() < 1e-12, "{}", contact.gap);
        assert!((contact.normal - DVec3::Z).length() < 1e-12);
        assert!(contact.identity_error(|k| x[k as usize]) < 1e-12);
        let of_b = contact.stencil.terms()[3].weight;
        assert!((of_b - (0.5 + shift / 8.0)).abs() < 1e-12, "{of_b}");
    }
}

/// Edges whose ends are on a lattice, so that most closest points are at ends, or straight over them.
#[test]
fn edges_that_slide_to_their_ends_stay_edges() {
    let (surface, on) = ball();
    let on = surface.positions(&on).unwrap();
    let margins = Margins::new(0.0, 100.0).unwrap();
    let mut at_ends = [0; 4];
    fixtures::generate::cases(24, 300, |u| {
        let coordinate =
            |u: &mut arbitrary::Unstructured<'_>| Ok(f64::from(u.int_in_range(-2..=2_i8)?));
        let start = contact(Stencil::edge_edge([0, 1], 0.5, [2, 3], 0.5), DVec3::Z, 1.0);
        let mut x = vec![DVec3::X, DVec3::NEG_X, DVec3::Y - DVec3::Z, DVec3::NEG_Y - DVec3::Z];
        let mut permanent =
            PermanentContacts::new(&[start], &x, GapMeasure::AlongNormal, margins).unwrap();
        for _ in 0..6 {
            for x in &mut x {
                *x = DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?);
            }
            permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first: 0 }).unwrap();
            let contact = permanent.contacts()[0];
            let particles: Vec<u32> = contact.stencil.terms().iter().map(|t| t.particle).collect();
            assert_eq!((particles, contact.anchor), (vec![0, 1, 2, 3], None), "{x:?}");

            // As near as the edges come to each other at 101 × 101 places, and no nearer than they are.
            let weights: Vec<f64> = contact.stencil.terms().iter().map(|t| t.weight).collect();
            let place = |ends: [DVec3; 2], step: u8| ends[0].lerp(ends[1], f64::from(step) / 100.0);
            let mut sampled = f64::INFINITY;
            for (i, j) in (0..=100).flat_map(|i| (0..=100).map(move |j| (i, j))) {
                sampled = sampled.min(place([x[0], x[1]], i).distance(place([x[2], x[3]], j)));
            }
            let points =
                [-(weights[0] * x[0] + weights[1] * x[1]), weights[2] * x[2] + weights[3] * x[3]];
            let distance = points[0].distance(points[1]);
            assert!(distance < sampled + 1e-12 && distance > sampled - 0.05, "{x:?}");
            assert!((contact.gap.abs() - distance).abs() < 1e-12, "{contact:?} {x:?}");
            assert!((weights[0] + weights[1] + 1.0).abs() < 1e-15, "{weights:?}");
            for (count, weight) in at_ends.iter_mut().zip(weights) {
                *count += u32::from(weight == 0.0);
            }
        }
        Ok(())
    });
    assert!(at_ends.iter().all(|count| *count > 100), "{at_ends:?}");
}

#[test]
fn anchors_move_as_given_and_bad_ones_are_named() {
    let x = [DVec3::Z * 0.5];
    let margins = Margins::new(0.0, 1.0).unwrap();
    let start = on_plane(0, x[0], DVec3::Z);
    let mut permanent =
        PermanentContacts::new(&[start], &x, GapMeasure::AlongNormal, margins).unwrap();
    permanent.move_anchors(|_, anchor, _| anchor.point.z += 0.75);
    permanent.stick(&x).unwrap();
    assert_eq!(permanent.contacts()[0].gap, -0.25);
    permanent.move_anchors(|_, _, normal| *normal = DVec3::ZERO);
    assert_eq!(permanent.stick(&x), Err(ResponseError::Normal { contact: 0, length: 0.0 }));
    let nowhere = permanent.stick(&[]);
    assert!(matches!(
        nowhere,
        Err(ResponseError::Normal { .. } | ResponseError::ParticleOutOfRange { .. })
    ));
    let nan = [DVec3::NAN];
    let refused = PermanentContacts::new(&[start], &nan, GapMeasure::Length, margins).map(|_| ());
    assert!(matches!(refused, Err(ResponseError::ParticleNotFinite { particle: 0, .. })));
}

/// What slid sticks where it is: at the same positions nothing changes, and the normal turns with
/// the face, or the edges, that the contact slid to.
#[test]
fn contacts_that_slid_stick_where_they_are() {
    let (surface, lower) = ball();
    let first = 3;
    let corners = surface.faces()[0].map(|k| k + first);
    let margins = Margins::new(0.1, 100.0).unwrap();
    let of_vertex = Stencil::vertex_face(0, corners, [1.0, 0.0, 0.0]);
    let [b0, b1, _] = corners;
    let of_edges = Stencil::edge_edge([0, 1], 0.5, [b0, b1], 0.5);
    let of_edge = Stencil::new(&[term(0, -0.5), term(1, -0.5), term(b0, 1.0)]).unwrap();
    for stencil in [of_vertex, of_edges, of_edge] {
        let mut x = vec![DVec3::Z * 11.0, DVec3::new(0.3, 1.0, 11.0), DVec3::ZERO];
        x.extend(&lower);
        let start = contact(stencil, DVec3::Z, 0.5);
        let mut permanent =
            PermanentContacts::new(&[start], &x, GapMeasure::AlongNormal, margins).unwrap();
        for step in 0..40 {
            // Over faces, edges and corners.
            let turn = 0.05 * f64::from(step);
            x[0] = 11.0 * DVec3::new(turn.sin(), 0.1, turn.cos());
            x[1] = x[0] + DVec3::new(0.3, 1.0, 0.2);
            let on = surface.positions(&x[3..]).unwrap();
            permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first }).unwrap();
            let slid = permanent.contacts()[0];
            permanent.stick(&x).unwrap();
            let stuck = permanent.contacts()[0];
            assert!((stuck.normal - slid.normal).length() < 1e-12, "{stencil:?}, step {step}");
            assert!((stuck.gap - slid.gap).abs() < 1e-11, "{stencil:?}, step {step}");

            // All turns together.
            let rotation = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
            let turned: Vec<DVec3> = x.iter().map(|x| rotation * *x).collect();
            permanent.stick(&turned).unwrap();
            let stuck = permanent.contacts()[0];
            assert!((stuck.normal - rotation * slid.normal).length() < 1e-12, "{stencil:?}");
            permanent.stick(&x).unwrap();
        }
    }
}

/// A foot in the corner of a face, of which one weight is computed as −0, belongs to P̄ all the same.
#[test]
fn zeros_of_a_foot_are_on_its_side() {
    let on = [DVec3::X, DVec3::new(0.5, 0.0, 1e-9), DVec3::ZERO];
    let x = [DVec3::new(0.0, -5.0, -3.0), on[0], on[1], on[2]];
    let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("valid");
    let margins = Margins::new(0.0, 100.0).expect("in range");
    let start = contact(Stencil::vertex_face(0, [1, 2, 3], [0.5, 0.0, 0.5]), DVec3::Z, 1.0);
    let mut permanent =
        PermanentContacts::new(&[start], &x, GapMeasure::AlongNormal, margins).expect("valid");
    let carrier = SurfaceCarrier::Particles { first: 1 };
    let positions = surface.positions(&on).expect("finite");
    permanent.slide(&x, &surface, positions, carrier).expect("valid");

    let terms = permanent.contacts()[0].stencil.terms();
    let of_p: Vec<bool> = terms.iter().map(|term| term.weight.is_sign_negative()).collect();
    assert_eq!(of_p, [true, false, false, false], "{terms:?}");
    assert_eq!(terms[3].weight, 1.0, "{terms:?}");
}

/// Contacts before and after the one that is refused, and that one itself, stay as they were.
#[test]
fn a_refused_contact_changes_none() {
    let (surface, lower) = ball();
    let first = 3;
    let mut x = vec![DVec3::Z * 10.5, DVec3::new(1.0, 0.0, 10.5), DVec3::new(0.0, 1.0, 10.5)];
    x.extend(&lower);
    let corners = surface.faces()[0].map(|k| k + first);
    let of_vertex = Stencil::vertex_face(0, corners, [1.0, 0.0, 0.0]);
    let on_bone = Contact {
        anchor: Some(surface::Anchor::default()),
        ..contact(Stencil::face([0, 1, 2], [-0.5, -0.25, -0.25]), DVec3::Z, 10.0)
    };
    let contacts = [contact(of_vertex, DVec3::Z, 0.5), on_bone];
    let margins = Margins::new(0.1, 100.0).expect("in range");
    let mut permanent =
        PermanentContacts::new(&contacts, &x, GapMeasure::AlongNormal, margins).expect("valid");

    // A face on the side of P does not fit onto particles.
    x[0].x += 2.0;
    let on = surface.positions(&lower).expect("finite");
    let refused = permanent.slide(&x, &surface, on, SurfaceCarrier::Particles { first });
    assert!(matches!(refused, Err(ResponseError::Count { got: 3, .. })), "{refused:?}");
    assert_eq!(permanent.contacts(), contacts);
    assert_eq!((permanent.face(0), permanent.face(1)), (None, None));

    permanent.move_anchors(|_, _, normal| *normal = DVec3::ZERO);
    let refused = permanent.stick(&x);
    assert_eq!(refused, Err(ResponseError::Normal { contact: 1, length: 0.0 }));
    assert_eq!(permanent.contacts()[0], contacts[0]);
}
