//! The cheapest way to look at each pair of bodies that is accurate enough.
//!
//! The caller says how wrong the gap of a contact may be. Each pair then gets
//! the cheapest method whose error is bounded by that, and only what some pair
//! needs is built: distance fields as coarse as the tolerance allows for bones,
//! surfaces of as few vertices as it allows for what yields, nothing for what
//! touches nothing that moves.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2, which
//! chooses distance maps for rigid bodies and surfaces or medial axes for
//! others by their kind. Here, the error that is measured on what was built
//! decides, and what it costs.

mod bone;
mod cost;
mod detect;
mod error;
mod make;
mod method;
mod params;
mod respond;
mod structures;
mod table;

pub use self::cost::{OperationCounts, machine_factor};
pub use self::detect::{Detection, PairDetection};
pub use self::error::PlanError;
pub use self::method::{DetectionMethod, ExclusionReason, Structure, StructureKind};
pub use self::params::PlanParams;
pub use self::respond::RespondParams;

use std::time::Duration;

use self::detect::PairWork;
use self::make::{Made, Maker};
use self::structures::Structures;
use glam::DVec3;

use scene::{Body, BodyId, PairId, Progress, Scene, SweepReport};

/// How each pair of a scene is looked at, with what was built for that.
///
/// ```
/// use distance_field::Pose;
/// use scene::glam::{DQuat, DVec3};
/// use surface::TriangleSurface;
/// use plan::{Detection, DetectionMethod, Plan, PlanParams, RespondParams};
/// use scene::{BodyKind, Scene};
///
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 30.0 * corner);
/// let mut scene = Scene::new();
/// let bone = TriangleSurface::new(4, faces.clone())?;
/// let bone = scene.add("bone", BodyKind::Rigid, bone, corners.to_vec())?;
/// let muscle = TriangleSurface::new(4, faces)?;
/// let muscle = scene.add("muscle", BodyKind::Deformable, muscle, corners.to_vec())?;
///
/// let mut plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.5))?;
/// assert_eq!(plan.pairs()[0].method, DetectionMethod::Field);
/// println!("{plan}");
///
/// // The bone has moved, so that one corner of the muscle is 3 over its base.
/// scene.pose_body(bone, &Pose::new(DQuat::IDENTITY, DVec3::new(-5.0, -8.0, -3.0)))?;
/// let mut detection = Detection::default();
/// plan.detect(&mut scene, &mut detection)?;
/// assert!((detection.pairs()[0].max_depth - 3.0).abs() < 0.5);
///
/// plan.respond(&mut scene, &detection, &RespondParams::default())?;
/// assert!(scene.body(muscle).positions()[0].length() > 2.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Plan {
    params: PlanParams,
    tolerance: f64,
    pairs: Vec<PairPlan>,
    work: Vec<PairWork>,
    structures: Structures,
    listed: Vec<Structure>,
    excluded_pairs: Vec<ExcludedPair>,
    not_built: Vec<(BodyId, StructureKind, ExclusionReason)>,
    follow: OperationCounts,
    bodies: Vec<Planned>,
}

/// How one pair is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct PairPlan {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// The method.
    pub method: DetectionMethod,
    /// The rigid body whose field is asked, where the method is that.
    bone: BodyId,
    /// Why not by a field, where the method is another.
    pub fallback_reason: Option<ExclusionReason>,
    /// The gap of a contact is wrong by this at most, in the length unit, as
    /// measured on what was built for the positions it was built at.
    pub error_bound: f64,
    /// What a frame has to do for it.
    pub work: OperationCounts,
    /// Predicted seconds a frame, of one thread.
    pub cost: f64,
}

impl PairPlan {
    /// The rigid body whose field is asked, where that is the method: then only
    /// the other body's vertices and edges are looked at.
    #[must_use]
    pub fn bone(&self) -> Option<BodyId> {
        (self.method == DetectionMethod::Field).then_some(self.bone)
    }

    /// The body that the field of the rigid one is asked about.
    fn other(&self) -> BodyId {
        if self.bone == self.a { self.b } else { self.a }
    }
}

/// A pair that is not looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcludedPair {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// Why not.
    pub reason: ExclusionReason,
}

/// What a plan remembers of a body.
#[derive(Debug)]
struct Planned {
    name: String,
    vertices: usize,
    /// What it may not leave while pairs that are left out stay apart.
    start: [DVec3; 2],
}

/// How much coarser the next plan is that is tried for a budget.
const COARSER: f64 = 1.5;

/// Plans that are tried for a budget.
const TRIES: u32 = 10;

