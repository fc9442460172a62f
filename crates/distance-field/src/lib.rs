//! Signed distance fields of rigid surfaces on regular grids.
//!
//! A rigid bone gets a grid of signed distances once. From then on the distance of any point
//! from it, and the direction away from it, cost one interpolation between eight numbers,
//! however fine the bone's mesh.
//!
//! # Two methods
//!
//! - [`FieldMethod::ExactBand`], the default: exact distances in a band of three spacings
//!   around the surface, and beyond it exact distances to the face that is closest to the
//!   nearest node of the band. The nodes of the band hold coefficients of a
//!   quasi-interpolation ([`NodeValues::QuasiInterpolating`]).
//! - [`FieldMethod::Voxel`], the method of the source: faces switch voxels on, and a Euclidean
//!   distance transform computes the distance from the nearest of these. It errs by half a
//!   voxel everywhere: 0.2 mm and 20° of direction at 1 mm, and the direction does not
//!   improve on finer grids. On the same grid the exact band is 50 times as accurate in
//!   distance, 10 times in direction.
//!
//! `docs/accuracy-distance-field.md` holds the figures, which `tests/accuracy.rs` prints and
//! checks.
//!
//! # Inside and outside
//!
//! Real bones have holes, reversed faces and parts that overlap. In the exact band a node is
//! inside where the generalized winding number of the surface exceeds one half: exact for
//! every closed surface, and for others what a person would say. It costs as much as a parity
//! of crossings, except close to holes.
//!
//! By the voxel method, a node is outside where a flood from the border of the grid reaches it.
//! Regions that the flood does not reach are inside where the surface encloses them, whichever way
//! its faces are oriented: closed cavities, which properly oriented shells enclose zero times, are
//! outside. Where neighboring faces have opposite orientations, or voxels leak between a cavity and
//! the solid around it, all that the flood does not reach is inside.
//!
//! # Accuracy
//!
//! - Values near a closed surface are within [`FieldReport::error_bound`], which is proved:
//!   one spacing. On bones the error is a tenth of that nearly everywhere, as every build
//!   measures at sample points ([`FieldReport::measured_error`]). Nearly all of it comes from
//!   interpolation. A value of the wrong sign is off by the sum of both distances.
//! - Beyond the band, the value of a node may be too large, never too small, where two parts of
//!   the surface compete: near medial planes and edges, by at most √3 spacings, which is proved;
//!   by up to .9 is measured, around boxes. Between nodes, across a crease of the distance, values
//!   are up to half a spacing too large or too small, as measured. Every build also measures that
//!   where it is expected to be largest ([`FieldReport::measured_deep_error`]).
//! - A solid thinner than 1.5 spacings loses part of its inside between nodes; the build
//!   warns about it ([`FieldWarning::ThinnerThanGrid`]).
//! - Where several parts of the surface are equally near, no direction is right; the gradient
//!   is then short ([`Sample::direction`]).
//! - The same surface and parameters give the same bits, whatever the number of threads.
//!
//! # Contacts
//!
//! [`FieldContacts`] finds the vertices and edges of a deformable surface within a margin of
//! a rigid body, given by the [`FieldDetector`] of its field.
//!
//! # Example
//!
//! ```
//! use distance_field::glam::DVec3;
//! use distance_field::{DistanceField, FieldParams, Interpolation};
//! use surface::{TriangleSurface, progress::Progress};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
//! let surface = TriangleSurface::new(4, faces)?;
//! let x = surface.positions(&corners)?;
//!
//! let field = DistanceField::build(&surface, x, &FieldParams::new(1.0), Progress::none())?;
//! let sample = field.evaluate(DVec3::new(8.0, 8.0, 2.0), Interpolation::Trilinear);
//! let sample = sample.expect("the point is within the padding");
//! assert!((sample.distance + 2.0).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: builds and batches of queries run on the threads of the current pool.
//! - `serde`: parameters, reports, samples and contacts implement `Serialize` and
//!   `Deserialize`.
//!
//! Source: B. Gilles, "Anatomical and kinematical modelling of the musculoskeletal system
//! from MRI", PhD thesis, University of Geneva, 2007, section 4.7.2, for the voxel method and
//! the use of fields; the modules name theirs.

mod accuracy;
mod band;
mod build;
mod contacts;
mod deep;
mod error;
mod face_groups;
mod field;
mod frame;
mod grid;
mod memory;
mod num;
mod params;
mod query;
mod report;
mod separable;
mod sign;
mod store;
mod transform;
mod units;
mod voxel;

pub use glam;
pub use surface::Pose;

pub use crate::contacts::{
    FieldContact, FieldContacts, FieldDetector, FieldDistance, FieldFeature,
};
pub use crate::error::FieldError;
pub use crate::field::DistanceField;
pub use crate::grid::FieldGrid;
pub use crate::params::{FieldMethod, FieldParams, NodeValues, Storage, Voxelization};
pub use crate::query::{Interpolation, QueryParams, Sample, SampleBatch, SegmentMinimum};
pub use crate::report::{FieldReport, FieldWarning, MeasuredError};
