//! Discrete oriented polytopes (k-DOPs) and quadtrees of them for deforming leaves.
//!
//! A k-DOP bounds a set by its extent along `k / 2` directions that are the same for every volume,
//! so a gap in any one direction tells two sets apart. More directions hug thin, slanted shapes (a
//! muscle belly, a tendon) better than a box does, at a cost that grows linearly; eighteen planes
//! take nearly all of the gain.
//!
//! A [`Tree`] bounds leaves that the caller numbers: triangles, edges, points, balls and the hulls
//! of two or three balls, or plain boxes. It is built once for a topology; a [refit](DopTree::refit)
//! follows the moving points without allocation. Traversals report candidate leaves to a visitor,
//! use a [`Workspace`] of the caller's and never lose a pair.
//!
//! # No pair is lost
//!
//! Take a point `q` of two leaves, and a direction `n`. A leaf is the convex hull of its points, so
//! `n·q` lies between the least and the greatest `n·P` of the corners `P` of either leaf. Rounding
//! to nearest is monotone, in f64 and again in f32, and each projection of the 6- and the 18-DOP is
//! one f64 operation at most; hence the *rounded* projection of `q` lies between the rounded bounds
//! of either leaf, and the intervals overlap. No outward rounding is needed, at any distance from
//! the origin. Where more than one operation rounds (radii, and the three-term directions of the 14-
//! and the 26-DOP) the f64 interval is first widened by a bound on that rounding. Margins are
//! handled in the same way, see [`DopTree::pairs`]. The tests in `tests/no_pair_lost.rs` hold this
//! against brute force, at up to a million edge lengths from the origin.
//!
//! # Sources
//!
//! - J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral and K. Zikan, "Efficient Collision
//!   Detection Using Bounding Volume Hierarchies of k-DOPs", IEEE TVCG 4(1), 1998: the volumes.
//! - J. Mezger, S. Kimmerle and O. Etzmuß, "Hierarchical Techniques in Collision Detection for Cloth
//!   Animation", Journal of WSCG 11(1), 2003: quadtrees of 18-DOPs, inflation, refits.
//! - B. Gilles, "Anatomical and kinematical modelling of the musculoskeletal system from MRI",
//!   doctoral thesis, University of Geneva, 2007, section 4.7.2: static and dynamic DOPs for muscles.
//!
//! Differs from them in the leaves: the bounds of up to eight neighbouring leaves are not stored but
//! computed from the projected points when a traversal comes near, which makes a refit cheaper than
//! that of a tree of boxes.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use kdop::{Leaves, Tree, Workspace};
//!
//! // Two triangles that cross, then one of them moves away.
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
//! moving.refit(&wall.map(|p| p + DVec3::Z * 5.0))?;
//! floor.pairs(&moving, 0.0, &mut workspace, |_, _| panic!("they are four apart"));
//! # Ok::<(), kdop::TreeError>(())
//! ```

mod build;
mod cluster;
mod directions;
mod dop;
mod error;
mod extents;
mod leaves;
mod neighbours;
mod quad;
mod refit;
mod rows;
mod traverse;
mod tree;
mod workspace;

pub use crate::directions::{Axis, direction, norm};
pub use crate::dop::{Dop, Dop6, Dop14, Dop18, Dop26};
pub use crate::error::{InvalidTree, TreeError};
pub use crate::extents::Extents;
pub use crate::leaves::Leaves;
pub use crate::tree::{DopTree, Tree};
pub use crate::workspace::{Counters, Workspace};
