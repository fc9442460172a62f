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
//! Rigid bodies stay. No round moves a vertex farther than the tissue around it can follow:
//! deep overlaps take several.

mod carry;
mod contacts;
mod guard;
mod near_pairs;
mod outcome;
mod params;
mod push;
mod resolver;
mod run;
mod sides;
mod spread;
mod tissue;
mod tuning;
mod volume;

pub use self::outcome::{BodyChange, Obstacle, Remaining, Resolution, Round};
pub use self::params::{ResolveError, ResolveParams};
pub use self::resolver::{Resolver, resolve};
