//! Faces whose area is rounding, where an edge of the other body passes.

use fixtures::Mesh;
use fixtures::random::Random;
use glam::{DQuat, DVec3};
use overlap::{JointContactParams, OverlapDetector};
use proximity::SurfaceTree;
use surface::progress::Progress;

/// A tetrahedron of corners of whole coordinates.
fn tetrahedron(corners: [[i8; 3]; 4]) -> Mesh {
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let positions = corners.map(|x| DVec3::from(x.map(f64::from))).to_vec();
    Mesh { positions, faces }
}

/// The same, where a face between the first edge and its middle fills a gap without width.
fn with_sliver(mesh: &Mesh) -> Mesh {
    let Mesh { mut positions, .. } = mesh.clone();
    positions.push(0.5 * (positions[0] + positions[1]));
    let faces = vec![[0, 2, 4], [4, 2, 1], [0, 4, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let filled = Mesh { positions, faces };
    if filled.volume() > 0.0 { filled } else { filled.flipped() }
}

fn tree(mesh: &Mesh, turn: DQuat) -> SurfaceTree {
    let mesh = mesh.clone().mapped(|x| turn * x);
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("planted bodies are finite")
}

/// Parts of the other body that are nearest to the filled edge are outside all the same: its faces
/// meet at an acute angle, and the sliver between them has no normal, or any.
#[test]
fn slivers_do_not_turn_the_side_of_a_joint() {
    let plain = tetrahedron([[-6, 0, 0], [6, 0, 0], [0, 1, -6], [0, -1, -6]]);
    let plain = if plain.volume() > 0.0 { plain } else { plain.flipped() };
    let filled = with_sliver(&plain);
    let other = tetrahedron([[-2, -3, 1], [-2, 3, 1], [2, 0, -5], [3, 0, 4]]);
    let other = if other.volume() > 0.0 { other } else { other.flipped() };

    let params = JointContactParams { margin: 0.1, resolution: 0.1, foundation: None };
    let measure = |mesh: &Mesh, turn: DQuat| {
        let (a, b) = (tree(mesh, turn), tree(&other, turn));
        let mut detector = OverlapDetector::default();
        detector.measure(&a, &b);
        let found = detector.joint_contact([&a, &b], &params, Progress::none());
        found.expect("in range").map(|contact| contact.total.area)
    };
    let known = measure(&plain, DQuat::IDENTITY);
    assert!(known[1] > 0.1, "{known:?}");
    for step in 0..20_u8 {
        let turn = DQuat::from_scaled_axis(f64::from(step) * DVec3::new(0.1, 0.2, -0.05));
        for (found, known) in measure(&filled, turn).into_iter().zip(known) {
            assert!((found - known).abs() < 0.02 * known, "{found} for {known}, turned by {turn}");
        }
    }
}

/// Turns leave the sliver an area of rounding, in any direction, and its middle corner lies on an
/// edge of the other body.
#[test]
fn measures_of_bodies_with_slivers_are_those_without() {
    let plain = tetrahedron([[-4, 4, -4], [0, -4, 4], [-4, 0, 0], [4, 0, -4]]);
    let other = tetrahedron([[0, 4, 4], [0, 0, 4], [-4, 0, -4], [4, 4, 4]]);
    assert!(plain.volume() > 0.0 && other.volume() > 0.0, "faces outward");
    let filled = with_sliver(&plain);

    let mut detector = OverlapDetector::default();
    let mut measure = |a: &Mesh, b: &Mesh, turn: DQuat| {
        let found = detector.measure(&tree(a, turn), &tree(b, turn)).total;
        [found.volume, found.area_of_a_inside_b, found.area_of_b_inside_a].map(Option::unwrap)
    };
    let known = measure(&plain, &other, DQuat::IDENTITY);
    assert!((known[0] - 0.406_349_206_349_2).abs() < 1e-12, "{known:?}");

    let mut random = Random(5);
    for _ in 0..1000 {
        let mut number = || random.unit() - 0.5;
        let turn = DQuat::from_xyzw(number(), number(), number(), number()).normalize();
        for (found, known) in measure(&filled, &other, turn).into_iter().zip(known) {
            assert!((found - known).abs() < 1e-11, "{found} for {known}, turned by {turn}");
        }
    }
}
