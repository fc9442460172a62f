//! Single queries, compared with planted impacts, integer arithmetic and closed forms.

#![expect(clippy::panic, reason = "a miss says what was missed")]

use arbitrary::{Result, Unstructured};
use ccd::{CcdContact, CcdError, CcdParams, Certainty, StepEnd, edge_edge, vertex_face};
use glam::DVec3;

use crate::random::check;

type Query =
    fn([DVec3; 4], [DVec3; 4], &CcdParams) -> std::result::Result<Option<CcdContact>, CcdError>;
type Integers = [[i64; 3]; 4];

/// Runs a query on finite points.
fn run(query: Query, x0: [DVec3; 4], x1: [DVec3; 4]) -> Option<CcdContact> {
    query(x0, x1, &CcdParams::DEFAULT).expect("the points are finite")
}

fn reals(x: &Integers) -> [DVec3; 4] {
    #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
    x.map(|p| DVec3::from_array(p.map(|c| c as f64)))
}

fn lattice_point(u: &mut Unstructured<'_>, size: i64) -> Result<[i64; 3]> {
    Ok([
        u.int_in_range(-size..=size)?,
        u.int_in_range(-size..=size)?,
        u.int_in_range(-size..=size)?,
    ])
}

/// Draws points that touch, in `(corner 0) + r/8 edge + s/8 edge` of a polygon.
fn touching(u: &mut Unstructured<'_>, edges: bool) -> Result<Integers> {
    let (a, b, c) = (lattice_point(u, 6)?, lattice_point(u, 6)?, lattice_point(u, 6)?);
    let r = u.int_in_range(0_i64..=8)?;
    let s = u.int_in_range(0_i64..=if edges { 8 } else { 8 - r })?;
    let mut x = [[0; 3]; 4];
    for k in 0..3 {
        if edges {
            // A point of edge (a, b) is one of edge (p, q) with q as chosen.
            let meet = 8 * a[k] + r * (b[k] - a[k]);
            let away = c[k];
            x[0][k] = 8 * a[k];
            x[1][k] = 8 * b[k];
            x[2][k] = meet - s * away;
            x[3][k] = meet + (8 - s) * away;
        } else {
            x[0][k] = 8 * a[k] + r * (b[k] - a[k]) + s * (c[k] - a[k]);
            x[1][k] = 8 * a[k];
            x[2][k] = 8 * b[k];
            x[3][k] = 8 * c[k];
        }
    }
    Ok(x)
}

/// Draws a step on which a touch is planted at time `n / 4`, exactly.
fn planted(u: &mut Unstructured<'_>, edges: bool) -> Result<([DVec3; 4], [DVec3; 4], f64)> {
    let x = touching(u, edges)?;
    let n = u.int_in_range(0_i64..=4)?;
    let (mut x0, mut x1) = (x, x);
    for i in 0..4 {
        let v = lattice_point(u, 12)?;
        for k in 0..3 {
            x0[i][k] -= n * v[k];
            x1[i][k] += (4 - n) * v[k];
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "0 to 4")]
    Ok((reals(&x0), reals(&x1), n as f64 / 4.0))
}

/// Checks that planted touches are neither missed nor reported late.
fn planted_impacts_are_found(query: Query, edges: bool) {
    check(100_000, |u| {
        let (x0, x1, time) = planted(u, edges)?;
        let contact =
            run(query, x0, x1).unwrap_or_else(|| panic!("missed {x0:?} {x1:?} at {time}"));
        assert!(contact.lo <= time, "{} is after {time}: {x0:?} {x1:?}", contact.lo);
        assert!(contact.lo <= contact.hi, "{contact:?}");
        assert!(contact.lo > 0.0 || contact.at_start, "apart at the start: {contact:?}");
        if contact.is_certain() {
            // Points are within 200 of each other; a triple root has a long interval.
            let max = 1e-9 + 400.0 * (contact.hi - contact.lo);
            assert!(gap(&contact, &x0, &x1) < max, "weights do not meet: {contact:?}");
        }
        assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        Ok(())
    });
}

/// Computes `|sum weights_i x_i|` in the middle of the interval of contact.
fn gap(contact: &CcdContact, x0: &[DVec3; 4], x1: &[DVec3; 4]) -> f64 {
    let t = 0.5 * (contact.lo + contact.hi);
    assert!(contact.weights.iter().sum::<f64>().abs() < 1e-12, "{contact:?}");
    (0..4).map(|i| contact.weights[i] * (x0[i] * (1.0 - t) + x1[i] * t)).sum::<DVec3>().length()
}

