//! Errors of surfaces and simplex surfaces.

use glam::DVec3;

/// Error of a surface or its positions.
///
/// Each variant names the first offender, so that a message can be matched
/// with the file the mesh came from.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A face refers to a vertex that does not exist.
    #[error("face {face} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    VertexOutOfRange {
        /// Position of the face in the list.
        face: usize,
        /// The index it holds.
        vertex: u32,
        /// Vertices the surface was declared with.
        vertex_count: usize,
    },
    /// More vertices or faces than 32-bit indices can number.
    #[error("{count} {what} are more than the {limit} that a surface can number")]
    TooMany {
        /// `"vertices"` or `"faces"`.
        what: &'static str,
        /// Number given.
        count: usize,
        /// Maximum.
        limit: usize,
    },
    /// The list of positions differs in length from the surface's vertices.
    #[error("the surface has {expected} vertices, but {got} positions were given")]
    PositionCount {
        /// Vertices of the surface.
        expected: usize,
        /// Positions given.
        got: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is at ({}, {}, {}), which is not finite", .at.x, .at.y, .at.z)]
    NotFinite {
        /// The first such vertex.
        vertex: usize,
        /// Its position, as given.
        at: DVec3,
    },
    /// A coordinate is so large that products of coordinates could overflow.
    #[error(
        "vertex {vertex} has the coordinate {value:e}, but magnitudes end at {max:e}: products of coordinates would overflow",
        max = crate::range::MAX_COORDINATE
    )]
    TooLarge {
        /// The first such vertex.
        vertex: usize,
        /// Its largest coordinate.
        value: f64,
    },
    /// All coordinates are so small that their products vanish.
    #[error(
        "the largest coordinate is {largest:e}, but must reach {min:e}, or be 0: products of coordinates would vanish",
        min = crate::range::MIN_SIZE
    )]
    TooSmall {
        /// Magnitude of the largest coordinate.
        largest: f64,
    },
    /// The surface has a border, so it has no interior.
    #[error(
        "the surface is open: {count} edges have one face only, the first between vertices {from} and {to} of face {face}"
    )]
    Open {
        /// Edges with one face.
        count: usize,
        /// First end of the first of them.
        from: u32,
        /// Its second end.
        to: u32,
        /// Its face.
        face: u32,
    },
    /// Edges of the border are in the same place: their vertices are not welded.
    #[error(
        "the vertices are not welded: {count} edges with one face only are in the place of others, the first between vertices {from} and {to}; merge vertices of equal positions"
    )]
    Unwelded {
        /// Edges with one face in the place of another one.
        count: usize,
        /// First end of the first of them.
        from: u32,
        /// Its second end.
        to: u32,
    },
    /// More than two faces meet at an edge.
    #[error(
        "the surface is not manifold: {count} edges have more than two faces, the first between vertices {from} and {to}"
    )]
    NonManifold {
        /// Edges with more than two faces.
        count: usize,
        /// First end of the first of them.
        from: u32,
        /// Its second end.
        to: u32,
    },
    /// A vertex joins faces that no edge joins.
    #[error(
        "the surface is not manifold: {count} vertices join faces that no edge joins, the first is vertex {vertex}"
    )]
    NonManifoldVertex {
        /// Such vertices.
        count: usize,
        /// The first of them.
        vertex: u32,
    },
    /// Neighboring faces have opposite orientations.
    #[error(
        "the surface is not oriented: {count} edges are run along by more than one face in the same direction, the first from vertex {from} to {to}"
    )]
    Misoriented {
        /// Directed edges with more than one face.
        count: usize,
        /// First end of the first of them.
        from: u32,
        /// Its second end.
        to: u32,
    },
}

/// Error of a simplex surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplexError {
    /// The triangulation has no dual, or is not a surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A polygon refers to a vertex that does not exist.
    #[error("polygon {polygon} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    VertexOutOfRange {
        /// Position of the polygon in the list.
        polygon: usize,
        /// The index it holds.
        vertex: u32,
        /// Vertices the surface was declared with.
        vertex_count: usize,
    },
    /// A polygon has fewer than three vertices.
    #[error("polygon {polygon} has {len} vertices, but needs at least 3")]
    ShortPolygon {
        /// Position of the polygon in the list.
        polygon: usize,
        /// Number of its vertices.
        len: usize,
    },
    /// The polygons at a vertex are none, more than three, or not consecutive.
    #[error(
        "vertex {vertex} has {polygons} polygons, but needs one to three that are consecutive around it"
    )]
    NotSimplex {
        /// The first such vertex.
        vertex: usize,
        /// Number of references by polygons.
        polygons: usize,
    },
    /// A vertex on the border has fewer than three polygons, so it has no dual triangle.
    #[error("vertex {vertex} is on the border: only {polygons} polygons meet there")]
    Border {
        /// The first such vertex.
        vertex: usize,
        /// Number of its polygons.
        polygons: usize,
    },
}
