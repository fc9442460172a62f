//! Certified continuous collision detection (CCD) of moving vertices, edges and faces.
//!
//! Points move on straight lines from time 0 to time 1 of a step. [`vertex_face`] and [`edge_edge`]
//! find when two primitives first meet, or first come within a separation:
//!
//! - **no contact is missed**, whatever rounding does: `None` is returned only where a certificate
//!   holds for every time of the step;
//! - **no time is late**: [`CcdContact::lo`] is never after the first contact;
//! - [`Certainty::Certain`] states that there is a contact in `lo..=hi`. A contact that rounding
//!   cannot distinguish from a near miss is [`Certainty::Possible`], or, with the feature `exact`
//!   and [`Undecided::DecideExactly`], decided in integers.
//!
//! Not promised: a possible contact may be none, and `lo` may be early, by 1e-13 of the step for
//! most contacts and by more where paths are tangent.
//!
//! There is no absolute tolerance. Multiplying all lengths by a power of two changes no bit of an
//! answer. Only differences of coordinates count, so the scene may be far from the origin.
//!
//! [`first_contact_on_paths`] promises the same on curved paths, of which the second derivative is
//! bounded: rotations of bones.
//!
//! [`MovingPoints`] processes many candidates by index into shared positions, filters them in SIMD
//! lanes, and finds the first contact of all.
//!
//! # How it works
//!
//! Both queries reduce to the time at which a moving convex polygon contains the origin: the face
//! relative to the vertex, or the parallelogram of differences of two edges. Two certificates
//! exclude that. *Direction*: some direction in which all corners are positive at both ends of an
//! interval, and so in between. *Cubic*: Bernstein coefficients of the volume that the polygon spans
//! with the origin, all of one sign beyond their rounding bound. Everything else, Newton steps and
//! closest points, is a hint that decides where to search, never what is true.
//! `docs/ccd-error-analysis.md` derives every bound, and tests compare each with exact arithmetic.
//!
//! # Sources
//!
//! - X. Provot, "Collision and self-collision handling in cloth model dedicated to design garments",
//!   Graphics Interface 1997: the cubic.
//! - M. Tang, D. Manocha and R. Tong, "Fast continuous collision detection using deforming
//!   non-penetration filters", I3D 2010: its Bernstein form.
//! - B. Wang et al., "A large-scale benchmark and an inclusion-based algorithm for continuous
//!   collision detection", ACM TOG 40(5), 2021: the benchmark of missed contacts and false alarms.
//!
//! # Example
//!
//! ```
//! use ccd::{CcdParams, vertex_face};
//! use glam::DVec3;
//!
//! // A vertex falls from 1 above a face to 1 below it.
//! let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
//! let at = |height: f64| [DVec3::new(0.2, 0.3, height), face[0], face[1], face[2]];
//! let contact = vertex_face(at(1.0), at(-1.0), &CcdParams::DEFAULT)?.expect("it falls through");
//!
//! assert!(contact.is_certain() && contact.lo <= 0.5 && 0.5 <= contact.hi);
//! assert!(contact.hi - contact.lo < 1e-12);
//! assert_eq!(contact.normal, DVec3::Z);
//! assert!((contact.weights[2] - 0.2).abs() < 1e-12);
//! # Ok::<(), ccd::CcdError>(())
//! ```
//!
//! # Features
//!
//! - `exact`: decides in exact integer arithmetic what rounding leaves open.
//! - `rayon`: processes batches on several threads, with the results of one thread.
//! - `serde`: serializes parameters and contacts.
//!
//! None is on by default.

mod advance;
mod batch;
mod closest;
mod contact;
mod coplanarity;
mod cubic;
mod curved;
mod ends;
mod error;
#[cfg(feature = "exact")]
mod exact;
mod lanes;
mod outline;
mod polygon;
mod rounding;
mod scalar;
mod search;
mod shape;

pub use batch::{CandidateContact, FirstContact, MovingPoints};
pub use contact::{CcdContact, CcdParams, Certainty, Undecided};
pub use curved::{PathBounds, Primitives, chord_deviation, first_contact_on_paths};
pub use error::{CcdError, StepEnd};
pub use glam;

use glam::DVec3;

/// Finds the first contact of a moving vertex and a moving face.
///
/// `x0` and `x1` hold the vertex, then the corners of the face, at the start and the end of the
/// step. `None` means that they certainly do not meet until [`CcdParams::t_max`].
///
/// # Errors
///
/// When a coordinate is not finite or a parameter is out of range.
pub fn vertex_face(
    x0: [DVec3; 4],
    x1: [DVec3; 4],
    params: &CcdParams,
) -> Result<Option<CcdContact>, CcdError> {
    params.validate()?;
    search::first_contact::<3>(&x0, &x1, params)
}

/// Finds the first contact of two moving edges.
///
/// `x0` and `x1` hold the ends of the first edge, then of the second, at the start and the end of
/// the step.
///
/// # Errors
///
/// When a coordinate is not finite or a parameter is out of range.
///
/// # Example
///
/// ```
/// use ccd::{CcdParams, edge_edge};
/// use glam::DVec3;
///
/// let crossed = |gap: f64| {
///     [DVec3::new(-1.0, 0.0, gap), DVec3::new(1.0, 0.0, gap), DVec3::NEG_Y, DVec3::Y]
/// };
/// let near = CcdParams { min_separation: 0.1, ..CcdParams::DEFAULT };
/// assert_eq!(edge_edge(crossed(1.0), crossed(0.2), &near)?, None);
///
/// let contact = edge_edge(crossed(1.0), crossed(0.0), &near)?.expect("within 0.1 at 0.9");
/// assert!(contact.lo <= 0.9 && contact.lo > 0.9 - 1e-6);
/// # Ok::<(), ccd::CcdError>(())
/// ```
pub fn edge_edge(
    x0: [DVec3; 4],
    x1: [DVec3; 4],
    params: &CcdParams,
) -> Result<Option<CcdContact>, CcdError> {
    params.validate()?;
    search::first_contact::<4>(&x0, &x1, params)
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
