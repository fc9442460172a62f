//! Errors, and reasons why a surface has no inside.

use ccd::CcdError;
use kdop::TreeError;
use surface::progress::Interrupted;
use surface::{SurfaceError, TriangleSurface};

/// Error of building a tree over a surface, or of moving it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProximityError {
    /// The positions do not fit the surface, or are not finite.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The surface has more faces or vertices than a tree can hold.
    #[error(transparent)]
    Tree(#[from] TreeError),
}

/// Error of a swept query.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SweptError {
    /// The parameters are out of range.
    #[error(transparent)]
    Ccd(#[from] CcdError),
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Error of comparing two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PairError {
    /// More faces are near each other than can be listed in reasonable memory.
    #[error(
        "more than {limit} pairs of faces are within the margin of {margin} of each other: take a smaller margin, in the unit of the positions, or coarser surfaces"
    )]
    TooManyNearFaces {
        /// The margin.
        margin: f64,
        /// The limit.
        limit: usize,
    },
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Reason why "inside" is undefined for a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NoInside {
    /// The surface was declared open.
    #[error("declared open, so nothing is inside it")]
    DeclaredOpen,
    /// The parity of ray crossings is undefined.
    #[error(
        "no inside: {count} edges have an odd number of faces, the first, between vertices {from} and {to}, has {faces}"
    )]
    OddEdges {
        /// Edges with an odd number of faces.
        count: usize,
        /// First end of the first of them.
        from: u32,
        /// Its second end.
        to: u32,
        /// Its number of faces.
        faces: usize,
    },
    /// Winding numbers are undefined; ray parity is not.
    #[error(
        "no winding number: along {count} edges more faces run in one direction than in the other, the first from vertex {from} to {to}; orient the faces alike"
    )]
    Misoriented {
        /// Edges along which more faces run in one direction than in the other.
        count: usize,
        /// First end of the first of them, in that direction.
        from: u32,
        /// Its second end.
        to: u32,
    },
}

impl NoInside {
    /// Returns the reason why ray parity is undefined for a surface, if it is.
    pub(crate) fn find(surface: &TriangleSurface) -> Option<Self> {
        let mut odd = (0_u32..)
            .zip(surface.edges())
            .map(|(edge, ends)| (ends, surface.edge_faces(edge).len()))
            .filter(|(_, faces)| faces % 2 == 1);

        let (&[from, to], faces) = odd.next()?;
        Some(Self::OddEdges { count: 1 + odd.count(), from, to, faces })
    }

    /// Returns the reason why winding numbers are undefined where ray parity is defined, if there is
    /// one.
    pub(crate) fn find_misoriented(surface: &TriangleSurface) -> Option<Self> {
        // One pass over the faces settles that there are none, as on nearly all surfaces.
        surface.require_oriented().err()?;
        let mut unbalanced = surface.unbalanced_half_edges();
        let [from, to] = unbalanced.next()?;
        Some(Self::Misoriented { count: 1 + unbalanced.count(), from, to })
    }
}
