//! Methods of detection, and reasons against them.

use std::fmt;

use decimate::DecimateError;
use distance_field::FieldError;
use medial::MedialError;

/// Method by which a pair of bodies is detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum DetectionMethod {
    /// Vertices and edges of one body, reduced as far as the tolerance allows, against the
    /// distance field of the other, which is rigid, and the vertices of that one against the
    /// reduced surface. The error of a gap is that of the field plus the deviation of the reduced
    /// surface.
    Field,
    /// Vertices of each body against the surface of the other, both reduced as far as the
    /// tolerance allows. The error of a gap is the deviation of both; 0 where neither is reduced.
    Surfaces,
    /// Vertices of each body against the medial surface of the other, with as few balls as the
    /// tolerance allows; rigid bodies have none. The error of a gap is the deviation of the
    /// medial surface.
    ///
    /// Never the cheapest, so that it is used only where it is forced: following balls costs more
    /// than surfaces of the same error. It serves depths across the whole of a thin muscle, with
    /// normals that do not jump.
    Medial,
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
    Reduced,
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
    /// The field's error exceeds the tolerance at the finest spacing that was tried.
    #[error(
        "a field with spacing {spacing:.3} still exceeds the tolerance ({error:.3} > {tolerance:.3})"
    )]
    FieldInaccurate {
        /// Finest spacing that was tried.
        spacing: f64,
        /// Measured error at this spacing.
        error: f64,
        /// Largest accepted error of the field.
        tolerance: f64,
    },
    /// The field could not be built: it needs too much memory, for instance.
    #[error("a field with spacing {spacing:.3} cannot be built: {source}")]
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
    /// The surface has too many vertices within the tolerance to be worth following.
    #[error(
        "a coarser surface within the tolerance keeps more than {percent:.0} % of the vertices"
    )]
    TooManyVertices {
        /// Percentage of its vertices that a coarser surface may keep.
        percent: f64,
    },
    /// An open surface has no inside, and so no depths.
    #[error(
        "an open surface has no inside: use `Scene::sweep`, or `Scene::segment` where it is crossed"
    )]
    Open,
    /// Neither body of the pair can have a field.
    #[error("neither body is rigid with an inside")]
    NoBone,
}

impl fmt::Display for DetectionMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Field => "field",
            Self::Surfaces => "surfaces",
            Self::Medial => "balls",
        })
    }
}

impl fmt::Display for StructureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Tree => "tree",
            Self::Reduced => "reduced surface",
            Self::Field => "distance field",
            Self::Medial => "medial surface",
        })
    }
}
