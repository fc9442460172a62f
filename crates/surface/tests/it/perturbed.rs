//! Crossings of triangles of which one is moved by an infinitesimal, beside those of triangles that
//! are moved by a small number.
//!
//! On a small grid every sign that a crossing depends on is that of an integer, and the move by
//! which ties are settled is one by these powers of two, which coordinates hold exactly.

use arbitrary::{Result, Unstructured};
use fixtures::generate::cases;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use surface::glam::DVec3;
use surface::{
    Meeting, PerturbedMeeting, Stretch, StretchEnd, meet_perturbed, passing_share,
    segment_meets_triangle, triangles_meet,
};

use crate::support::Exact;

/// How far the first triangle is moved.
fn small_move() -> DVec3 {
    DVec3::new(2.0_f64.powi(-16), 2.0_f64.powi(-32), 2.0_f64.powi(-48))
}

fn grid_triangle(u: &mut Unstructured<'_>) -> Result<[DVec3; 3]> {
    let mut x = || Ok(f64::from(u.int_in_range(0_i8..=3)?));
    let mut corner = || Ok(DVec3::new(x()?, x()?, x()?));
    Ok([corner()?, corner()?, corner()?])
}

fn edge(corners: [DVec3; 3], k: usize) -> [DVec3; 2] {
    [corners[k], corners[(k + 1) % 3]]
}

