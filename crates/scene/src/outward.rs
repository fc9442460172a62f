//! Surfaces turned over: the outer sides of bodies whose faces look inward.
//!
//! Inside is decided by the parity of crossings, whichever way faces look. Contact steps also take the outer
//! side of faces from their normals: those of a body that is inside out, of its faces turned over.

use surface::{SurfaceError, TriangleSurface};

/// Returns a surface with all faces turned over, by the same numbers.
pub(crate) fn turned_over(surface: &TriangleSurface) -> Result<TriangleSurface, SurfaceError> {
    let faces = surface.faces().iter().map(|&[p, q, r]| [p, r, q]).collect();
    TriangleSurface::new(surface.vertex_count(), faces)
}
