//! Errors of overlap removal.

use response::ResponseError;
use scene::SceneError;
use surface::progress::Interrupted;

/// Failure of overlap removal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// A parameter outside its range.
    #[error("{name} is {value}, but must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value as given.
        value: f64,
        /// Accepted values, in words.
        range: &'static str,
    },
    /// A failure of detection.
    #[error(transparent)]
    Scene(SceneError),
    /// A failure of the contact solver.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<SceneError> for ResolveError {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Scene(error),
        }
    }
}
