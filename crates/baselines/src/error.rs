//! Errors of the methods, and checks of their parameters.

use surface::SurfaceError;

/// Error of a method, with the value that it refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// A surface lacks a property that the method needs.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A cell size is not a length above 0.
    #[error("cell size is {0}, but must be a finite length above 0")]
    CellSize(f64),
    /// A count is 0 or above its limit.
    #[error("{name} is {value}, but must be in 1..={limit}")]
    Count {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: u64,
        /// Maximum of the parameter.
        limit: u64,
    },
    /// A share or a probability is out of range.
    #[error("{name} is {value}, but must be above 0 and at most 1")]
    Share {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A distance is negative or not finite.
    #[error("{name} is {value}, but must be a finite length of at least 0")]
    Distance {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
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

/// Checks that a count is at least 1 and within its limit.
pub(crate) fn check_count(name: &'static str, value: u64, limit: u64) -> Result<(), BaselineError> {
    if (1..=limit).contains(&value) {
        Ok(())
    } else {
        Err(BaselineError::Count { name, value, limit })
    }
}

/// Checks that a share is above 0 and at most 1.
pub(crate) fn check_share(name: &'static str, value: f64) -> Result<(), BaselineError> {
    if value > 0.0 && value <= 1.0 { Ok(()) } else { Err(BaselineError::Share { name, value }) }
}

/// Checks that a distance is finite and not negative.
pub(crate) fn check_distance(name: &'static str, value: f64) -> Result<(), BaselineError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(BaselineError::Distance { name, value })
    }
}
