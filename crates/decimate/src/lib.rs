//! Coarser surfaces on a subset of a surface's own vertices, with certified deviation.
//!
//! A closed surface of tens of thousands of faces, asked for contacts within half a
//! millimetre, is served as well by a few thousand. [`Decimation`] finds them by edge
//! collapses that move a vertex into one of its neighbors. No vertex is ever placed
//! anew, so a [`ReducedSurface`] surface follows any deformation of the full one for free: its
//! positions are [gathered](ReducedSurface::gather).
//!
//! How far the two are from each other is bounded both ways ([`Deviation`]): no point of
//! either surface is farther from the other, up to rounding. The bound holds at the
//! positions that it was measured at; [`deviation()`] measures at others.
//!
//! What may happen: a reduced surface can cross itself where the full one comes closer to
//! itself than the deviation, since only its topology and the turn of its faces are
//! guarded.
//!
//! # Sources
//!
//! - M. Garland and P. S. Heckbert, "Surface Simplification Using Quadric Error Metrics",
//!   SIGGRAPH 1997: the order of the collapses.
//! - T. K. Dey, H. Edelsbrunner, S. Guha and D. V. Nekhayev, "Topology Preserving Edge
//!   Contraction", Publications de l'Institut Mathématique 66, 1999: the link condition.
//! - M. Guthe, P. Borodin and R. Klein, "Fast and Accurate Hausdorff Distance Calculation
//!   between Meshes", Journal of WSCG 13, 2005: branch and bound over faces. Differs in
//!   the bounds, which also use what covers a face.

mod cover;
mod decimation;
mod deviation;
mod error;
mod measure;
mod mesh;
mod one_sided;
mod order;
mod prefix;
mod quadric;
mod reduced;
mod triangles;

pub use crate::decimation::Decimation;
pub use crate::deviation::{Deviation, deviation};
pub use crate::error::DecimateError;
pub use crate::reduced::ReducedSurface;
pub use surface::DirectedHausdorff;
