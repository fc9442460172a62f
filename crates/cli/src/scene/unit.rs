//! Units of length, as names only: nothing is converted.

use serde::{Deserialize, Serialize};

/// Unit of all lengths of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) enum Unit {
    #[serde(rename = "um")]
    Micrometer,
    #[default]
    #[serde(rename = "mm")]
    Millimeter,
    #[serde(rename = "cm")]
    Centimeter,
    #[serde(rename = "m")]
    Meter,
    #[serde(rename = "in")]
    Inch,
}

impl Unit {
    /// Returns the symbol in scene files, tables and reports.
    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Self::Micrometer => "um",
            Self::Millimeter => "mm",
            Self::Centimeter => "cm",
            Self::Meter => "m",
            Self::Inch => "in",
        }
    }

    /// Returns the number of decimals that shows a length to about a micrometer.
    pub(crate) fn decimals(self) -> usize {
        match self {
            Self::Micrometer => 1,
            Self::Millimeter => 3,
            Self::Centimeter | Self::Inch => 4,
            Self::Meter => 6,
        }
    }
}
