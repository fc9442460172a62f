//! A surface as binary PLY.

use glam::DVec3;

/// A `.ply` file. Coordinates are doubles: rounded to single precision, bodies
/// that just do not touch would overlap again.
pub(crate) fn ply(positions: &[DVec3], faces: &[[u32; 3]]) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        positions.len(),
        faces.len()
    )
    .into_bytes();
    file.extend(positions.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes));
    for face in faces {
        file.push(3);
        file.extend(face.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    file
}
