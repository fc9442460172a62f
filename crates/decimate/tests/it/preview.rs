//! Surfaces to look at.

use decimate::{DecimateError, Preview};
use fixtures::{Mesh, data, shapes};
use surface::{SurfaceError, inspect};

use crate::bodies;
use crate::certificate::max_distance;

fn preview(mesh: &Mesh, tolerance: f64) -> Mesh {
    let preview = Preview::new(&mesh.surface(), &mesh.positions, tolerance);
    let Preview { kept, faces } = preview.expect("a closed surface");
    assert!(kept.is_sorted_by(|a, b| a < b), "vertices are numbered in their order");
    let positions = kept.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    Mesh { positions, faces }
}

/// Measures the farthest vertex of a mesh from a coarser one.
fn farthest(mesh: &Mesh, coarse: &Mesh) -> f64 {
    max_distance(mesh.positions.iter().copied(), coarse)
}

#[test]
fn it_is_near_the_surface_and_of_its_genus() {
    for (name, mesh) in bodies() {
        let euler = |mesh: &Mesh| {
            let surface = mesh.surface();
            inspect(&surface, surface.positions(&mesh.positions).expect("positions")).euler
        };
        for (tolerance, max_faces) in [(0.8, mesh.faces.len() / 2), (2.0, mesh.faces.len() / 10)] {
            let coarse = preview(&mesh, tolerance);
            let surface = coarse.surface();
            surface.require_closed().expect("a closed surface");
            surface.require_manifold().expect("a manifold");
            surface.require_oriented().expect("an oriented surface");
            assert_eq!(euler(&coarse), euler(&mesh), "{name}: handles");

            let distance = farthest(&mesh, &coarse);
            assert!(distance <= 1.1 * tolerance, "{name}: {distance} at {tolerance}");
            let faces = coarse.faces.len();
            assert!(faces <= max_faces, "{name}: {faces} of {} faces", mesh.faces.len());
        }
    }
}

#[test]
fn real_bodies_are_near() {
    let Some(folder) = data::anatomy("real_bodies_are_near") else {
        return;
    };
    for name in ["muscle_pectineus", "muscle_tensor_fasciae_latae", "bone_pelvis"] {
        let mesh = data::mesh(&folder.join("vhf_left_thigh").join(name).with_extension("ply"));
        for tolerance in [0.2, 0.5, 1.0] {
            let distance = farthest(&mesh, &preview(&mesh, tolerance));
            assert!(distance <= 1.2 * tolerance, "{name}: {distance} at {tolerance}");
        }
    }
}

#[test]
fn what_cannot_be_thinned_out_is_refused() {
    let ball = shapes::icosphere(10.0, 2);
    let surface = ball.surface();
    let of = |positions, tolerance| Preview::new(&surface, positions, tolerance).expect_err("no");
    for tolerance in [0.0, -1.0, f64::NAN] {
        let error = of(&ball.positions, tolerance);
        assert!(matches!(error, DecimateError::MaxDeviation { .. }), "{tolerance}: {error}");
    }
    let error = of(&ball.positions[1..], 1.0);
    assert!(matches!(error, DecimateError::Surface(SurfaceError::PositionCount { .. })), "{error}");

    let mut open = ball.clone();
    open.faces.pop();
    let error = Preview::new(&open.surface(), &open.positions, 1.0).expect_err("a hole");
    assert!(matches!(error, DecimateError::Surface(SurfaceError::Open { .. })), "{error}");
}
