//! Batches of candidates, compared with single queries.

use arbitrary::{Result, Unstructured};
use ccd::{CandidateContact, CcdError, CcdParams, FirstContact, MovingPoints};
use glam::DVec3;

use crate::random::{check, point};

/// Moving points, and candidates of four different ones each.
#[derive(Clone)]
struct Scene {
    x0: Vec<DVec3>,
    x1: Vec<DVec3>,
    candidates: Vec<[u32; 4]>,
}

/// Draws 24 moving points and `count` candidates.
fn scene(u: &mut Unstructured<'_>, count: usize) -> Result<Scene> {
    let (mut x0, mut x1, mut candidates) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..24 {
        x0.push(point(u, 1.0)?);
        x1.push(x0[x0.len() - 1] + point(u, 0.5)?);
    }
    for _ in 0..count {
        let first = u.int_in_range(0_u32..=23)?;
        let step = [1, 5, 7, 11][usize::from(u.int_in_range(0_u8..=3)?)];
        candidates.push(std::array::from_fn(|i| (first + step * [0, 1, 2, 3][i]) % 24));
    }
    Ok(Scene { x0, x1, candidates })
}

/// Finds the contacts of a scene by single queries.
fn single_queries(scene: &Scene, params: &CcdParams, edges: bool) -> Vec<CandidateContact> {
    let gather = |x: &[DVec3], points: &[u32; 4]| points.map(|point| x[point as usize]);
    let query = if edges { ccd::edge_edge } else { ccd::vertex_face };
    let each = scene.candidates.iter().enumerate().filter_map(|(candidate, points)| {
        let contact = query(gather(&scene.x0, points), gather(&scene.x1, points), params);
        contact.expect("valid").map(|contact| CandidateContact { candidate, contact })
    });
    each.collect()
}

#[test]
fn batches_equal_single_queries() {
    check(2000, |u| {
        let scene = scene(u, 37)?;
        let motion = MovingPoints::new(&scene.x0, &scene.x1).expect("valid");
        for (min_separation, t_max) in [(0.0, 1.0), (0.01, 1.0), (0.0, 0.3)] {
            let params = CcdParams { min_separation, t_max, ..CcdParams::DEFAULT };
            let found = motion.vertex_face_contacts(&scene.candidates, &params).expect("valid");
            assert_eq!(found, single_queries(&scene, &params, false));
            let found = motion.edge_edge_contacts(&scene.candidates, &params).expect("valid");
            assert_eq!(found, single_queries(&scene, &params, true));
        }
        Ok(())
    });
}

/// A vertex falls towards a face and is just beyond the separation at the last time of interest,
/// which a contact that is a little early precedes.
#[test]
fn batches_equal_single_queries_at_the_last_time() {
    check(5000, |u| {
        let share = |u: &mut Unstructured<'_>| Ok(f64::from(u.arbitrary::<u16>()?) / 65535.0);
        let (d, t_max, fall) = (0.1, 0.1 + 0.8 * share(u)?, 0.3 + share(u)?);
        let excess = 1.0 + 10.0_f64.powf(-15.0 + 5.0 * share(u)?);
        let start = d * excess + fall * t_max;
        let face = [point(u, 2.0)?, point(u, 2.0)?, point(u, 2.0)?].map(|x| x.with_z(0.0));
        let at = |height: f64| [height * DVec3::Z, face[0], face[1], face[2]];
        let (x0, x1) = (at(start).to_vec(), at(start - fall).to_vec());

        let scene = Scene { x0, x1, candidates: vec![[0, 1, 2, 3]] };
        let params = CcdParams { min_separation: d, t_max, ..CcdParams::DEFAULT };
        let motion = MovingPoints::new(&scene.x0, &scene.x1).expect("valid");
        let found = motion.vertex_face_contacts(&scene.candidates, &params).expect("valid");
        assert_eq!(found, single_queries(&scene, &params, false));
        Ok(())
    });
}

