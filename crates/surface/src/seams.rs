//! Seams: edges of the border that lie in the same place, along which vertices are not welded.
//!
//! Files in which each face has corners of its own, and those that double vertices where a texture is cut, hold
//! surfaces that are closed to the eye and open by their connectivity.

use crate::positions::place_bits;
use crate::{Positions, SurfaceError, TriangleSurface};

impl TriangleSurface {
    /// Checks that no two edges of the border have ends of exactly the same positions.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Unwelded`] with the number of such edges and the first.
    ///
    /// # Panics
    ///
    /// When `x` was checked against a surface with fewer vertices.
    pub fn require_welded(&self, x: Positions<'_>) -> Result<(), SurfaceError> {
        let edges = self.unwelded_edges(x);
        let Some(&first) = edges.first() else { return Ok(()) };
        let [from, to] = self.edges()[first as usize];
        Err(SurfaceError::Unwelded { count: edges.len(), from, to })
    }

    /// Lists the edges with one face whose ends are exactly where those of another one are, ascending.
    pub(crate) fn unwelded_edges(&self, x: Positions<'_>) -> Vec<u32> {
        let mut places = Vec::new();
        for edge in self.boundary_edges() {
            let mut ends = self.edges()[edge as usize].map(|end| place_bits(x.at(end)));
            ends.sort_unstable();
            places.push((ends, edge));
        }
        places.sort_unstable();

        let mut unwelded = Vec::new();
        for in_place in places.chunk_by(|(p, _), (q, _)| p == q) {
            if in_place.len() > 1 {
                unwelded.extend(in_place.iter().map(|(_, edge)| *edge));
            }
        }
        unwelded.sort_unstable();
        unwelded
    }
}
