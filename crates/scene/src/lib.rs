//! Named bodies, with static and swept collision detection between all of them.
//!
//! A [`Scene`] holds bodies: rigid, deformable or open surfaces, each with a name.
//! [`Scene::check`] reports, for every pair of bodies within a margin of each other, whether they
//! overlap, how deep, by which volume and areas, and how far apart they are. [`Scene::sweep`] finds the first
//! contacts while bodies move to new positions, and [`SweepReport::pass_throughs`] those that
//! neither state shows. A [`SceneStep`] answers contacts inside a simulator's step.
//!
//! Candidate pairs come from a broad phase (sweep and prune). Trees are built and refit only for
//! bodies that may meet another one.
//!
//! # Example
//!
//! Two tetrahedra, one poked a tenth of a unit into the other.
//!
//! ```
//! use scene::glam::DVec3;
//! use scene::{BodyKind, CheckParams, PairId, Progress, Scene};
//! use surface::TriangleSurface;
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
//! let shifted = corners.map(|corner| corner + DVec3::new(1.0, 1.0, 9.9 - 2.0));
//!
//! let mut scene = Scene::new();
//! let surface = TriangleSurface::new(4, faces)?;
//! let bone = scene.add("bone", BodyKind::Rigid, surface.clone(), corners.to_vec())?;
//! let muscle = scene.add("muscle", BodyKind::Deformable, surface, shifted.to_vec())?;
//!
//! let reports = scene.check(&CheckParams::new(1.0), Progress::none())?;
//! assert_eq!(reports[0].pair, PairId::new(bone, muscle));
//! assert!(reports[0].overlaps);
//! assert_eq!(reports[0].b_against_a.inside_count, Ok(1));
//!
//! // One vertex of the muscle is inside, behind the slanted face of the bone.
//! let depth = reports[0].max_depth().ok_or("they overlap")?;
//! assert!((depth.lower - 0.1 / 3.0_f64.sqrt()).abs() < 1e-12);
//! let measures = &reports[0].overlap.as_ref().ok_or("measured")?.measures.total;
//! let volume = measures.volume.ok_or("both are closed")?;
//! assert!((volume - 0.1_f64.powi(3) / 6.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! - `rayon`: pairs are examined on the threads of the current pool; results are the same to the
//!   bit.
//! - `serde`: results implement `Serialize` and `Deserialize`.

mod body;
mod body_place;
mod broad_phase;
mod check;
mod closest_pairs;
mod coincidence;
mod depth_bracket;
mod edge_overlap;
mod error;
mod field_contacts;
mod geometry;
mod ids;
mod joint_contact;
mod joint_turn_paths;
mod kept_contacts;
mod kept_vertex;
mod medial_contacts;
mod outward;
mod pair_contacts;
mod pair_frame;
mod pair_overlap;
mod params;
mod pass_through;
mod path_steps;
mod report;
mod rigid_paths;
mod scene;
mod step;
mod step_detectors;
mod step_sides;
mod step_sweep;
mod sweep;
mod sweep_paths;

pub use distance_field::{FieldContact, FieldDetector, FieldFeature};
pub use glam;
pub use medial::{MedialContact, MedialDetector, MedialFeature, PrimitiveBall};
pub use overlap::{AreaBracket, CurveChain, Depth, Overlap, OverlapMeasures};
pub use response;

pub use proximity::{ContactKind, NearVertex, NoInside, Region, Side, SweptContact};

pub use surface::progress::{Interrupted, Progress};

pub use crate::body::{Body, BodyKind, Revision};
pub use crate::body_place::{BodyMove, BodyPlace};
pub use crate::coincidence::Coincidence;
pub use crate::depth_bracket::DepthBracket;
pub use crate::edge_overlap::{EdgeOverlap, FacePoint};
pub use crate::error::SceneError;
pub use crate::geometry::{OverlapGeometry, PatchFace};
pub use crate::ids::{BodyId, PairId};
pub use crate::joint_turn_paths::{JointScene, JointTurns, TurnContact, TurnEnd};
pub use crate::kept_contacts::{KeptPair, PermanentParams, Renewal};
pub use crate::pair_contacts::PairContacts;
pub use crate::pair_overlap::PairOverlap;
pub use crate::params::CheckParams;
pub use crate::pass_through::PassThrough;
pub use crate::path_steps::PathMove;
pub use crate::report::{PairReport, VertexReport};
pub use crate::scene::Scene;
pub use crate::step::{SceneStates, SceneStep, StepError};
pub use crate::step_detectors::{
    DetectorParams, Fallback, FallbackReason, StepDetectors, StepMethod,
};
pub use crate::sweep::{PairSweep, SweepReport};

/// Compiles and runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
