//! Coarse surfaces that follow a deformation.

use decimate::CoarseSurface;
use fixtures::shapes;
use glam::{DMat3, DVec3};
use surface::progress::Progress;

use crate::{reduced, tree};

fn coarse(mesh: &fixtures::Mesh) -> CoarseSurface {
    CoarseSurface::new(reduced(mesh, 0.5), &tree(mesh), Progress::none())
        .expect("a reduced surface")
}

#[test]
fn it_stands_on_the_vertices_of_the_full_surface() {
    let mesh = shapes::icosphere(40.0, 4);
    let mut coarse = coarse(&mesh);
    let bent = mesh.clone().mapped(|p| DVec3::new(p.x, p.y + 0.01 * p.x * p.x, 1.3 * p.z));
    coarse.follow(&bent.positions).expect("finite positions");
    for (x, &vertex) in coarse.tree().positions().as_slice().iter().zip(&coarse.reduced().kept) {
        assert_eq!(*x, bent.positions[vertex as usize]);
    }
    assert!(coarse.reduced().deviation.upper() <= 0.5);

    let mut unchanged = coarse.clone();
    unchanged.follow(&vec![DVec3::NAN; mesh.positions.len()]).expect_err("not finite");
    assert_eq!(unchanged.tree().positions().as_slice(), coarse.tree().positions().as_slice());
}

#[test]
fn every_vertex_is_attached_to_one_face_near_it() {
    let mesh = shapes::icosphere(40.0, 4);
    let coarse = coarse(&mesh);
    let mut count = 0;
    for face in 0..u32::try_from(coarse.tree().surface().faces().len()).unwrap() {
        let attached = coarse.attached_to(face);
        assert!(attached.is_sorted_by(|a, b| a < b));
        for &vertex in attached {
            let p = mesh.positions[vertex as usize];
            assert!(
                coarse.tree().closest_on_face(p, face).distance
                    <= coarse.reduced().deviation.upper()
            );
            count += 1;
        }
    }
    assert_eq!(count, mesh.positions.len());
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
        assert!(found.distance(*wanted) <= 0.3 * coarse.reduced().deviation.upper() + 1e-12);
    }
    for &vertex in &coarse.reduced().kept {
        assert_eq!(displacements[vertex as usize], wanted[vertex as usize]);
    }
}
