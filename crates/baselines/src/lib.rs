//! Other ways to detect collisions: hashing, layered depth images, chance.
//!
//! Fields, trees of bounds and medial surfaces are what this workspace builds
//! on. Here is what they are weighed against, each method small and in one
//! file with its paper:
//!
//! - [`spatial_hash`]: faces that cross, found in the cells of a hash table;
//! - [`layered_depth`]: overlap, volume and vertices inside, from sorted layers
//!   along parallel rays;
//! - [`average_case`]: whether two bodies overlap, by the chance that cells of
//!   two trees of boxes hold surface of both;
//! - [`selected_pairs`]: pairs of faces drawn at random, led to where they come
//!   closest, within a budget.
//!
//! All that compare two [`PlacedSurface`]s answer with [`PairFindings`], so that a chart can
//! set them beside each other: what was found, and the elementary tests it took.
//! Lengths are in the one unit of the positions. Same input, same bits out: what
//! is random comes from a seed.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use surface::TriangleSurface;
//! use baselines::{PlacedSurface, spatial_hash};
//!
//! // Two tetrahedra; a corner of the second is in the first.
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let body = |x| Ok::<_, surface::SurfaceError>(PlacedSurface { surface: &surface, x: surface.positions(x)? });
//!
//! let params = spatial_hash::SpatialHashParams { cell_size: 0.5, ..spatial_hash::SpatialHashParams::DEFAULT };
//! let found = spatial_hash::detect(body(&first)?, body(&second)?, &params)?;
//! assert!(found.overlap);
//! let [_, of_second] = found.inside.expect("hashing finds vertices inside");
//! assert_eq!(of_second.iter().map(|v| v.vertex).collect::<Vec<_>>(), [0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod average_case;
mod boxes;
mod cells;
mod error;
mod findings;
mod generator;
pub mod layered_depth;
mod propagation;
pub mod selected_pairs;
pub mod spatial_hash;

pub use crate::error::BaselineError;
pub use crate::findings::{PairFindings, PlacedSurface, VertexInside};
