//! Mesh decimation onto a surface's own vertices, with a proved deviation.
//!
//! A closed surface of tens of thousands of faces is represented within half a millimeter by
//! a few thousand. [`Decimation`] finds them by edge collapses that move a vertex into one of
//! its neighbors (half-edge collapse). No vertex gets a new position, so a [`ReducedSurface`]
//! follows any deformation of the full one for free: its positions are
//! [gathered](ReducedSurface::gather). A [`CoarseSurface`] does so with a tree for collision
//! queries, and carries displacements back to the full surface. A [`Preview`] is for the eye alone: fast,
//! without a proof.
//!
//! # Deviation
//!
//! A continuous map from the full surface onto the reduced one is built, and the largest distance
//! of a point from its image is computed. That bounds the Hausdorff distance both ways, and more:
//! moved along the map, the full surface becomes the reduced one, so that both have the same
//! winding number about every point that is farther from one of them. A point that is deeper in
//! one body is inside of the other.
//!
//! Collapses are ordered by the deviation that they leave, and go on as far as it is allowed. Where the
//! map fails nevertheless, the faces around are kept, and the rest goes on: no place holds others back.
//!
//! Since the map is fixed to vertices, its largest distance is computed anew at any positions in
//! a time that is linear in them ([`CoarseSurface::deviation`]): it grows where the surface bends
//! or stretches within a coarse face, and not where parts of it move or turn as they are.
//!
//! # Limits
//!
//! - A reduced surface may cross itself where the full one comes closer to itself than the
//!   deviation: only its topology and the rotation of its faces are guarded.
//! - Where a surface is folded over itself by a defect, a reduced one may enlarge the fold, and
//!   keeps more faces than its Hausdorff distance asks for, since the map has to follow the fold.
//!
//! # Sources
//!
//! - M. Garland and P. S. Heckbert, "Surface Simplification Using Quadric Error Metrics",
//!   SIGGRAPH 1997: the neighbor that a vertex moves into.
//! - R. Klein, G. Liebich and W. Straßer, "Mesh Reduction with Error Control", IEEE Visualization
//!   1996: the order of the collapses, by the distance of removed vertices. Differs in that the faces
//!   around the last collapse near a vertex are searched, not all.
//! - T. K. Dey, H. Edelsbrunner, S. Guha and D. V. Nekhayev, "Topology Preserving Edge
//!   Contraction", Publications de l'Institut Mathématique 66, 1999: the link condition.
//! - J. Cohen, D. Manocha and M. Olano, "Simplifying Polygonal Models Using Successive Mappings",
//!   IEEE Visualization 1997: deviations by piecewise linear maps between surfaces. Differs in
//!   that one map is built from the full surface to the last one, by closest points, in place of
//!   one per collapse by projection.
//!
//! # Example
//!
//! ```
//! use decimate::Decimation;
//! use proximity::SurfaceTree;
//! use surface::progress::Progress;
//!
//! let ball = fixtures::shapes::icosphere(30.0, 4);
//! let full = SurfaceTree::new(ball.surface(), ball.positions.clone())?;
//! let decimation = Decimation::new(full, Progress::none())?;
//!
//! let reduced = decimation.within(0.5, Progress::none())?;
//! assert!(reduced.deviation <= 0.5);
//! assert!(reduced.surface.faces().len() < ball.faces.len() / 5);
//!
//! // It follows whatever the full surface does.
//! let squeezed: Vec<_> = ball.positions.iter().map(|p| *p * 0.9).collect();
//! let mut positions = Vec::new();
//! reduced.gather(&squeezed, &mut positions);
//! assert_eq!(positions[7], squeezed[reduced.kept[7] as usize]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod coarse_map;
mod coarse_surface;
mod collapsed;
mod decimation;
mod edge_images;
mod edge_path;
mod error;
mod map_builder;
mod mesh;
mod mesh_point;
mod order;
mod preview;
mod quadric;
mod reduced;
mod surfaces;
mod vertex_images;

pub use glam;

pub use crate::coarse_surface::CoarseSurface;
pub use crate::decimation::Decimation;
pub use crate::error::DecimateError;
pub use crate::preview::Preview;
pub use crate::reduced::ReducedSurface;

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
