//! Swept detection against brute force over all vertices, edges and faces, and against states
//! in between.

use crate::support::{scene_of, share, vector};
use arbitrary::{Result, Unstructured};
use fixtures::generate::cases;
use fixtures::{Mesh, shapes};
use glam::DVec3;
use scene::{BodyId, BodyMove, CheckParams, Progress, SceneError, SweptContact};

/// A body's way to new positions.
fn moved(body: BodyId, positions: &[DVec3]) -> BodyMove<'_> {
    BodyMove { body, positions }
}

/// Two bodies of a few dozen faces, and where they go.
fn two_bodies(u: &mut Unstructured<'_>) -> Result<[Mesh; 4]> {
    let a = shapes::icosphere(10.0, 1);
    let b = shapes::ellipsoid(DVec3::new(4.0, 8.0, 12.0), 1)
        .rotated(DVec3::ONE, share(u, 0.0, 1.0)?)
        .translated(vector(u, 25.0)?);
    let shift = vector(u, 30.0)?;
    let bend = share(u, -0.02, 0.02)?;
    let a1 = a.clone().mapped(|x| x + DVec3::Z * bend * x.x * x.x);
    let b1 = b.clone().translated(shift);
    Ok([a, b, a1, b1])
}

/// Contacts of all vertices, edges and faces of two meshes, by the four points
/// of each, sorted.
fn slow_contacts([a, b, a1, b1]: &[Mesh; 4]) -> Vec<([u32; 4], f64)> {
    let offset = u32::try_from(a.positions.len()).expect("a small mesh");
    let x0 = [&a.positions[..], &b.positions].concat();
    let x1 = [&a1.positions[..], &b1.positions].concat();
    let at = |x: &[DVec3], points: [u32; 4]| points.map(|p| x[p as usize]);
    let shift = |face: &[u32; 3]| face.map(|v| v + offset);
    let mut found = Vec::new();
    let mut vertex_face = |vertex: u32, [p, q, r]: [u32; 3]| {
        let points = [vertex, p, q, r];
        let answer = ccd::vertex_face(at(&x0, points), at(&x1, points), &ccd::CcdParams::EXACT);
        found.extend(answer.expect("finite").map(|contact| (points, contact.lo)));
    };
    for vertex in 0..offset {
        b.faces.iter().for_each(|face| vertex_face(vertex, shift(face)));
    }
    for vertex in (offset..).take(b.positions.len()) {
        a.faces.iter().for_each(|face| vertex_face(vertex, *face));
    }
    for &[p, q] in a.surface().edges() {
        for edge in b.surface().edges() {
            let points = [p, q, edge[0] + offset, edge[1] + offset];
            let answer = ccd::edge_edge(at(&x0, points), at(&x1, points), &ccd::CcdParams::EXACT);
            found.extend(answer.expect("finite").map(|contact| (points, contact.lo)));
        }
    }
    found.sort_by_key(|&(points, _)| points);
    found
}

fn particles(contact: &SweptContact) -> [u32; 4] {
    let terms = contact.contact.stencil.terms();
    std::array::from_fn(|k| terms[k].particle)
}

#[test]
fn finds_the_contacts_of_brute_force() {
    let mut met = 0;
    cases(1, 40, |u| {
        let meshes = two_bodies(u)?;
        let (mut scene, ids) = scene_of(&[&meshes[0], &meshes[1]]);
        let moves = [moved(ids[0], &meshes[2].positions), moved(ids[1], &meshes[3].positions)];
        let report = scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none()).unwrap();
        let mut found: Vec<_> = report
            .pairs
            .iter()
            .flat_map(|pair| &pair.contacts)
            .map(|contact| (particles(contact), contact.contact.time.unwrap()))
            .collect();
        found.sort_by_key(|&(points, _)| points);
        let slow = slow_contacts(&meshes);
        assert_eq!(found, slow);
        let first = slow.iter().map(|&(_, time)| time).fold(1.0, f64::min);
        assert!((report.largest_free_step - first).abs() < f64::EPSILON);
        met += usize::from(!slow.is_empty());
        Ok(())
    });
    assert!(met > 10, "{met} pairs met");
}

/// Before the largest free step nothing overlaps that did not overlap at the
/// start; just after the first certain contact something has met.
#[test]
fn nothing_overlaps_within_the_free_step() {
    cases(2, 100, |u| {
        let [a, b, a1, b1] = two_bodies(u)?;
        let (mut scene, ids) = scene_of(&[&a, &b]);
        let params = CheckParams::without_measures(0.0);
        if scene.check(&params, Progress::none()).unwrap().iter().any(|pair| pair.overlaps) {
            return Ok(());
        }
        let moves = [moved(ids[0], &a1.positions), moved(ids[1], &b1.positions)];
        let free = scene
            .sweep(&moves, &ccd::CcdParams::EXACT, Progress::none())
            .unwrap()
            .largest_free_step;
        for part in [0.25, 0.5, 0.999] {
            for (id, (from, to)) in ids.iter().zip([(&a, &a1), (&b, &b1)]) {
                let between = from.positions.iter().zip(&to.positions);
                let x: Vec<DVec3> = between.map(|(p, q)| p.lerp(*q, part * free)).collect();
                scene.move_body(*id, &x).unwrap();
            }
            let overlaps =
                scene.check(&params, Progress::none()).unwrap().iter().any(|pair| pair.overlaps);
            assert!(!overlaps, "overlap at {part} of the free step {free}");
        }
        Ok(())
    });
}

