//! Why a plan cannot be made or followed.

use response::ResponseError;

use crate::{ExclusionReason, SceneError};

/// What a plan refuses, naming the bodies concerned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
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
    /// A method was forced on a pair that it cannot serve.
    #[error("{a:?} and {b:?} cannot be told apart {method}: {reason}")]
    Forced {
        /// Name of the first body.
        a: String,
        /// Name of the second body.
        b: String,
        /// The method, in words.
        method: String,
        /// Why not.
        reason: ExclusionReason,
    },
    /// The scene is not the one that was planned for: it has other bodies.
    #[error("the plan was made for another scene")]
    OtherScene,
    /// A rigid body whose field is to be asked was moved vertex by vertex.
    #[error("where the field of {name:?} is, is not known: place rigid bodies by their pose")]
    NoPose {
        /// The body's name.
        name: String,
    },
    /// A failure of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A failure of the contact solver.
    #[error(transparent)]
    Response(#[from] ResponseError),
}
