//! Tests of every bound of `docs/ccd-error-analysis.md` against rational arithmetic.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use glam::DVec3;
use num_bigint::BigInt;
use num_rational::BigRational;

use super::{
    AREA_DIRECTION, COPLANARITY, DIRECTION, EDGE_FUNCTION, EDGE_FUNCTION_RATE, LENGTH_UP, NORMAL,
    SUBDIVISION, TURNING, UNIT,
};
use crate::contact::CcdParams;
use crate::coplanarity::Coplanarity;
use crate::cubic::{BernsteinCubic, RootInterval, RootKind};
use crate::outline::Outline;
use crate::polygon::{MovingPolygon, TurningDirection, projections};
use crate::scalar::mix;
use crate::search::ContactSearch;
use crate::shape::{Corners, PolygonShape};

type Exact = BigRational;
type Point = [Exact; 3];

fn exact(x: f64) -> Exact {
    BigRational::from_float(x).expect("the number is finite")
}

fn exact_point(x: DVec3) -> Point {
    x.to_array().map(exact)
}

fn minus(a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn dot(a: &Point, b: &Point) -> Exact {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

fn at(a: &Point, b: &Point, t: f64) -> Point {
    std::array::from_fn(|k| (exact(1.0) - exact(t)) * &a[k] + exact(t) * &b[k])
}

/// Checks a property on a fixed number of random inputs, the same in every run.
fn check(property: impl Fn(&mut Unstructured<'_>) -> Result<()>) {
    for i in 0..250_u64 {
        // The lower half of a seed is the number of random bytes.
        let random = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        arbtest(&property).seed(random << 32 | 512).run();
    }
}

/// Draws a coordinate with all digits in use, of one of several sizes, so that sums round and
/// cancel.
fn coordinate(u: &mut Unstructured<'_>) -> Result<f64> {
    let size = [1.0, 1e-3, 1e3, 1.0][usize::from(u.int_in_range(0_u8..=3)?)];
    let digits = i64::from(u.arbitrary::<i32>()?) << 20 | i64::from(u.arbitrary::<u32>()? >> 12);
    #[expect(clippy::cast_precision_loss, reason = "52 digits")]
    let share = digits as f64 / 2_f64.powi(51);
    Ok(size * share)
}

fn point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    Ok(DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?))
}

fn points(u: &mut Unstructured<'_>) -> Result<[DVec3; 4]> {
    Ok([point(u)?, point(u)?, point(u)?, point(u)?])
}

fn time(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(f64::from(u.arbitrary::<u32>()?) / f64::from(u32::MAX))
}

/// Computes the exact corners at one end of the step.
fn exact_corners<const N: usize>(x: &[DVec3; 4]) -> [Point; N]
where
    PolygonShape<N>: Corners<N>,
{
    PolygonShape::<N>::PAIRS.map(|(to, from)| minus(&exact_point(x[to]), &exact_point(x[from])))
}

fn assert_within(computed: f64, exactly: &Exact, bound: f64, what: &str) {
    let error = exact(computed) - exactly;
    let error = if error < exact(0.0) { -error } else { error };
    assert!(error <= exact(bound), "{what}: {computed} is off by more than {bound}");
}

/// Compares the constants with the counts of roundings of the proof, with room for second-order
/// terms and for the rounding of the bound itself.
#[test]
fn constants_cover_the_proof() {
    let proven = [
        (DIRECTION, 7.0),
        (TURNING, 8.0),
        (AREA_DIRECTION, 11.0),
        (COPLANARITY, 35.0 / 3.0),
        (SUBDIVISION, 9.0),
        (NORMAL, 5.0),
        (EDGE_FUNCTION, 210.0),
        (LENGTH_UP - 1.0, 6.0),
    ];
    for (constant, roundings) in proven {
        assert!(constant > roundings * UNIT * (1.0 + 1000.0 * UNIT), "{constant} < {roundings} u");
    }
    const { assert!(EDGE_FUNCTION_RATE > 6.0, "edge functions change by up to 6") };
}

fn direction_bound_holds<const N: usize>(u: &mut Unstructured<'_>) -> Result<()>
where
    PolygonShape<N>: Corners<N>,
{
    let (x0, x1, m, t) = (points(u)?, points(u)?, point(u)?, time(u)?);
    let outline = Outline::new::<N>(&x0, &x1).expect("the points are finite");
    let polygon = MovingPolygon::<N>::new(&outline, [&x0, &x1]);
    let (start, end) = (exact_corners::<N>(&x0), exact_corners::<N>(&x1));
    let bound = polygon.direction_bound(m, 0.0);
    for i in 0..N {
        let computed = mix(m.dot(polygon.start[i]), m.dot(polygon.end[i]), t);
        let exactly = dot(&exact_point(m), &at(&start[i], &end[i], t));
        assert_within(computed, &exactly, bound, "projection");
    }
    Ok(())
}

#[test]
fn projections_are_within_their_bound() {
    check(direction_bound_holds::<3>);
    check(direction_bound_holds::<4>);
}

fn turning_bound_holds<const N: usize>(u: &mut Unstructured<'_>) -> Result<()>
where
    PolygonShape<N>: Corners<N>,
{
    let (x0, x1, m) = (points(u)?, points(u)?, [point(u)?, point(u)?]);
    let times = [time(u)?, time(u)?];
    let outline = Outline::new::<N>(&x0, &x1).expect("the points are finite");
    let polygon = MovingPolygon::<N>::new(&outline, [&x0, &x1]);
    let (start, end) = (exact_corners::<N>(&x0), exact_corners::<N>(&x1));
    let m_exactly = m.map(exact_point);
    let m = TurningDirection { start: m[0], end: m[1] };
    let [bound, _] = polygon.turning_bounds(m, 0.0);
    for i in 0..N {
        let computed = projections(m, times.map(|t| polygon.corners(t)[i]));
        let q = times.map(|t| at(&start[i], &end[i], t));
        let mixed = dot(&m_exactly[0], &q[1]) + dot(&m_exactly[1], &q[0]);
        let exactly = [dot(&m_exactly[0], &q[0]), mixed * exact(0.5), dot(&m_exactly[1], &q[1])];
        for (computed, exactly) in computed.into_iter().zip(&exactly) {
            assert_within(computed, exactly, bound, "projection onto a turning direction");
        }
    }
    Ok(())
}

#[test]
fn projections_onto_turning_directions_are_within_their_bound() {
    check(turning_bound_holds::<3>);
    check(turning_bound_holds::<4>);
}

fn coefficient_bound_holds<const N: usize>(u: &mut Unstructured<'_>) -> Result<()>
where
    PolygonShape<N>: Corners<N>,
{
    let (x0, x1) = (points(u)?, points(u)?);
    let outline = Outline::new::<N>(&x0, &x1).expect("the points are finite");
    let cubic = Coplanarity::new(&outline).cubic();
    let (start, end) = (exact_corners::<N>(&x0), exact_corners::<N>(&x1));
    let edges = |q: &[Point; N]| (minus(&q[1], &q[0]), minus(&q[N - 1], &q[0]));
    let ((e0, f0), (e1, f1)) = (edges(&start), edges(&end));
    let (n0, n1) = (cross(&e0, &f0), cross(&e1, &f1));
    let (m, m_other) = (cross(&e0, &f1), cross(&e1, &f0));
    let third = Exact::new(BigInt::from(1), BigInt::from(3));
    let middle = |a: &Point| dot(a, &m) + dot(a, &m_other);
    let exactly = [
        dot(&start[0], &n0),
        (dot(&end[0], &n0) + middle(&start[0])) * &third,
        (dot(&start[0], &n1) + middle(&end[0])) * &third,
        dot(&end[0], &n1),
    ];
    for (computed, exactly) in cubic.bernstein.into_iter().zip(&exactly) {
        assert_within(computed, exactly, cubic.error, "coefficient");
    }
    Ok(())
}

#[test]
fn coefficients_are_within_their_bound() {
    check(coefficient_bound_holds::<3>);
    check(coefficient_bound_holds::<4>);
}

/// Computes the exact blossom of given Bernstein coefficients.
fn blossom(b: [f64; 4], times: [f64; 3]) -> Exact {
    let mut row = b.map(exact).to_vec();
    for t in times {
        row = row
            .windows(2)
            .map(|pair| (exact(1.0) - exact(t)) * &pair[0] + exact(t) * &pair[1])
            .collect();
    }
    row.remove(0)
}

#[test]
fn values_and_parts_are_within_their_bound() {
    check(|u| {
        let b = [coordinate(u)?, coordinate(u)?, coordinate(u)?, coordinate(u)?];
        let (lo, hi) = (time(u)?, time(u)?);
        let cubic = BernsteinCubic::new(b, 0.0);
        let blossom = |x, y, z| blossom(b, [x, y, z]);
        let bound = cubic.evaluation_error;
        assert_within(cubic.value(lo), &blossom(lo, lo, lo), bound, "value");
        let parts = [(lo, lo, lo), (lo, lo, hi), (lo, hi, hi), (hi, hi, hi)];
        for (computed, (x, y, z)) in cubic.on(lo, hi).into_iter().zip(parts) {
            assert_within(computed, &blossom(x, y, z), bound, "coefficient of a part");
        }
        Ok(())
    });
}

/// Draws Bernstein coefficients: at random, or of a cubic with two roots that are nearly one.
fn coefficients(u: &mut Unstructured<'_>) -> Result<[f64; 4]> {
    if u.arbitrary()? {
        return Ok([coordinate(u)?, coordinate(u)?, coordinate(u)?, coordinate(u)?]);
    }
    let apart = 10_f64.powi(-u.int_in_range(1..=16)?);
    let [r, s] = [time(u)?, 3.0 * time(u)? - 1.0];
    let factors = [r, r + apart, s].map(|root| [-root, 1.0 - root]);
    let corner = |[i, j, k]: [usize; 3]| factors[0][i] * factors[1][j] * factors[2][k];
    let mean = |corners: [[usize; 3]; 3]| corners.map(corner).iter().sum::<f64>() / 3.0;
    let second = mean([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    let third = mean([[1, 1, 0], [1, 0, 1], [0, 1, 1]]);
    Ok([corner([0; 3]), second, third, corner([1; 3])])
}

#[test]
fn no_exact_root_is_before_a_single_root() {
    let found = std::cell::Cell::new(0);
    check(|u| {
        let b = coefficients(u)?;
        let Some(RootInterval { lo, hi, kind }) = BernsteinCubic::new(b, 0.0).single_root() else {
            return Ok(());
        };
        found.set(found.get() + 1);

        // All exact coefficients up to the interval have the sign of the start; its end has not.
        let side = exact(if kind == RootKind::Rising { 1.0 } else { -1.0 });
        for times in [[0.0; 3], [0.0, 0.0, lo], [0.0, lo, lo], [lo; 3]] {
            assert!(&side * blossom(b, times) < exact(0.0), "{b:?} may be zero before {lo}");
        }
        assert!(side * blossom(b, [hi; 3]) > exact(0.0), "{b:?} does not change sign up to {hi}");
        Ok(())
    });
    assert!(found.get() > 80, "only {} cubics have a single root", found.get());
}

fn edge_function_bound_holds<const N: usize>(u: &mut Unstructured<'_>) -> Result<()>
where
    PolygonShape<N>: Corners<N>,
{
    let (x0, x1, t) = (points(u)?, points(u)?, time(u)?);
    let length = time(u)? * (2.0 * t.min(1.0 - t)).max(0.0);
    let (lo, hi) = (t - 0.5 * length, t + 0.5 * length);
    let interval = RootInterval { lo, hi, kind: RootKind::Grazing };
    let (start, end) = (exact_corners::<N>(&x0), exact_corners::<N>(&x1));
    let outline = Outline::new::<N>(&x0, &x1).expect("the points are finite");
    let params = CcdParams::DEFAULT;
    let Some(search) = ContactSearch::<N>::new(&outline, [&x0, &x1], &params) else {
        return Ok(());
    };

    let position = search.origin_position(&interval);
    let bound = search.edge_function_bound(position.area, hi - lo);
    for when in [lo, t, hi] {
        let q: [Point; N] = std::array::from_fn(|i| at(&start[i], &end[i], when));
        for i in 0..N {
            let exactly = dot(&exact_point(position.area), &cross(&q[i], &q[(i + 1) % N]));
            assert_within(position.edge_functions[i], &exactly, bound, "edge function");
        }
    }
    Ok(())
}

#[test]
fn edge_functions_are_within_their_bound() {
    check(edge_function_bound_holds::<3>);
    check(edge_function_bound_holds::<4>);
}

/// Checks that where area vectors separate, the exact heights of all corners over one of them have
/// one sign.
fn area_bound_holds<const N: usize>(u: &mut Unstructured<'_>) -> Result<()>
where
    PolygonShape<N>: Corners<N>,
{
    let (x0, x1) = (points(u)?, points(u)?);
    let outline = Outline::new::<N>(&x0, &x1).expect("the points are finite");
    if Coplanarity::new(&outline).areas_separate::<N>(1.0, 0.0) {
        let (start, end) = (exact_corners::<N>(&x0), exact_corners::<N>(&x1));
        let normals = outline.first_edge.cross(outline.last_edge).to_array();
        let one_sided = normals.iter().any(|n| {
            let n = exact_point(*n);
            let heights: Vec<Exact> = start.iter().chain(&end).map(|q| dot(&n, q)).collect();
            let zero = exact(0.0);
            heights.iter().all(|h| *h > zero) || heights.iter().all(|h| *h < zero)
        });
        assert!(one_sided, "area vectors do not separate {x0:?} {x1:?}");
    }
    Ok(())
}

#[test]
fn queries_that_area_vectors_drop_are_separate() {
    check(area_bound_holds::<3>);
    check(area_bound_holds::<4>);
}
