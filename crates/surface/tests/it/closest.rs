//! Closest points against rational arithmetic: triangles of any thinness, near
//! and far from the origin.

use arbitrary::{Result, Unstructured};
use fixtures::generate::cases;
use surface::glam::DVec3;
use surface::{
    Barycentric, TriangleFeature, closest_between_segments, closest_between_triangles,
    closest_on_segment, closest_on_triangle,
};

use crate::support::{self, Exact, between_segments, root, to_segment, to_triangle};

/// Half an ulp of one.
const U: f64 = f64::EPSILON / 2.0;

/// Computes the excess of the distance of two points over the least one.
fn excess(points: [DVec3; 2], least: &num_rational::BigRational) -> f64 {
    root(&Exact::new(points[0]).distance_squared(&Exact::new(points[1]))) - root(least)
}

fn largest(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.length()).fold(0.0, f64::max)
}

fn assert_weights(barycentric: Barycentric, corners: [DVec3; 3], point: DVec3) {
    let sum: f64 = barycentric.iter().sum();
    assert!((sum - 1.0).abs() <= 4.0 * U, "{barycentric:?}");
    assert!(barycentric.iter().all(|w| (0.0..=1.0).contains(w)), "{barycentric:?}");
    let [a, b, c] = corners;
    let combined = a * barycentric[0] + b * barycentric[1] + c * barycentric[2];
    assert!(combined.distance(point) <= 16.0 * U * largest(&corners), "{combined} {point}");
}

fn assert_feature(feature: TriangleFeature, barycentric: Barycentric) {
    let zeros = |k: usize| barycentric[k % 3] == 0.0;
    match feature {
        TriangleFeature::Face => {}
        TriangleFeature::Edge(k) => assert!(zeros(k + 2), "{barycentric:?}"),
        TriangleFeature::Corner(k) => assert!(zeros(k + 1) && zeros(k + 2), "{barycentric:?}"),
    }
}

/// A place at which a body may stand, in edge lengths from the origin.
fn offset(u: &mut Unstructured<'_>) -> Result<DVec3> {
    Ok(DVec3::new(1.0, -0.7, 0.4) * *u.choose(&[0.0, 0.0, 1.0, 1e3, 1e6])?)
}

/// The promise of the module, for the scale that it names.
fn assert_small(excess: f64, scale: f64, what: &dyn std::fmt::Debug) {
    let relative = excess / (U * scale);
    assert!(relative <= 256.0, "{relative} u by {excess:e}: {what:?}");
}

#[test]
fn a_foot_on_a_triangle_is_the_closest_point() {
    cases(21, 2000, |u| {
        let (offset, size) = (offset(u)?, *u.choose(&[1e-3, 1.0, 1e3])?);
        let corners = support::triangle(u)?.map(|x| offset + x * size);
        let p = support::point_near(u, corners)?;
        let foot = closest_on_triangle(p, corners);

        let [a, b, c] = corners.map(Exact::new);
        let least = to_triangle(&Exact::new(p), [&a, &b, &c]);
        let longest = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3])).fold(0.0, f64::max);
        let scale = longest + p.distance(corners[0]) + p.length();
        assert_small(excess([p, foot.point], &least), scale, &(p, corners));
        let scale = largest(&corners).max(p.length());
        let off = root(&to_triangle(&Exact::new(foot.point), [&a, &b, &c]));
        assert!(off <= 8.0 * U * scale, "{off:e} off {corners:?} at {p}");
        assert_weights(foot.barycentric, corners, foot.point);
        assert_feature(foot.feature, foot.barycentric);
        Ok(())
    });
}

