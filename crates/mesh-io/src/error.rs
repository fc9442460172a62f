//! Refusals of files: the reason, and the place in the file.
//!
//! Refusals quote text of the file with its control characters escaped, so that no file
//! can send commands to the terminal that shows them.

use std::path::PathBuf;

use distance_field::FieldError;
use glam::DVec3;
use volume_mesh::VolumeError;

use crate::text::{escaped, quoted};

/// Refusal of a file, with its path.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}", path = .path.display())]
pub struct FileError {
    /// Path of the file, as the caller gave it.
    pub path: PathBuf,
    /// Reason of the refusal.
    #[source]
    pub reason: ReadError,
}

/// Reason why the content of a file is not a mesh or a distance field.
///
/// Vertices and faces are counted from 0, in the order of the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refuses to open or to read the file.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The file has no content.
    #[error("is empty (0 bytes)")]
    Empty,
    /// Neither content nor extension belong to a known format.
    #[error("unknown format: expected {expected}")]
    UnknownFormat {
        /// Names of the formats that are known here.
        expected: &'static str,
    },
    /// The file is text of two bytes per character.
    #[error("is text in UTF-16: save it in UTF-8")]
    Utf16,
    /// The text or the bytes do not follow the format.
    #[error("{format} file: {place}: {problem}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// Place of the first offense.
        place: FilePlace,
        /// Offense in words, without control characters.
        problem: String,
    },
    /// The format allows a feature that this crate does not support.
    #[error(
        "{format} file: {place}{feature} cannot be read; {remedy}",
        place = .line.map(|line| format!("line {line}: ")).unwrap_or_default()
    )]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// Line of a text file that has it, counted from 1, where it is one line.
        line: Option<usize>,
        /// Name of the feature, without control characters.
        feature: String,
        /// Way to write the file without the feature.
        remedy: &'static str,
    },
    /// The file has more or fewer bytes of values than its grid has nodes.
    #[error(
        "{format} file: a grid of {dims} nodes needs {expected} bytes of data, but the file has {found}",
        dims = .dims.map(|n| n.to_string()).join(" x ")
    )]
    WrongSize {
        /// Name of the format.
        format: &'static str,
        /// Number of nodes along each axis.
        dims: [usize; 3],
        /// Bytes that the grid needs.
        expected: u128,
        /// Bytes in the file.
        found: usize,
    },
    /// The file has no faces.
    #[error("has {vertices} vertices and no faces")]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
    },
    /// The number of vertices is beyond 32 bits.
    #[error("has {0} vertices, but at most {max} are allowed", max = u32::MAX)]
    TooManyVertices(usize),
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is at ({x}, {y}, {z}), which is not finite", x = .at.x, y = .at.y, z = .at.z)]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Position of the vertex.
        at: DVec3,
    },
    /// A corner of a face is not a vertex.
    #[error(
        "face {face} refers to vertex {vertex}, but there are {vertex_count} vertices (counted from 0)"
    )]
    VertexOutOfRange {
        /// Index of the face.
        face: usize,
        /// Index of the vertex.
        vertex: i64,
        /// Number of vertices.
        vertex_count: usize,
    },
    /// A face is a point or an edge.
    #[error("face {face} has {corners} corners, fewer than a triangle")]
    TooFewCorners {
        /// Index of the face.
        face: usize,
        /// Number of its corners.
        corners: usize,
    },
    /// No fan about a corner covers the polygon without folding over.
    #[error(
        "face {face} is a polygon of {corners} corners, and its fan folds over about any of them: split it into triangles first"
    )]
    NotFannable {
        /// Index of the face.
        face: usize,
        /// Number of its corners.
        corners: usize,
    },
    /// Cells are no volume mesh.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// An element has the same node twice, and is no wedge and no tetrahedron by its other nodes.
    #[error(
        "element {element} has node {node} twice: save it as one of fewer nodes, or as tetrahedra (nodes may be repeated in linear hexahedra that are wedges or tetrahedra, and in linear wedges that are tetrahedra)"
    )]
    RepeatedNode {
        /// Number of the element in the file.
        element: u64,
        /// Number of the node in the file.
        node: u64,
    },
    /// Two elements have the same nodes.
    #[error("elements {a} and {b} have the same nodes", a = .elements[0], b = .elements[1])]
    RepeatedElement {
        /// Numbers of the elements in the file.
        elements: [u64; 2],
    },
    /// More than two elements have a face in common.
    #[error("elements {a}, {b} and {c} share one face: at most two may", a = .elements[0], b = .elements[1], c = .elements[2])]
    SharedFace {
        /// Numbers of the first three elements in the file.
        elements: [u64; 3],
    },
    /// A node cannot be in the middle of an edge.
    #[error(
        "node {node} is no node between nodes {a} and {b} alone: it is a corner or on another edge, or they are no corners",
        a = .ends[0], b = .ends[1]
    )]
    MiddleNode {
        /// Number of the node in the file.
        node: u64,
        /// Numbers of the nodes at the ends of the edge.
        ends: [u64; 2],
    },
    /// A file has no part of a name.
    #[error("has no part {part}; its parts are {known}", part = quoted(.part), known = listed(.known))]
    UnknownPart {
        /// Name that is none.
        part: String,
        /// Names of its parts.
        known: Vec<String>,
    },
    /// A file has several parts, of which none is named.
    #[error("has the parts {known}: name those of the body", known = listed(.known))]
    SeveralParts {
        /// Names of its parts.
        known: Vec<String>,
    },
    /// A format has no parts by name.
    #[error("has no parts that can be named: only FEBio models and Abaqus input files do")]
    NoParts,
    /// A node moves that several instances of a part have.
    #[error("the part {part} has several instances and one set of coordinates: save a part for each one that moves", part = quoted(.part))]
    SharedPart {
        /// Name of the part.
        part: String,
    },
    /// An edge of a quadratic element is curved.
    #[error(
        "node {node} is {offset} off the middle between nodes {a} and {b}, which are {length} apart: edges of quadratic elements must be straight, within a thousandth of their length; save linear elements",
        a = .ends[0], b = .ends[1]
    )]
    CurvedEdge {
        /// Number of the node in the file.
        node: u64,
        /// Numbers of the nodes at the ends of the edge.
        ends: [u64; 2],
        /// Distance of the node from the middle.
        offset: f64,
        /// Distance of the ends.
        length: f64,
    },
    /// A file is to be written with more or fewer positions than it has.
    #[error("has {expected} positions to be replaced, but {found} are given")]
    PositionCount {
        /// Number of positions in the file.
        expected: usize,
        /// Number of positions given.
        found: usize,
    },
    /// A file is to be written with a position that its numbers cannot hold.
    #[error(
        "vertex {vertex} is to be at ({x}, {y}, {z}), beyond the range of the file's numbers", x = .at.x, y = .at.y, z = .at.z
    )]
    OutOfRange {
        /// Index of the vertex.
        vertex: usize,
        /// Position that is given for it.
        at: DVec3,
    },
    /// Grid or values are not those of a distance field.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// Maximum number of names that a message lists: files may have any number of them.
