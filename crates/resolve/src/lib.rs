//! Overlap removal: bodies that overlap are pushed apart.
//!
//! Works in rounds of detection and correction. The first ones take vertices out. Each
//!
//! 1. detects contacts again, for pairs of which a body has moved;
//! 2. solves for the displacements since the start of least elastic energy, under all contacts and
//!    volumes (augmented Lagrangian, block Gauss–Seidel). What was pushed too far comes back.
//!
//! Later ones separate edges that still cross. Each
//!
//! 1. detects contacts again; corners that were pushed back leave in the direction in which the
//!    bodies cover each other least;
//! 2. solves all contacts together for displacements (projected Gauss–Seidel, particles
//!    weighted by inverse mass);
//! 3. spreads the displacements to the tissue around, along surfaces and through bodies;
//! 4. restores the shape of tissue and separates it again, in turns;
//! 5. gives lost volume back where bodies are free.
//!
//! Rounds are compared by their [merit](Round::merit), of the depth of vertices and crossing edges, and
//! accepted where it falls within all limits. The certified depth of surfaces decides whether an overlap
//! is within the tolerance.
//!
//! With a [gap](ResolveParams::gap), more rounds follow from the state that does not cross. Each
//!
//! 1. lists the closest points of all near vertices, edges and faces;
//! 2. solves for the displacement of least elastic energy that brings them to the gap and keeps
//!    volumes (augmented Lagrangian, block Gauss–Seidel);
//! 3. goes as far as certified continuous detection finds no contact on the way, and holds back
//!    faces that would turn over or cross others of their body.
//!
//! In the end positions are rounded to the [precision of the file](WrittenPrecision), and
//! [`GapProof`] holds certified distances between the surfaces of all pairs: each keeps the gap, or
//! is named with its distance and the reason. [`Conditions`] tie bodies to each other, fix
//! vertices, and keep the corners of elements open.
//!
//! Rigid bodies stay. No round moves a vertex farther than the tissue around it can follow:
//! deep overlaps take several.
//!
//! # Features
//!
//! - `rayon`: pairs, bodies and large batches of contacts on the threads of the current pool;
//!   results are the same to the bit.
//! - `serde`: parameters and results implement `Serialize` and `Deserialize`.
//!
//! None is on by default.

mod attempts;
mod cell_corners;
mod conditions;
mod contact_islands;
mod count;
mod curve_exits;
mod damage;
mod detection;
mod edge_contacts;
mod elastic;
mod elastic_part;
mod elastic_push;
mod error;
mod exempt;
mod exit_patches;
mod exit_sides;
mod free_step;
mod gap_rounds;
mod held;
mod held_overlaps;
#[cfg(feature = "serde")]
mod infinite;
mod level_pairs;
mod limits;
mod local_displacements;
mod loose_ties;
mod near_pairs;
mod near_pieces;
mod obstacle;
mod occurrences;
mod params;
mod parts;
mod pieces;
mod proof;
mod push;
mod relaxation;
mod resolution;
mod resolver;
mod round;
mod run;
mod seam_faces;
mod seam_particles;
mod seams;
mod self_contacts;
mod settle;
mod shape;
mod shared_number;
mod soft_positions;
mod spread;
mod squeeze;
mod struts;
#[cfg(test)]
mod test_scenes;
mod tied_motion;
mod tied_overlaps;
mod ties;
mod tissue;
mod tuning;
mod turning_faces;
mod turns;
mod uncross;
mod volume_row;
mod warm_start;
mod way_back;

pub use glam;

pub use crate::error::ResolveError;
pub use crate::obstacle::Obstacle;
pub use crate::params::{
    BodyStiffness, CellCorners, Conditions, FixedVertices, ResolveParams, Tie, TiedVertices,
    WrittenPrecision,
};
pub use crate::resolution::{
    BodyChange, BrokenLimit, DistanceBracket, GapObstacle, GapProof, GapRound, Remaining,
    Resolution, ShortGap,
};
pub use crate::resolver::{Resolver, resolve};
pub use crate::round::Round;
pub use crate::tuning::ResolveTuning;

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
