//! Plans: a method per pair of bodies, with the structures that it needs.

use std::sync::Arc;
use std::time::Duration;

use ccd::CcdParams;
use glam::DVec3;
use scene::{Body, BodyKind, BodyMove, PairId, Progress, Revision, Scene, SweepReport};
use surface::{Aabb, TriangleSurface};

use crate::cost::count;
use crate::motion::BodyMotion;
use crate::pair_detector::PairDetector;
use crate::structures::Structures;
use crate::{
    ExcludedPair, ForcedMethod, MissingStructure, OperationCounts, PairPlan, PlanError, PlanParams,
    Structure,
};

/// Method for each pair of a scene that may meet, with the structures that were built for it.
///
/// Its size grows with the number of bodies and of pairs near each other, and the vertices of rigid bodies.
#[derive(Debug)]
pub struct Plan {
    pub(crate) params: PlanParams,
    pub(crate) pairs: Vec<PairPlan>,
    pub(crate) excluded_pairs: Vec<ExcludedPair>,
    pub(crate) far_pair_count: usize,
    pub(crate) structures: Structures,
    pub(crate) built: Vec<Structure>,
    pub(crate) missing: Vec<MissingStructure>,
    /// Methods that the caller has chosen.
    pub(crate) forced: Vec<ForcedMethod>,
    /// Operations that refit the structures of all bodies.
    pub(crate) follow: OperationCounts,
    pub(crate) bodies: Vec<PlannedBody>,
    /// Detectors of the planned pairs, in their order.
    pub(crate) detectors: Vec<PairDetector>,
    /// Motion of each body, where frames are detected under a budget.
    pub(crate) motion: Option<Vec<BodyMotion>>,
    /// Number of frames that were detected.
    pub(crate) frame_count: u64,
}

/// Body of the scene that a plan was made for.
#[derive(Debug)]
pub(crate) struct PlannedBody {
    pub(crate) name: String,
    origin: Revision,
    kind: BodyKind,
    surface: Arc<TriangleSurface>,
    /// Positions from which a rigid body is posed.
    reference: Option<Vec<DVec3>>,
    /// Box around the body's vertices when the plan was made.
    pub(crate) bounds: Aabb,
    /// Revision of the positions that were found in range last.
    in_range: Option<Revision>,
}

impl PlannedBody {
    pub(crate) fn new(body: &Body) -> Self {
        Self {
            name: body.name().to_owned(),
            origin: body.origin(),
            kind: body.kind(),
            surface: body.shared_surface(),
            reference: body.reference().map(<[DVec3]>::to_vec),
            bounds: Aabb::of_points(body.positions().iter().copied()),
            in_range: None,
        }
    }

    /// Returns true if the body is within a distance of its box when the plan was made.
    pub(crate) fn is_in_range(&mut self, body: &Body, max_displacement: f64) -> bool {
        if self.in_range == Some(body.revision()) {
            return true;
        }
        let bounds = self.bounds.inflate(max_displacement);
        let is_in_range = body.positions().iter().all(|&p| bounds.contains(p));
        if is_in_range {
            self.in_range = Some(body.revision());
        }
        is_in_range
    }

    /// Returns true if what was built for the body holds for another: that of a clone, or of the same file.
    fn is_like(&self, body: &Body) -> bool {
        let is_same = self.origin == body.origin();
        is_same
            || (self.name == body.name()
                && self.kind == body.kind()
                && self.surface.faces() == body.surface().faces()
                && self.reference.as_deref() == body.reference())
    }
}

impl Plan {
    /// Returns the planned pairs, in the order of the bodies.
    #[must_use]
    pub fn pairs(&self) -> &[PairPlan] {
        &self.pairs
    }

    /// Returns the pairs near enough to be planned that are not detected, with the reasons.
    #[must_use]
    pub fn excluded_pairs(&self) -> &[ExcludedPair] {
        &self.excluded_pairs
    }

    /// Returns the number of pairs that are too far apart to be planned. They are detected by the
    /// surfaces of both bodies once they come near.
    #[must_use]
    pub fn far_pair_count(&self) -> usize {
        self.far_pair_count
    }

    /// Returns the structures that were built, in the order of the bodies.
    #[must_use]
    pub fn structures(&self) -> &[Structure] {
        &self.built
    }

    /// Returns the structures that planned pairs might use and that were not built, with the
    /// reasons, in the order of the bodies.
    #[must_use]
    pub fn missing_structures(&self) -> &[MissingStructure] {
        &self.missing
    }

    /// Returns the parameters.
    #[must_use]
    pub fn params(&self) -> &PlanParams {
        &self.params
    }

    /// Returns the predicted time of a frame, on the machine and the threads of the parameters.
    #[must_use]
    pub fn predicted_time(&self) -> Duration {
        let PlanParams { machine_factor, threads, .. } = self.params;
        let seconds = machine_factor * self.operations().seconds() / count(threads);
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
    }

    /// Returns the operations of a frame: predicted from the state in which the plan was made, and
    /// the exponential mean of the counts since frames were detected. Where no structure could have
    /// paid, nothing is counted before the first frame.
    #[must_use]
    pub fn operations(&self) -> OperationCounts {
        self.pairs.iter().fold(self.follow, |sum, pair| sum + pair.operations)
    }

    /// Finds the first contacts of pairs that are not excluded while bodies move to new
    /// positions; see [`Scene::sweep`]. All vertices take part, and no contact is missed,
    /// whatever the tolerance.
    ///
    /// # Errors
    ///
    /// As [`Scene::sweep`], and [`PlanError::OtherScene`].
    pub fn sweep(
        &self,
        scene: &mut Scene,
        moves: &[BodyMove<'_>],
        params: &CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, PlanError> {
        self.check_scene(scene)?;

        // Two bones are swept only if they are a pair of the plan.
        let is_rigid: Vec<bool> = scene.bodies().iter().map(Body::is_rigid).collect();
        let is_wanted = |pair: PairId| {
            self.is_planned(pair) || pair.bodies().into_iter().any(|id| !is_rigid[id.index()])
        };
        Ok(scene.sweep_among(moves, params, is_wanted, progress)?)
    }

    /// Returns true if a pair has a method in this plan.
    pub(crate) fn is_planned(&self, pair: PairId) -> bool {
        self.pairs.binary_search_by_key(&pair, |planned| planned.pair).is_ok()
    }

    /// Checks that the plan was made for bodies of these names, kinds, faces and references.
    pub(crate) fn check_scene(&self, scene: &Scene) -> Result<(), PlanError> {
        let mut pairs = self.bodies.iter().zip(scene.bodies());
        let as_many = self.bodies.len() == scene.bodies().len();
        let is_same = as_many && pairs.all(|(planned, body)| planned.is_like(body));
        if is_same { Ok(()) } else { Err(PlanError::OtherScene) }
    }
}
