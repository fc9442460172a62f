//! Errors, proved or measured.

use std::fmt;
use std::ops::Add;

/// Error of a structure or of the gaps of a pair, in the length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ErrorEstimate {
    /// Proved upper bound.
    Bound(f64),
    /// Largest error of some samples. Between them it may be exceeded.
    Measured(f64),
}

impl ErrorEstimate {
    /// Error of what is exact.
    pub const NONE: Self = Self::Bound(0.0);

    /// Returns the error, proved or measured.
    #[must_use]
    pub const fn value(self) -> f64 {
        match self {
            Self::Bound(value) | Self::Measured(value) => value,
        }
    }

    /// Returns the larger error, as one that is proved if both are.
    pub(crate) fn max(self, other: Self) -> Self {
        self.with(other, f64::max)
    }

    fn with(self, other: Self, combine: fn(f64, f64) -> f64) -> Self {
        let value = combine(self.value(), other.value());
        match (self, other) {
            (Self::Bound(_), Self::Bound(_)) => Self::Bound(value),
            _ => Self::Measured(value),
        }
    }
}

impl Add for ErrorEstimate {
    type Output = Self;

    /// Returns the sum, which is proved if both are.
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl fmt::Display for ErrorEstimate {
    /// Writes the error and whether it is a bound, in equal widths.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bound(value) => write!(f, "{value:>9.4} bound   "),
            Self::Measured(value) => write!(f, "{value:>9.4} measured"),
        }
    }
}
