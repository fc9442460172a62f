//! Why a file is not a mesh, and where in it.

/// What is wrong with a mesh file. The path is the caller's to name.
///
/// Vertices and faces are counted from 0 in the order of the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum MeshError {
    /// The operating system could not hand over the file.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    #[error("is empty (0 bytes)")]
    Empty,
    #[error("is of no format known here: expected PLY, OBJ, STL or VTP")]
    Unrecognised,
    /// The text or bytes do not follow the format.
    #[error("{format} file: {place}: {problem}")]
    Malformed { format: &'static str, place: String, problem: String },
    /// The format allows it, this program does not read it.
    #[error("{format} file: {feature} cannot be read; {advice}")]
    Unsupported { format: &'static str, feature: String, advice: &'static str },
    #[error("holds {vertices} vertices and no faces")]
    NoFaces { vertices: usize },
    #[error("holds {count} {what}, more than 32-bit indices can number")]
    TooMany { what: &'static str, count: usize },
    #[error("vertex {vertex} is at ({x}, {y}, {z}), which is not finite")]
    NotFinite { vertex: usize, x: f64, y: f64, z: f64 },
    #[error(
        "face {face} refers to vertex {vertex}, but there are {vertex_count} vertices (counted from 0)"
    )]
    VertexOutOfRange { face: usize, vertex: i64, vertex_count: usize },
    #[error("face {face} has {corners} corners, fewer than a triangle")]
    TooFewCorners { face: usize, corners: usize },
    /// No fan about a corner covers the polygon without folding over.
    #[error(
        "face {face} is a polygon of {corners} corners that folds over when it is fanned from any of them; split it into triangles first"
    )]
    NotFannable { face: usize, corners: usize },
}
