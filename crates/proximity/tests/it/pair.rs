//! One side of a pair against both.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use proximity::{PairProximity, SurfaceTree};

fn tree(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("a tree")
}

#[test]
fn the_first_side_alone_is_that_of_both() {
    let a = tree(shapes::icosphere(10.0, 3));
    let (mut both, mut first) = (PairProximity::default(), PairProximity::default());
    let mut inside = 0;
    for (by, margin) in [(15.0, 0.0), (19.5, 0.5), (2.0, 0.0), (2.0, 1.0), (40.0, 1.0)] {
        let other = shapes::ellipsoid(DVec3::new(10.0, 4.0, 4.0), 3);
        let b = tree(other.translated(DVec3::new(by, 0.3, 0.1)));
        both.compute(&a, &b, margin);
        // Memory of another pair, both sides of which were computed, is no part of the answer.
        first.compute(&b, &a, margin);
        first.compute_first(&a, &b, margin);

        assert_eq!(first.crossing_faces(), both.crossing_faces(), "by {by}");
        let ([one, none], [same, _]) = (first.sides(), both.sides());
        assert_eq!(one.inside_vertices(), same.inside_vertices(), "by {by}");
        assert_eq!(one.near(), same.near(), "by {by}");
        assert!(none.near().is_empty() && none.inside_vertices().is_empty(), "by {by}");
        inside += one.inside_vertices().len();
    }
    assert!(inside > 20, "{inside}");
}
