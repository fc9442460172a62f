//! Methods of detection, and reasons against them.

use std::fmt;

use decimate::DecimateError;
use distance_field::FieldError;
use medial::MedialError;

use crate::accuracy::length;

/// Method by which a pair of bodies is detected.
///
/// By every method but [`Balls`](Self::Balls), no overlap deeper than the pair's bound goes
/// unseen: whatever a method leaves out is counted in its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum DetectionMethod {
    /// The surfaces of both bodies as they are. Overlap and contacts are exact; the bound is the
    /// width of the bracket on the depth. The depth errs to the low side.
    Exact,
    /// The same on coarser surfaces of one body or both. The bound holds for the certified deviations
    /// of both and the bracket together. Overlaps that are shallower may go unseen, and bodies that
    /// are apart by less may be reported as overlapping. The depth errs to either side.
    Coarse,
    /// Contacts of one body's vertices and edges by the distance field of the other, which is
    /// rigid, and of that one's vertices by the first one's surface. Overlap and depth as
    /// [`Exact`](Self::Exact); the gaps of contacts err by up to the bound of the field, to either
    /// side.
    Field,
    /// Vertices of each body against the medial surface of the other; rigid bodies have none. Gaps err by up to the
    /// bound of that [structure](StructureKind::Medial), in the shape at which balls were generated. No overlap by edges
    /// or faces is seen, and none of a muscle's vertices in a bone: the bound on the pair's depth is that of the boxes
    /// around both bodies, and a pair without contacts is [undecided](crate::PairState::Undecided).
    ///
    /// Used only where it is forced. It serves depths across the whole of a thin muscle, with
    /// normals that do not jump.
    Balls,
}

/// Structure that a body may be given for detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum StructureKind {
    /// Bounding volume tree over the body's own faces.
    Tree,
    /// Coarser surface on some of the body's vertices, with a tree.
    Coarse,
    /// Distance field.
    Field,
    /// Medial surface that follows the body.
    Medial,
}

/// Reason why a pair is not detected, or a structure is not built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExclusionReason {
    /// Distance fields are of rigid bodies.
    #[error("the body is not rigid")]
    NotRigid,
    /// Contacts between rigid bodies change nothing.
    #[error("both bodies are rigid")]
    BothRigid,
    /// The scene ignores the pair.
    #[error("the pair is ignored")]
    Ignored,
    /// The field could not be built: it needs too much memory, for instance.
    #[error("a field with spacing {} cannot be built: {source}", length(*spacing))]
    Field {
        /// Spacing that the tolerance asks for.
        spacing: f64,
        /// Reason.
        source: FieldError,
    },
    /// The medial surface could not be generated.
    #[error(transparent)]
    Medial(MedialError),
    /// The surface could not be simplified.
    #[error(transparent)]
    Decimation(DecimateError),
    /// The coarse surface has too many faces to be worth following.
    #[error("a coarser surface within the tolerance keeps more than {percent:.0} % of the faces")]
    TooManyFaces {
        /// Percentage of its faces that a coarser surface may keep.
        percent: f64,
    },
    /// Neither body of the pair can have a field.
    #[error("neither body is rigid with an inside")]
    NoBone,
}

impl fmt::Display for DetectionMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Exact => "exact",
            Self::Coarse => "coarse",
            Self::Field => "field",
            Self::Balls => "balls",
        })
    }
}

impl fmt::Display for StructureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Tree => "tree",
            Self::Coarse => "coarse surface",
            Self::Field => "distance field",
            Self::Medial => "medial surface",
        })
    }
}
