//! Errors of a scene, which name the body concerned.

use ccd::CcdError;
use kdop::TreeError;
use medial::MedialError;
use overlap::JointContactError;
use proximity::{PairError, SweptError};
use surface::SurfaceError;
use surface::progress::Interrupted;

/// Error of adding or moving a body, or of a query over a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Two bodies of one name could not be told apart in a report.
    #[error("two bodies are named {name:?}")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A body without a name could not be told from others in a report.
    #[error("a body has no name")]
    EmptyName,
    /// A control character in a name, as NUL or the end of a line, could command a terminal or break a table.
    #[error("the name {name:?} of a body has a control character")]
    ControlCharacter {
        /// The name.
        name: String,
    },
    /// A body without faces touches nothing.
    #[error("body {name:?} has no faces")]
    NoFaces {
        /// The body's name.
        name: String,
    },
    /// The body's positions do not fit its surface.
    #[error("body {name:?}: {source}")]
    Surface {
        /// The body's name.
        name: String,
        /// The underlying error.
        source: SurfaceError,
    },
    /// No tree of bounds could be built over the body.
    #[error("body {name:?}: {source}")]
    Tree {
        /// The body's name.
        name: String,
        /// The underlying error.
        source: TreeError,
    },
    /// A medial surface that does not fit the body, or fails for it.
    #[error("body {name:?}: {source}")]
    Medial {
        /// The body's name.
        name: String,
        /// The underlying error.
        source: MedialError,
    },
    /// A query for the contacts of a body with itself.
    #[error("both bodies of a pair are {name:?}")]
    Itself {
        /// The body's name.
        name: String,
    },
    /// The parameters of swept detection are out of range.
    #[error(transparent)]
    Ccd(#[from] CcdError),
    /// The caller interrupted the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A body that the scene does not have.
    #[error("the scene has {count} bodies, not a body number {index}")]
    NoSuchBody {
        /// The number asked for.
        index: usize,
        /// Bodies of the scene.
        count: usize,
    },
    /// A body that moves vertex by vertex has no pose.
    #[error("body {name:?} is not rigid: it has no pose")]
    NotRigid {
        /// The body's name.
        name: String,
    },
    /// All bodies together have more vertices than 32-bit indices can number.
    #[error("body {name:?} would bring the scene to {count} vertices, more than {limit}")]
    TooManyParticles {
        /// The body's name.
        name: String,
        /// Vertices with it.
        count: usize,
        /// Largest possible number.
        limit: usize,
    },
    /// A tolerance of depths that is not finite or not above 0.
    #[error("the depth tolerance is {tolerance}, but must be finite and above 0")]
    DepthTolerance {
        /// The value given.
        tolerance: f64,
    },
    /// The parameters of joint contact are out of range.
    #[error(transparent)]
    JointContact(JointContactError),
    /// More faces of two bodies are within the margin of each other than can be listed in reasonable
    /// memory.
    #[error("bodies {a:?} and {b:?}: {source}")]
    NearFaces {
        /// Name of the first body.
        a: String,
        /// Name of the second body.
        b: String,
        /// The underlying error, with the margin.
        source: PairError,
    },
    /// A margin that is negative, infinite or not a number.
    #[error("the margin is {margin}, but must be finite and at least 0")]
    Margin {
        /// The value given.
        margin: f64,
    },
}

impl SceneError {
    /// Names the bodies of a comparison that failed.
    #[must_use]
    pub fn of_pair([a, b]: [&str; 2], error: PairError) -> Self {
        match error {
            PairError::Interrupted(error) => Self::Interrupted(error),
            source => Self::NearFaces { a: a.to_owned(), b: b.to_owned(), source },
        }
    }
}

impl From<JointContactError> for SceneError {
    fn from(error: JointContactError) -> Self {
        match error {
            JointContactError::Interrupted(error) => Self::Interrupted(error),
            error => Self::JointContact(error),
        }
    }
}

impl From<SweptError> for SceneError {
    fn from(error: SweptError) -> Self {
        match error {
            SweptError::Ccd(error) => Self::Ccd(error),
            SweptError::Interrupted(error) => Self::Interrupted(error),
        }
    }
}
