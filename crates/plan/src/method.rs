//! Ways to look at a pair of bodies, and reasons against them.

use std::fmt;

use scene::BodyId;

/// How a pair of bodies is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DetectionMethod {
    /// Vertices and edges of one body, with as few vertices as the tolerance
    /// allows, against the distance field of the other, which is rigid. The gap
    /// is wrong by the field's error and what the first body's surface deviates.
    Field,
    /// The vertices of both against the surface of the other, each body with as
    /// few of its vertices as the tolerance allows. The gap is wrong by what
    /// both surfaces deviate; 0 where both are as they are.
    Surfaces,
    /// The vertices of each against the medial surface of the other, with as few
    /// balls as the tolerance allows; bones have none. The gap is wrong by what the
    /// medial surfaces deviate. To follow balls costs more than surfaces that are as
    /// accurate, so that this is never the cheapest and is taken where it is forced:
    /// for depths across the whole of a thin muscle, with normals that do not jump.
    Medial,
}

/// What a body may be given for detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum StructureKind {
    /// A tree of bounds over its own faces.
    Tree,
    /// A coarser surface on some of its vertices, with a tree.
    Reduced,
    /// A distance field.
    Field,
    /// Balls, cones and slabs that follow the body.
    Medial,
}

/// Why something was not built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExclusionReason {
    /// No pair that is looked at needs it.
    #[error("no pair needs it")]
    NotNeeded,
    /// Fields are of rigid bodies.
    #[error("it is not rigid")]
    NotRigid,
    /// Neither of the two moves by itself, so that no contact changes anything.
    #[error("both are rigid")]
    BothRigid,
    /// The caller wants nothing said about the pair.
    #[error("the pair is ignored")]
    Ignored,
    /// The pair cannot come within the margin.
    #[error("they are at least {distance:.3} apart, farther than they can go")]
    FarApart {
        /// A lower bound of their distance along one direction.
        distance: f64,
    },
    /// The grid that the tolerance asks for has too many nodes.
    #[error("a field of spacing {spacing:.3} takes too much memory")]
    FieldTooLarge {
        /// The spacing that the tolerance asks for.
        spacing: f64,
    },
    /// The field stays wronger than allowed, however fine.
    #[error("a field of spacing {spacing:.3} is still wronger than allowed")]
    FieldTooWrong {
        /// The last spacing that was tried.
        spacing: f64,
    },
    /// The field was refused.
    #[error("{reason}")]
    Field {
        /// By the crate that builds it.
        reason: String,
    },
    /// The medial surface was refused.
    #[error("{reason}")]
    Medial {
        /// By the crate that generates it.
        reason: String,
    },
    /// The body cannot be simplified.
    #[error("{reason}")]
    Decimation {
        /// By the crate that simplifies.
        reason: String,
    },
    /// A coarser surface within the tolerance would save little.
    #[error("a coarser surface within the tolerance would save little")]
    SavesLittle,
    /// A body is open, so that depths mean nothing.
    #[error("an open surface has no inside: sweep it, or segment it where it is crossed")]
    Open,
    /// Neither body of a pair has a field.
    #[error("neither is a rigid body that has an inside")]
    NoBone,
}

/// Something that was built for a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Structure {
    /// The body.
    pub body: BodyId,
    /// What it was given.
    pub kind: StructureKind,
    /// Faces of a surface, nodes of a field, or balls.
    pub size: usize,
    /// Distance between nodes of a field.
    pub spacing: Option<f64>,
    /// How far it may be from the body's own surface, in the length unit.
    pub error_bound: f64,
    /// Bytes it holds.
    pub bytes: usize,
}

impl fmt::Display for DetectionMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Field => "by the field",
            Self::Surfaces => "by surfaces",
            Self::Medial => "by balls",
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
