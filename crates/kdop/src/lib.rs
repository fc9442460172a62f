//! Discrete oriented polytopes (k-DOPs) and 4-ary trees of them over deforming leaves.
//!
//! A k-DOP bounds a set by its extent along `k / 2` directions that are the same for every volume,
//! so a gap along any one direction separates two sets. More directions fit thin, slanted shapes (a
//! muscle belly, a tendon) better than a box does, at a cost that grows linearly. Eighteen planes
//! take nearly all of the gain.
//!
//! A [`Tree`] bounds leaves that the caller numbers: triangles, edges, points, balls, and the
//! convex hulls of two or three balls. It is built once per topology; a [refit](DopTree::refit)
//! follows the moving points without allocation. Traversals report candidate leaves to a visitor,
//! use a [`Workspace`] of the caller and never lose a pair.
//!
//! # No pair is lost
//!
//! Take a point `q` of two leaves, and a direction `n`. A leaf is the convex hull of its points, so
//! `n·q` lies between the minimum and the maximum of `n·P` over the corners `P` of either leaf.
//! Rounding to nearest is monotone, in f64 and again in f32, and each projection of the 6- and the
//! 18-DOP is at most one f64 operation. Hence the *rounded* projection of `q` lies between the
//! rounded bounds of either leaf, and the intervals overlap. No outward rounding is needed, at any
//! distance from the origin. Where more than one operation rounds (radii, and the three-term
//! directions of the 14- and the 26-DOP), the f64 interval is first widened by a bound on that
//! rounding. Margins are handled in the same way, see [`DopTree::pairs`]. The tests in
//! `tests/it/no_pair_lost.rs` compare all of this with brute force, up to a million edge lengths
//! from the origin.
//!
//! # Sources
//!
//! - J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral and K. Zikan, "Efficient Collision
//!   Detection Using Bounding Volume Hierarchies of k-DOPs", IEEE TVCG 4(1), 1998: the volumes.
//! - J. Mezger, S. Kimmerle and O. Etzmuß, "Hierarchical Techniques in Collision Detection for Cloth
//!   Animation", Journal of WSCG 11(1), 2003: 4-ary trees (their quadtrees) of 18-DOPs, inflation,
//!   refits.
//! - B. Gilles, "Anatomical and kinematical modelling of the musculoskeletal system from MRI",
//!   doctoral thesis, University of Geneva, 2007, section 4.7.2: static and dynamic DOPs for muscles.
//!
//! Differs from them in the leaves. The bounds of up to eight neighboring leaves are not stored, but
//! computed from the projected points when a traversal comes near, which makes a refit cheaper than
//! that of a tree of boxes.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use kdop::{Leaves, Tree, Workspace};
//!
//! // Two triangles that cross.
//! let floor = [DVec3::ZERO, DVec3::X, DVec3::Y];
//! let wall = [DVec3::new(0.2, 0.2, -1.0), DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.2, 0.3, 1.0)];
//! let floor = Tree::build(Leaves::Triangles(&[[0, 1, 2]]), &floor)?;
//! let mut moving = Tree::build(Leaves::Triangles(&[[0, 1, 2]]), &wall)?;
//!
//! let mut workspace = Workspace::default();
//! let mut found = Vec::new();
//! floor.pairs(&moving, 0.0, &mut workspace, |a, b| found.push((a, b)));
//! assert_eq!(found, [(0, 0)]);
//!
//! // One of them moves away.
//! moving.refit(&wall.map(|p| p + DVec3::Z * 5.0))?;
//! floor.pairs(&moving, 0.0, &mut workspace, |_, _| panic!("they are four apart"));
//! # Ok::<(), kdop::TreeError>(())
//! ```
//!
//! # Features
//!
//! None.

mod build;
mod cluster;
mod common_points;
mod directions;
mod dop;
mod dop4;
mod error;
mod extents;
mod leaves;
mod moved_node;
mod neighbors;
mod node;
mod packed;
mod projections;
mod queue;
mod refit;
mod traverse;
mod tree;
mod validate;
mod workspace;

pub use glam;

pub use crate::directions::{Axis, direction, norm};
pub use crate::dop::{Dop, Dop18};
pub use crate::error::{InvalidTree, TreeError};
pub use crate::extents::Extents;
pub use crate::leaves::Leaves;
pub use crate::traverse::{MovingPairs, RigidSweep, StepTree};
pub use crate::tree::{DopTree, Tree};
pub use crate::workspace::{Counters, Workspace};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
