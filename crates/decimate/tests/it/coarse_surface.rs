//! Coarse surfaces that follow a deformation.

use decimate::CoarseSurface;
use fixtures::shapes;
use glam::{DMat3, DVec3};

use crate::{reduced, tree};

fn coarse(mesh: &fixtures::Mesh) -> CoarseSurface {
    CoarseSurface::new(reduced(mesh, 0.5), &tree(mesh)).expect("a reduced surface")
}

#[test]
fn it_stands_on_the_vertices_of_the_full_surface() {
    let mesh = shapes::icosphere(40.0, 4);
    let mut coarse = coarse(&mesh);
    let bent = mesh.clone().mapped(|p| DVec3::new(p.x, p.y + 0.01 * p.x * p.x, 1.3 * p.z));
    coarse.follow(&bent.positions).expect("finite positions");
    assert!(coarse.deviation() > coarse.reduced().deviation, "{}", coarse.deviation());
    for (x, &vertex) in coarse.tree().positions().as_slice().iter().zip(&coarse.reduced().kept) {
        assert_eq!(*x, bent.positions[vertex as usize]);
    }
    assert!(coarse.reduced().deviation <= 0.5);

    let mut unchanged = coarse.clone();
    unchanged.follow(&vec![DVec3::NAN; mesh.positions.len()]).expect_err("not finite");
    assert_eq!(unchanged.deviation().to_bits(), coarse.deviation().to_bits());
    assert_eq!(unchanged.tree().positions().as_slice(), coarse.tree().positions().as_slice());
}

/// The full surface need not be where it was decimated.
#[test]
fn its_deviation_is_that_of_the_positions_it_is_built_at() {
    let mesh = shapes::icosphere(40.0, 4);
    let large = mesh.clone().mapped(|p| 3.0 * p);
    let built = CoarseSurface::new(reduced(&mesh, 0.5), &tree(&large)).expect("a reduced surface");
    let mut moved = coarse(&mesh);
    moved.follow(&large.positions).expect("finite positions");
    assert_eq!(built.deviation().to_bits(), moved.deviation().to_bits());
    assert!(built.deviation() > 2.0 * built.reduced().deviation, "{}", built.deviation());
    assert_eq!(coarse(&mesh).deviation().to_bits(), built.reduced().deviation.to_bits());
}

/// A vertex that was not kept is no less part of the deviation.
#[test]
fn positions_out_of_range_are_refused_by_their_vertex() {
    let mesh = shapes::icosphere(40.0, 3);
    let mut coarse = coarse(&mesh);
    let kept = coarse.reduced().kept.clone();
    let removed = (0..).find(|vertex| !kept.contains(vertex)).expect("a removed vertex");
    let before = coarse.deviation();
    for vertex in [removed, kept[3]] {
        for value in [f64::NAN, f64::INFINITY, 1e200, 1e32] {
            let mut x = mesh.positions.clone();
            x[vertex as usize].y = value;
            let error = coarse.follow(&x).expect_err("out of range").to_string();
            assert!(error.contains(&format!("vertex {vertex} ")), "{error}");
            assert_eq!(coarse.deviation().to_bits(), before.to_bits());
        }
    }
}

#[test]
fn every_vertex_moves_with_a_point_near_it() {
    let mut mesh = shapes::icosphere(40.0, 4);
    mesh.positions.push(DVec3::splat(500.0));
    let coarse = coarse(&mesh);
    let faces = coarse.reduced().surface.faces();
    for (vertex, &p) in (0..).zip(&mesh.positions) {
        let leaders = coarse.leaders(vertex);
        let sum: f64 = leaders.iter().map(|(_, weight)| weight).sum();
        let image: DVec3 = leaders.iter().map(|&(v, w)| w * mesh.positions[v as usize]).sum();
        assert!((sum - 1.0).abs() < 1e-12 && p.distance(image) <= coarse.deviation());

        // All in one face, but for the vertex without faces.
        let has_all = |face: &[u32; 3]| {
            let kept = face.map(|corner| coarse.reduced().kept[corner as usize]);
            leaders.iter().all(|(leader, _)| kept.contains(leader))
        };
        let is_alone = leaders.iter().all(|&(leader, _)| leader == vertex);
        assert!(faces.iter().any(has_all) || is_alone, "{vertex}: {leaders:?}");
    }
}

/// Displacements that are linear in the position are reproduced where both surfaces agree, and
/// elsewhere up to the deviation.
#[test]
fn displacements_carry_over() {
    let mesh = shapes::icosphere(40.0, 4);
    let coarse = coarse(&mesh);
    let stretch = DMat3::from_diagonal(DVec3::new(0.1, -0.2, 0.3));
    let wanted: Vec<DVec3> = mesh.positions.iter().map(|&p| stretch * p + DVec3::X).collect();
    let mut displacements = vec![DVec3::ZERO; wanted.len()];
    for &vertex in &coarse.reduced().kept {
        displacements[vertex as usize] = wanted[vertex as usize];
    }
    coarse.spread(&mut displacements);
    for (found, wanted) in displacements.iter().zip(&wanted) {
        assert!(found.distance(*wanted) <= 0.3 * coarse.reduced().deviation + 1e-12);
    }
    for &vertex in &coarse.reduced().kept {
        assert_eq!(displacements[vertex as usize], wanted[vertex as usize]);
    }
}
