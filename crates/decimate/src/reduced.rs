//! A coarser surface on vertices of a full one.

use std::sync::Arc;

use glam::DVec3;
use surface::{HausdorffBounds, TriangleSurface};

/// Coarser surface on some of the vertices of a full one.
#[derive(Clone, Debug)]
pub struct ReducedSurface {
    /// Its connectivity, in its own vertex numbers: closed, manifold and oriented, of the
    /// same genus as the full surface.
    pub surface: Arc<TriangleSurface>,
    /// Per vertex of `surface`, its number in the full surface, ascending.
    pub kept: Vec<u32>,
    /// Hausdorff distance between the full surface (`forward`) and this one, at the
    /// positions it was decimated at.
    pub deviation: HausdorffBounds,
}

impl ReducedSurface {
    /// Writes the positions of its vertices into `out`, which is cleared, from those of the
    /// full surface. Allocates nothing where the capacity suffices.
    ///
    /// # Panics
    ///
    /// When `x` has fewer positions than the full surface has vertices.
    pub fn gather(&self, x: &[DVec3], out: &mut Vec<DVec3>) {
        out.clear();
        out.extend(self.kept.iter().map(|&vertex| x[vertex as usize]));
    }
}
