//! Errors of volume meshes.

use surface::progress::Interrupted;

/// Reason why cells are no volume mesh, or why its interior cannot follow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The mesh has no cells.
    #[error("has {nodes} nodes and no tetrahedra, wedges or hexahedra")]
    NoCells {
        /// Number of nodes.
        nodes: usize,
    },
    /// A corner of a cell is not a node.
    #[error("cell {cell} refers to node {node}, but there are {node_count} nodes (counted from 0)")]
    NodeOutOfRange {
        /// Index of the cell.
        cell: usize,
        /// Index of the node.
        node: u32,
        /// Number of nodes.
        node_count: usize,
    },
    /// A cell has the same node twice.
    #[error("cell {cell} has node {node} twice")]
    RepeatedNode {
        /// Index of the cell.
        cell: usize,
        /// Index of the node.
        node: u32,
    },
    /// A node cannot be in the middle of an edge.
    #[error(
        "node {node} is no node between {a} and {b} alone: it is a corner or on another edge, or they are no corners (counted from 0)",
        a = .ends[0], b = .ends[1]
    )]
    MiddleNode {
        /// Index of the node.
        node: u32,
        /// Indices of the ends of the edge.
        ends: [u32; 2],
    },
    /// More than two cells have a face in common.
    #[error("cells {cells:?} share one face: at most two may")]
    SharedFace {
        /// Indices of the first three cells.
        cells: [usize; 3],
    },
    /// Two cells have the same nodes.
    #[error("cells {cells:?} have the same nodes")]
    RepeatedCell {
        /// Indices of the cells.
        cells: [usize; 2],
    },
    /// No face belongs to one cell alone.
    #[error("has no surface: every face of its {cells} cells is shared by two of them")]
    NoBoundary {
        /// Number of cells.
        cells: usize,
    },
    /// Cells are inverted, or without volume, before anything moves.
    #[error(
        "{count} of the cells are inverted or flat at the start, the worst is cell {cell} with a scaled Jacobian of {scaled_jacobian:.3}"
    )]
    Inverted {
        /// Number of such cells.
        count: usize,
        /// Index of the worst cell.
        cell: usize,
        /// Its scaled Jacobian.
        scaled_jacobian: f64,
    },
    /// Positions do not fit the mesh.
    #[error("{found} positions of {of}, but {expected} are needed")]
    Count {
        /// Points that the positions belong to.
        of: &'static str,
        /// Number of positions needed.
        expected: usize,
        /// Number of positions given.
        found: usize,
    },
    /// A position is infinite or not a number.
    #[error("node {node} has a position that is not finite")]
    NotFinite {
        /// Index of the node.
        node: usize,
    },
    /// A parameter outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Its range in words.
        range: &'static str,
    },
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