impl Plan {
    /// Chooses and builds for the bodies where they are.
    ///
    /// Fields are built at the positions that rigid bodies were added with, and
    /// follow their poses. Reduced surfaces are built at the present positions
    /// and follow the vertices that they have; where a body is stretched, so is
    /// their deviation.
    ///
    /// # Errors
    ///
    /// [`PlanError::Parameter`], and [`PlanError::Scene`] when a body is too large to
    /// build bounds for.
    pub fn new(scene: &mut Scene, params: &PlanParams) -> Result<Self, PlanError> {
        Self::with_forced(scene, params, &[])
    }

    /// As [`Self::new`], with methods that the caller has chosen for some pairs.
    /// Their error is then what it is.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], and [`PlanError::Forced`] for a method that cannot
    /// serve its pair.
    pub fn with_forced(
        scene: &mut Scene,
        params: &PlanParams,
        forced: &[(BodyId, BodyId, DetectionMethod)],
    ) -> Result<Self, PlanError> {
        params.validate()?;
        let mut maker = Maker::new(scene, params, forced);
        let mut tolerance = params.tolerance;
        let mut plan = Self::from(scene, params, tolerance, maker.make(tolerance)?);
        for _ in 0..TRIES {
            if plan.keeps_budget() {
                break;
            }
            tolerance *= COARSER;
            plan = Self::from(scene, params, tolerance, maker.make(tolerance)?);
        }
        scene.fit(&plan.structures.trees)?;
        plan.listed = plan.structures.list(scene);
        Ok(plan)
    }

    fn from(scene: &Scene, params: &PlanParams, tolerance: f64, made: Made) -> Self {
        let Made { pairs, structures, far, not_built, follow } = made;
        let planned = |body: &Body| {
            let positions = body.positions();
            let start = [
                positions.iter().copied().fold(DVec3::INFINITY, DVec3::min),
                positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
            ];
            Planned { name: body.name().to_owned(), vertices: positions.len(), start }
        };
        Self {
            params: *params,
            tolerance,
            work: pairs.iter().map(|_| PairWork::default()).collect(),
            listed: Vec::new(),
            pairs,
            structures,
            excluded_pairs: far,
            not_built,
            follow,
            bodies: scene.bodies().iter().map(planned).collect(),
        }
    }

    /// The pairs that are looked at, in the order of the bodies.
    #[must_use]
    pub fn pairs(&self) -> &[PairPlan] {
        &self.pairs
    }

    /// The pairs that are not, with the reasons.
    #[must_use]
    pub fn excluded_pairs(&self) -> &[ExcludedPair] {
        &self.excluded_pairs
    }

    /// What was built, in the order of the bodies.
    #[must_use]
    pub fn structures(&self) -> &[Structure] {
        &self.listed
    }

    /// What was not built though it might have been, with the reasons.
    #[must_use]
    pub fn not_built(&self) -> &[(BodyId, StructureKind, ExclusionReason)] {
        &self.not_built
    }

    /// The tolerance that is served: the one asked for, or a larger one where
    /// that takes longer than the budget.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns the predicted time of a frame, on the threads and the machine of the
    /// parameters.
    #[must_use]
    pub fn predicted(&self) -> Duration {
        let PlanParams { machine_factor, threads, .. } = self.params;
        Duration::from_secs_f64(machine_factor * self.work().seconds() / count(threads))
    }

    /// What a frame has to do, counted where the bodies were when it was planned.
    #[must_use]
    pub fn work(&self) -> OperationCounts {
        self.pairs.iter().fold(self.follow, |sum, pair| sum + pair.work)
    }

    /// Whether the plan is predicted to keep to the budget, if there is one.
    #[must_use]
    pub fn keeps_budget(&self) -> bool {
        self.params.budget.is_none_or(|budget| self.predicted() <= budget)
    }

    /// Finds who of the pairs that are looked at meets while bodies go to new
    /// positions; see [`Scene::sweep`]. Every vertex counts, and no contact is
    /// missed, whatever the tolerance.
    ///
    /// # Errors
    ///
    /// As [`Scene::sweep`], and [`PlanError::OtherScene`].
    pub fn sweep(
        &self,
        scene: &mut Scene,
        moves: &[(BodyId, &[DVec3])],
        params: &ccd::CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, PlanError> {
        self.check_scene(scene)?;
        let is_planned = |id| self.pairs.iter().any(|pair| PairId::new(pair.a, pair.b) == id);
        Ok(scene.sweep_among(moves, params, is_planned, progress)?)
    }

    fn check_scene(&self, scene: &Scene) -> Result<(), PlanError> {
        let same = |(planned, body): (&Planned, &Body)| {
            planned.vertices == body.positions().len() && planned.name == body.name()
        };
        let as_many = self.bodies.len() == scene.bodies().len();
        let all = as_many && self.bodies.iter().zip(scene.bodies()).all(same);
        if all { Ok(()) } else { Err(PlanError::OtherScene) }
    }
}

/// A count, for sums of costs.
#[expect(clippy::cast_precision_loss, reason = "no count here comes near 2^53")]
pub(crate) fn count(n: usize) -> f64 {
    n as f64
}
