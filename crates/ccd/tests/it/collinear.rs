//! Faces whose corners are in line up to rounding: their area vectors are rounding alone.

use arbitrary::{Result, Unstructured};
use ccd::{CcdContact, CcdParams, vertex_face};
use glam::DVec3;

use crate::random::check;

/// Scales by which whole numbers become rounded ones, and one of tiny lengths.
const SCALES: [f64; 6] = [0.1, 0.3, 1.0 / 3.0, 0.7, 1e-3, 1e-150];

/// Separations, relative to the distance.
const SHARES: [f64; 7] = [0.6, 0.75, 0.9, 0.999, 1.001, 1.1, 1.5];

/// Returns the contact of points that move by one displacement.
fn contact(x: [DVec3; 4], moved: DVec3, d: f64) -> Option<CcdContact> {
    let params = CcdParams { min_separation: d, ..CcdParams::DEFAULT };
    vertex_face(x, x.map(|x| x + moved), &params).expect("the points are finite")
}

/// Returns the length of the weighted points.
fn weighted_length(contact: &CcdContact, x: [DVec3; 4]) -> f64 {
    // Relative to one of the points, as weights sum to zero only up to rounding.
    (1..4).map(|k| contact.weights[k] * (x[k] - x[0])).sum::<DVec3>().length()
}

/// Computes the distance of a point from the segment that contains points in line.
fn distance(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let ends = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| [corners[i], corners[j]]);
    let longest =
        |a: &[DVec3; 2], b: &[DVec3; 2]| a[0].distance(a[1]).total_cmp(&b[0].distance(b[1]));
    let [a, b] = ends.into_iter().max_by(longest).expect("three edges");
    let along = b - a;
    if along == DVec3::ZERO {
        return p.distance(a);
    }
    let size = along.abs().max_element();
    let unit = (along / size).normalize();
    let t = (p - a).dot(unit).clamp(0.0, size * (along / size).length());
    let offset = p - a - t * unit;
    let size = offset.abs().max_element();
    if size > 0.0 { size * (offset / size).length() } else { 0.0 }
}

#[test]
fn a_face_in_line_that_stays_away_is_no_contact() {
    let whole = [[5.0, 8.5, 8.0], [-1.0, 4.0, 2.0], [3.0, 8.0, 6.0], [-3.0, 2.0, 0.0]];
    let x = whole.map(|x| 0.3 * DVec3::from_array(x));
    let far = distance(x[0], [x[1], x[2], x[3]]);
    assert!((far - 0.86168).abs() < 1e-5, "{far}");
    assert_eq!(contact(x, DVec3::ZERO, 0.646_263_3), None);

    let near = contact(x, DVec3::ZERO, 0.87).expect("it is within the separation");
    let length = weighted_length(&near, x);
    assert!(near.is_certain() && length <= 0.87, "{length} for {near:?}");
}

/// Draws a vertex and a face in line, of whole numbers times a scale, and a displacement.
fn query(u: &mut Unstructured<'_>) -> Result<([DVec3; 4], DVec3)> {
    let mut whole = |size: i32| Ok(f64::from(u.int_in_range(-size..=size)?));
    let mut point = || Ok(DVec3::new(whole(4)?, whole(4)?, whole(4)?));
    let (from, along, aside, moved) = (point()?, point()?, 0.5 * point()?, 0.3 * point()?);
    let mut on_line = |size: i32| Ok(from + along * f64::from(u.int_in_range(-size..=size)?));
    let x = [on_line(4)? + aside, on_line(3)?, on_line(3)?, on_line(3)?];
    let scale = *u.choose(&SCALES)?;
    Ok((x.map(|x| x * scale), moved * scale))
}

#[test]
fn contacts_of_faces_in_line_are_as_near_as_they_are_said_to_be() {
    check(4000, |u| {
        let (x, moved) = query(u)?;
        let far = distance(x[0], [x[1], x[2], x[3]]);
        let size = x.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
        if far < 1e-9 * size {
            return Ok(());
        }
        for share in SHARES {
            let d = share * far;
            let found = contact(x, moved, d);
            assert_eq!(found.is_some(), share > 1.0, "{d:e} of {far:e} for {x:?}: {found:?}");
            if let Some(found) = found {
                let length = weighted_length(&found, x.map(|x| x / far)) * far;
                assert!(found.is_certain() && length <= d, "{length:e} above {d:e} for {x:?}");
            }
        }
        Ok(())
    });
}
