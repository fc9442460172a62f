//! Contacts of points, balls and primitives with a medial surface.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2: trees of bounds over the primitives of the balls, tested
//! against the points or balls of the other object, whose distance to the nearest ball is compared
//! with the radii.
//!
//! Differs from the printed pseudo code:
//!
//! - The bound of a ball along n is `n·c ± r‖n‖`, and lower bounds are minima.
//! - A pair of a leaf and an inner node descends the inner node.
//! - Primitives within the margin are contacts, not only those that overlap; one of the trees is
//!   widened by the margin.
//! - Of several contacts of a point, those with the smallest gap are kept, not the one with the
//!   closest center: up to three with distinct normals, since one is not enough in a groove.
//! - The foot on a slab is exact, unless the bare face is requested.
//! - A point at the center of a ball has the normal of the sheet. One beyond the middle of the sheet
//!   is on the other side.

mod contact;
mod point_search;
mod points;
mod primitives;
mod separation;

pub use self::contact::{CandidatePair, ParticleOffsets, PointContact};
pub use self::point_search::PointCandidates;
pub use self::points::{QueryPoints, point_contacts, point_contacts_among};
pub use self::primitives::{PrimitiveContact, primitive_contacts, primitive_contacts_among};
use crate::{FootRule, MedialSurface, PrimitiveTree};

/// Maximum number of contacts per point: a groove with three sides needs as many.
pub const MAX_CONTACTS: usize = 3;

/// Parameters of the contacts of points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MedialContactParams {
    /// Gap up to which a contact is reported, `>= 0`.
    pub margin: f64,
    /// Ball of a primitive that is compared with a point.
    pub rule: FootRule,
    /// Number of contacts that are kept per point, `1..=`[`MAX_CONTACTS`].
    pub max_contacts: usize,
}

impl MedialContactParams {
    /// Returns exact feet and up to [`MAX_CONTACTS`] contacts per point.
    #[must_use]
    pub const fn new(margin: f64) -> Self {
        Self { margin, rule: FootRule::Exact, max_contacts: MAX_CONTACTS }
    }
}

/// Medial surface with the tree over its primitives.
#[derive(Clone, Copy, Debug)]
pub struct MedialBounds<'a> {
    /// The medial surface.
    pub medial: &'a MedialSurface,
    /// Its tree, fitted to the present balls.
    pub tree: &'a PrimitiveTree,
}

/// Numbers of tests of one detection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TestCounts {
    /// Tests of four bounds against others, in the trees.
    pub bound_tests: u64,
    /// Tests of a direction that may separate a point or a primitive from a primitive.
    pub direction_tests: u64,
    /// Distances of a point, a ball or a primitive from a primitive.
    pub leaf_tests: u64,
}
