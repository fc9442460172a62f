//! Levels of a correction: positions, velocities or accelerations.

/// Quantity that a solver corrects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SolveLevel {
    /// Displacements since the contacts were detected: no depth is left, and slip
    /// is taken back within Coulomb's disc. Rigid objects count as at rest.
    Position,
    /// Velocities: the approach times λ is canceled.
    Velocity,
    /// Accelerations: likewise.
    Acceleration,
}

impl SolveLevel {
    /// Computes the factor on impulses of the last step that start the next, where steps are
    /// `ratio` times as long: forces persist, and impulses are forces times h², h and 1.
    #[must_use]
    pub fn impulse_scale(self, ratio: f64) -> f64 {
        match self {
            Self::Position => ratio * ratio,
            Self::Velocity => ratio,
            Self::Acceleration => 1.0,
        }
    }

    /// Returns the name of the unknowns in errors.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Position => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
        }
    }
}
