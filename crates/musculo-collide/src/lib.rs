//! Collision handling between bones and soft tissue: detection and response for musculoskeletal
//! models.
//!
//! Anatomical surfaces overlap at rest, slide on each other and move by centimeters between frames.
//! This crate answers where they touch, how deep, since when, and what to do about it, with an error
//! that it states. It has no functions of its own: it puts the crates below it under one name, and
//! this page is a tour through them.
//!
//! Source of the method: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal
//! system using MRI*, PhD thesis, 2007, section 4.7.2.
//!
//! | to | take | crate |
//! |---|---|---|
//! | find overlaps and near contacts | [`Scene::check`] | [`scene`] |
//! | measure an overlap: volume, areas, curve, depth | [`PairReport::overlap`] | [`overlap`] |
//! | measure a joint: contact area, gaps, pressure | [`Scene::joint_contacts`] | [`overlap`] |
//! | find first contacts of a motion | [`Scene::sweep`], [`Scene::sweep_paths`] | [`ccd`], [`proximity`] |
//! | detect and respond at rate, within a tolerance | [`Plan`] | [`plan`] |
//! | remove overlaps | [`resolve()`] | [`resolve`](mod@resolve) |
//! | ask for signed distances from a bone | [`distance_field::DistanceField`] | [`distance_field`] |
//! | approximate a muscle by balls | [`medial::generate`] | [`medial`] |
//! | approximate a surface by fewer faces | [`decimate::Decimation`] | [`decimate`] |
//! | let the interior of a volume mesh follow | [`volume_mesh::VolumeMesh::follow`] | [`volume_mesh`] |
//! | answer contacts inside a simulator's step | [`SceneStep`], [`StepDetectors`] | [`scene`], [`response`] |
//! | compute forces and corrections of contacts | [`response::ContactSystem`] | [`response`] |
//!
//! # A scene
//!
//! A [`Scene`] holds bodies with names. A surface is a list of triangles over numbered vertices;
//! positions are an argument of their own, since they change and the triangles do not. Lengths are in
//! whatever unit the caller takes, the same for all bodies: nothing is tuned to millimeters.
//!
//! ```
//! use musculo_collide::surface::TriangleSurface;
//! use musculo_collide::{BodyKind, Scene, glam::DVec3};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
//!
//! let mut scene = Scene::new();
//! let surface = TriangleSurface::new(corners.len(), faces)?;
//! let bone = scene.add("bone", BodyKind::Rigid, surface, corners.to_vec())?;
//! assert_eq!(scene.find("bone"), Some(bone));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Real meshes have holes, flipped faces and faces without area. They are accepted: what needs a
//! property that a surface lacks fails by name, and the rest is answered. [`BodyKind::Open`] declares
//! a sheet, of which nothing is inside.
//!
//! # Where, and how deep?
//!
//! [`Scene::check`] reports each pair of bodies within a margin of each other. Whether surfaces cross
//! is decided exactly, and which vertices are inside by counting crossings, never by a nearby normal.
//!
//! ```
//! # use musculo_collide::{BodyKind, Scene, glam::DVec3};
//! use musculo_collide::{CheckParams, PairId, Progress};
//!
//! # let ball = fixtures::shapes::icosphere(10.0, 3);
//! # let muscle_mesh = ball.clone().translated(DVec3::X * 19.0);
//! # let mut scene = Scene::new();
//! # let bone = scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions)?;
//! # let muscle = scene.add("muscle", BodyKind::Deformable, muscle_mesh.surface(), muscle_mesh.positions)?;
//! // Two balls of radius 10, 19 apart.
//! for report in scene.check(&CheckParams::new(1.0), Progress::none())? {
//!     assert_eq!(report.pair, PairId::new(bone, muscle));
//!     assert!(report.overlaps && report.a_against_b.inside_count? > 0);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How much do they share?
//!
//! The report of a pair that overlaps measures what both share: volume, centroid, areas, the curve in
//! which they cross, for each separate region of contact, and how deep each surface reaches into the
//! other body, between its vertices, too. Bodies that coincide have their volume in common.
//!
//! ```
//! # use musculo_collide::{BodyKind, CheckParams, Progress, Scene, glam::DVec3};
//! # let cube = fixtures::shapes::cube(10.0);
//! # let half = cube.clone().translated(DVec3::X * 5.0);
//! # let mut scene = Scene::new();
//! # scene.add("cube", BodyKind::Rigid, cube.surface(), cube.positions)?;
//! # scene.add("moved", BodyKind::Rigid, half.surface(), half.positions)?;
//! // A cube of edge 10, and the same moved by half of it: four of their sides coincide.
//! let reports = scene.check(&CheckParams::new(0.0), Progress::none())?;
//! let overlap = reports[0].overlap.as_ref().ok_or("they overlap")?;
//! let total = &overlap.measures.total;
//! assert!((total.volume.ok_or("both are closed")? - 500.0).abs() < 1e-9);
//! assert!((total.flush_area - 4.0 * 50.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Joints are measured as the tools of joint mechanics do, by area, gaps and the pressure of a layer
//! of cartilage: [`Scene::joint_contacts`].
//!
//! # When do they meet?
//!
//! Between two frames a thin body can pass through another. [`Scene::sweep`] finds the first contact
//! of every vertex, edge and face while bodies move; none is missed, and no time is late.
//!
//! ```
//! # use musculo_collide::{BodyKind, Progress, Scene, glam::DVec3};
//! use musculo_collide::{BodyMove, ccd::CcdParams};
//!
//! # let ball = fixtures::shapes::icosphere(10.0, 3);
//! # let moving = ball.clone().translated(DVec3::X * 30.0);
//! # let mut scene = Scene::new();
//! # scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions)?;
//! # let muscle = scene.add("muscle", BodyKind::Deformable, moving.surface(), moving.positions)?;
//! // The muscle goes from one side of the bone to the other; it meets the bone after 10 of 60.
//! let start = scene.body(muscle).positions();
//! let positions: Vec<DVec3> = start.iter().map(|p| *p - 60.0 * DVec3::X).collect();
//! let moves = [BodyMove { body: muscle, positions: &positions }];
//! let sweep = scene.sweep(&moves, &CcdParams::EXACT, Progress::none())?;
//! assert!((sweep.largest_free_step - 10.0 / 60.0).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # At rate, within a tolerance
//!
//! A [`Plan`] chooses a method for each pair whose error is proved to be within a tolerance, by cost
//! over a number of frames, and builds only what that needs: coarser surfaces, or fields for bones.
//! [`Plan::detect`] then runs every frame, and [`Plan::respond`] pushes bodies apart.
//!
//! ```
//! # use musculo_collide::{BodyKind, Progress, Scene, glam::DVec3};
//! use musculo_collide::{Detection, Plan, PlanParams, RespondParams};
//!
//! # let ball = fixtures::shapes::icosphere(10.0, 3);
//! # let moving = ball.clone().translated(DVec3::X * 22.0);
//! # let mut scene = Scene::new();
//! # scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions)?;
//! # let muscle = scene.add("muscle", BodyKind::Deformable, moving.surface(), moving.positions)?;
//! let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.2), Progress::none())?;
//! let mut detection = Detection::default();
//! for _ in 0..3 {
//!     let now = scene.body(muscle).positions();
//!     let next: Vec<DVec3> = now.iter().map(|p| *p - DVec3::X).collect();
//!     scene.move_body(muscle, &next)?;
//!     plan.detect(&mut scene, &mut detection)?;
//!     plan.respond(&mut scene, &detection, &RespondParams::default())?;
//! }
//! assert!(!detection.contacts().is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A state without overlap
//!
//! [`resolve()`] pushes apart what overlaps: bones stay, soft tissue yields, keeps its volume, and is
//! smooth afterwards. A [`Resolver`] does so frame after frame, each from the last.
//!
//! ```
//! # use musculo_collide::{BodyKind, Progress, Scene, glam::DVec3};
//! use musculo_collide::{ResolveParams, resolve};
//!
//! # let ball = fixtures::shapes::icosphere(10.0, 3);
//! # let moved = ball.clone().translated(DVec3::X * 19.0);
//! # let mut scene = Scene::new();
//! # scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions)?;
//! # scene.add("muscle", BodyKind::Deformable, moved.surface(), moved.positions)?;
//! let resolution = resolve(&mut scene, &ResolveParams::with_smoothing(6.0), Progress::none())?;
//! assert!(resolution.remaining.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # One crate alone
//!
//! Each crate below stands by itself: its detectors take surfaces with trees and write
//! [`surface::Contact`] records, its solvers take those records. A certified query of one vertex and
//! one face:
//!
//! ```
//! use musculo_collide::ccd::{CcdParams, vertex_face};
//! use musculo_collide::glam::DVec3;
//!
//! let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
//! let at = |height: f64| [DVec3::new(0.2, 0.3, height), face[0], face[1], face[2]];
//! let contact = vertex_face(at(1.0), at(-1.0), &CcdParams::DEFAULT)?.ok_or("it falls through")?;
//! assert!(contact.lo <= 0.5 && 0.5 <= contact.hi);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The distance field of a bone:
//!
//! ```
//! use musculo_collide::distance_field::{DistanceField, FieldParams, Interpolation};
//! use musculo_collide::{Progress, glam::DVec3};
//!
//! let bone = fixtures::shapes::icosphere(10.0, 4);
//! let surface = bone.surface();
//! let x = surface.positions(&bone.positions)?;
//! let field = DistanceField::build(&surface, x, &FieldParams::new(1.0), Progress::none())?;
//! let sample = field.evaluate(DVec3::X * 9.0, Interpolation::Trilinear).ok_or("in the grid")?;
//! assert!((sample.distance + 1.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A coarser surface on a muscle's own vertices, proved to be within a distance of the full one:
//!
//! ```
//! use musculo_collide::Progress;
//! use musculo_collide::decimate::Decimation;
//! use musculo_collide::proximity::SurfaceTree;
//!
//! let muscle = fixtures::shapes::icosphere(30.0, 4);
//! let full = SurfaceTree::new(muscle.surface(), muscle.positions)?;
//! let coarse = Decimation::new(full, Progress::none())?.within(0.5, Progress::none())?;
//! assert!(coarse.deviation <= 0.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The response to one contact: a particle that falls on a floor at rest.
//!
//! ```
//! use musculo_collide::glam::DVec3;
//! use musculo_collide::response::{
//!     ContactLaw, ContactRows, ContactSystem, Margins, SolveLevel, SolverParams, SweepOrder,
//! };
//! use musculo_collide::surface::{Contact, ContactSide, Term};
//!
//! let particle = [Term { particle: 0, weight: 1.0 }];
//! let floor = ContactSide::at_rest(DVec3::ZERO);
//! let contact = Contact::between(ContactSide::Particles(&particle), floor, DVec3::Z, 0.0);
//!
//! let mut rows = ContactRows::new(1);
//! rows.push(&contact, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.3)?)?;
//! let system = ContactSystem::new(&rows, &[1.0], SweepOrder::Colored)?;
//! let mut velocities = [DVec3::Z * -2.0];
//! let (level, params) = (SolveLevel::Velocity, SolverParams::default());
//! system.solve(level, &mut velocities, &mut system.no_impulses(), &params)?;
//! assert_eq!(velocities[0], DVec3::ZERO);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Long calls
//!
//! Calls that may take long have a [`Progress`] as their last argument: a function that is given the
//! finished share, and interrupts the call by returning an error. [`Progress::none`] is neither.
//!
//! # Promises
//!
//! - No contact is lost by rounding, by a tolerance or by a tree.
//! - A *bound* is proved, an *error* is measured; their names say which.
//! - Same input, same bits, for any number of threads and from run to run.
//! - No panic on data, no `unsafe`, no I/O, no clock.
//!
//! # Features
//!
//! - `rayon` (default): pairs, bodies and batches are spread over the threads of the current pool.
//! - `serde`: most parameters and results implement `Serialize`, and `Deserialize` where they can be read.

