//! A coarser surface on vertices of a full one.

use std::sync::Arc;

use glam::DVec3;
use surface::TriangleSurface;

use crate::coarse_map::CoarseMap;

/// Coarser surface on some of the vertices of a full one.
#[derive(Clone, Debug)]
pub struct ReducedSurface {
    /// Its connectivity, in its own vertex numbers: closed, manifold and oriented, of the
    /// same genus as the full surface.
    pub surface: Arc<TriangleSurface>,
    /// Per vertex of `surface`, its number in the full surface, ascending.
    pub kept: Vec<u32>,
    /// Proved bound on the deviation of this surface from the full one, at the positions that
    /// it was decimated at.
    ///
    /// No point of either surface is farther from the other (Hausdorff distance). About every
    /// point that is farther from one of them, both have the same winding number: what is
    /// deeper inside of one is inside of the other, and no crack or plate that is thinner opens
    /// or closes farther away.
    pub deviation: f64,
    /// Map from the full surface onto this one.
    pub(crate) map: CoarseMap,
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

    /// Bounds the deviation at positions of the full surface and of the kept vertices.
    pub(crate) fn deviation_at(&self, x: &[DVec3], kept: &[DVec3]) -> f64 {
        // All vertices of the full surface itself are kept.
        if self.map.is_empty() { 0.0 } else { self.map.max_shift(x, kept) }
    }
}
