//! Areas, normals and edge lengths of whole surfaces.

use glam::DVec3;

use crate::triangle;
use crate::{Positions, TriangleSurface};

/// Computes the area of each vertex, |V|: a third of the areas of its faces.
///
/// # Panics
///
/// When a face refers to a vertex without a position.
#[must_use]
pub fn vertex_areas(faces: &[[u32; 3]], x: &[DVec3]) -> Vec<f64> {
    let mut areas = vec![0.0; x.len()];
    for face in faces {
        let third = triangle::normal(face.map(|vertex| x[vertex as usize])).length() / 6.0;
        for &vertex in face {
            areas[vertex as usize] += third;
        }
    }
    areas
}

/// Computes the area-weighted unit normal of each vertex, |V|; zero for a vertex whose
/// faces have no area.
///
/// These suit shading and the direction of a correction. For the sign of a distance use
/// [`Pseudonormals`](crate::Pseudonormals).
///
/// # Panics
///
/// When a face refers to a vertex without a position.
#[must_use]
pub fn vertex_normals(faces: &[[u32; 3]], x: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; x.len()];
    for face in faces {
        let normal = triangle::normal(face.map(|vertex| x[vertex as usize]));
        for &vertex in face {
            normals[vertex as usize] += normal;
        }
    }
    normalized(normals)
}

/// Scales vectors to unit length, or to zero where they have none.
pub(crate) fn normalized(mut vectors: Vec<DVec3>) -> Vec<DVec3> {
    for vector in &mut vectors {
        *vector = vector.normalize_or_zero();
    }
    vectors
}

/// Computes the mean length of the edges, 0 for a surface without edges.
///
/// # Panics
///
/// When `x` was checked against a surface with fewer vertices.
#[must_use]
pub fn mean_edge(surface: &TriangleSurface, x: Positions<'_>) -> f64 {
    let edges = surface.edges();
    if edges.is_empty() {
        return 0.0;
    }
    let total: f64 = edges.iter().map(|&[from, to]| x.at(from).distance(x.at(to))).sum();
    total / as_f64(edges.len())
}

#[expect(clippy::cast_precision_loss, reason = "there are fewer than 2^33 edges")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "exact by construction")]

    use super::*;

    #[test]
    fn a_right_angle_is_measured() {
        let surface = TriangleSurface::new(4, vec![[0, 1, 2]]).unwrap();
        let x = [DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 4.0, DVec3::ONE];
        let positions = surface.positions(&x).unwrap();
        assert_eq!(vertex_areas(surface.faces(), &x), [2.0, 2.0, 2.0, 0.0]);
        assert_eq!(mean_edge(&surface, positions), 4.0);
        let up = DVec3::Z;
        assert_eq!(vertex_normals(surface.faces(), &x), [up, up, up, DVec3::ZERO]);
    }

    #[test]
    fn nothing_has_no_edges() {
        let surface = TriangleSurface::new(0, vec![]).unwrap();
        assert_eq!(mean_edge(&surface, surface.positions(&[]).unwrap()), 0.0);
    }
}
