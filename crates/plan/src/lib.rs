//! Choice of a collision detection method for each pair of bodies, by tolerance and cost.
//!
//! The caller states the largest accepted error of a depth, and for how many frames the plan is
//! made. Each pair then gets the method that is predicted to take the least time for construction
//! and all frames, among those whose error is proved to be within the tolerance: exact surfaces,
//! coarser ones, or the distance field of a bone. Only what some pair needs is built. No pair that
//! overlaps by more than the tolerance is reported as apart.
//!
//! Depth is that of surfaces: the greatest distance of any point of one surface inside the other
//! body, not of its vertices. It changes by no more than the shapes do, so that the deviation of
//! coarser surfaces bounds its error.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2, which chooses distance maps for rigid bodies and
//! surfaces or medial axes for others by their kind. Here, proved bounds and predicted costs
//! decide.
//!
//! ```
//! use plan::{Detection, DetectionMethod, Plan, PlanParams, RespondParams};
//! use scene::{BodyKind, Scene};
//! use surface::glam::{DQuat, DVec3};
//! use surface::progress::Progress;
//! use surface::{Pose, TriangleSurface};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
//! let surface = TriangleSurface::new(4, faces)?;
//! let mut scene = Scene::new();
//! let bone = scene.add("bone", BodyKind::Rigid, surface.clone(), corners.to_vec())?;
//! let muscle = scene.add("muscle", BodyKind::Deformable, surface, corners.to_vec())?;
//!
//! let params = PlanParams::with_tolerance(0.5);
//! let mut plan = Plan::new(&mut scene, &params, Progress::none())?;
//! assert_eq!(plan.pairs()[0].method, DetectionMethod::Exact);
//! println!("{plan}");
//!
//! // The bone moves until one corner of the muscle is 3 over its base.
//! scene.pose_body(bone, &Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0)))?;
//! let mut detection = Detection::default();
//! plan.detect(&mut scene, &mut detection)?;
//! assert!(detection.pairs()[0].is_overlapping() && detection.pairs()[0].depth.upper >= 3.0);
//!
//! plan.respond(&mut scene, &detection, &RespondParams::default())?;
//! assert!(scene.body(muscle).positions()[0].length() > 2.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: structures are built, and pairs are detected, on the threads of the current pool;
//!   results are the same to the bit.
//! - `serde`: parameters, results, methods and operation counts implement `Serialize` and
//!   `Deserialize`.
//!
//! None is on by default.

mod accuracy;
mod bone_field;
mod box_depth;
mod budget;
mod builder;
mod candidates;
mod choice;
mod coarse_levels;
mod coarse_size;
mod compared;
mod cost;
mod cut_face;
mod detection;
mod error;
mod followers;
mod frame;
mod method;
mod motion;
mod pair;
mod pair_detector;
mod params;
mod plan;
mod planner;
mod respond;
mod rounding;
mod structures;
mod surface_depth;
mod table;
mod workload;

pub use glam;

pub use crate::accuracy::Accuracy;
pub use crate::budget::FrameBudget;
pub use crate::cost::{OperationCounts, machine_factor};
pub use crate::detection::{Detection, LeftOutPair, PairDetection, PairState};
pub use crate::error::PlanError;
pub use crate::method::{DetectionMethod, ExclusionReason, StructureKind};
pub use crate::pair::{ExcludedPair, PairPlan};
pub use crate::params::{ForcedMethod, PlanParams};
pub use crate::plan::Plan;
pub use crate::respond::RespondParams;
pub use crate::structures::{MissingStructure, Structure};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
