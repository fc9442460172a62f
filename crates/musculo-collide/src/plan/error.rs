//! Why a plan cannot be made or followed.

use crate::{NotBuilt, SceneError};

/// What a plan refuses, naming the bodies concerned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A value that no plan can serve.
    #[error("a {name} of {value} cannot be planned for")]
    Need {
        /// Which value.
        name: &'static str,
        /// As given.
        value: f64,
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
        reason: NotBuilt,
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
    /// What the scene itself refuses.
    #[error(transparent)]
    Scene(#[from] SceneError),
}
