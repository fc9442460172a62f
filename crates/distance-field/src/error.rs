//! Errors of parameters, builds and stored values.

use surface::SurfaceError;
use surface::progress::Interrupted;

/// Reason why a field or a detector cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The surface has no faces, so that no distance is defined.
    #[error("the surface has no faces")]
    Empty,
    /// A parameter is out of range.
    #[error("{name} is {value}, but must be {expected}")]
    InvalidParam {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range.
        expected: &'static str,
    },
    /// The grid and its scratch memory exceed the budget.
    #[error(
        "a grid of {nodes:.3e} nodes needs {bytes:.3e} bytes to build, but the budget is {max_bytes} bytes: increase the spacing"
    )]
    TooLarge {
        /// Nodes of the grid.
        nodes: f64,
        /// Bytes that a build holds at once.
        bytes: f64,
        /// The budget, [`FieldParams::max_bytes`](crate::FieldParams::max_bytes).
        max_bytes: u64,
    },
    /// An axis has so many nodes that squared distances along it overflow.
    #[error(
        "a grid of {nodes:.3e} nodes along one axis exceeds the maximum of {max_nodes}: increase the spacing"
    )]
    AxisTooLong {
        /// Nodes along the longest axis.
        nodes: f64,
        /// Maximum number of nodes along an axis.
        max_nodes: usize,
    },
    /// The system refused memory that the budget allows.
    #[error("the system refused {bytes} bytes")]
    OutOfMemory {
        /// Bytes that were requested at once.
        bytes: usize,
    },
    /// The surface is not closed, as the flood fill of the voxel method requires.
    #[error("the voxel method needs a closed surface, but {source}: use the exact band")]
    NotClosed {
        /// The first open edge.
        source: SurfaceError,
    },
    /// 16-bit steps do not reach the largest distance of the field.
    #[error(
        "a storage step of {step} reaches {range}, but the field holds {needed}: truncate it or increase the step"
    )]
    StepTooSmall {
        /// The step, in the length unit.
        step: f64,
        /// Largest magnitude that it stores.
        range: f64,
        /// Largest magnitude of the field.
        needed: f64,
    },
    /// The number of values differs from the number of nodes.
    #[error("the grid has {expected} nodes, but {got} values were given")]
    ValueCount {
        /// Nodes of the grid.
        expected: usize,
        /// Number of values.
        got: usize,
    },
    /// A value is infinite or not a number.
    #[error("the value of node {node} is not finite")]
    NotFinite {
        /// The first such node.
        node: usize,
    },
    /// The progress handler ended the build.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Checks that a parameter is finite and positive.
pub(crate) fn check_positive(name: &'static str, value: f64) -> Result<(), FieldError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(FieldError::InvalidParam { name, value, expected: "finite and positive" })
}

/// Checks that a parameter is finite and not negative.
pub(crate) fn check_not_negative(name: &'static str, value: f64) -> Result<(), FieldError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(FieldError::InvalidParam { name, value, expected: "finite and >= 0" })
}
