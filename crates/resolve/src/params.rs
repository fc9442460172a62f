//! Parameters of overlap removal.

use response::{ParameterError, not_negative, positive};

/// Parameters of overlap removal. Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolveParams {
    /// Largest depth of an overlap that may remain, `> 0`.
    pub tolerance: f64,
    /// Gap to which contacts are pushed apart, `>= 0`. More keeps the edges of curved surfaces
    /// apart where vertices alone would let them cross; less moves tissue less.
    pub clearance: f64,
    /// Length along a surface over which a displacement falls to a third, `> 0`. More keeps
    /// shape better; less moves fewer vertices.
    pub smoothing: f64,
    /// Largest number of rounds of detection and pushing.
    pub max_rounds: u32,
}

impl ResolveParams {
    /// Returns parameters for a smoothing length, of which the tolerance is 1/120 and the
    /// clearance 1/300, and 60 rounds.
    ///
    /// A few edge lengths of the soft bodies are a good smoothing length.
    #[must_use]
    pub const fn with_smoothing(smoothing: f64) -> Self {
        Self {
            tolerance: smoothing / 120.0,
            clearance: smoothing / 300.0,
            smoothing,
            max_rounds: 60,
        }
    }

    /// Checks that all parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] for the first one that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        positive("smoothing", self.smoothing)?;
        positive("tolerance", self.tolerance)?;
        not_negative("clearance", self.clearance)?;
        Ok(())
    }
}