const MAX_LISTED: usize = 20;

/// Lists names in quotation marks.
fn listed(names: &[String]) -> String {
    let mut list: Vec<String> = names.iter().take(MAX_LISTED).map(quoted).collect();
    let more = names.len().saturating_sub(MAX_LISTED);
    if more > 0 {
        list.push(format!("and {more} more"));
    }
    list.join(", ")
}

/// Format of a file, which builds the refusals that name it.
#[derive(Debug)]
pub(crate) struct Format {
    pub(crate) name: &'static str,
    /// Way to write a file that can be read here.
    pub(crate) remedy: &'static str,
}

impl Format {
    pub(crate) fn malformed(&self, place: FilePlace, problem: impl AsRef<str>) -> ReadError {
        ReadError::Malformed { format: self.name, place, problem: escaped(problem.as_ref()) }
    }

    pub(crate) fn on_line(&self, line: usize, problem: impl AsRef<str>) -> ReadError {
        self.malformed(FilePlace::Line(line), problem)
    }

    pub(crate) fn in_header(&self, problem: impl AsRef<str>) -> ReadError {
        self.malformed(FilePlace::Header, problem)
    }

    pub(crate) fn in_field(&self, name: &'static str, problem: impl AsRef<str>) -> ReadError {
        self.malformed(FilePlace::Field(name), problem)
    }

    pub(crate) fn unsupported(&self, feature: impl AsRef<str>) -> ReadError {
        self.unsupported_at(None, feature)
    }

    pub(crate) fn unsupported_on_line(&self, line: usize, feature: impl AsRef<str>) -> ReadError {
        self.unsupported_at(Some(line), feature)
    }

    fn unsupported_at(&self, line: Option<usize>, feature: impl AsRef<str>) -> ReadError {
        let feature = escaped(feature.as_ref());
        ReadError::Unsupported { format: self.name, line, feature, remedy: self.remedy }
    }
}

/// Place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilePlace {
    /// The header of a PLY, STL or NRRD file.
    Header,
    /// A line of text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(u64),
    /// An element of a PLY file or a tag of a VTK file, by its name.
    Element(String),
    /// A data array of a VTK file, by its name.
    Array(String),
    /// A field or key in the header of an NRRD file, by its name.
    Field(&'static str),
    /// A facet of a binary STL file, counted from 0.
    Facet(usize),
}

impl std::fmt::Display for FilePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Header => write!(f, "header"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Element(name) => write!(f, "element {}", quoted(name)),
            Self::Array(name) => write!(f, "array {}", quoted(name)),
            Self::Field(name) => write!(f, "field '{name}'"),
            Self::Facet(facet) => write!(f, "facet {facet}"),
        }
    }
}
