//! Plans: a method per pair of bodies, with the structures that it needs.

use std::time::Duration;

use ccd::CcdParams;
use glam::DVec3;
use scene::{Body, BodyId, PairId, Progress, Scene, SweepReport};
use surface::Aabb;

use crate::cost::count;
use crate::detection::PairScratch;
use crate::structures::Structures;
use crate::{
    DetectionMethod, ExclusionReason, MissingStructure, OperationCounts, PlanError, PlanParams,
    Structure,
};

/// Method for each pair of a scene, with the structures that were built for it.
#[derive(Debug)]
pub struct Plan {
    pub(crate) params: PlanParams,
    pub(crate) tolerance: f64,
    pub(crate) pairs: Vec<PairPlan>,
    pub(crate) excluded_pairs: Vec<ExcludedPair>,
    pub(crate) structures: Structures,
    pub(crate) built: Vec<Structure>,
    pub(crate) missing: Vec<MissingStructure>,
    /// Operations that refit the structures of all bodies.
    pub(crate) follow: OperationCounts,
    pub(crate) bodies: Vec<PlannedBody>,
    /// Reused memory of detection, one per pair.
    pub(crate) scratch: Vec<PairScratch>,
}

/// Method for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairPlan {
    /// The two bodies.
    pub pair: PairId,
    /// The method.
    pub method: DetectionMethod,
    /// The rigid body whose field the pair may use.
    pub(crate) bone: Option<BodyId>,
    /// Reason why the pair does not use a field, where it does not.
    pub fallback_reason: Option<ExclusionReason>,
    /// Measured error of a contact's gap, in the length unit: of the structures as they were
    /// built, at the positions they were built at.
    pub measured_error: f64,
    /// Operations per frame.
    pub operations: OperationCounts,
    /// Predicted time per frame, of one thread \[s\].
    pub cost: f64,
}

/// Pair that is not detected.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcludedPair {
    /// The two bodies.
    pub pair: PairId,
    /// Reason why it is not detected.
    pub reason: ExclusionReason,
}

/// Body of the scene that a plan was made for.
#[derive(Debug)]
pub(crate) struct PlannedBody {
    pub(crate) name: String,
    vertex_count: usize,
    /// Box around the body's vertices when the plan was made.
    pub(crate) bounds: Aabb,
}

impl PairPlan {
    /// Returns the rigid body whose field is queried, where that is the method: only vertices and
    /// edges of the other body are then compared.
    #[must_use]
    pub fn bone(&self) -> Option<BodyId> {
        self.bone.filter(|_| self.method == DetectionMethod::Field)
    }

    /// Returns the body that is compared with the field of `bone`.
    pub(crate) fn other(&self, bone: BodyId) -> BodyId {
        if bone == self.pair.a { self.pair.b } else { self.pair.a }
    }
}

impl PlannedBody {
    pub(crate) fn new(body: &Body) -> Self {
        let positions = body.positions();
        let bounds = Aabb::of_points(positions.iter().copied());
        Self { name: body.name().to_owned(), vertex_count: positions.len(), bounds }
    }

    fn is_like(&self, body: &Body) -> bool {
        self.vertex_count == body.positions().len() && self.name == body.name()
    }
}

impl Plan {
    /// Returns the pairs that are detected, in the order of the bodies.
    #[must_use]
    pub fn pairs(&self) -> &[PairPlan] {
        &self.pairs
    }

    /// Returns the pairs that are not detected, with the reasons.
    #[must_use]
    pub fn excluded_pairs(&self) -> &[ExcludedPair] {
        &self.excluded_pairs
    }

    /// Returns the structures that were built, in the order of the bodies.
    #[must_use]
    pub fn structures(&self) -> &[Structure] {
        &self.built
    }

    /// Returns the structures that might have been built and were not, with the reasons, in the
    /// order of the bodies.
    #[must_use]
    pub fn missing_structures(&self) -> &[MissingStructure] {
        &self.missing
    }

    /// Returns the tolerance that is served: that of the parameters, or a larger one under a
    /// budget.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns the predicted time of a frame, on the machine and the threads of the parameters.
    #[must_use]
    pub fn predicted_time(&self) -> Duration {
        let PlanParams { machine_factor, threads, .. } = self.params;
        Duration::from_secs_f64(machine_factor * self.operations().seconds() / count(threads))
    }

    /// Returns the operations of a frame, counted where the bodies were when the plan was made.
    #[must_use]
    pub fn operations(&self) -> OperationCounts {
        self.pairs.iter().fold(self.follow, |sum, pair| sum + pair.operations)
    }

    /// Returns true if the predicted time is within the budget, or there is none.
    #[must_use]
    pub fn is_within_budget(&self) -> bool {
        self.params.budget.is_none_or(|budget| self.predicted_time() <= budget)
    }

    /// Finds the first contacts of planned pairs while bodies move to new positions; see
    /// [`Scene::sweep`]. All vertices take part, and no contact is missed, whatever the
    /// tolerance.
    ///
    /// # Errors
    ///
    /// As [`Scene::sweep`], and [`PlanError::OtherScene`].
    pub fn sweep(
        &self,
        scene: &mut Scene,
        moves: &[(BodyId, &[DVec3])],
        params: &CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, PlanError> {
        self.check_scene(scene)?;
        let is_planned = |id| self.pairs.iter().any(|planned| planned.pair == id);
        Ok(scene.sweep_among(moves, params, is_planned, progress)?)
    }

    /// Checks that the plan was made for a scene of these bodies.
    pub(crate) fn check_scene(&self, scene: &Scene) -> Result<(), PlanError> {
        let mut pairs = self.bodies.iter().zip(scene.bodies());
        let as_many = self.bodies.len() == scene.bodies().len();
        let is_same = as_many && pairs.all(|(planned, body)| planned.is_like(body));
        if is_same { Ok(()) } else { Err(PlanError::OtherScene) }
    }
}
