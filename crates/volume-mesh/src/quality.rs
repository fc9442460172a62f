//! Quality of cells: the scaled Jacobian.
//!
//! At each corner of a cell, the determinant of its three edges over the product of their lengths;
//! times √2 in tetrahedra and 2/√3 in wedges, so that regular ones have 1. The least of all corners is that of the cell.
//! It is 0 for a flat cell, and negative for an inverted one.
//!
//! Source: P. M. Knupp, C. D. Ernst, D. C. Thompson, C. J. Stimpson and P. P. Pébay, "The Verdict
//! geometric quality library", SAND2007-1751, 2007, sections 5, 6 and 8.

use std::f64::consts::SQRT_2;

use glam::{DMat3, DVec3};

use crate::{Cell, VolumeMesh};

/// Quality of all cells of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Smallest scaled Jacobian, at most 1.
    pub min_scaled_jacobian: f64,
    /// Cell with the smallest scaled Jacobian.
    pub worst_cell: usize,
    /// Number of cells whose scaled Jacobian is not above 0.
    pub inverted: usize,
}

impl VolumeMesh {
    /// Measures the cells at some positions of the nodes.
    ///
    /// # Panics
    ///
    /// With fewer positions than nodes.
    #[must_use]
    pub fn quality(&self, positions: &[DVec3]) -> MeshQuality {
        let (min_scaled_jacobian, worst_cell, inverted) = (f64::INFINITY, 0, 0);
        let mut quality = MeshQuality { min_scaled_jacobian, worst_cell, inverted };
        for (number, cell) in self.cells().iter().enumerate() {
            let jacobian = scaled_jacobian(cell, positions);
            quality.inverted += usize::from(jacobian <= 0.0);
            if jacobian < quality.min_scaled_jacobian {
                quality.min_scaled_jacobian = jacobian;
                quality.worst_cell = number;
            }
        }
        quality
    }

    /// Computes the scaled Jacobian of every cell.
    pub(crate) fn scaled_jacobians(&self, positions: &[DVec3]) -> Vec<f64> {
        self.cells().iter().map(|cell| scaled_jacobian(cell, positions)).collect()
    }
}

/// Computes the least scaled Jacobian of a cell's corners; −1 where it is not finite.
pub(crate) fn scaled_jacobian(cell: &Cell, positions: &[DVec3]) -> f64 {
    let node = |place: usize| positions[cell.nodes()[place] as usize];
    let factor = match cell {
        Cell::Tetrahedron(_) => SQRT_2,
        Cell::Wedge(_) => 2.0 / 3.0_f64.sqrt(),
        Cell::Hexahedron(_) => 1.0,
    };
    let mut least = f64::INFINITY;

    for &[corner, a, b, c] in cell.corners() {
        // Edges without a length make the corner flat, whatever their determinant.
        let edges = [a, b, c].map(|end| node(end) - node(corner));
        let lengths: f64 = edges.iter().map(|edge| edge.length()).product();
        let determinant = DMat3::from_cols(edges[0], edges[1], edges[2]).determinant();
        let scaled = if lengths > 0.0 { factor * determinant / lengths } else { 0.0 };
        least = least.min(if scaled.is_finite() { scaled } else { -1.0 });
    }
    least
}
