//! Normals at vertices for smooth shading: those of the faces around, weighted
//! by their area. Only the eye is served; distances have normals of their own.

use glam::DVec3;

/// |V| unit normals; a vertex without a face that has area gets an arbitrary one.
pub(crate) fn vertex_normals(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for face in faces {
        let [a, b, c] = face.map(|vertex| positions[vertex as usize]);
        let area = (b - a).cross(c - a);
        for vertex in face {
            normals[*vertex as usize] += area;
        }
    }
    for normal in &mut normals {
        *normal = normal.normalize_or(DVec3::Z);
    }
    normals
}
