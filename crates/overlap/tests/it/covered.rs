//! Bodies that are inside out, cover a place twice, or have faces without area.

use fixtures::Mesh;
use fixtures::random::Random;
use fixtures::shapes::{cube, icosphere, tetrahedron};
use glam::DVec3;
use overlap::{DepthParams, Overlap, OverlapDetector, OverlapMeasures};
use proximity::SurfaceTree;

fn measure(a: &Mesh, b: &Mesh) -> Overlap {
    let [a, b] = [a, b].map(|mesh| {
        SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("bodies are finite")
    });
    OverlapDetector::default().measure(&a, &b)
}

fn volume(a: &Mesh, b: &Mesh) -> f64 {
    measure(a, b).total.volume.expect("both are closed")
}

fn areas(measures: &OverlapMeasures) -> [f64; 2] {
    [measures.area_of_a_inside_b, measures.area_of_b_inside_a].map(|area| area.expect("closed"))
}

/// A body that is inside out covers its places -1 times.
#[test]
fn a_body_inside_out_changes_the_sign_alone() {
    let a = icosphere(10.0, 2);
    let b = icosphere(8.0, 2).translated(DVec3::new(14.0, 0.3, 0.2));
    let expected = measure(&a, &b).total;
    let volume = expected.volume.expect("both are closed");
    let [flipped_a, flipped_b] = [&a, &b].map(|mesh| mesh.clone().flipped());

    for (a, b, signs) in [
        (&flipped_a, &b, [1.0, -1.0]),
        (&a, &flipped_b, [-1.0, 1.0]),
        (&flipped_a, &flipped_b, [-1.0, -1.0]),
    ] {
        let found = measure(a, b);
        let sign = signs[0] * signs[1];
        let difference = found.total.volume.expect("both are closed") - sign * volume;
        assert!(difference.abs() < 1e-10, "{signs:?}: {difference}");
        let (found_areas, areas) = (areas(&found.total), areas(&expected));
        for side in 0..2 {
            let difference = found_areas[side] - signs[side] * areas[side];
            assert!(difference.abs() < 1e-10, "{signs:?}: {difference}");
        }
        assert_eq!(found.regions.len(), 1, "{signs:?}");
    }
}

/// Bars that cross with no vertex in each other.
#[test]
fn a_bar_inside_out_is_named_where_no_vertex_shows_it() {
    let long = cube(1.0).scaled(DVec3::new(10.0, 2.0, 2.0));
    let across = cube(1.0).scaled(DVec3::new(1.0, 10.0, 1.0));
    for flipped in [[false, false], [true, false], [false, true], [true, true]] {
        let mut bodies = [&long, &across].map(Clone::clone);
        for (body, is_flipped) in bodies.iter_mut().zip(flipped) {
            if is_flipped {
                *body = body.clone().flipped();
            }
        }
        let [a, b] = &bodies;
        let found = measure(a, b);
        assert_eq!(found.total.inside_vertices, [0; 2], "{flipped:?}");
        assert_eq!(found.covers_twice, flipped);
        let apart = measure(a, &b.clone().translated(20.0 * DVec3::X));
        assert_eq!(apart.covers_twice, [false; 2], "{flipped:?}: nothing is shared");
    }
}

/// The volume shared with a body of two parts is the sum of the volumes shared with each.
#[test]
fn parts_that_cross_are_summed_up() {
    let mut random = Random(11);
    let mut crossed = 0;
    for scene in 0..300 {
        let mut part = || {
            let turned = tetrahedron(1.0).rotated(DVec3::new(1.0, 2.0, 3.0), random.unit());
            let place = DVec3::new(random.unit(), random.unit(), random.unit());
            turned.translated(DVec3::splat(20.0) + 0.7 * place)
        };
        let [p, q] = [part(), part()];
        let other = icosphere(0.8, 1).translated(DVec3::splat(20.0));
        let expected = volume(&p, &other) + volume(&q, &other);
        let overlap = measure(&p.joined(&q), &other);
        let found = overlap.total.volume.expect("both are closed");
        assert!((found - expected).abs() < 1e-10, "scene {scene}: {found} for {expected}");
        crossed += usize::from(overlap.covers_twice[0]);
    }
    assert!(crossed > 100, "{crossed}");
}

