//! Meshes of `boolmesh`, and their volumes.

use boolmesh::prelude::Manifold;
use fixtures::Mesh;

/// Builds the mesh that `boolmesh` computes with.
///
/// # Errors
///
/// The reason for which it refuses a mesh.
pub fn manifold(mesh: &Mesh) -> Result<Manifold, String> {
    let mut coordinates = Vec::new();
    for position in &mesh.positions {
        coordinates.extend(position.to_array());
    }
    let mut corners = Vec::new();
    for face in &mesh.faces {
        corners.extend(face.map(|vertex| vertex as usize));
    }
    Manifold::new(&coordinates, &corners)
}

/// Computes the volume of a mesh.
#[must_use]
pub fn volume(mesh: &Manifold) -> f64 {
    let mut six_volumes = 0.0_f64;
    for face in mesh.hs.chunks_exact(3) {
        let [p, q, r] = [0, 1, 2].map(|corner| mesh.ps[face[corner].tail]);
        six_volumes += p.dot(q.cross(r));
    }
    six_volumes / 6.0
}
