//! Exact decisions on queries whose roots are far closer than rounding: whole-number corners, each
//! moved by an ulp at most.

use std::cell::Cell;

use arbitrary::{Result, Unstructured};
use ccd::{CcdContact, CcdError, CcdParams, Certainty, edge_edge, vertex_face};
use glam::{DVec3, DVec4};

use crate::random::check;

type Answer = std::result::Result<Option<CcdContact>, CcdError>;
type Query = fn([DVec3; 4], [DVec3; 4], &CcdParams) -> Answer;

/// Distance by which zero is moved.
#[derive(Clone, Copy, PartialEq)]
enum ZeroStep {
    /// The ulp of numbers below 1.
    Ulp,
    /// The smallest number: coordinates then span more than a thousand binary digits.
    Smallest,
}

/// Draws a whole number, or one of the two numbers next to it.
fn nudged(u: &mut Unstructured<'_>, size: i32, step: ZeroStep) -> Result<f64> {
    let whole = f64::from(u.int_in_range(-size..=size)?);
    let direction = f64::from(u.int_in_range(-1..=1)?);
    if whole == 0.0 && step == ZeroStep::Ulp {
        return Ok(direction * f64::EPSILON / 2.0);
    }
    Ok(if direction > 0.0 {
        whole.next_up()
    } else if direction < 0.0 {
        whole.next_down()
    } else {
        whole
    })
}

fn points(u: &mut Unstructured<'_>, size: i32, step: ZeroStep) -> Result<[DVec3; 4]> {
    let mut x = [DVec3::ZERO; 4];
    for p in &mut x {
        *p = DVec3::new(nudged(u, size, step)?, nudged(u, size, step)?, nudged(u, size, step)?);
    }
    Ok(x)
}

/// Runs a query, and checks that its answer is certain.
fn decided(query: Query, x0: [DVec3; 4], x1: [DVec3; 4]) -> Option<CcdContact> {
    let contact = query(x0, x1, &CcdParams::EXACT).expect("the points are finite");
    let certainty = contact.map(|contact| contact.certainty);
    assert_ne!(certainty, Some(Certainty::Possible), "{x0:?} {x1:?}");
    contact
}

/// Checks random queries: every answer is certain, and the same for other orders of the corners,
/// whose polynomials differ, and for the motion backward. Returns the number of contacts.
fn every_query_is_decided(count: u64, size: i32, step: ZeroStep) -> usize {
    let contacts = Cell::new(0);
    check(count, |u| {
        let (x0, x1) = (points(u, size, step)?, points(u, size, step)?);
        let turned = |x: [DVec3; 4]| [x[0], x[2], x[3], x[1]];
        let swapped = |x: [DVec3; 4]| [x[3], x[2], x[0], x[1]];
        let orders: [(Query, _); 2] =
            [(vertex_face, [turned(x0), turned(x1)]), (edge_edge, [swapped(x0), swapped(x1)])];

        for (query, [y0, y1]) in orders {
            let (one, other) = (decided(query, x0, x1), decided(query, y0, y1));
            assert_eq!(one.is_some(), other.is_some(), "{x0:?} {x1:?}");
            assert_eq!(one.is_some(), decided(query, x1, x0).is_some(), "{x0:?} {x1:?}");
            if let (Some(one), Some(other)) = (one, other) {
                assert!(one.lo <= other.hi && other.lo <= one.hi, "{one:?} against {other:?}");
                contacts.set(contacts.get() + 1);
            }
        }
        Ok(())
    });
    contacts.get()
}

#[test]
fn lattices_moved_by_an_ulp_are_decided() {
    for size in 1..=4 {
        assert!(every_query_is_decided(10_000, size, ZeroStep::Ulp) > 1000);
    }
}

#[test]
fn coordinates_of_a_thousand_digits_are_decided() {
    assert!(every_query_is_decided(1000, 2, ZeroStep::Smallest) > 100);
}

