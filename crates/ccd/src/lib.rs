//! Certified continuous collision detection of moving vertices, edges and faces.

mod advance;
mod batch;
mod closest;
mod contact;
mod coplanarity;
pub mod cubic;
mod error;
#[cfg(feature = "exact")]
mod exact;
mod lanes;
mod polygon;
mod rounding;
mod search;

pub use batch::{CandidateContact, FirstContact, Motion};
pub use contact::{Certainty, Contact, Params, Undecided};
pub use error::{CcdError, StepEnd};

use glam::DVec3;

/// Finds when a moving vertex first meets a moving face.
///
/// # Errors
///
/// When a coordinate is not finite or a parameter is out of range.
pub fn vertex_face(
    x0: [DVec3; 4],
    x1: [DVec3; 4],
    params: &Params,
) -> Result<Option<Contact>, CcdError> {
    params.check()?;
    search::first_contact::<3>(&x0, &x1, params)
}

/// Finds when two moving edges first meet.
///
/// # Errors
///
/// When a coordinate is not finite or a parameter is out of range.
pub fn edge_edge(
    x0: [DVec3; 4],
    x1: [DVec3; 4],
    params: &Params,
) -> Result<Option<Contact>, CcdError> {
    params.check()?;
    search::first_contact::<4>(&x0, &x1, params)
}
