//! Triangle surfaces, exact primitives on them, and the contact record of collision
//! handling.
//!
//! Topology ([`TriangleSurface`]) is built once; positions are arguments, wrapped once
//! into a proof that they are finite and of the right number ([`Positions`]). Any list of
//! triangles with valid indices is a surface: *closed*, *manifold* and *oriented* are
//! properties that an operation checks, and its error names the first offender.
//!
//! This crate holds vocabulary and primitives only: no search structure, no
//! solver, no input or output.
//!
//! - Surfaces: [`TriangleSurface`], [`SimplexSurface`], [`inspect`], [`Pseudonormals`].
//! - Exact tests: [`triangles_meet`], [`segment_meets_triangle`], [`meet_perturbed`],
//!   [`ray_crosses_triangle`].
//! - Closest points: [`closest_on_triangle`], [`closest_between_triangles`] and others.
//! - Geometry: [`triangle`], [`vectors`], [`Aabb`], [`vertex_areas`], [`vertex_normals`], [`mean_edge`].
//! - Contacts: [`Contact`], [`Stencil`], [`ContactSide`].
//! - Rigid motion: [`Pose`], [`RigidState`].
//! - Tools: [`parallel`], [`progress`], [`UnionFind`], [`Csr`], [`TotalF64`].
//!
//! # Example
//!
//! ```
//! use surface::glam::DVec3;
//! use surface::{Meeting, triangles_meet};
//!
//! let floor = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
//! let wall = [DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 1.0)];
//! assert_eq!(triangles_meet(floor, wall), Meeting::Crossing);
//! ```
//!
//! # Features
//!
//! - `rayon`: runs the loops of [`parallel`] on the current thread pool.
//! - `serde`: serializes plain data.
//!
//! None is on by default.

mod aabb;
mod closest;
mod contact;
mod crossing;
mod csr;
mod defects;
mod error;
mod expansion;
mod face_bounds;
mod fan;
mod hausdorff;
mod inspect;
mod measures;
pub mod parallel;
mod path;
mod perturbed;
mod positions;
mod predicates;
pub mod progress;
mod pseudonormal;
mod range;
mod relative_path;
mod rigid;
mod seams;
mod simplex;
mod total;
pub mod triangle;
mod triangle_surface;
mod union_find;
pub mod vectors;
mod winding;

pub use glam;

pub use crate::aabb::Aabb;
pub use crate::closest::{
    Barycentric, ClosestBetweenSegments, ClosestBetweenTriangles, ClosestOnSegment,
    ClosestOnTriangle, TriangleFeature, closest_between_segments, closest_between_triangles,
    closest_on_segment, closest_on_triangle,
};
pub use crate::contact::{Anchor, Contact, ContactSide, Stencil, Term};
pub use crate::crossing::{Meeting, segment_meets_triangle, triangles_meet};
pub use crate::csr::Csr;
pub use crate::error::{SimplexError, SurfaceError};
pub use crate::hausdorff::DirectedHausdorff;
pub use crate::inspect::{Defect, Element, Finding, Inspection, inspect};
pub use crate::measures::{mean_edge, vertex_areas, vertex_normals};
pub use crate::path::{NearRigidPath, Path, RigidBodyPath, RigidPath, RigidPlace, StraightPath};
pub use crate::perturbed::{PerturbedMeeting, Stretch, StretchEnd, meet_perturbed, passing_share};
pub use crate::positions::{PositionBuffer, Positions};
pub use crate::pseudonormal::Pseudonormals;
pub use crate::range::{MAX_COORDINATE, MIN_SIZE};
pub use crate::relative_path::RelativePath;
pub use crate::rigid::{Pose, RigidState};
pub use crate::simplex::{NO_NEIGHBOR, SimplexSurface};
pub use crate::total::TotalF64;
pub use crate::triangle_surface::{NO_EDGE, TriangleSurface};
pub use crate::union_find::UnionFind;
pub use crate::winding::{
    ray_crosses_triangle, ray_crosses_triangle_from_below, solid_angle, winding_number,
};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
