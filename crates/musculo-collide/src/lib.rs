//! Collision detection and response between bones and soft tissue.
//!
//! A [`Scene`] holds bodies: rigid, deformable or open surfaces, each with a
//! name. [`Scene::check`] answers, for every pair of bodies that come within
//! the margin of each other, whether they overlap, how deep, where, and how far
//! apart they are elsewhere.
//!
//! Bodies may overlap at rest, deeply or only by their edges; both are found:
//! whether two surfaces cross is decided exactly, and which side a vertex is on
//! by counting crossings, never by a nearby normal.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2.
//!
//! # Example
//!
//! Two tetrahedra, one poked a tenth of a millimetre into the other.
//!
//! ```
//! use musculo_collide::glam::DVec3;
//! use musculo_collide::surface::TriangleSurface;
//! use musculo_collide::{BodyKind, CheckParams, PairId, Progress, Scene};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
//! let shifted = corners.map(|corner| corner + DVec3::new(1.0, 1.0, 9.9 - 2.0));
//!
//! let mut scene = Scene::new();
//! let bone = scene.add("bone", BodyKind::Rigid, TriangleSurface::new(4, faces.clone())?, corners.to_vec())?;
//! let muscle = scene.add("muscle", BodyKind::Deformable, TriangleSurface::new(4, faces)?, shifted.to_vec())?;
//!
//! let reports = scene.check(&CheckParams::new(1.0), Progress::none())?;
//! let [pair] = &reports[..] else { panic!("one pair") };
//! assert_eq!(pair.pair, PairId::new(bone, muscle));
//! assert!(pair.overlaps);
//! assert_eq!(pair.b_against_a.inside_count, Ok(1));
//! let depth = pair.max_depth().ok_or("they overlap")?;
//! assert!((depth.lower - 0.1 / 3.0_f64.sqrt()).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use ::{
    ccd, decimate, distance_field, glam, kdop, medial, overlap, plan, proximity, resolve, response,
    scene, surface,
};

pub use ::resolve::{
    BodyChange, Obstacle, Remaining, Resolution, ResolveError, ResolveParams, Resolver, Round,
    resolve,
};
pub use overlap::{
    ContactMeasures, ElasticFoundation, FoundationLaw, JointContact, JointContactError,
    JointContactParams,
};
pub use plan::{
    Detection, DetectionMethod, ErrorEstimate, ExcludedPair, ExclusionReason, ForcedMethod,
    MissingStructure, OperationCounts, PairDetection, PairPlan, Plan, PlanError, PlanParams,
    RespondParams, Structure, StructureKind, machine_factor,
};
pub use surface::RigidState;

pub use scene::{
    AreaBracket, Body, BodyId, BodyKind, BodyMove, CheckParams, Coincidence, ContactKind,
    CurveChain, Depth, DepthBracket, EdgeOverlap, FacePoint, FieldContact, FieldDetector,
    FieldFeature, MedialContact, MedialDetector, MedialFeature, NearVertex, NoInside, Overlap,
    OverlapGeometry, OverlapMeasures, PairId, PairOverlap, PairReport, PairSweep, PassThrough,
    PatchFace, PrimitiveBall, Region, Scene, SceneError, Side, SweepReport, SweptContact,
    VertexReport,
};
pub use surface::progress::{Interrupted, Progress};

/// Holds the README's example to what the library does.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
