//! What collision handling between surfaces shares: triangle surfaces and
//! their defects, exact primitives on bare points, and the contact record.
//!
//! Topology ([`TriangleSurface`]) is built once; positions are arguments,
//! wrapped once into a proof that they fit ([`Positions`]). Any list of
//! triangles with valid indices is a surface: being closed, manifold or
//! oriented is a property it can be asked for, and an operation that needs one
//! fails with the first offender's place.
//!
//! This crate holds vocabulary and primitives only: no search structure, no
//! solver, no input or output.

mod aabb;
mod closest;
mod contact;
mod crossing;
mod csr;
mod defects;
mod error;
mod expansion;
mod fan;
mod hausdorff;
mod inspect;
mod measures;
pub mod parallel;
mod perturbed;
mod positions;
mod predicates;
pub mod progress;
mod pseudonormal;
mod rigid;
mod simplex;
mod total;
pub mod triangle;
mod triangle_surface;
mod union_find;
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
pub use crate::hausdorff::{DirectedHausdorff, HausdorffBounds};
pub use crate::inspect::{Defect, Element, Finding, Inspection, inspect};
pub use crate::measures::{mean_edge, vertex_areas, vertex_normals};
pub use crate::perturbed::{PerturbedMeeting, Stretch, StretchEnd, meet_perturbed, passing_share};
pub use crate::positions::{PositionBuffer, Positions};
pub use crate::pseudonormal::Pseudonormals;
pub use crate::rigid::{Pose, RigidState};
pub use crate::simplex::{NO_NEIGHBOR, SimplexSurface};
pub use crate::total::TotalF64;
pub use crate::triangle_surface::{NO_EDGE, TriangleSurface};
pub use crate::union_find::UnionFind;
pub use crate::winding::{
    ray_crosses_triangle, ray_crosses_triangle_from_below, solid_angle, winding_number,
};