/// Far from the origin only the foot itself is rounded: the rest is as exact
/// as at the origin.
#[test]
fn an_offset_costs_the_rounding_of_the_foot_only() {
    cases(22, 20_000, |u| {
        let grid = |x: DVec3| (x * 1024.0).round() / 1024.0; // stays exact when moved
        let far = DVec3::new(1048576.0, -524288.0, 262144.0);
        let corners = support::triangle(u)?.map(grid);
        let p = grid(support::point_near(u, corners)?);
        let here = closest_on_triangle(p, corners);
        let there = closest_on_triangle(p + far, corners.map(|x| x + far));
        for (a, b) in here.barycentric.into_iter().zip(there.barycentric) {
            assert!((a - b).abs() <= 0.0, "{a} {b}");
        }
        assert_eq!(here.feature, there.feature);
        assert!((here.point + far).distance(there.point) <= 4.0 * U * far.length());
        Ok(())
    });
}

#[test]
fn a_foot_on_a_segment_is_the_closest_point() {
    cases(23, 1000, |u| {
        let offset = offset(u)?;
        let [a, b, c] = support::triangle(u)?.map(|x| offset + x);
        let p = support::point_near(u, [a, b, c])?;
        let foot = closest_on_segment(p, [a, b]);
        let least = to_segment(&Exact::new(p), [&Exact::new(a), &Exact::new(b)]);
        let scale = largest(&[a, b, p]);
        assert_small(excess([p, foot.point], &least), scale, &(p, [a, b]));
        assert!((a + foot.t * (b - a)).distance(foot.point) <= 4.0 * U * scale);
        Ok(())
    });
}

#[test]
fn feet_between_segments_are_the_closest_points() {
    cases(24, 1000, |u| {
        let offset = offset(u)?;
        let corners = support::triangle(u)?;
        let a = [corners[0], corners[1]];
        let b = match u.int_in_range(0..=3)? {
            0 => [support::point(u)?, support::point(u)?],
            1 => [corners[2], corners[2] + (a[1] - a[0]) * support::coordinate(u)?],
            2 => [support::point_near(u, corners)?, support::point_near(u, corners)?],
            _ => {
                let tilt = support::point(u)? * support::thinness(u, 17)?;
                let start = support::point_near(u, corners)?;
                [start, start + (a[1] - a[0]) * support::coordinate(u)? + tilt]
            }
        };
        let [a, b] = [a, b].map(|segment| segment.map(|x| offset + x));
        let feet = closest_between_segments(a, b);
        let [a0, a1, b0, b1] = [a[0], a[1], b[0], b[1]].map(Exact::new);
        let least = between_segments([&a0, &a1], [&b0, &b1]);
        let scale = largest(&[a[0], a[1], b[0], b[1]]);
        assert_small(excess(feet.points, &least), scale, &(a, b));
        assert!((a[0] + feet.s * (a[1] - a[0])).distance(feet.points[0]) <= 4.0 * U * scale);
        assert!((b[0] + feet.t * (b[1] - b[0])).distance(feet.points[1]) <= 4.0 * U * scale);
        Ok(())
    });
}

#[test]
fn feet_between_triangles_are_the_closest_of_all_pairs() {
    cases(25, 200, |u| {
        let a = support::triangle(u)?;
        let b = support::triangle(u)?.map(|x| x + DVec3::new(0.3, 0.2, 1.0));
        let feet = closest_between_triangles(a, b);
        for (corners, (point, weights)) in
            [a, b].into_iter().zip(feet.points.into_iter().zip(feet.barycentric))
        {
            assert_weights(weights, corners, point);
        }
        let [ea, eb] = [a, b].map(|corners| corners.map(Exact::new));
        let mut least = to_triangle(&ea[0], [&eb[0], &eb[1], &eb[2]]);
        for k in 0..3 {
            least = least.min(to_triangle(&ea[k], [&eb[0], &eb[1], &eb[2]]));
            least = least.min(to_triangle(&eb[k], [&ea[0], &ea[1], &ea[2]]));
            for j in 0..3 {
                let edge = |e: [usize; 2]| [&ea[e[0]], &ea[e[1]]];
                let other = [&eb[j], &eb[(j + 1) % 3]];
                least = least.min(between_segments(edge([k, (k + 1) % 3]), other));
            }
        }
        let scale = largest(&a).max(largest(&b));
        let excess = excess(feet.points, &least).abs();
        assert!(excess <= 64.0 * U * scale, "{excess:e} {a:?} {b:?}");
        assert!((feet.distance() - root(&least)).abs() <= 64.0 * U * scale);
        Ok(())
    });
}

