//! Medial surfaces: volumes as balls, with the cones and slabs between them.
//!
//! A muscle is a sheet with thickness: a hundred balls approximate thousands of faces within a third
//! of a millimeter. And balls have an inside of their own, so that the depth of a point is a closed
//! formula at one slab, where a closed surface needs to know first what is inside.
//!
//! In the order of use:
//!
//! - [`generate`] builds a [`MedialSurface`] of a closed surface, by number of balls or by
//!   tolerance, and bounds its [`Deviation`] in both directions; [`MedialSurface::from_sheet`] takes
//!   one that is given as a 2-simplex surface, [`MedialSurface::from_ma`] one in text. [`Topology`]
//!   checks that the union of balls is still one piece without holes.
//! - [`Links`] let it follow the surface as that deforms: centers are carried, balls refitted. Or the
//!   balls are what is simulated: see [`MedialSurface::set_centers`].
//! - [`MedialDetector`] finds the contacts of a body that follows: with vertices, with other medial
//!   surfaces, and with rigid bodies by their distance. Its contacts act on the body's surface.
//! - [`point_contacts`] finds points or balls of another object in it or near it,
//!   [`primitive_contacts`] pairs of primitives of two medial surfaces, on a [`PrimitiveTree`] each,
//!   which [refits](PrimitiveTree::refit) to moved balls. Their contacts act on the balls.
//! - [`foot`], [`slab_foot`], [`cone_foot`] and [`pair_foot`] are the exact distances beneath, on
//!   bare balls.
//!
//! # Limits
//!
//! Distances to the union are exact outside it. Inside, a distance is that to the envelope of the one
//! primitive that extends deepest: where primitives overlap, the way out of all of them may be
//! longer.
//!
//! # Sources
//!
//! - B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using MRI*, PhD
//!   thesis, University of Geneva, 2007, section 4.7.2: collisions of medial surfaces.
//! - The modules name those of generation and distances.
//!
//! # Example
//!
//! ```
//! use kdop::{Leaves, Tree, Workspace};
//! use medial::{
//!     MedialBounds, MedialContactParams, MedialParams, ParticleOffsets, PrimitiveTree, QueryPoints,
//!     generate, point_contacts,
//! };
//! use surface::glam::DVec3;
//! use surface::progress::Progress;
//!
//! let muscle = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 3);
//! let surface = muscle.surface();
//! let x = surface.positions(&muscle.positions)?;
//! let medial = generate(&surface, x, &MedialParams::balls(40), Progress::none())?.medial;
//!
//! // A point 2 deep under the flat side, and one far away.
//! let points = [DVec3::new(0.0, 0.0, 8.0), DVec3::new(0.0, 0.0, 50.0)];
//! let tree = Tree::build(Leaves::Points, &points)?;
//! let query = QueryPoints { tree: &tree, points: &points, radii: None };
//! let on = MedialBounds { medial: &medial, tree: &PrimitiveTree::new(&medial)? };
//! let params = MedialContactParams::new(0.0);
//! let particles = ParticleOffsets { first_point: 0, first_ball: 2 };
//! let workspace = &mut Workspace::default();
//! let (found, _) = point_contacts(&query, on, &params, particles, workspace);
//! assert_eq!(found[0].stencil.terms()[0].particle, 0);
//! assert!((found[0].gap + 2.0).abs() < 0.5 && found[0].normal.z > 0.9, "{found:?}");
//! # Ok::<(), medial::MedialError>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: generation and links run on the threads of the current pool; results are the same to
//!   the bit.
//! - `serde`: balls, parameters, deviations and contacts implement `Serialize` and `Deserialize`.

mod ball;
mod batches;
mod detect;
mod detector;
mod deviation;
mod distance;
mod error;
mod follow;
mod generate;
mod ma_text;
mod medial_surface;
mod primitive_tree;
mod sheet;
mod surface_distance;
mod symmetric;
mod topology;

pub use crate::ball::Ball;
pub use crate::detect::{
    CandidatePair, MAX_CONTACTS, MedialBounds, MedialContactParams, ParticleOffsets,
    PointCandidates, PointContact, PrimitiveContact, QueryPoints, TestCounts, point_contacts,
    point_contacts_among, primitive_contacts, primitive_contacts_among,
};
pub use crate::detector::{
    ContactBody, MedialContact, MedialDetector, MedialFeature, MedialScratch, PrimitiveBall,
    RigidDistance, RigidSide,
};
pub use crate::deviation::Deviation;
pub use crate::distance::{
    Foot, FootRule, PairFoot, bare_face_foot, cone_foot, foot, pair_foot, slab_foot,
};
pub use crate::error::MedialError;
pub use crate::follow::{FollowScratch, Link, Links, REFIT_PASSES};
pub use crate::generate::{Generated, MedialParams, MedialSize, generate, generate_each};
pub use crate::medial_surface::MedialSurface;
pub(crate) use crate::primitive_tree::{ExactFeet, PreparedSlabs};
pub use crate::primitive_tree::{NearestPrimitive, PrimitiveTree};
pub use crate::topology::Topology;

#[expect(clippy::cast_possible_truncation, reason = "counts of surfaces and balls fit 32 bits")]
fn index(count: usize) -> u32 {
    count as u32
}

#[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^52")]
fn real(count: usize) -> f64 {
    count as f64
}

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