/// Six times the volume of the tetrahedron between a triangle and a point in front of it.
fn height([a, b, c]: [DVec3; 3], p: DVec3) -> BigRational {
    let [a, b, c, p] = [a, b, c, p].map(Exact::new);
    b.sub(&a).cross(&c.sub(&a)).dot(&p.sub(&a))
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns the point at which an edge passes through the plane of the other triangle.
fn place(end: StretchEnd, triangles: [[DVec3; 3]; 2]) -> Exact {
    let (edge, other) = (edge(triangles[end.triangle], end.edge), triangles[1 - end.triangle]);
    let [from, to] = edge.map(|corner| height(other, corner));
    let [p, q] = edge.map(Exact::new);
    p.lerp(&q, &(&from / (&from - &to)))
}

/// Checks that the ends of a stretch are where their edges pass, in its direction.
fn check_stretch(stretch: &Stretch, triangles: [[DVec3; 3]; 2]) {
    for end in [stretch.begin, stretch.end] {
        let (edge, other) = (edge(triangles[end.triangle], end.edge), triangles[1 - end.triangle]);
        let passes = segment_meets_triangle(edge, other);
        assert_eq!(passes, Meeting::Crossing, "{end:?} of {triangles:?}");
        assert_eq!(end.enters, height(other, edge[0]).is_positive(), "{end:?} of {triangles:?}");
    }

    let [of_a, of_b] = triangles.map(normal);
    let way = place(stretch.end, triangles).sub(&place(stretch.begin, triangles));
    let along = way.dot(&Exact::new(of_a.cross(of_b)));
    let is_flat = of_a == DVec3::ZERO || of_b == DVec3::ZERO;
    assert!(along.is_positive() || (is_flat && way.is_zero()), "{stretch:?} of {triangles:?}");
}

/// Returns true if triangles without ties cross; of one without area, whether one of its edges does.
fn cross([a, b]: [[DVec3; 3]; 2]) -> bool {
    match [a, b].map(|corners| normal(corners) == DVec3::ZERO) {
        [false, false] => triangles_meet(a, b) == Meeting::Crossing,
        [true, true] => false,
        [a_is_flat, _] => {
            let (segment, other) = if a_is_flat { (a, b) } else { (b, a) };
            let passes = |k| segment_meets_triangle(edge(segment, k), other) == Meeting::Crossing;
            (0..3).any(passes)
        }
    }
}

/// Returns true if one of the signs that a crossing may depend on is zero.
fn have_tie([a, b]: [[DVec3; 3]; 2]) -> bool {
    let corners = a.iter().map(|p| height(b, *p)).chain(b.iter().map(|p| height(a, *p)));
    let of_edges = |i: usize, j: usize| {
        let ([p, q], [r, s]) = (edge(a, i), edge(b, j));
        height([p, q, r], s)
    };
    let edges = (0..9).map(|k| of_edges(k / 3, k % 3));
    corners.chain(edges).any(|sign| sign.is_zero())
}

/// Counts of what was met.
#[derive(Debug, Default)]
struct Counts {
    crossing: u32,
    ties: u32,
    flat: u32,
    coplanar: u32,
    apart: u32,
}

#[test]
fn a_move_by_an_infinitesimal_is_one_by_a_small_number() {
    let mut counts = Counts::default();
    cases(11, 10_000, |u| {
        let (a, b) = (grid_triangle(u)?, grid_triangle(u)?);
        let moved = [a.map(|corner| corner + small_move()), b];
        match meet_perturbed(a, b) {
            PerturbedMeeting::Crossing(stretch) => {
                assert!(cross(moved), "{a:?}, {b:?}");
                check_stretch(&stretch, moved);
                assert!(stretch.is_tie || cross([a, b]), "no tie, and no crossing: {a:?}, {b:?}");
                assert!(!stretch.is_tie || have_tie([a, b]), "a tie of nothing: {a:?}, {b:?}");
                counts.crossing += 1;
                counts.ties += u32::from(stretch.is_tie);
                counts.flat += u32::from(normal(a) == DVec3::ZERO || normal(b) == DVec3::ZERO);
            }
            PerturbedMeeting::Coplanar { same_normal, first_moves_outward } => {
                let [of_a, of_b] = [a, b].map(normal);
                assert!(b.iter().all(|p| of_a.dot(*p - a[0]) == 0.0), "{a:?}, {b:?}");
                assert_eq!(of_a.cross(of_b), DVec3::ZERO);
                assert_eq!(same_normal, of_a.dot(of_b) > 0.0);
                let forward = Exact::new(of_a).dot(&Exact::new(small_move()));
                assert_eq!(first_moves_outward, forward.is_positive());
                assert!(!cross(moved), "{a:?}, {b:?}");
                counts.coplanar += 1;
            }
            PerturbedMeeting::Apart => {
                assert!(!cross(moved), "{a:?}, {b:?}");
                counts.apart += 1;
            }
        }
        Ok(())
    });
    let Counts { crossing, ties, flat, coplanar, apart } = counts;
    assert!(crossing > 2000 && ties > 1000 && ties < crossing, "{counts:?}");
    assert!(flat > 50 && coplanar > 20 && apart > 1000, "{counts:?}");
}

/// Where an edge passes is right to rounding, however near the plane its ends are, and however far
/// from the origin.
#[test]
fn edges_pass_where_rational_numbers_say() {
    let mut cancelled = 0;
    cases(12, 2000, |u| {
        let far = DVec3::splat(2.0_f64.powi(u.int_in_range(0..=20)?));
        let mut coordinate = || Ok(f64::from(u.arbitrary::<i16>()?) / 2.0_f64.powi(15));
        let mut point = || Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
        let [a, b, c, p, q] = [point()?, point()?, point()?, point()?, point()?];
        // Ends within some ulps of the plane, and others.
        let thin = if u.ratio(1, 2)? { f64::EPSILON } else { 1.0 };
        let on = a + 0.25 * (b - a) + 0.25 * (c - a);
        let edge = [p, q].map(|end| on + thin * (end - on) + far);
        let corners = [a, b, c].map(|corner| corner + far);

        let [from, to] = edge.map(|end| height(corners, end));
        if !(&from * &to).is_negative() {
            return Ok(());
        }
        let exact = (&from / (&from - &to)).to_f64().expect("a number");
        let share = passing_share(edge, corners);
        assert!((share - exact).abs() < 1e-7, "{share}, {exact}: {edge:?} through {corners:?}");
        cancelled += u32::from(thin < 1.0);
        Ok(())
    });
    assert!(cancelled > 20, "{cancelled}");
}
