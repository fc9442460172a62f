//! Errors of overlap removal.

use proximity::{NoInside, ProximityError};
use response::{ParameterError, ResponseError};
use scene::SceneError;
use surface::SurfaceError;
use surface::progress::Interrupted;

use crate::BodyStiffness;

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
    /// Rounding to the written precision leaves the range of numbers.
    #[error("positions do not fit 32-bit floating point: {0}")]
    Rounding(ProximityError),
    /// A condition names a body or a vertex that the scene does not have.
    #[error("no vertex {vertex} in body {body}, which has {count}")]
    NoSuchVertex {
        /// The body, by its number.
        body: usize,
        /// The vertex.
        vertex: u32,
        /// The number of vertices of the body.
        count: usize,
    },
    /// A stiffness outside its [range](BodyStiffness::FACTORS).
    #[error(
        "the stiffness of '{name}' is {factor:?}, but must be from {:e} to {:e}",
        BodyStiffness::FACTORS.start(),
        BodyStiffness::FACTORS.end()
    )]
    Stiffness {
        /// Name of the body.
        name: String,
        /// The factor as given.
        factor: f64,
    },
    /// A tie reaches no vertex.
    #[error("'{a}' is not tied to '{b}': no vertex is {} the other surface", within(*distance))]
    NothingTied {
        /// Name of the first body.
        a: String,
        /// Name of the second body.
        b: String,
        /// Distance within which vertices are tied.
        distance: f64,
    },
    /// A soft body was added as polygons, whose centers follow their corners.
    #[error(
        "'{name}' has polygons, whose centers follow their corners: add its triangles as a surface"
    )]
    Polygons {
        /// Name of the body.
        name: String,
    },
    /// A soft body would tear along edges whose vertices are not welded.
    #[error("'{name}' would tear: {source}")]
    Unwelded {
        /// Name of the body.
        name: String,
        /// The first edge of such a seam.
        source: SurfaceError,
    },
    /// A body that is to be uncrossed has no inside, or is not oriented.
    #[error("'{name}' cannot be uncrossed: {source}")]
    NoInside {
        /// Name of the body.
        name: String,
        /// The first edge that is open or misoriented.
        source: NoInside,
    },
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

/// Writes how near to a surface a tie reaches: nodes that two bodies have in common are on it.
fn within(distance: f64) -> String {
    if distance > f64::MIN_POSITIVE { format!("within {distance} of") } else { "on".to_owned() }
}
