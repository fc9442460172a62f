//! Bodies that are inside out or cover a place twice: measures count a place as often as it is
//! covered.

use fixtures::Mesh;
use fixtures::random::Random;
use fixtures::shapes::{icosphere, tetrahedron};
use glam::DVec3;
use overlap::{Overlap, OverlapDetector, OverlapMeasures};
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