/// Queries that meet at times whose roots are closer than 2^-120 of the step to others; in the
/// second, the edges pass within 1e-48 of each other's ends. Times are from interval arithmetic of
/// 400 digits.
#[test]
fn roots_closer_than_the_resolution_are_told_apart() {
    const P: f64 = 1.0 + f64::EPSILON;
    const M: f64 = 1.0 - f64::EPSILON / 2.0;
    const D: f64 = f64::EPSILON / 2.0;
    let cases: [(Query, [[f64; 3]; 8], f64); 3] = [
        (
            vertex_face,
            [
                [-M, 0.0, -M],
                [P, -D, -M],
                [-P, -1.0, M],
                [-P, D, P],
                [-M, 0.0, M],
                [M, D, M],
                [-1.0, D, -P],
                [-1.0, D, -P],
            ],
            0.5,
        ),
        (
            edge_edge,
            [
                [-1.0, -P, M],
                [P, D, M],
                [P, -M, -P],
                [-M, 0.0, 0.0],
                [P, -1.0, M],
                [-1.0, D, -1.0],
                [-1.0, 1.0, P],
                [0.0, 1.0, D],
            ],
            0.5,
        ),
        (
            edge_edge,
            [
                [D, 0.0, -M],
                [-M, -1.0, -D],
                [D, -1.0, -M],
                [-D, -P, 0.0],
                [-1.0, M, M],
                [D, P, D],
                [-1.0, 1.0, 1.0],
                [-M, P, D],
            ],
            M,
        ),
    ];

    for (query, case, time) in cases {
        let [a, b, c, d, x1 @ ..] = case.map(DVec3::from_array);
        let x0 = [a, b, c, d];
        let rounded = query(x0, x1, &CcdParams::DEFAULT).expect("the points are finite");
        assert_eq!(rounded.map(|contact| contact.certainty), Some(Certainty::Possible));
        let contact = decided(query, x0, x1).expect("they meet");
        assert!((contact.lo - time).abs() < 1e-15, "{contact:?}");
    }
}

/// Computes the weighted points of a contact at a time: the second primitive minus the first.
fn weighted(contact: &CcdContact, [x0, x1]: [[DVec3; 4]; 2], t: f64) -> DVec3 {
    (0..4).map(|k| contact.weights[k] * (x0[k] * (1.0 - t) + x1[k] * t)).sum()
}

#[test]
fn weights_are_those_at_the_time_that_is_decided() {
    let x0 = [[-1.0, 0.0], [-1.0, -1.0], [1.0, 1.0], [1.0, 1.0]];
    let x1 = [[-1.0, -1.0], [1.0, 0.0], [-1.0, -1.0], [0.0, 1.0]];
    let [x0, x1] = [x0, x1].map(|x| x.map(|[x, y]| DVec3::new(x, y, 0.0)));
    let contact = decided(edge_edge, x0, x1).expect("points 0 and 2 meet at the end");
    assert_eq!((contact.lo, contact.hi), (1.0, 1.0), "{contact:?}");
    let of_points = DVec4::new(-1.0, 0.0, 1.0, 0.0);
    assert_eq!(DVec4::from_array(contact.weights), of_points);

    // The normal is that just before, when point 2 slides onto the end of the first edge, which lies
    // along (2, 1).
    let before = DVec3::new(1.0, -2.0, 0.0) / 5.0_f64.sqrt();
    assert!(contact.normal.distance(before) < 1e-3, "{}", contact.normal);
}

/// Draws four points of whole coordinates in a plane.
fn plane_points(u: &mut Unstructured<'_>, size: i32) -> Result<[DVec3; 4]> {
    let mut x = [DVec3::ZERO; 4];
    for p in &mut x {
        let mut whole = || Ok(f64::from(u.int_in_range(-size..=size)?));
        *p = DVec3::new(whole()?, whole()?, 0.0);
    }
    Ok(x)
}

#[test]
fn weighted_points_of_decided_contacts_coincide() {
    let contacts = Cell::new(0);
    check(4000, |u| {
        let size = u.int_in_range(1..=4)?;
        let x = [plane_points(u, size)?, plane_points(u, size)?];
        for query in [vertex_face as Query, edge_edge] {
            let Some(contact) = decided(query, x[0], x[1]) else { continue };
            contacts.set(contacts.get() + 1);
            let apart = weighted(&contact, x, contact.lo).length();
            assert!(apart < 1e-13, "{apart:e} at {contact:?} of {x:?}");
            assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        }
        Ok(())
    });
    assert!(contacts.get() > 1000, "{} contacts", contacts.get());
}
