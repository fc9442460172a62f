//! The point of a depth is on the surface, also where no depth was to be computed.

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere, octasphere};
use glam::DVec3;
use overlap::{Depth, DepthParams, OverlapDetector};
use proximity::SurfaceTree;
use surface::closest_on_triangle;
use surface::progress::Progress;

/// Two cubes that stand far from the origin, the lower one on an edge along x below the upper one
/// on an edge along y, which is lower by `depth` than where they touch.
fn crossed_edges(depth: f64) -> [SurfaceTree; 2] {
    let lower = cube(1.0).rotated(DVec3::X, 0.125);
    let upper = cube(1.0).rotated(DVec3::Y, 0.125).translated((2.0_f64.sqrt() - depth) * DVec3::Z);
    [lower, upper].map(|mesh: Mesh| {
        let mesh = mesh.translated(DVec3::new(100.0, 50.0, -20.0));
        SurfaceTree::new(mesh.surface(), mesh.positions).expect("planted bodies are finite")
    })
}

fn check(body: &SurfaceTree, other: &SurfaceTree, found: Option<Depth>) {
    let Depth { lower, upper, point, face, foot, .. } = found.expect("the edges cross");
    let on_face = closest_on_triangle(point, body.corners(face)).point;
    assert!(on_face.distance(point) < 1e-12, "{point} is not on face {face}");
    let nearest = other.closest_point(point, f64::INFINITY, None, &mut Default::default());
    let distance = nearest.expect("a surface").distance;
    assert!((foot.distance(point) - distance).abs() < 1e-12, "{foot} is not the nearest point");
    assert!((lower - distance).abs() < 1e-12 && lower <= upper, "{lower} is not attained");
}

#[test]
fn depths_within_the_tolerance_have_a_point_of_the_surface() {
    for (depth, tolerance) in [(0.1, 1.0), (0.1, 1e-6), (1e-9, 1e-6), (0.0, 1e-6)] {
        let [a, b] = crossed_edges(depth);
        let mut detector = OverlapDetector::default();
        let overlap = detector.measure(&a, &b);
        if overlap.regions.is_empty() {
            continue;
        }
        assert_eq!(overlap.total.inside_vertices, [0, 0], "they cross by their edges alone");

        let params = DepthParams::with_floor(tolerance);
        let [of_a, of_b] = detector.depths([&a, &b], &params);
        check(&a, &b, of_a);
        check(&b, &a, of_b);
        let in_region = detector.depths_in_region(0, [&a, &b], &params, Progress::none());
        let [of_a, of_b] = in_region.expect("nothing interrupts");
        check(&a, &b, of_a);
        check(&b, &a, of_b);
    }
}

/// A search that ends early has bounds still, and says that they are wide.
#[test]
fn a_depth_is_narrow_where_the_search_has_come_to_its_end() {
    let [a, b] = [0.0, 1.3].map(|x| {
        let ball = icosphere(1.0, 3).translated(DVec3::new(x, 0.1, 0.2));
        SurfaceTree::new(ball.surface(), ball.positions).expect("planted bodies are finite")
    });
    let mut detector = OverlapDetector::default();
    detector.measure(&a, &b);
    let mut depth = |max_queries: u32| {
        let params = DepthParams { relative_tolerance: 0.0, tolerance: 1e-6, max_queries };
        detector.depths([&a, &b], &params)[0].expect("they overlap")
    };

    let exact = depth(1_000_000);
    assert!(exact.is_narrow && exact.upper - exact.lower <= 1e-6, "{exact:?}");
    for max_queries in [1, 10] {
        let wide = depth(max_queries);
        assert!(!wide.is_narrow && wide.upper - wide.lower > 1e-6, "{wide:?}");
        assert!(wide.lower <= exact.upper && exact.lower <= wide.upper, "{wide:?}, {exact:?}");
    }
}

/// Bodies that are one shape in two divisions are equally deep nearly everywhere, and much less than their faces
/// are long.
#[test]
fn two_divisions_of_a_ball_take_few_queries() {
    let [a, b] = [icosphere(1.0, 4), octasphere(1.0, 5).rotated(DVec3::new(1.0, 2.0, 3.0), 0.4)]
        .map(|ball| {
            let ball = ball.translated(DVec3::new(3.0, -2.0, 5.0));
            SurfaceTree::new(ball.surface(), ball.positions).expect("planted bodies are finite")
        });
    let mut detector = OverlapDetector::default();
    let overlap = detector.measure(&a, &b);
    assert!(overlap.total.inside_vertices[0] < a.surface().vertex_count());
    let params = DepthParams { relative_tolerance: 0.1, tolerance: 0.0, max_queries: 100_000 };
    for (side, found) in detector.depths([&a, &b], &params).into_iter().enumerate() {
        let found = found.expect("they overlap");
        assert!(found.is_narrow && found.upper < 0.01, "{side} {found:?}");

        // No point of a face that is inside is deeper.
        let (body, other) = if side == 0 { (&a, &b) } else { (&b, &a) };
        let mut workspace = Default::default();
        let mut deepest: f64 = 0.0;
        for face in 0..body.surface().faces().len() {
            let corners = body.corners(u32::try_from(face).expect("few faces"));
            for [u, v] in
                [[0.0, 0.0], [0.2, 0.2], [0.6, 0.2], [0.2, 0.6], [0.4, 0.4], [1.0 / 3.0; 2]]
            {
                let point =
                    corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
                if other.contains(point, &mut workspace) {
                    let near = other.closest_point(point, f64::INFINITY, None, &mut workspace);
                    deepest = deepest.max(near.expect("a surface").distance);
                }
            }
        }
        assert!(deepest <= found.upper && deepest > 0.8 * found.lower, "{deepest}: {found:?}");
    }
}