/// Two corners on an edge of a cube leave two faces without area side by side: the curve passes
/// their common edge, too.
#[test]
fn faces_without_area_carry_the_curve() {
    let positions = (0..8).map(|k| {
        let corner = [k >> 2, (k >> 1) & 1, k & 1].map(|bit| if bit == 1 { 5.0 } else { -5.0 });
        DVec3::from(corner)
    });
    let on_diagonal = [DVec3::new(-2.0, -2.0, 5.0), DVec3::new(2.0, 2.0, 5.0)];
    let sides = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
    ];
    let top = [[1, 5, 8], [8, 5, 9], [5, 7, 9], [1, 7, 3], [1, 8, 9], [1, 9, 7]];
    let plain = Mesh {
        positions: positions.clone().collect(),
        faces: sides.into_iter().chain([[1, 5, 7], [1, 7, 3]]).collect(),
    };
    let divided = Mesh {
        positions: positions.chain(on_diagonal).collect(),
        faces: sides.into_iter().chain(top).collect(),
    };

    let ball = icosphere(4.0, 2).translated(DVec3::new(0.3, 0.2, 5.1));
    for turned in [DVec3::X, DVec3::Y, DVec3::new(1.0, 2.0, 3.0)] {
        let [plain, divided, ball] =
            [&plain, &divided, &ball].map(|mesh| mesh.clone().rotated(turned, 0.25));
        for swapped in [false, true] {
            let measure = |cube: &Mesh| {
                if swapped { measure(&ball, cube) } else { measure(cube, &ball) }
            };
            let (expected, found) = (measure(&plain), measure(&divided));
            assert_eq!(found.covers_twice, [false; 2], "{turned}");
            assert_eq!((found.total.curve_loops, found.total.curve_arcs), (1, 0), "{turned}");
            let [volume, expected] =
                [&found, &expected].map(|overlap| overlap.total.volume.expect("both are closed"));
            assert!((volume - expected).abs() < 1e-10, "{turned}: {volume} for {expected}");
        }
    }
}

/// A cavity with faces that look outward is covered twice, and a part inside out -1 times: no vertex of
/// the other body is there.
#[test]
fn inverted_parts_in_the_overlap_are_named() {
    let walls = cube(20.0).joined(&cube(10.0));
    let hollow = cube(20.0).joined(&cube(10.0).flipped());
    let beside = cube(6.0).translated(DVec3::new(20.0, 0.0, 0.0));
    let reversed = cube(10.0).joined(&beside.clone().flipped());
    let pair = cube(10.0).joined(&beside);
    let bar = cube(1.0).mapped(|p| DVec3::new(20.0 + p.x, p.y, 30.0 * p.z));
    let corner = cube(2.0).translated(DVec3::new(9.5, 9.5, 9.5));
    for (name, body, other, volume, covers_twice) in [
        ("around a cavity", &walls, &cube(11.0), 2331.0, true),
        ("in a cavity", &walls, &cube(1.0), 2.0, true),
        ("at the corner of the outer part", &walls, &corner, 1.5_f64.powi(3), false),
        ("around a true cavity", &hollow, &cube(11.0), 331.0, false),
        ("through a reversed part", &reversed, &bar, -6.0, true),
        ("through a part", &pair, &bar, 6.0, false),
    ] {
        let [a, b] = [body, other].map(|mesh| {
            SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("bodies are finite")
        });
        let mut detector = OverlapDetector::default();
        for (side, bodies) in [[&a, &b], [&b, &a]].into_iter().enumerate() {
            let overlap = detector.measure(bodies[0], bodies[1]);
            let found = overlap.total.volume.expect("both are closed");
            assert!((found - volume).abs() < 1e-9, "{name}: {found} for {volume}");
            let mut expected = [false; 2];
            expected[side] = covers_twice;
            assert_eq!(overlap.covers_twice, expected, "{name}");
            let depths = detector.depths(bodies, &DepthParams::with_floor(1e-3));
            assert!(!covers_twice || depths[1 - side].is_none(), "{name}: {depths:?}");
        }
    }
}