/// Points off their lines take room of their own: each candidate has the separation of its worst
/// corners, on either side.
#[test]
fn deviations_are_separations_of_each_candidate() {
    check(1000, |u| {
        let scene = scene(u, 37)?;
        let mut deviations = Vec::new();
        for _ in 0..scene.x0.len() {
            deviations.push(0.2 * f64::from(u.int_in_range(0_u8..=100)?) / 100.0);
        }
        let motion = MovingPoints::new(&scene.x0, &scene.x1).expect("valid");
        let motion = motion.with_deviations(&deviations).expect("valid");
        let params = CcdParams { min_separation: 0.01, ..CcdParams::DEFAULT };

        for edges in [false, true] {
            let found = match edges {
                true => motion.edge_edge_contacts(&scene.candidates, &params),
                false => motion.vertex_face_contacts(&scene.candidates, &params),
            };
            let found = found.expect("valid");
            let mut expected = Vec::new();
            for (candidate, points) in scene.candidates.iter().enumerate() {
                let [a, b, c, d] = points.map(|point| deviations[point as usize]);
                let room = if edges { a.max(b) + c.max(d) } else { a + b.max(c).max(d) };
                let min_separation = (0.01 + room) * (1.0 + 2.0 * f64::EPSILON);
                let alone = Scene { candidates: vec![*points], ..scene.clone() };
                let params = CcdParams { min_separation, ..params };
                for contact in single_queries(&alone, &params, edges) {
                    expected.push(CandidateContact { candidate, ..contact });
                }
            }
            assert_eq!(found, expected);
        }
        Ok(())
    });
    let x = [DVec3::ZERO];
    let motion = MovingPoints::new(&x, &x).expect("valid");
    assert!(motion.with_deviations(&[]).is_err() && motion.with_deviations(&[-1.0]).is_err());
}

#[test]
fn filters_keep_every_candidate_with_a_contact() {
    check(2000, |u| {
        let scene = scene(u, 37)?;
        let motion = MovingPoints::new(&scene.x0, &scene.x1).expect("valid");
        let params = CcdParams::DEFAULT;
        let kept = motion.filter_vertex_faces(&scene.candidates, &params).expect("valid");
        assert!(single_queries(&scene, &params, false).iter().all(|c| kept.contains(&c.candidate)));
        let kept = motion.filter_edge_edges(&scene.candidates, &params).expect("valid");
        assert!(single_queries(&scene, &params, true).iter().all(|c| kept.contains(&c.candidate)));
        Ok(())
    });
}

/// Returns the numbers of some queries that the filters keep, as vertices and faces or as edges.
fn kept(queries: &[[[DVec3; 4]; 2]], params: &CcdParams, edges: bool) -> Vec<usize> {
    let [x0, x1] =
        [0, 1].map(|end: usize| queries.iter().flat_map(|query| query[end]).collect::<Vec<_>>());
    let motion = MovingPoints::new(&x0, &x1).expect("valid");
    let count = u32::try_from(queries.len()).expect("few queries");
    let candidates: Vec<_> = (0..count).map(|k| [0, 1, 2, 3].map(|point| 4 * k + point)).collect();
    if edges {
        motion.filter_edge_edges(&candidates, params).expect("valid")
    } else {
        motion.filter_vertex_faces(&candidates, params).expect("valid")
    }
}

#[test]
fn filters_keep_edges_that_cross_within_a_plane() {
    check(4000, |u| {
        // Whole numbers: exactly in a plane through the origin, but products are rounded.
        let [i, j] = [point(u, 32768.0 * 30011.0)?, point(u, 32768.0 * 30011.0)?];
        let noise = [point(u, 32768.0)? / 128.0, point(u, 32768.0)? / 128.0].map(DVec3::round);
        let in_plane = |s: f64, t: f64| s.round() * i + t.round() * j;

        // An end passes from one side of the other edge to the other.
        let still = [in_plane(noise[0].x - 900.0, 0.0), in_plane(noise[0].y + 900.0, 0.0)];
        let tail = in_plane(noise[1].x, 2000.0 + noise[1].y);
        let start = [still[0], still[1], in_plane(noise[0].z, 900.0), tail];
        let end = [still[0], still[1], in_plane(noise[1].z, -900.0), tail + i];
        assert_eq!(kept(&[[start, end]], &CcdParams::DEFAULT, true), [0]);
        Ok(())
    });
}

