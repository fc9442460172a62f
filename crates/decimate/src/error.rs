//! Errors of decimation.

use proximity::ProximityError;
use surface::SurfaceError;
use surface::progress::Interrupted;

/// Error of decimating a surface, or of measuring a reduced one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DecimateError {
    /// The surface is open, not manifold or not oriented.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A tree over the reduced surface could not be built.
    #[error(transparent)]
    Proximity(#[from] ProximityError),
    /// The progress handler ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A face uses one vertex twice, so that it is an edge.
    #[error("face {face} uses vertex {vertex} more than once: remove it")]
    RepeatedVertex {
        /// The first such face.
        face: usize,
        /// The vertex it repeats.
        vertex: u32,
    },
    /// The surface has fewer faces than a tetrahedron.
    #[error("the surface has {faces} faces; a closed one has at least 4")]
    TooSmall {
        /// Number of its faces.
        faces: usize,
    },
    /// The largest deviation allowed is not positive, or not finite.
    #[error("max_deviation is {value}, but must be positive and finite")]
    MaxDeviation {
        /// The value given.
        value: f64,
    },
}
