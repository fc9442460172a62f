//! Accuracy of structures and pairs: proved bounds, measured errors.

use std::fmt;

/// Accuracy of a structure or of the results of a pair, in the length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Accuracy {
    /// Upper bound on the error.
    pub bound: f64,
    /// True if the bound is proved; false where it holds for an earlier shape only.
    pub is_proved: bool,
    /// Largest error of some samples; `None` where nothing was sampled. Between samples it may be
    /// exceeded, up to the bound.
    pub measured_error: Option<f64>,
}

impl Accuracy {
    /// Accuracy of exact results.
    pub const EXACT: Self = Self::proved(0.0);

    /// Returns the accuracy of a proved bound.
    #[must_use]
    pub const fn proved(bound: f64) -> Self {
        Self { bound, is_proved: true, measured_error: None }
    }
}

impl fmt::Display for Accuracy {
    /// Writes the bound, whether it is proved, and the measured error, in equal widths.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.is_proved { "proved" } else { "of rest" };
        write!(f, "{:>9} {word:<7} ", length(self.bound))?;
        write!(f, "{:>9}", self.measured_error.map_or("-".to_owned(), length))
    }
}

/// Writes a length with four decimals, a small one in three digits with an exponent.
pub(crate) fn length(value: f64) -> String {
    if value > 0.0 && value < 0.01 { format!("{value:.2e}") } else { format!("{value:.4}") }
}
