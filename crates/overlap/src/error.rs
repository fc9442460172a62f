//! Errors of joint contact.

use proximity::PairError;
use surface::progress::Interrupted;

/// Error of the contact of a joint.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JointContactError {
    /// The margin is not finite or below 0.
    #[error("the contact margin is {margin}; it must be finite and at least 0")]
    Margin {
        /// The margin.
        margin: f64,
    },
    /// The resolution is not finite or not above 0.
    #[error("the resolution is {resolution}; it must be finite and above 0")]
    Resolution {
        /// The resolution.
        resolution: f64,
    },
    /// The resolution makes more cells than can be computed in reasonable time.
    #[error("a resolution of {resolution} makes up to {cells:.1e} cells; {limit:.0e} are allowed")]
    TooFine {
        /// The resolution.
        resolution: f64,
        /// Upper bound on the number of cells.
        cells: f64,
        /// The limit.
        limit: f64,
    },
    /// The elastic foundation is out of range.
    #[error(
        "a layer of modulus {youngs_modulus:?} (must be between 1e-60 and 1e60) and thickness {thickness:?} (must be between 1e-90 and 1e30) with Poisson's ratio {poissons_ratio} (must be above -1 and below 0.5)"
    )]
    Foundation {
        /// Young's modulus.
        youngs_modulus: f64,
        /// Poisson's ratio.
        poissons_ratio: f64,
        /// Thickness.
        thickness: f64,
    },
    /// More faces are near each other than can be listed in reasonable memory.
    #[error(transparent)]
    NearFaces(PairError),
    /// The progress handler ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<PairError> for JointContactError {
    fn from(error: PairError) -> Self {
        match error {
            PairError::Interrupted(error) => Self::Interrupted(error),
            error => Self::NearFaces(error),
        }
    }
}