/// A small body that passes wholly through a plate within one step: both
/// states are free, so only the way between them shows it.
#[test]
fn a_body_that_passes_through_a_plate_is_reported() {
    let plate = shapes::plate(DVec3::new(60.0, 60.0, 2.0), [6, 6]);
    let ball = shapes::octasphere(3.0, 2).translated(DVec3::new(1.3, 0.7, 20.0));
    let beyond = ball.clone().translated(DVec3::Z * -40.0);
    let (mut scene, ids) = scene_of(&[&plate, &ball]);
    let params = CheckParams::new(1.0);
    let before = scene.check(&params, Progress::none()).unwrap();
    assert!(before.is_empty(), "apart at the start");
    let report = scene
        .sweep(&[moved(ids[1], &beyond.positions)], &ccd::CcdParams::EXACT, Progress::none())
        .unwrap();
    scene.move_body(ids[1], &beyond.positions).unwrap();
    let after = scene.check(&params, Progress::none()).unwrap();
    assert!(after.is_empty(), "apart at the end");
    let unseen = report.pass_throughs(&scene, &before, &after);
    assert!(unseen[0].overlaps_in_neither);
    let through = scene.body(ids[1]).particles();
    let ball_particles = unseen[0].particles.iter().filter(|&particle| through.contains(particle));
    assert_eq!(ball_particles.count(), ball.positions.len(), "every vertex went through");
    // The ball's lowest vertex is at 17, the plate's upper side at 1 (or 2, if it stands on 0).
    let top = plate.bounds().max;
    let expected = (17.0 - top.z) / 40.0;
    assert!((report.largest_free_step - expected).abs() < 1e-9, "{}", report.largest_free_step);
    for contact in &report.pairs[0].contacts {
        assert!(contact.certain && !contact.at_start);
        assert!(contact.contact.time.unwrap() <= contact.latest);
    }
}

/// A ball that stays in the plate is seen by static detection.
#[test]
fn a_body_that_stays_inside_does_not_pass_through() {
    let plate = shapes::plate(DVec3::new(60.0, 60.0, 9.0), [6, 6]);
    let top = plate.bounds().max;
    let ball = shapes::octasphere(1.0, 1).translated(DVec3::new(1.3, 0.7, top.z + 2.0));
    let within = ball.clone().translated(DVec3::Z * -5.0);
    let (mut scene, ids) = scene_of(&[&plate, &ball]);
    let params = CheckParams::new(0.0);
    let before = scene.check(&params, Progress::none()).unwrap();
    let report = scene
        .sweep(&[moved(ids[1], &within.positions)], &ccd::CcdParams::EXACT, Progress::none())
        .unwrap();
    scene.move_body(ids[1], &within.positions).unwrap();
    let after = scene.check(&params, Progress::none()).unwrap();
    assert!(report.largest_free_step < 1.0 && after[0].overlaps);
    assert_eq!(report.pass_throughs(&scene, &before, &after), []);
}

/// A state in which bodies touch shows the touch: only what is met between the states passes through.
#[test]
fn bodies_that_touch_in_a_state_do_not_pass_through() {
    let cube = shapes::cube(1.0);
    for (from, to, passes) in [
        (DVec3::X, 2.0 * DVec3::X, false),
        (2.0 * DVec3::X, DVec3::X, false),
        (DVec3::X, DVec3::X, false),
        (2.0 * DVec3::X, -2.0 * DVec3::X, true),
        (DVec3::X, -2.0 * DVec3::X, true),
        (DVec3::X, -DVec3::X, true),
    ] {
        let [start, end] = [from, to].map(|by| cube.clone().translated(by));
        let (mut scene, ids) = scene_of(&[&cube, &start]);
        let params = CheckParams::new(0.0);
        let before = scene.check(&params, Progress::none()).unwrap();
        let moves = [moved(ids[1], &end.positions)];
        let report = scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none()).unwrap();
        assert!(!report.pairs.is_empty(), "{from} to {to}");
        scene.move_body(ids[1], &end.positions).unwrap();
        let after = scene.check(&params, Progress::none()).unwrap();
        let through = report.pass_throughs(&scene, &before, &after);
        assert_eq!(!through.is_empty(), passes, "{from} to {to}: {through:?}");
    }
}

#[test]
fn contacts_satisfy_their_identity() {
    cases(3, 100, |u| {
        let [a, b, a1, b1] = two_bodies(u)?;
        let (mut scene, ids) = scene_of(&[&a, &b]);
        let moves = [moved(ids[0], &a1.positions), moved(ids[1], &b1.positions)];
        let report = scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none()).unwrap();
        let x0 = [&a.positions[..], &b.positions].concat();
        let x1 = [&a1.positions[..], &b1.positions].concat();
        for SweptContact { contact, .. } in report.pairs.iter().flat_map(|pair| &pair.contacts) {
            let time = contact.time.unwrap();
            let at = |k: u32| x0[k as usize].lerp(x1[k as usize], time);
            assert!(contact.identity_error(at) < 1e-12, "{contact:?}");
            assert!(contact.separation(at).length() < 1e-6, "{contact:?}");
            assert!((contact.normal.length() - 1.0).abs() < 1e-12);
        }
        Ok(())
    });
}

#[test]
fn moves_that_do_not_fit_are_rejected() {
    let ball = shapes::octasphere(3.0, 1);
    let (mut scene, ids) = scene_of(&[&ball]);
    let short = scene.sweep(
        &[moved(ids[0], &ball.positions[1..])],
        &ccd::CcdParams::EXACT,
        Progress::none(),
    );
    assert!(matches!(short, Err(SceneError::Surface { .. })), "{short:?}");
    let params = ccd::CcdParams { min_separation: -1.0, ..ccd::CcdParams::EXACT };
    let negative = scene.sweep(&[], &params, Progress::none());
    assert!(matches!(negative, Err(SceneError::Ccd(_))), "{negative:?}");
}
