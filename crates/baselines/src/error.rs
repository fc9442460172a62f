//! Why a baselines's method refuses its input.

use surface::SurfaceError;

/// What a method refuses, and the value that it refuses.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// A body lacks a property that the method needs.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A size of cells is not a length above 0.
    #[error("cell size {0} is not a finite length above 0")]
    CellSize(f64),
    /// A count that must be at least 1, or is larger than the method can hold.
    #[error("{name} is {value}, but must be in 1..={limit}")]
    Count {
        /// The parameter.
        name: &'static str,
        /// What it is.
        value: u64,
        /// What it may be.
        limit: u64,
    },
    /// A share or a probability is out of range.
    #[error("{name} is {value}, but must be above 0 and at most 1")]
    Share {
        /// The parameter.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// A distance that must not be negative.
    #[error("{name} is {value}, but must be a finite length of at least 0")]
    Distance {
        /// The parameter.
        name: &'static str,
        /// What it is.
        value: f64,
    },
    /// Boxes of the input cover more cells than are stored.
    #[error(
        "cells of size {cell_size} would be {cells:e} entries, more than {limit}: use larger ones"
    )]
    TooManyCells {
        /// Size of the cells.
        cell_size: f64,
        /// Entries there would be.
        cells: f64,
        /// Entries there may be.
        limit: usize,
    },
}

/// Refuses a count that is 0 or above its limit.
pub(crate) fn check_count(name: &'static str, value: u64, limit: u64) -> Result<(), BaselineError> {
    if (1..=limit).contains(&value) {
        Ok(())
    } else {
        Err(BaselineError::Count { name, value, limit })
    }
}

/// Refuses a share that is not in `0.0..=1.0` or is 0.
pub(crate) fn check_share(name: &'static str, value: f64) -> Result<(), BaselineError> {
    if value > 0.0 && value <= 1.0 { Ok(()) } else { Err(BaselineError::Share { name, value }) }
}
