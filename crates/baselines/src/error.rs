//! Errors of the methods, and the check of their parameters.

use surface::SurfaceError;

/// Error of a method, with the value that it refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// A surface lacks a property that the method needs.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A parameter is out of range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Range of the parameter, in words.
        range: &'static str,
    },
    /// Boxes cover more cells than a table holds.
    #[error(
        "cells of size {cell_size} make {cells:e} entries, but at most {limit} fit: use larger cells"
    )]
    TooManyCells {
        /// Size of the cells.
        cell_size: f64,
        /// Number of entries.
        cells: f64,
        /// Maximum number of entries.
        limit: usize,
    },
}

/// Returns an error that names the parameter unless it is in range.
pub(crate) fn check(
    name: &'static str,
    value: f64,
    is_in_range: bool,
    range: &'static str,
) -> Result<(), BaselineError> {
    if is_in_range { Ok(()) } else { Err(BaselineError::Parameter { name, value, range }) }
}

/// Checks that a share is above 0 and at most 1.
pub(crate) fn check_share(name: &'static str, value: f64) -> Result<(), BaselineError> {
    check(name, value, value > 0.0 && value <= 1.0, "above 0 and at most 1")
}
