//! A coarser surface, and its positions.

use glam::DVec3;
use surface::TriangleSurface;

use crate::Deviation;

/// A coarser surface on some of the vertices of a full one.
#[derive(Clone, Debug)]
pub struct ReducedSurface {
    /// Its connectivity, in its own numbers: closed, manifold and oriented, of the
    /// same genus.
    pub surface: TriangleSurface,
    /// For each vertex of `surface`, its number in the full surface, ascending.
    pub kept: Vec<u32>,
    /// How far it is from the full surface, at the positions it was made for.
    pub deviation: Deviation,
}

impl ReducedSurface {
    /// Positions of its vertices from those of the full surface, into `out`, which is
    /// cleared; nothing is allocated where its capacity suffices.
    ///
    /// # Panics
    ///
    /// When `x` has fewer positions than the full surface has vertices.
    pub fn gather(&self, x: &[DVec3], out: &mut Vec<DVec3>) {
        out.clear();
        out.extend(self.kept.iter().map(|vertex| x[*vertex as usize]));
    }
}