pub use ::{
    ccd, decimate, distance_field, glam, kdop, medial, overlap, plan, proximity, resolve, response,
    scene, surface, volume_mesh,
};

pub use ::resolve::{
    BodyChange, BodyStiffness, BrokenLimit, CellCorners, Conditions, DistanceBracket,
    FixedVertices, GapObstacle, GapProof, GapRound, Obstacle, Remaining, Resolution, ResolveError,
    ResolveParams, ResolveTuning, Resolver, Round, ShortGap, Tie, TiedVertices, WrittenPrecision,
    resolve,
};
pub use overlap::{
    ContactMeasures, ElasticFoundation, FoundationLaw, JointContact, JointContactError,
    JointContactParams,
};
pub use plan::{
    Accuracy, Detection, DetectionMethod, ExcludedPair, ExclusionReason, ForcedMethod, FrameBudget,
    LeftOutPair, MissingStructure, OperationCounts, PairDetection, PairPlan, PairState, Plan,
    PlanError, PlanParams, RespondParams, Structure, StructureKind, machine_factor,
};
pub use response::{
    Friction, Margins, Material, ParticleLoads, Restraint, RigidMotion, SpringDamper, StepLength,
    StepParams, StepReport, SweptReport,
};
pub use surface::{
    NearRigidPath, Path, RelativePath, RigidBodyPath, RigidPath, RigidState, StraightPath,
};

pub use scene::{
    AreaBracket, Body, BodyId, BodyKind, BodyMove, BodyPlace, CheckParams, Coincidence,
    ContactKind, CurveChain, Depth, DepthBracket, DetectorParams, EdgeOverlap, FacePoint, Fallback,
    FallbackReason, FieldContact, FieldDetector, FieldFeature, JointScene, JointTurns, KeptPair,
    MedialContact, MedialDetector, MedialFeature, NearVertex, NoInside, Overlap, OverlapGeometry,
    OverlapMeasures, PairContacts, PairId, PairOverlap, PairReport, PairSweep, PassThrough,
    PatchFace, PathMove, PermanentParams, PrimitiveBall, Region, Renewal, Scene, SceneError,
    SceneStates, SceneStep, Side, StepDetectors, StepError, StepMethod, SweepReport, SweptContact,
    TurnContact, TurnEnd, VertexReport,
};
pub use surface::progress::{Interrupted, Progress};

/// Holds the README's example to what the library does.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
