//! Why a surface cannot be decimated, or a coarser one not be had.

use surface::SurfaceError;

/// What is wrong with a surface or with what was asked of it, and where.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DecimateError {
    /// The surface is open, not manifold or not oriented, or its positions are wrong.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A tree over it cannot be built.
    #[error(transparent)]
    Tree(#[from] kdop::TreeError),
    /// A face uses one vertex twice, so that it is an edge.
    #[error("face {face} uses vertex {vertex} more than once")]
    RepeatedVertex {
        /// The first such face.
        face: usize,
        /// The vertex it repeats.
        vertex: u32,
    },
    /// A closed surface has at least the four faces of a tetrahedron.
    #[error("the surface has {faces} faces; a closed one has at least 4")]
    TooSmall {
        /// How many it has.
        faces: usize,
    },
    /// A parameter is outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// Fewer faces were asked for than shape and topology allow.
    #[error("{asked} faces were asked for, but shape and topology allow no fewer than {fewest}")]
    TooFewFaces {
        /// Faces asked for.
        asked: usize,
        /// Faces of the coarsest surface.
        fewest: usize,
    },
}