#[test]
fn feet_are_on_the_planted_features() {
    let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 3.0];
    let cases = [
        (DVec3::new(1.0, 1.0, 7.0), TriangleFeature::Face),
        (DVec3::new(1.0, -1.0, 7.0), TriangleFeature::Edge(0)),
        (DVec3::new(4.0, 4.0, 7.0), TriangleFeature::Edge(1)),
        (DVec3::new(-1.0, 1.0, 7.0), TriangleFeature::Edge(2)),
        (DVec3::new(-1.0, -1.0, 7.0), TriangleFeature::Corner(0)),
        (DVec3::new(9.0, -1.0, 7.0), TriangleFeature::Corner(1)),
        (DVec3::new(-1.0, 9.0, 7.0), TriangleFeature::Corner(2)),
    ];
    for thinness in [1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
        let squeeze = |x: DVec3| x * DVec3::new(1.0, thinness, 1.0);
        for turn in 0..3 {
            let mut turned = corners.map(squeeze);
            turned.rotate_left(turn);
            for (p, expected) in cases {
                let back = |k: usize| (k + 3 - turn) % 3;
                let expected = match expected {
                    TriangleFeature::Face => TriangleFeature::Face,
                    TriangleFeature::Edge(k) => TriangleFeature::Edge(back(k)),
                    TriangleFeature::Corner(k) => TriangleFeature::Corner(back(k)),
                };
                // Squeezed, a point beyond the long edge stays beyond it only sideways.
                if thinness < 1.0 && p == DVec3::new(4.0, 4.0, 7.0) {
                    continue;
                }
                let foot = closest_on_triangle(squeeze(p), turned);
                assert_eq!(foot.feature, expected, "{p} at {thinness}, turned by {turn}");
            }
        }
    }
}

#[test]
fn any_finite_size_gives_a_finite_foot() {
    for size in [0.0, 1e-150, 1e-80, 1.0, 1e80, 1e150] {
        let corners = [DVec3::ZERO, DVec3::X * size, DVec3::Y * size];
        let p = DVec3::new(0.25, 0.25, 1.0) * size;
        let foot = closest_on_triangle(p, corners);
        assert!(foot.point.distance(p.with_z(0.0)) <= 1e-15 * size, "{size:e}: {foot:?}");
        let hypotenuse = [corners[1], corners[2]];
        let up = [p, p + DVec3::Z * size];
        for (s, segment) in [(0.0, up), (1.0, [up[1], up[0]])] {
            let feet = closest_between_segments(segment, hypotenuse);
            let error = (feet.s - s).abs() + (feet.t - 0.5).abs();
            assert!(
                error < 1e-15 || size <= 0.0 && feet.points[0] == DVec3::ZERO,
                "{feet:?} at {size:e}"
            );
        }
    }
}

/// Signs of weights distinguish the two sides of a contact: a foot has no negative one, zeros included.
#[test]
fn zeros_of_weights_are_positive() {
    let corners = [DVec3::NEG_X, DVec3::new(-0.5, 0.0, 1e-9), DVec3::ZERO];
    for turn in 0..3 {
        let mut turned = corners;
        turned.rotate_left(turn);
        let [a, b, c] = turned;
        for corners in [turned, [b, a, c]] {
            let foot = closest_on_triangle(DVec3::new(0.0, -5.0, -3.0), corners);
            assert!(foot.barycentric.iter().all(|w| w.is_sign_positive()), "{foot:?}");
        }
    }
}