#[test]
fn filters_keep_edges_within_a_separation_that_are_parallel_at_both_ends() {
    let near_queries = std::cell::Cell::new(0);
    check(4000, |u| {
        // At the end nearly parallel as at the start, since one edge turns the other way.
        let ([e0, e1], at) = ([point(u, 8.0)?, point(u, 8.0)?], point(u, 4.0)?);
        let [f0, f1] = [point(u, 0.5)? + e0, point(u, 0.5)? - e1];
        let query = [[-e0, e0, at - f0, at + f0], [-e1, e1, at - f1, at + f1]];

        // Points of both are sampled on the way.
        let is_near = (0..16 * 17 * 17).any(|k| {
            let [s, t, time] = [k % 17, k / 17 % 17, k / 289].map(|k| f64::from(k) / 16.0);
            let [a, b, c, d] = [0, 1, 2, 3].map(|i: usize| query[0][i].lerp(query[1][i], time));
            a.lerp(b, s).distance(c.lerp(d, t)) < 1.0
        });
        if is_near {
            near_queries.set(near_queries.get() + 1);
            let params = CcdParams { min_separation: 1.0, ..CcdParams::DEFAULT };
            assert_eq!(kept(&[query], &params, true), [0]);
        }
        Ok(())
    });
    assert!(near_queries.get() > 100, "{}", near_queries.get());
}

#[test]
fn filters_keep_what_touches_at_the_end_of_the_step() {
    let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut queries = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let turned = |p: DVec3| side * DVec3::from_array([0, 1, 2].map(|k| p[(k + axis) % 3]));
            let [a, b, c] = face.map(turned);
            let (above, below) = (DVec3::new(0.25, 0.25, 1.0), DVec3::new(0.25, 0.25, 0.0));
            queries.push([[turned(above), a, b, c], [turned(below), a, b, c]]);
        }
    }
    assert_eq!(kept(&queries, &CcdParams::DEFAULT, false), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn the_first_contact_is_the_earliest_of_all() {
    check(2000, |u| {
        let (faces, edges) = (scene(u, 30)?, scene(u, 30)?.candidates);
        let motion = MovingPoints::new(&faces.x0, &faces.x1).expect("valid");
        let params = CcdParams::DEFAULT;
        let first = motion.first_contact(&faces.candidates, &edges, &params).expect("valid");
        let by_time =
            |a: &CandidateContact, b: &CandidateContact| a.contact.lo.total_cmp(&b.contact.lo);
        let face = single_queries(&faces, &params, false).into_iter().min_by(by_time);
        let edge = single_queries(&Scene { candidates: edges, ..faces }, &params, true);
        let edge = edge.into_iter().min_by(by_time);
        let edge = edge.filter(|e| face.is_none_or(|f| e.contact.lo < f.contact.lo));
        let expected = edge.map(FirstContact::EdgeEdge).or(face.map(FirstContact::VertexFace));
        assert_eq!(first, expected);
        Ok(())
    });
}

#[test]
fn candidates_out_of_range_are_refused() {
    let x = [DVec3::ZERO; 4];
    let motion = MovingPoints::new(&x, &x).unwrap();
    let refused = motion.edge_edge_contacts(&[[0, 1, 2, 3], [0, 1, 9, 3]], &CcdParams::DEFAULT);
    assert_eq!(refused, Err(CcdError::PointOutOfRange { candidate: 1, point: 9, count: 4 }));
    let uneven = MovingPoints::new(&x, &x[1..]).map(|_| ());
    assert_eq!(uneven, Err(CcdError::PositionCount { start: 4, end: 3 }));
}

#[cfg(feature = "rayon")]
#[test]
fn results_are_the_same_for_any_number_of_threads() {
    let mut state = 1_u64;
    let mut byte = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        u8::try_from(state >> 56).expect("eight bits are left")
    };
    let bytes: Vec<u8> = (0..40_000).map(|_| byte()).collect();
    let scene = scene(&mut Unstructured::new(&bytes), 5000).expect("enough bytes");
    let motion = MovingPoints::new(&scene.x0, &scene.x1).expect("valid");
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let params = CcdParams::DEFAULT;
        pool.install(|| {
            let first = motion.first_contact(&scene.candidates, &scene.candidates, &params);
            (motion.vertex_face_contacts(&scene.candidates, &params), first)
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(7));
}
