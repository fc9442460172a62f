//! Errors of overlap removal.

use response::{ParameterError, ResponseError};
use scene::SceneError;
use surface::progress::Interrupted;

/// Failure of overlap removal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
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
