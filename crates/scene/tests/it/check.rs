//! Static detection against brute force and planted answers.

use std::ops::ControlFlow;

use crate::support::{scene_of, share, vector};
use arbitrary::{Result, Unstructured};
use fixtures::generate::cases;
use fixtures::{Mesh, shapes};
use glam::DVec3;
use scene::{
    BodyKind, BodyMove, CheckParams, NoInside, PairId, PairReport, Scene, SceneError, VertexReport,
};
use scene::{Interrupted, Progress};
use surface::{
    Meeting, closest_between_triangles, closest_on_triangle, triangles_meet, winding_number,
};

/// One of several closed shapes of some 10 mm.
fn shape(u: &mut Unstructured<'_>) -> Result<Mesh> {
    let mesh = match u.int_in_range(0..=5)? {
        0 => shapes::tetrahedron(8.0),
        1 => shapes::cube(10.0),
        2 => shapes::icosphere(6.0, 1),
        3 => shapes::ellipsoid(DVec3::new(2.0, 5.0, 9.0), 2),
        4 => shapes::torus(7.0, 2.0, [10, 6]),
        _ => shapes::plate(DVec3::new(14.0, 12.0, 0.5), [3, 3]),
    };
    // Often not rotated, and moved by whole numbers: vertices, edges and faces
    // then lie exactly in each other.
    let mesh = if u.ratio(1, 2)? {
        mesh
    } else {
        mesh.rotated(vector(u, 1.0)? + DVec3::Z * 1.5, share(u, 0.0, 1.0)?)
    };
    let shift = vector(u, 10.0)?;
    Ok(mesh.translated(if u.ratio(1, 2)? { shift.round() } else { shift }))
}

/// A shape a fifth as large, somewhere near the middle of another.
fn shrunk_into(u: &mut Unstructured<'_>, mesh: Mesh, other: &Mesh) -> Result<Mesh> {
    let middle = |mesh: &Mesh| mesh.bounds().center();
    let to = middle(other) + vector(u, 3.0)?;
    let shift = -middle(&mesh);
    Ok(mesh.translated(shift).scaled(DVec3::splat(0.2)).translated(to))
}

/// What a report must say, by looking at everything.
struct Slow {
    crossing: Vec<[u32; 2]>,
    a_inside: Vec<u32>,
    b_inside: Vec<u32>,
    /// Unsigned distances of the vertices of `a`, then those of `b`.
    distances: [Vec<f64>; 2],
    distance: f64,
}

fn slow(a: &Mesh, b: &Mesh) -> Slow {
    let corners = |mesh: &Mesh| -> Vec<[DVec3; 3]> {
        mesh.faces.iter().map(|face| face.map(|v| mesh.positions[v as usize])).collect()
    };
    let (of_a, of_b) = (corners(a), corners(b));
    let mut crossing = Vec::new();
    let mut distance = f64::INFINITY;
    for (fa, ta) in (0..).zip(&of_a) {
        for (fb, tb) in (0..).zip(&of_b) {
            let meeting = triangles_meet(*ta, *tb);
            if meeting == Meeting::Crossing {
                crossing.push([fa, fb]);
            }
            let between = closest_between_triangles(*ta, *tb).distance();
            distance = distance.min(if meeting.shares_a_point() { 0.0 } else { between });
        }
    }
    let distances = |mesh: &Mesh, faces: &[[DVec3; 3]]| -> Vec<f64> {
        let to = |x: &DVec3| {
            let each = faces.iter().map(|face| closest_on_triangle(*x, *face).point.distance(*x));
            each.fold(f64::INFINITY, f64::min)
        };
        mesh.positions.iter().map(to).collect()
    };
    let distances = [distances(a, &of_b), distances(b, &of_a)];
    let inside = |mesh: &Mesh, other: &Mesh, distances: &[f64]| -> Vec<u32> {
        let surface = other.surface();
        let x = surface.positions(&other.positions).expect("finite");
        let winds = |(_, p): &(u32, &DVec3)| winding_number(&surface, x, **p).abs() > 0.5;
        let off = |(v, _): &(u32, &DVec3)| distances[*v as usize] > 1e-9;
        (0..).zip(&mesh.positions).filter(off).filter(winds).map(|(v, _)| v).collect()
    };
    Slow {
        crossing,
        a_inside: inside(a, b, &distances[0]),
        b_inside: inside(b, a, &distances[1]),
        distances,
        distance,
    }
}

/// Vertices that a report says are inside, those on the surface left out.
fn inside(report: &VertexReport) -> Vec<u32> {
    report.near.iter().filter(|near| near.gap < -1e-9).map(|near| near.vertex).collect()
}

