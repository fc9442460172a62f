//! Volume meshes of tetrahedra, wedges and hexahedra: their boundary surface, their quality, and an interior
//! that follows the surface.
//!
//! - [`VolumeMesh`] has the cells; positions of the nodes are arguments, as those of surfaces are.
//!   Nodes in the middle of the straight edges of quadratic elements go with their ends ([`MiddleNode`]).
//!   Wedges and tetrahedra that are written as hexahedra with repeated nodes are read by [`Cell::collapsed`].
//! - [`VolumeMesh::boundary`] returns the triangles around it, over the nodes that they use.
//! - [`VolumeMesh::quality`] measures the scaled Jacobian of each cell.
//! - [`VolumeMesh::follow`] moves the nodes inside after those of the boundary: the equilibrium of a
//!   linear elastic body, in steps that are cut where a cell would be spoilt and no node inside can give way.

mod boundary;
mod cell;
mod collapsed;
mod elastic;
mod error;
mod follow;
mod mesh;
mod open_cells;
mod quality;

pub use glam;
pub use surface::progress::{Interrupted, Progress};

pub use crate::boundary::Boundary;
pub use crate::cell::Cell;
pub use crate::error::VolumeError;
pub use crate::follow::{BlockingCell, FollowParams, Followed};
pub use crate::mesh::{MiddleNode, VolumeMesh};
pub use crate::quality::MeshQuality;

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
