//! Overlap removal: bodies that overlap are pushed apart.
//!
//! Works in rounds of detection and correction. Each round
//!
//! 1. detects contacts again, for pairs of which a body has moved;
//! 2. solves all contacts together for displacements (projected Gauss–Seidel, particles
//!    weighted by inverse mass);
//! 3. spreads the displacements to the tissue around, along surfaces and through bodies;
//! 4. restores the shape of tissue and separates it again, in turns;
//! 5. gives lost volume back where bodies are free.
//!
//! Rounds are compared by the depth of vertices and crossing edges. The certified depth of surfaces
//! decides whether an overlap is within the tolerance.
//!
//! Rigid bodies stay. No round moves a vertex farther than the tissue around it can follow:
//! deep overlaps take several.
//!
//! # Features
//!
//! - `rayon`: pairs, bodies and large batches of contacts on the threads of the current pool;
//!   results are the same to the bit.
//! - `serde`: parameters implement `Serialize` and `Deserialize`.
//!
//! None is on by default.

mod edge_contacts;
mod error;
mod exit_sides;
mod near_pairs;
mod params;
mod push;
mod resolution;
mod resolver;
mod run;
mod shape;
mod spread;
mod tissue;
mod tuning;
mod warm_start;

pub use glam;

pub use crate::error::ResolveError;
pub use crate::params::ResolveParams;
pub use crate::resolution::{BodyChange, Obstacle, Remaining, Resolution, Round};
pub use crate::resolver::{Resolver, resolve};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
