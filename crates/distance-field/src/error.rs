//! Why a field cannot be built.

use surface::SurfaceError;

/// What a build was refused for, and how much.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The surface has no faces, so it has no distance.
    #[error("the surface has no faces")]
    Empty,
    /// A length of the options is not finite, or on the wrong side of zero.
    #[error("{name} is {value}, but must be {expected}")]
    InvalidParam {
        /// Which field of the options.
        name: &'static str,
        /// What it holds.
        value: f64,
        /// What it may hold.
        expected: &'static str,
    },
    /// The grid and its scratch memory exceed the budget.
    #[error(
        "a grid of {nodes:.3e} nodes needs {bytes:.3e} bytes to build, but the budget is {max_bytes} bytes"
    )]
    TooLarge {
        /// Nodes of the grid.
        nodes: f64,
        /// Bytes in use while it is built.
        bytes: f64,
        /// The budget of the options.
        max_bytes: u64,
    },
    /// An axis has more nodes than squares of distances along it can number.
    #[error(
        "a grid of {nodes:.3e} nodes along one axis is longer than the {limit} that distances are counted over"
    )]
    AxisTooLong {
        /// Nodes along the longest axis.
        nodes: f64,
        /// Most that are possible.
        limit: usize,
    },
    /// The system refused memory that the budget allowed.
    #[error("the system refused {bytes} bytes")]
    OutOfMemory {
        /// Bytes asked for at once.
        bytes: usize,
    },
    /// The surface is not closed, as the flood fill of the voxel method needs.
    #[error("the voxel method: {source}; the exact band needs no closed surface")]
    NotClosed {
        /// The first open edge.
        source: SurfaceError,
    },
    /// A 16-bit storage step cannot reach the largest stored distance.
    #[error(
        "a storage step of {step} reaches {reach}, but the field holds {needed}: truncate it or take a larger step"
    )]
    StepTooSmall {
        /// The step asked for, in the length unit.
        step: f64,
        /// Largest magnitude that it stores.
        reach: f64,
        /// Largest magnitude of the field.
        needed: f64,
    },
    /// A list of values does not fit the grid it was given with.
    #[error("the grid has {expected} nodes, but {got} values were given")]
    ValueCount {
        /// Nodes of the grid.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A stored value is infinite or not a number.
    #[error("the value of node {node} is not finite")]
    NotFinite {
        /// The first such node.
        node: usize,
    },
}
