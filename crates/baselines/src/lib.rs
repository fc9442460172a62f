//! Collision detection methods to compare with: spatial hashing, layered depth images,
//! average-case trees and random pairs.
//!
//! Each method is small and stands in one file with its paper:
//!
//! - [`spatial_hash`]: crossing faces by the cells of a hash table, vertices inside by
//!   propagation from the crossings;
//! - [`layered_depth`]: volume and vertices inside, from sorted layers along parallel rays;
//! - [`average_case`]: probability of an overlap, from counts of filled cells in trees of boxes;
//! - [`selected_pairs`]: random pairs of faces that walk to local minima of their distance,
//!   within a budget.
//!
//! All take two [`PlacedSurface`]s and return [`PairFindings`]. Lengths are in the unit of the
//! positions. Same input, same bits out: random numbers come from a seed.
//!
//! # Example
//!
//! ```
//! use baselines::glam::DVec3;
//! use baselines::spatial_hash::{self, SpatialHashParams};
//! use baselines::{PlacedSurface, VertexInside};
//! use surface::TriangleSurface;
//!
//! // Two tetrahedra; a corner of the second is in the first.
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let a = PlacedSurface { surface: &surface, x: surface.positions(&first)? };
//! let b = PlacedSurface { surface: &surface, x: surface.positions(&second)? };
//!
//! let found = spatial_hash::detect(a, b, &SpatialHashParams::new(0.5))?;
//! assert!(found.overlap);
//! let [_, of_second] = found.inside.expect("hashing finds vertices inside");
//! assert_eq!(of_second.iter().map(|v: &VertexInside| v.vertex).collect::<Vec<_>>(), [0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! None.

pub mod average_case;
mod cells;
mod error;
mod findings;
mod generator;
pub mod layered_depth;
mod propagation;
pub mod selected_pairs;
pub mod spatial_hash;

pub use glam;

pub use crate::error::BaselineError;
pub use crate::findings::{PairFindings, PlacedSurface, VertexInside};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
