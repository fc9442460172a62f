//! Why a plan cannot be made or followed.

use crate::ExclusionReason;
use proximity::ProximityError;
use response::ResponseError;
use scene::SceneError;

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
    /// The coarser surface of a body could not follow it.
    #[error(transparent)]
    Proximity(#[from] ProximityError),
    /// Contacts could not be solved.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// What the scene itself refuses.
    #[error(transparent)]
    Scene(#[from] SceneError),
}
