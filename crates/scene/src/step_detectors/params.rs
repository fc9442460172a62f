//! Methods and lengths of the detectors of a contact step, and reasons against a method.

use response::ResponseError;

use crate::closest_pairs::ActingGaps;
use crate::{BodyId, PairId};

/// Largest gap of a contact that touches, over the tolerance. Corrections leave less. Contacts within
/// it stop a body whichever way they lean, so that it is small.
const TOUCH: f64 = 1e-4;

/// Method by which a contact step detects a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum StepMethod {
    /// Vertices of both bodies against the surface of the other, and ridges, edges at which a
    /// surface turns by more than 30°, against those of the other.
    #[default]
    Exact,
    /// The same with the coarse surface of a body in place of its own. Vertices that it left out
    /// follow those that it kept: see [`StepDetectors::followers`](crate::StepDetectors::followers).
    Coarse,
    /// Vertices and edges of a body against the distance field of the other, which is rigid, and
    /// the vertices of the rigid one against the surface.
    Field,
    /// Vertices of both bodies against the balls of the other, measured at its surface. Where ridges
    /// cross, or edges do and no vertex touches, the pair is detected exactly.
    Balls,
}

/// Parameters of the detectors of a contact step, in the length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DetectorParams {
    /// Gap up to which contacts are detected, finite and `>= 0`.
    pub margin: f64,
    /// Depth of an overlap that may go undetected, finite and `>= 0`.
    pub tolerance: f64,
}

/// Pair that was not detected by its method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fallback {
    /// The pair, detected by [`StepMethod::Exact`].
    pub pair: PairId,
    /// Its method.
    pub method: StepMethod,
    /// Reason against it in this frame.
    pub reason: FallbackReason,
}

/// Reason why a pair is detected exactly instead of by its method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum FallbackReason {
    /// Neither body has the structure that the method takes.
    NoStructure,
    /// The vertices of a rigid body with a field were moved one by one: it has no pose.
    NoPose,
    /// The surface of a body may extend beyond its balls by more than their margin and the
    /// tolerance allow: overlaps could go undetected.
    BallDeviation {
        /// The body.
        body: BodyId,
        /// Proved bound on the distance of the surface outside the balls.
        bound: f64,
        /// Distance up to which the balls are trusted.
        allowed: f64,
    },
    /// The surface of a body may be farther from its coarse surface than the tolerance, less the
    /// deviation of the other body's, where both are coarse.
    CoarseDeviation {
        /// The body.
        body: BodyId,
        /// Proved bound on the deviation of both ([`CoarseSurface::deviation`](decimate::CoarseSurface::deviation)).
        bound: f64,
        /// Distance up to which the coarse surface is trusted.
        allowed: f64,
    },
    /// Ridges cross, or edges do where no vertex touches, or they did when ridges last held the bodies:
    /// balls do not compare edges.
    CrossingEdges,
}

impl DetectorParams {
    /// Checks that both lengths are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] with the first that is not.
    pub fn validate(&self) -> Result<(), ResponseError> {
        response::not_negative("margin", self.margin)?;
        response::not_negative("tolerance", self.tolerance)?;
        Ok(())
    }

    /// Returns the gaps up to which contacts act.
    pub(super) fn gaps(&self) -> ActingGaps {
        ActingGaps { margin: self.margin, touch: TOUCH * self.tolerance }
    }
}