fn agrees(report: &PairReport, slow: &Slow, margin: f64) {
    assert_eq!(report.crossing_faces, slow.crossing, "crossing faces");
    assert_eq!(inside(&report.a_against_b), slow.a_inside, "vertices of a inside b");
    assert_eq!(inside(&report.b_against_a), slow.b_inside, "vertices of b inside a");
    let sides = [&report.a_against_b, &report.b_against_a];
    for (side, distances) in sides.iter().zip(&slow.distances) {
        for near in &side.near {
            let expected = distances[near.vertex as usize];
            assert!((near.gap.abs() - expected).abs() < 1e-12, "{near:?}, not {expected}");
        }
        let within = (0_u32..).zip(distances).filter(|(_, d)| **d < margin - 1e-9);
        for (vertex, distance) in within {
            let found = side.near.iter().any(|near| near.vertex == vertex);
            assert!(found, "vertex {vertex} at {distance} is missing");
        }
    }
    match report.distance {
        Some(distance) => {
            assert!((distance - slow.distance).abs() < 1e-12, "{distance}, not {}", slow.distance);
        }
        None => assert!(slow.distance >= margin - 1e-9, "{} is within the margin", slow.distance),
    }
}

#[test]
fn agrees_with_brute_force() {
    let (mut crossed, mut nested, mut apart) = (0, 0, 0);
    cases(1, 400, |u| {
        let (a, b) = (shape(u)?, shape(u)?);
        let b = if u.ratio(1, 3)? { shrunk_into(u, b, &a)? } else { b };
        let margin = share(u, 0.0, 3.0)?;
        let (mut scene, ids) = scene_of(&[&a, &b]);
        let reports = scene.check(&CheckParams::new(margin), Progress::none()).unwrap();
        let slow = slow(&a, &b);
        let any_inside = !(slow.a_inside.is_empty() && slow.b_inside.is_empty());
        match &reports[..] {
            [report] => {
                assert_eq!(report.pair.bodies(), [ids[0], ids[1]]);
                agrees(report, &slow, margin);
                let overlaps = any_inside || !slow.crossing.is_empty();
                assert!(report.overlaps || !overlaps);
                assert!(overlaps || report.max_vertex_depth < 1e-9);
            }
            [] => {
                assert!(slow.distance > margin - 1e-9 && !any_inside, "{} lost", slow.distance);
            }
            _ => unreachable!("two bodies are one pair"),
        }
        crossed += usize::from(!slow.crossing.is_empty());
        nested += usize::from(any_inside && slow.crossing.is_empty());
        apart += usize::from(reports.is_empty());
        Ok(())
    });
    assert!(crossed > 10 && nested > 0 && apart > 10, "{crossed} {nested} {apart}");
}

/// Moving and refitting give the reports of a scene built in place.
#[test]
fn a_moved_scene_gives_the_reports_of_a_new_one() {
    cases(2, 100, |u| {
        let (a, b) = (shape(u)?, shape(u)?);
        let moved = b.clone().translated(vector(u, 4.0)?).rotated(DVec3::Y, share(u, 0.0, 1.0)?);
        let params = CheckParams::new(1.0);
        let (mut scene, ids) = scene_of(&[&a, &b]);
        scene.check(&params, Progress::none()).unwrap();
        scene.move_body(ids[1], &moved.positions).unwrap();
        let (mut new, _) = scene_of(&[&a, &moved]);
        assert_eq!(scene.check(&params, Progress::none()), new.check(&params, Progress::none()));
        Ok(())
    });
}

#[test]
fn contacts_satisfy_their_identity() {
    let bone = shapes::icosphere(10.0, 2);
    let muscle = shapes::ellipsoid(DVec3::new(4.0, 4.0, 20.0), 3).translated(DVec3::X * 13.0);
    for kinds in [
        [BodyKind::Rigid, BodyKind::Deformable],
        [BodyKind::Deformable; 2],
        [BodyKind::Deformable, BodyKind::Rigid],
    ] {
        let mut scene = Scene::new();
        for (mesh, (name, kind)) in [&bone, &muscle].iter().zip(["a", "b"].iter().zip(kinds)) {
            scene.add(*name, kind, mesh.surface(), mesh.positions.clone()).unwrap();
        }
        let reports = scene.check(&CheckParams::new(1.0), Progress::none()).unwrap();
        let contacts = reports[0].contacts(&scene);
        let x = scene.particle_positions();
        assert!(contacts.len() > 20 && contacts.iter().any(|contact| contact.gap < 0.0));
        for contact in contacts {
            assert!(contact.identity_error(|k| x[k as usize]) < 1e-13, "{contact:?}");
            assert!((contact.normal.length() - 1.0).abs() < 1e-14, "{contact:?}");
            assert_eq!(contact.anchor.is_some(), kinds.contains(&BodyKind::Rigid));
        }
    }
}

