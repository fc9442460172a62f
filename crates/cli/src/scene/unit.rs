//! Units of length. Nothing is converted: the unit only names the numbers.

use serde::{Deserialize, Serialize};

/// The one unit of a scene's lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) enum Unit {
    #[serde(rename = "um")]
    Micrometre,
    #[default]
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "in")]
    Inch,
}

impl Unit {
    /// As scene files, tables and reports write it.
    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Self::Micrometre => "um",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
        }
    }

    /// Decimals that show a length to about a micrometre.
    pub(crate) fn decimals(self) -> usize {
        match self {
            Self::Micrometre => 1,
            Self::Millimetre => 3,
            Self::Centimetre | Self::Inch => 4,
            Self::Metre => 6,
        }
    }

    /// A length given in millimetres.
    pub(crate) fn of_millimetres(self, length: f64) -> f64 {
        match self {
            Self::Micrometre => length * 1000.0,
            Self::Millimetre => length,
            Self::Centimetre => length / 10.0,
            Self::Metre => length / 1000.0,
            Self::Inch => length / 25.4,
        }
    }
}
