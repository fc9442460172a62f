//! Range of coordinates: refusals beyond it, and exact answers at its ends.

use arbitrary::Unstructured;
use fixtures::generate::cases;
use surface::glam::{DVec3, dvec3};
use surface::{MAX_COORDINATE, MIN_SIZE, Meeting, SurfaceError, TriangleSurface, triangles_meet};

const FACE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

/// Returns the error of positions, after checking that all three doors refuse alike.
fn refusal(x: &[DVec3; 3]) -> Option<String> {
    let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a triangle");
    let refused = surface.positions(x).err().map(|error| error.to_string());
    let owned = surface.own_positions(x.to_vec()).err().map(|error| error.to_string());
    assert_eq!(refused, owned, "owned positions");

    // A buffer keeps its positions where it refuses new ones.
    let mut buffer = surface.own_positions(FACE.to_vec()).expect("in range");
    let overwritten = buffer.overwrite(x.iter().copied()).err().map(|error| error.to_string());
    assert_eq!(refused, overwritten, "overwritten positions");
    let kept = if refused.is_some() { &FACE } else { x };
    assert_eq!(buffer.as_positions().as_slice(), kept, "all or none is written");
    refused
}

#[test]
fn coordinates_out_of_range_are_refused_by_vertex_and_value() {
    let large = |value: &str| {
        format!(
            "vertex 1 has the coordinate {value}, but magnitudes end at 1e30: products of \
             coordinates would overflow"
        )
    };
    let small = "the largest coordinate is 2e-91, but must reach 1e-90, or be 0: products of \
                 coordinates would vanish";
    let cases = [
        (dvec3(1.0, MAX_COORDINATE, -MAX_COORDINATE), None),
        (dvec3(1.0, MAX_COORDINATE.next_up(), 0.0), Some(large("1.0000000000000002e30"))),
        (dvec3(-1e110, 1e40, 0.0), Some(large("-1e110"))),
        (dvec3(1.0, f64::NAN, 1e110), Some("vertex 1 is at (1, NaN, 1".to_owned())),
        (dvec3(1.0, f64::NEG_INFINITY, 0.0), Some("vertex 1 is at (1, -inf, 0)".to_owned())),
    ];
    for (corner, expected) in cases {
        let refused = refusal(&[DVec3::ZERO, corner, DVec3::Y]);
        assert_eq!(refused.is_some(), expected.is_some(), "{corner}");
        let start = expected.unwrap_or_default();
        assert!(refused.as_deref().unwrap_or_default().starts_with(&start), "{refused:?}");
    }

    assert_eq!(
        refusal(&[DVec3::ZERO, DVec3::X * 2e-91, DVec3::Y * -1e-91]).as_deref(),
        Some(small)
    );
    assert_eq!(refusal(&[DVec3::ZERO, DVec3::X * MIN_SIZE, DVec3::Y * 1e-300]), None);
    assert_eq!(refusal(&[DVec3::ZERO; 3]), None, "a surface that is a point");
}

#[test]
fn the_first_vertex_out_of_range_is_named() {
    let surface = TriangleSurface::new(3, vec![[0, 1, 2]]).expect("a triangle");
    let refused = surface.positions(&[DVec3::ZERO, DVec3::X * 1e31, DVec3::NAN]).unwrap_err();
    assert_eq!(refused, SurfaceError::TooLarge { vertex: 1, value: 1e31 });
}

/// Draws a triangle of whole-number corners, each moved by an ulp of 1 at most.
fn triangle(u: &mut Unstructured<'_>) -> arbitrary::Result<[DVec3; 3]> {
    let mut coordinate = || {
        let whole = f64::from(u.int_in_range(-3..=3_i32)?);
        Ok(whole + f64::from(u.int_in_range(-1..=1_i32)?) * f64::EPSILON)
    };
    let mut corner = || Ok(dvec3(coordinate()?, coordinate()?, coordinate()?));
    Ok([corner()?, corner()?, corner()?])
}

/// At both ends of the range the answers are those of the middle, where tests compare them with
/// rational arithmetic: 4 · 2^97 is just below 1e30, and 2^-298 above 1e-90.
#[test]
fn answers_are_exact_at_both_ends_of_the_range() {
    cases(21, 1000, |u| {
        let (a, b) = (triangle(u)?, triangle(u)?);
        let expected = triangles_meet(a, b);
        for exponent in [97, -298] {
            let scaled = |t: [DVec3; 3]| t.map(|p| p * 2_f64.powi(exponent));
            assert_eq!(triangles_meet(scaled(a), scaled(b)), expected, "2^{exponent}: {a:?} {b:?}");
        }
        Ok(())
    });
}

/// A spike pierces a face by less and less: the crossing is found down to heights of 1e-290, and
/// below may count as a touch.
#[test]
fn coordinates_that_are_nearly_zero_stay_exact_above_the_underflow() {
    let face = [dvec3(-0.7, -0.6, 0.0), dvec3(0.9, -0.5, 0.0), dvec3(0.1, 0.8, 0.0)];
    let spike = |depth: f64| [dvec3(0.1, 0.2, -depth), dvec3(0.0, 0.1, 1.0), dvec3(0.2, 0.1, 1.0)];
    for depth in [1e-16, 1e-90, 1e-200, 1e-290] {
        assert_eq!(triangles_meet(face, spike(depth)), Meeting::Crossing, "{depth:e}");
        assert_eq!(triangles_meet(face, spike(-depth)), Meeting::Disjoint, "{depth:e}");
    }
    for depth in [1e-310, 5e-324] {
        assert_ne!(triangles_meet(face, spike(depth)), Meeting::Disjoint, "{depth:e}");
    }
}