/// Two long prisms crossed like an X: no vertex of either is inside the other.
#[test]
fn finds_overlap_of_edges_only() {
    let beam = |length: DVec3| shapes::cube(2.0).scaled(length);
    let a = beam(DVec3::new(10.0, 1.0, 1.0));
    let b = beam(DVec3::new(1.0, 10.0, 1.0)).rotated(DVec3::Y, 0.125);
    let (mut scene, _) = scene_of(&[&a, &b]);
    let reports = scene.check(&CheckParams::new(0.5), Progress::none()).unwrap();
    assert!(reports[0].overlaps && !reports[0].crossing_faces.is_empty());
    let inside = |side: &VertexReport| side.inside_count;
    assert_eq!([inside(&reports[0].a_against_b), inside(&reports[0].b_against_a)], [Ok(0); 2]);
    assert_eq!(reports[0].distance, Some(0.0));
}

#[test]
fn a_body_within_another_overlaps_it() {
    let outer = shapes::icosphere(10.0, 2);
    let inner = shapes::octasphere(2.0, 1).translated(DVec3::X * 3.0);
    let (mut scene, _) = scene_of(&[&outer, &inner]);
    let report = &scene.check(&CheckParams::new(1.0), Progress::none()).unwrap()[0];
    assert!(report.overlaps && report.crossing_faces.is_empty());
    assert_eq!(report.b_against_a.inside_count, Ok(inner.positions.len()));
    assert_eq!(report.a_against_b.inside_count, Ok(0));
    assert!(report.max_vertex_depth > 4.0, "{}", report.max_vertex_depth);
}

/// A vertex on the other's wall is not inside, and says nothing of its
/// neighbours, which are.
#[test]
fn a_vertex_on_the_wall_hides_no_neighbor() {
    let room = shapes::cube(20.0);
    let positions = [[10.0, 0.5, 0.25], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [2.0, 0.0, 3.0]];
    let mesh = shapes::tetrahedron(1.0);
    let guest = Mesh { positions: positions.map(DVec3::from).to_vec(), ..mesh };
    let (mut scene, _) = scene_of(&[&room, &guest]);
    let report = &scene.check(&CheckParams::new(0.0), Progress::none()).unwrap()[0];
    assert_eq!(report.b_against_a.inside_count, Ok(3));
    assert!(report.overlaps && report.crossing_faces.is_empty());
    assert_eq!(report.distance, Some(0.0));
}

#[test]
fn touching_is_not_overlap() {
    let a = shapes::cube(2.0);
    let b = shapes::cube(2.0).translated(DVec3::X * 2.0);
    let (mut scene, _) = scene_of(&[&a, &b]);
    let report = &scene.check(&CheckParams::new(0.5), Progress::none()).unwrap()[0];
    assert!(!report.overlaps, "{report:?}");
    assert_eq!(
        (report.distance, report.min_gap, report.max_vertex_depth),
        (Some(0.0), Some(0.0), 0.0)
    );
}

#[test]
fn a_body_without_inside_is_reported_as_such() {
    let mut holed = shapes::icosphere(10.0, 2);
    holed.faces.swap_remove(17);
    let ball = shapes::octasphere(2.0, 1).translated(DVec3::X * 9.5);
    let (mut scene, ids) = scene_of(&[&holed, &ball]);
    let report = &scene.check(&CheckParams::new(1.0), Progress::none()).unwrap()[0];
    assert!(report.overlaps && !report.crossing_faces.is_empty());
    let refused = report.b_against_a.inside_count;
    assert!(matches!(refused, Err(NoInside::OddEdges { count: 3, faces: 1, .. })), "{refused:?}");
    assert!(report.b_against_a.near.iter().all(|near| near.gap >= 0.0));
    assert!(report.a_against_b.inside_count.is_ok(), "the ball is closed");
    assert!(scene.body(ids[1]).has_inside().is_ok());
}

#[test]
fn invalid_bodies_and_margins_are_rejected() {
    let ball = shapes::octasphere(2.0, 0);
    let add = |scene: &mut Scene, name: &str, mesh: &Mesh| {
        scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions.clone())
    };
    let mut scene = Scene::new();
    add(&mut scene, "ball", &ball).unwrap();
    let twice = add(&mut scene, "ball", &ball);
    assert_eq!(twice, Err(SceneError::DuplicateName { name: "ball".into() }));
    assert_eq!(add(&mut scene, "", &ball), Err(SceneError::EmptyName));
    for name in ["\0", "left\0femur", "femur\n", "\x1b[2J", "femur\u{9b}", "\t"] {
        let refused = add(&mut scene, name, &ball);
        assert_eq!(refused, Err(SceneError::ControlCharacter { name: name.into() }));
    }
    let refused = add(&mut scene, "a\0", &ball).unwrap_err().to_string();
    assert_eq!(refused, "the name \"a\\0\" of a body has a control character");
    add(&mut scene, "Oberschenkelknochen (größer) \u{2066}", &ball).expect("text");
    let faceless = Mesh { faces: Vec::new(), ..ball.clone() };
    let none = add(&mut scene, "dust", &faceless);
    assert_eq!(none, Err(SceneError::NoFaces { name: "dust".into() }));
    let mut broken = ball;
    broken.positions[3].y = f64::NAN;
    let message = add(&mut scene, "broken", &broken).unwrap_err().to_string();
    assert!(message.contains("\"broken\": vertex 3 is at"), "{message}");
    for margin in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = scene.check(&CheckParams::new(margin), Progress::none());
        assert!(matches!(refused, Err(SceneError::Margin { .. })), "{refused:?}");
    }
}

