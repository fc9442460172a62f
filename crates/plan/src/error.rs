//! Errors of plans.

use medial::MedialError;
use proximity::ProximityError;
use response::{ParameterError, ResponseError};
use scene::SceneError;
use surface::progress::Interrupted;

use crate::{DetectionMethod, ExclusionReason};

/// Failure to make or to follow a plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A forced method that does not suit its pair.
    #[error("method {method} does not suit {a:?} and {b:?}: {reason}")]
    Forced {
        /// Name of the first body.
        a: String,
        /// Name of the second body.
        b: String,
        /// The method.
        method: DetectionMethod,
        /// Reason why it does not suit them.
        reason: ExclusionReason,
    },
    /// A scene with other bodies than the plan was made for, by their names, kinds, faces, or positions
    /// from which rigid ones are posed.
    #[error("the scene has other bodies than the plan was made for: make a new plan")]
    OtherScene,
    /// A rigid body with a field, whose vertices were moved one by one.
    #[error("the pose of {name:?} is unknown: move rigid bodies with `Scene::pose_body`")]
    NoPose {
        /// The body's name.
        name: String,
    },
    /// A soft body to move was added as polygons, whose centers follow their corners.
    #[error(
        "{name:?} has polygons, whose centers follow their corners: move it by steps of `SceneStep`"
    )]
    Polygons {
        /// The body's name.
        name: String,
    },
    /// A reduced surface that cannot follow its body.
    #[error(transparent)]
    Proximity(#[from] ProximityError),
    /// A medial surface that cannot follow its body.
    #[error(transparent)]
    Medial(#[from] MedialError),
    /// A failure of the scene.
    #[error(transparent)]
    Scene(SceneError),
    /// A failure of the contact solver.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<SceneError> for PlanError {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Scene(error),
        }
    }
}
