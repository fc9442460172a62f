//! Units of length. Meshes are not converted, tables of poses are.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Unit of all lengths of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, ValueEnum)]
pub(crate) enum Unit {
    #[serde(rename = "um")]
    #[value(name = "um")]
    Micrometer,
    #[default]
    #[serde(rename = "mm")]
    #[value(name = "mm")]
    Millimeter,
    #[serde(rename = "cm")]
    #[value(name = "cm")]
    Centimeter,
    #[serde(rename = "m")]
    #[value(name = "m")]
    Meter,
    #[serde(rename = "in")]
    #[value(name = "in")]
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

    /// Returns the length of the unit in meters.
    pub(crate) fn meters(self) -> f64 {
        match self {
            Self::Micrometer => 1e-6,
            Self::Millimeter => 1e-3,
            Self::Centimeter => 1e-2,
            Self::Meter => 1.0,
            Self::Inch => 0.0254,
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
