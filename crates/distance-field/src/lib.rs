//! Signed distance grids of rigid surfaces: built in a third of a second, asked
//! millions of times.
//!
//! A rigid bone gets a grid of signed distances once. From then on the height
//! of any point over it, and the direction away from it, cost one look at eight
//! numbers, however fine the bone's mesh.
//!
//! # Two ways to build
//!
//! - [`FieldMethod::Voxel`]: faces switch voxels on, and a Euclidean distance
//!   transform measures how far the nearest of these is. Quick and simple, and
//!   half a voxel wrong everywhere: 0.2 mm and 20° of direction at 1 mm, and the
//!   direction does not get better on finer grids.
//! - [`FieldMethod::ExactBand`], the default: exact distances to the surface in a
//!   band of three voxels, and beyond it exact distances to the face that the
//!   nearest node of the band is closest to. Nodes of the band give way a little
//!   to what lies between them ([`NodeValues::QuasiInterpolating`]). On the same
//!   grid 50 times as accurate in distance, 10 times in direction.
//!
//! `docs/accuracy-distance-field.md` holds the figures, written from what
//! `tests/accuracy.rs` prints and holds.
//!
//! # Inside and outside
//!
//! Real bones have holes, faces the wrong way round and parts that overlap. By
//! default a node is inside where the generalized winding
//! number of the surface is above one half: exact on every closed surface, and
//! on others what a person would say. It costs no more than a parity of
//! crossings, except close to holes.
//!
//! # What to expect
//!
//! - Values near a closed surface are within what the build calls certain
//!   ([`FieldReport::error_bound`], one spacing), and on bones nearly everywhere
//!   within a tenth of that, as the build measures at sample points
//!   ([`FieldReport::measured_error`]). Interpolation, not the nodes, makes nearly all
//!   of the error.
//! - Beyond the band a value may be too long, never too short, where two parts of
//!   the surface compete: by hundredths of a spacing over a bone, by up to a fifth
//!   around what is no larger than the band.
//! - A solid thinner than 1.5 spacings loses part of its inside between nodes; the
//!   build says so ([`FieldWarning::ThinnerThanGrid`]).
//! - Where several parts of the surface are equally near, no direction is right;
//!   the gradient is then short ([`Sample::direction`]).
//! - The same surface and options give the same bits, whatever the number of
//!   threads (feature `rayon`).
//!
//! Sources: B. Gilles, "Anatomical and kinematical modelling of the
//! musculoskeletal system from MRI", PhD thesis, University of Geneva, 2007,
//! section 4.7.2, for the seed method and its use; the modules name theirs.

mod along;
mod ask;
mod band;
mod build;
mod carry;
mod chain;
mod compare;
mod convert;
mod crossings;
mod envelope;
mod error;
mod field;
mod flood;
mod frame;
mod grid;
mod inside;
mod interpolate;
mod lanes;
mod measure;
mod memory;
mod num;
mod par;
mod params;
mod quasi;
mod query;
mod report;
mod spread;
mod store;
mod transform;
mod units;
mod winding;

pub use crate::along::SegmentMinimum;
pub use crate::error::FieldError;
pub use crate::field::DistanceField;
pub use crate::grid::{FieldGrid, GridCell};
pub use crate::params::{FieldMethod, FieldParams, NodeValues, Storage, Voxelization};
pub use surface::Pose;

pub use crate::query::{Interpolation, QueryParams, Sample, SampleBatch};
pub use crate::report::{FieldReport, FieldWarning, MeasuredError};
