//! Signed distance grids of rigid surfaces: built in a third of a second, asked
//! millions of times.

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
mod grid;
mod inside;
mod interpolate;
mod memory;
mod num;
mod options;
mod par;
mod query;
mod report;
mod sign;
mod spread;
mod store;
mod transform;
mod units;
mod winding;

pub use crate::error::FieldError;
pub use crate::field::DistanceField;
pub use crate::grid::{Cell, Grid};
pub use crate::options::{BuildOptions, Conversion, Method, SignRule, Storage, Transform};
pub use crate::query::{Interpolation, Pose, Query, Sample, Samples};
pub use crate::report::{BuildReport, Comparison, Phase, Warning};
