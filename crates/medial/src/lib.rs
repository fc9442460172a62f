//! Medial surfaces: volumes as balls, and the cones and slabs between them.
//!
//! A muscle is a sheet with thickness: a hundred balls say within a third of a
//! millimetre what thousands of faces say. And balls carry their inside with
//! them, so that a point's depth is a closed formula at one slab, where a closed
//! surface needs to know what is inside first.
//!
//! In the order of use:
//!
//! - [`generate`] makes a [`MedialSurface`] of a closed surface, by number of
//!   balls or by tolerance, and bounds its [`Deviation`] in both directions;
//!   [`MedialSurface::from_sheet`] takes one that is given as a 2-simplex surface,
//!   [`MedialSurface::from_ma`] one in text. [`Topology`] tells whether the union
//!   of balls is still one piece without holes.
//! - [`Links`] let it follow the surface as that deforms: centers are carried,
//!   balls refitted. Or the balls are what is simulated: see
//!   [`MedialSurface::set_centers`].
//! - [`point_contacts`] finds points or balls of another object in it or near it,
//!   [`primitive_contacts`] pairs of primitives of two medial surfaces, on a
//!   [`PrimitiveTree`] each, which [refits](PrimitiveTree::refit) to moved balls.
//! - [`foot`], [`slab_foot`], [`cone_foot`] and [`pair_foot`] are the exact
//!   distances beneath, on bare balls.
//!
//! # What is not promised
//!
//! Distances to the union are exact outside of it. Inside, a distance is that to
//! the envelope of the one primitive that reaches deepest: where primitives
//! overlap, the way out of all of them may be longer.
//!
//! # Sources
//!
//! - B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal
//!   system using MRI*, PhD thesis, University of Geneva, 2007, section 4.7.2:
//!   collisions of medial surfaces.
//! - The modules name those of generation and distances.
//!
//! # Example
//!
//! ```
//! use kdop::{Leaves, Tree, Workspace};
//! use medial::{ParticleOffsets, MedialParams, PrimitiveTree, QueryPoints, MedialContactParams, point_contacts, generate};
//! use surface::glam::DVec3;
//!
//! let muscle = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 3);
//! let surface = muscle.surface();
//! let medial = generate(&surface, surface.positions(&muscle.positions)?, &MedialParams::balls(40), |_| {})?
//!     .medial;
//!
//! // A point 2 deep under the flat side, and one far away.
//! let points = [DVec3::new(0.0, 0.0, 8.0), DVec3::new(0.0, 0.0, 50.0)];
//! let probes = QueryPoints { tree: &Tree::build(Leaves::Points, &points)?, points: &points, radii: None };
//! let tree = PrimitiveTree::new(&medial)?;
//! let workspace = &mut Workspace::default();
//! let (found, _) = point_contacts(
//!     &probes, &medial, &tree, &MedialContactParams::new(0.0), ParticleOffsets { first_point: 0, first_ball: 2 }, None, workspace,
//! );
//! assert_eq!(found[0].stencil.terms()[0].particle, 0);
//! assert!((found[0].gap + 2.0).abs() < 0.5 && found[0].normal.z > 0.9, "{found:?}");
//! # Ok::<(), medial::MedialError>(())
//! ```

mod ball;
mod carrier;
mod detect;
mod deviation;
mod distance;
mod error;
mod follow;
mod generate;
mod medial_surface;
mod parallel;
mod primitive_tree;
mod surface_distance;
mod text;
mod topology;

pub use crate::ball::Ball;
pub use crate::detect::{
    MAX_CONTACTS, MedialContactParams, ParticleOffsets, PointContact, PreviousNormals,
    PrimitiveContact, QueryPoints, TestCounts, point_contacts, point_contacts_among,
    primitive_contacts, primitive_contacts_among,
};
pub use crate::deviation::Deviation;
pub use crate::distance::{
    Foot, FootRule, PairFoot, bare_face_foot, cone_foot, foot, pair_foot, slab_foot,
};
pub use crate::error::MedialError;
pub use crate::follow::{FollowScratch, Link, Links, REFIT_PASSES};
pub use crate::generate::{
    Generated, MedialParams, MedialSize, Progress, Step, generate, generate_each,
};
pub use crate::medial_surface::MedialSurface;
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