#[test]
fn ignored_pairs_are_left_out() {
    let ball = shapes::octasphere(2.0, 1);
    let (mut scene, ids) = scene_of(&[&ball, &ball, &ball]);
    scene.ignore(ids[2], ids[0]);
    let reports = scene.check(&CheckParams::new(0.0), Progress::none()).unwrap();
    let pairs: Vec<_> =
        reports.iter().map(|report| (report.pair.a.index(), report.pair.b.index())).collect();
    assert_eq!(pairs, [(0, 1), (1, 2)]);
}

#[cfg(feature = "rayon")]
#[test]
fn reports_are_the_same_for_any_number_of_threads() {
    let bodies: Vec<Mesh> = (0..9)
        .map(|i| {
            shapes::ellipsoid(DVec3::new(4.0, 6.0, 20.0), 3)
                .translated(DVec3::X * 5.5 * f64::from(i))
        })
        .collect();
    let bodies: Vec<&Mesh> = bodies.iter().collect();
    let check = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            scene_of(&bodies).0.check(&CheckParams::new(2.0), Progress::none()).unwrap()
        })
    };
    let one = check(1);
    assert!(one.len() > 7);
    assert_eq!(check(2), one);
    assert_eq!(check(7), one);
}

#[test]
fn a_check_and_a_sweep_can_be_interrupted() {
    let ball = shapes::octasphere(2.0, 1);
    let (mut scene, ids) = scene_of(&[&ball, &ball]);
    let stop = |_| ControlFlow::Break(());
    let progress = Progress::new(&stop);

    let check = scene.check(&CheckParams::new(0.0), progress);
    assert_eq!(check, Err(SceneError::Interrupted(Interrupted)));
    let moves = [BodyMove { body: ids[0], positions: &ball.positions }];
    let sweep = scene.sweep(&moves, &ccd::CcdParams::DEFAULT, progress);
    assert_eq!(sweep, Err(SceneError::Interrupted(Interrupted)));
}

/// A row of tetrahedra, of which the first two overlap.
#[test]
fn ten_thousand_bodies_are_checked() {
    let mut scene = Scene::new();
    for number in 0..10_000_u32 {
        let place = if number == 1 { 0.5 } else { 3.0 * f64::from(number) };
        let body = shapes::tetrahedron(1.0).translated(DVec3::X * place);
        scene
            .add(number.to_string(), BodyKind::Rigid, body.surface(), body.positions)
            .expect("a body");
    }
    let reports = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
    assert_eq!(reports.len(), 1);
    let fitted: Vec<usize> = scene
        .ids()
        .filter(|id| scene.body(*id).tree().is_some())
        .map(scene::BodyId::index)
        .collect();
    assert_eq!(fitted, [0, 1]);
}

/// A margin of millimeters beside bodies in meters takes in all faces of both.
#[test]
fn margins_that_take_in_too_many_faces_are_an_error() {
    let ball = shapes::icosphere(0.1, 5);
    let other = ball.clone().translated(0.3 * DVec3::X);
    let (mut scene, ids) = scene_of(&[&ball, &other]);
    let named = |error: &SceneError| {
        let text = error.to_string();
        assert!(matches!(error, SceneError::NearFaces { .. }), "{text}");
        assert!(text.contains("margin of 1000") && text.contains("67108864 pairs"), "{text}");
    };
    let checked = scene.check(&CheckParams::new(1000.0), Progress::none());
    named(&checked.expect_err("419 million pairs of faces"));
    let params = overlap::JointContactParams { margin: 1000.0, resolution: 1.0, foundation: None };
    let pairs = [PairId::new(ids[0], ids[1])];
    let contacts = scene.joint_contacts(&pairs, &params, Progress::none());
    named(&contacts.expect_err("419 million pairs of faces"));

    // Within a margin in their unit they are near.
    let near = scene.check(&CheckParams::new(0.11), Progress::none()).expect("a check");
    assert_eq!(near.len(), 1);
}
