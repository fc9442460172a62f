//! Tests of decimation as a caller uses it.

mod anatomy;
mod certificate;
mod coarse_surface;
mod preview;
mod reduced;

use decimate::{DecimateError, Decimation, ReducedSurface};
use fixtures::{Mesh, femur, shapes};
use proximity::SurfaceTree;
use surface::progress::Progress;

/// Three closed bodies: round, with a handle, and of varying curvature.
fn bodies() -> [(&'static str, Mesh); 3] {
    [
        ("sphere", shapes::icosphere(40.0, 4)),
        ("torus", shapes::torus(40.0, 12.0, [72, 32])),
        ("femur", femur::femur(6.0)),
    ]
}

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("finite positions")
}

fn decimation(mesh: &Mesh) -> Result<Decimation, DecimateError> {
    Decimation::new(tree(mesh), Progress::none())
}

/// Decimates a closed mesh.
fn reduced(mesh: &Mesh, max_deviation: f64) -> ReducedSurface {
    let decimation = decimation(mesh).expect("a closed surface");
    decimation.within(max_deviation, Progress::none()).expect("a deviation in range")
}

/// Returns a reduced surface of a mesh as a mesh.
fn gathered(mesh: &Mesh, reduced: &ReducedSurface) -> Mesh {
    let mut positions = Vec::new();
    reduced.gather(&mesh.positions, &mut positions);
    Mesh { positions, faces: reduced.surface.faces().to_vec() }
}