#[test]
fn planted_vertex_face_impacts_are_found_in_time() {
    planted_impacts_are_found(vertex_face, false);
}

#[test]
fn planted_edge_edge_impacts_are_found_in_time() {
    planted_impacts_are_found(edge_edge, true);
}

/// Returns true if the polygon of differences contains the origin: the reference implementation in
/// integers, for points at rest.
fn touch(x: &[[i128; 3]; 4], edges: bool) -> bool {
    let minus = |a: [i128; 3], b: [i128; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [i128; 3], b: [i128; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [i128; 3], b: [i128; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let corners = if edges {
        vec![minus(x[2], x[0]), minus(x[3], x[0]), minus(x[3], x[1]), minus(x[2], x[1])]
    } else {
        vec![minus(x[1], x[0]), minus(x[2], x[0]), minus(x[3], x[0])]
    };
    let count = corners.len();
    let area = cross(minus(corners[1], corners[0]), minus(corners[count - 1], corners[0]));
    let pairs = || (0..count).map(|i| (corners[i], corners[(i + 1) % count]));
    if area == [0; 3] {
        return pairs().any(|(a, b)| cross(a, b) == [0; 3] && dot(a, b) <= 0);
    }
    dot(area, corners[0]) == 0 && pairs().all(|(a, b)| dot(area, cross(a, b)) >= 0)
}

/// Checks that contacts at multiples of 1/24 of the step are found.
fn integer_contacts_are_found(query: Query, edges: bool) {
    check(100_000, |u| {
        let [x0, x1]: [Integers; 2] = [
            [
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
            ],
            [
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
                lattice_point(u, 3)?,
            ],
        ];
        let first = (0..=24).find(|n| {
            let at = |i: usize, k: usize| i128::from(x0[i][k] * (24 - n) + x1[i][k] * n);
            touch(&std::array::from_fn(|i| std::array::from_fn(|k| at(i, k))), edges)
        });
        if let Some(n) = first {
            let contact = run(query, reals(&x0), reals(&x1));
            #[expect(clippy::cast_precision_loss, reason = "0 to 24")]
            let time = n as f64 / 24.0;
            let lo = contact.unwrap_or_else(|| panic!("missed {x0:?} {x1:?} at {time}")).lo;
            assert!(lo <= time, "{lo} is after {time}: {x0:?} {x1:?}");
        }
        Ok(())
    });
}

#[test]
fn vertex_face_contacts_in_integers_are_found() {
    integer_contacts_are_found(vertex_face, false);
}

#[test]
fn edge_edge_contacts_in_integers_are_found() {
    integer_contacts_are_found(edge_edge, true);
}

const FACE: [DVec3; 3] = [DVec3::new(-2.0, -1.0, 0.0), DVec3::new(2.0, -1.0, 0.0), DVec3::Y];

fn over_face(height: f64) -> [DVec3; 4] {
    [DVec3::Z * height, FACE[0], FACE[1], FACE[2]]
}

#[test]
fn a_contact_at_the_start_is_marked() {
    let contact = run(vertex_face, over_face(0.0), over_face(1.0)).expect("it starts on the face");
    assert_eq!((contact.lo, contact.at_start), (0.0, true));
    let contact = run(vertex_face, over_face(1e-9), over_face(-1.0)).expect("it falls through");
    assert!(!contact.at_start && contact.lo <= 1e-9, "{contact:?}");
}

#[test]
fn contacts_after_t_max_are_left_out() {
    let early = |t_max| CcdParams { t_max, ..CcdParams::DEFAULT };
    let ask = |t_max| vertex_face(over_face(1.0), over_face(-1.0), &early(t_max)).unwrap();
    assert_eq!(ask(0.499), None);
    assert!(ask(0.501).expect("0.5 is before").is_certain());
}

/// A vertex that falls onto a face reaches the separation at a time in closed form.
#[test]
fn a_separation_is_reached_on_time() {
    for d in [1e-2, 1e-3, 1e-6] {
        let params = CcdParams { min_separation: d, ..CcdParams::DEFAULT };
        let miss = vertex_face(over_face(1.0), over_face(d * (1.0 + 1e-9)), &params).unwrap();
        assert_eq!(miss, None, "{d} is not reached");
        let contact = vertex_face(over_face(1.0), over_face(-1.0), &params).unwrap().unwrap();
        let time = 0.5 * (1.0 - d);
        assert_eq!(contact.certainty, Certainty::Certain, "{d}: {contact:?}");
        assert!(contact.lo <= time && time - contact.lo <= 1e-6 * d + 1e-15, "{d}: {contact:?}");
        assert!(contact.normal.distance(DVec3::Z) < 1e-12, "{contact:?}");
    }
}

#[test]
fn scaling_by_powers_of_two_changes_no_bit() {
    check(20_000, |u| {
        let (x0, x1, _) = planted(u, true)?;
        for query in [vertex_face as Query, edge_edge] {
            let plain = run(query, x0, x1);
            for exponent in [-900, -40, 30, 900] {
                let by = |x: [DVec3; 4]| x.map(|p| p * 2_f64.powi(exponent));
                assert_eq!(run(query, by(x0), by(x1)), plain, "times 2^{exponent}: {x0:?} {x1:?}");
            }
        }
        Ok(())
    });
}

#[test]
fn an_offset_of_a_million_edges_misses_nothing() {
    check(20_000, |u| {
        for edges in [false, true] {
            let (x0, x1, time) = planted(u, edges)?;
            let by = |x: [DVec3; 4]| x.map(|p| p + DVec3::new(3e6, -1e7, 5e6));
            let query: Query = if edges { edge_edge } else { vertex_face };
            let contact = run(query, by(x0), by(x1)).expect("integers are moved exactly");
            assert!(contact.lo <= time, "{contact:?} is after {time}");
        }
        Ok(())
    });
}

/// Rotating the corners of a face, or exchanging the ends of an edge, changes no certain answer.
#[test]
fn the_order_of_corners_changes_no_certain_answer() {
    check(20_000, |u| {
        let (x0, x1, _) = planted(u, false)?;
        let turned = |x: [DVec3; 4]| [x[0], x[2], x[3], x[1]];
        let swapped = |x: [DVec3; 4]| [x[1], x[0], x[2], x[3]];
        let pairs: [(Query, _); 2] =
            [(vertex_face, (turned(x0), turned(x1))), (edge_edge, (swapped(x0), swapped(x1)))];
        for (query, (y0, y1)) in pairs {
            let (a, b) = (run(query, x0, x1), run(query, y0, y1));
            for (one, other) in [(a, b), (b, a)] {
                if let Some(one) = one.filter(CcdContact::is_certain) {
                    let other = other.expect("a certain contact has no other answer");
                    assert!(other.lo <= one.hi, "{one:?} against {other:?}");
                }
            }
        }
        Ok(())
    });
}

#[test]
fn coordinates_that_are_not_finite_are_rejected() {
    let mut x = over_face(-1.0);
    x[2].y = f64::NAN;
    let rejected = vertex_face(over_face(1.0), x, &CcdParams::DEFAULT);
    assert!(
        matches!(rejected, Err(CcdError::NotFinite { point: 2, end: StepEnd::Finish, value }) if value.is_nan()),
        "{rejected:?}"
    );
    x[2].y = f64::NEG_INFINITY;
    let error = edge_edge(x, over_face(1.0), &CcdParams::DEFAULT).unwrap_err();
    let expected = CcdError::NotFinite { point: 2, end: StepEnd::Start, value: f64::NEG_INFINITY };
    assert_eq!(error, expected);
    assert_eq!(error.to_string(), "point 2 at the start of the step is not finite: -inf");
}

#[test]
fn parameters_out_of_range_are_rejected() {
    let with = |params| vertex_face(over_face(1.0), over_face(0.0), &params).unwrap_err();
    let d = CcdParams { min_separation: -1.0, ..CcdParams::DEFAULT };
    assert_eq!(with(d), CcdError::MinSeparation(-1.0));
    assert_eq!(with(CcdParams { t_max: 1.5, ..CcdParams::DEFAULT }), CcdError::TimeMax(1.5));
}

/// Queries of the largest and the smallest numbers of f64.
#[test]
fn no_size_overflows_or_underflows() {
    for size in [f64::MAX, f64::MAX / 8.0, 1e-300, f64::MIN_POSITIVE, 64.0 * 5e-324] {
        let by = |x: [DVec3; 4]| x.map(|p| p * (0.5 * size));
        let contact = run(vertex_face, by(over_face(1.0)), by(over_face(-1.0)));
        let contact = contact.unwrap_or_else(|| panic!("missed at size {size:e}"));
        assert!((contact.lo..=contact.hi).contains(&0.5), "size {size:e}: {contact:?}");
        assert_eq!(run(vertex_face, by(over_face(1.0)), by(over_face(0.25))), None, "{size:e}");
    }
}
