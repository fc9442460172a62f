//! Exact proximity queries between triangle surfaces with bounding volume trees.
//!
//! A [`SurfaceTree`] is a [`TriangleSurface`](surface::TriangleSurface) at finite positions, with
//! a tree of k-DOPs over its faces. The three always fit each other, so that a query needs
//! neither exclusive access nor a check:
//!
//! - [`SurfaceTree::closest_point`], [`SurfaceTree::contains`] and
//!   [`SurfaceTree::self_crossings`] on one surface;
//! - [`PairProximity`] between two: crossing faces, vertices inside or within a margin, their
//!   closest points, and the distance between the surfaces;
//! - [`SeparationBounds`]: certified bounds on the distance between two, and [`NearFeatures`]: the
//!   closest points of all their near vertices, edges and faces;
//! - [`regions`] of a surface that another one cuts;
//! - [`SweptQuery`]: the first contacts of vertices, edges and faces during a step.
//!
//! Whether two surfaces cross is decided by exact predicates, and whether a point is inside by
//! ray parity, never by a nearby normal. Distances are right up to rounding.
//!
//! [`LazySurfaceTree`] is for surfaces that move often and are queried seldom: its tree is built
//! or refit on demand. [`contact()`] turns a vertex and its closest point into a contact record
//! for a response.
//!
//! # Example
//!
//! Two tetrahedra, one poked a tenth of a unit into the other.
//!
//! ```
//! use proximity::{PairProximity, SurfaceTree};
//! use proximity::glam::DVec3;
//! use surface::TriangleSurface;
//!
//! let surface = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
//! let shifted = corners.map(|corner| corner + DVec3::new(1.0, 1.0, 9.9 - 2.0));
//! let bone = SurfaceTree::new(surface.clone(), corners.to_vec())?;
//! let muscle = SurfaceTree::new(surface, shifted.to_vec())?;
//!
//! let mut pair = PairProximity::default();
//! pair.compute(&bone, &muscle, 0.0)?;
//! assert!(pair.overlaps());
//! assert_eq!(pair.sides()[1].inside_vertices(), [0]);
//! assert!((pair.max_vertex_depth() - 0.1 / 3.0_f64.sqrt()).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: batches of swept queries run on the threads of the current pool.
//! - `serde`: results implement `Serialize` and `Deserialize`.

mod closest;
mod contact;
mod crossings;
mod distance;
mod division;
mod error;
mod face_boxes;
mod face_groups;
mod inside;
mod inverted_parts;
mod maximum;
mod near_faces;
mod near_features;
mod pair;
mod projection;
mod regions;
mod rounding;
mod self_crossings;
mod separation;
mod surface_tree;
mod swept;

pub use glam;

pub use crate::closest::ClosestPoint;
pub use crate::contact::{ContactSurface, ParticleNumbers, contact};
pub use crate::division::TriangleDivision;
pub use crate::error::{NoInside, PairError, ProximityError, SweptError};
pub use crate::face_boxes::{FaceBox, FaceBoxes};
pub use crate::maximum::MaximumSearch;
pub use crate::near_faces::{NearFaces, list_near_faces};
pub use crate::near_features::{FeaturePoint, NearFeatures};
pub use crate::pair::{PairProximity, PairSide};
pub use crate::projection::NearVertex;
pub use crate::regions::{Region, Side, regions};
pub use crate::separation::SeparationBounds;
pub use crate::surface_tree::{LazySurfaceTree, SurfaceTree};
pub use crate::swept::{ContactKind, SweptContact, SweptContacts, SweptQuery, SweptSide};
