//! Making of a plan: candidate pairs, structures within a tolerance, and their costs.

use glam::DVec3;
use kdop::Dop18;
use scene::{BodyId, Scene};
use surface::progress::Progress;

use crate::builder::Builder;
use crate::candidates::Candidates;
use crate::cost::{OperationCounts, count};
use crate::pair_detector::PairDetector;
use crate::plan::PlannedBody;
use crate::structures::Structures;
use crate::{DetectionMethod, ForcedMethod, PairPlan, Plan, PlanError, PlanParams};

/// Factor from one tolerance to the next that is tried under a budget. Below, more plans are
/// built; above, more accuracy is given up than the budget needs.
const COARSENING: f64 = 1.5;

/// Number of tolerances that are tried under a budget.
const MAX_COARSENINGS: u32 = 10;

impl Plan {
    /// Chooses a method for each pair of bodies that may meet, and builds what they need.
    ///
    /// Fields are built at the positions that rigid bodies were added with, and follow their
    /// poses. Reduced surfaces are built at the present positions and follow the vertices that
    /// they have kept. Where a body is stretched, so is their deviation.
    ///
    /// # Errors
    ///
    /// [`PlanError::Parameter`], [`PlanError::Interrupted`], and [`PlanError::Scene`] when a body
    /// is too large to build bounds for.
    pub fn new(
        scene: &mut Scene,
        params: &PlanParams,
        progress: Progress<'_>,
    ) -> Result<Self, PlanError> {
        Self::with_forced(scene, params, &[], progress)
    }

    /// Makes a plan as [`Self::new`] does, with methods that the caller has chosen for some
    /// pairs.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], and [`PlanError::Forced`] for a method that does not suit its pair.
    pub fn with_forced(
        scene: &mut Scene,
        params: &PlanParams,
        forced: &[ForcedMethod],
        progress: Progress<'_>,
    ) -> Result<Self, PlanError> {
        params.validate()?;
        let candidates = Candidates::find(scene, params, forced)?;
        let mut planner = Planner::new(scene, params, forced, candidates);

        // Under a budget, coarser plans are tried until one keeps to it.
        let mut plan = planner.plan(params.tolerance, progress)?;
        for _ in 0..MAX_COARSENINGS {
            if plan.is_within_budget() {
                break;
            }
            plan = planner.plan(COARSENING * plan.tolerance, progress.part(1.0, 1.0))?;
        }
        scene.fit(&plan.structures.uses_tree)?;
        plan.built = plan.structures.list(scene);
        Ok(plan)
    }
}

/// Maker of plans for one scene, with what does not depend on the tolerance.
struct Planner<'a> {
    scene: &'a Scene,
    params: &'a PlanParams,
    candidates: Candidates,
    builder: Builder<'a>,
    /// Bounds of each body.
    bounds: Vec<Dop18>,
}

impl<'a> Planner<'a> {
    fn new(
        scene: &'a Scene,
        params: &'a PlanParams,
        forced: &'a [ForcedMethod],
        candidates: Candidates,
    ) -> Self {
        let bounds = scene.bodies().iter().map(|body| Dop18::from_points(body.positions()));
        let builder = Builder::new(scene, params.margin, forced);
        Self { scene, params, candidates, builder, bounds: bounds.collect() }
    }

    /// Makes a plan for a tolerance.
    fn plan(&mut self, tolerance: f64, progress: Progress<'_>) -> Result<Plan, PlanError> {
        // Structures first: a pair whose structure cannot be built changes its method.
        let mut pairs = self.candidates.planned.clone();
        let (structures, missing) = self.builder.build(&mut pairs, tolerance, progress)?;

        // Then the errors and costs of what was built.
        for pair in &mut pairs {
            pair.error = structures.error(pair);
            pair.operations = self.pair_operations(pair, &structures);
            pair.cost = self.params.machine_factor * pair.operations.seconds();
        }
        let follow = self.follow_operations(&structures);
        let mut detectors = Vec::new();
        detectors.resize_with(pairs.len(), PairDetector::default);
        Ok(Plan {
            params: *self.params,
            tolerance,
            pairs,
            excluded_pairs: self.candidates.excluded.clone(),
            far_pair_count: self.candidates.far_pair_count,
            structures,
            built: Vec::new(),
            missing,
            follow,
            bodies: self.scene.bodies().iter().map(PlannedBody::new).collect(),
            detectors,
        })
    }

    /// Counts the operations that refit the structures of all bodies.
    fn follow_operations(&self, structures: &Structures) -> OperationCounts {
        let mut operations = OperationCounts::default();
        for (number, body) in self.scene.bodies().iter().enumerate() {
            // Trees are refit over all of their faces, and balls follow all vertices.
            let of_body = &structures.bodies[number];
            if structures.uses_tree[number] {
                operations.refit_faces += count(body.surface().faces().len());
            }
            if let Some(coarse) = &of_body.coarse {
                operations.refit_faces += count(coarse.tree().surface().faces().len());
            }
            if of_body.medial.is_some() {
                operations.tied_vertices += count(body.positions().len());
            }
        }
        operations
    }

    /// Counts the operations that detect one pair.
    fn pair_operations(&self, pair: &PairPlan, structures: &Structures) -> OperationCounts {
        let mut operations = OperationCounts::default();
        match (pair.method, pair.bone()) {
            (DetectionMethod::Field, None) => {}
            (DetectionMethod::Field, Some(bone)) => {
                // What is far from the other body is culled in no time.
                let other = pair.other(bone);
                let side = structures.contact_surface(self.scene, other);
                operations.field_vertices = self.count_near(side.positions.as_slice(), bone);
                // A bone has two faces per vertex.
                let positions = self.scene.body(bone).positions();
                operations.compared_faces = 2.0 * self.count_near(positions, other);
            }
            (DetectionMethod::Surfaces, _) => {
                for id in pair.pair.bodies() {
                    let side = structures.contact_surface(self.scene, id);
                    operations.compared_faces += count(side.surface.faces().len());
                }
            }
            (DetectionMethod::Medial, _) => {
                let [a, b] = pair.pair.bodies();
                for (body, other) in [(a, b), (b, a)] {
                    if structures.bodies[other.index()].medial.is_some() {
                        let positions = self.scene.body(body).positions();
                        operations.ball_vertices += self.count_near(positions, other);
                    }
                }
            }
        }
        operations
    }

    /// Counts the points within the margin of a body's bounds.
    fn count_near(&self, points: &[DVec3], body: BodyId) -> f64 {
        let bounds = self.bounds[body.index()].inflated(self.params.margin);
        count(points.iter().filter(|&&p| bounds.overlaps(&Dop18::from_points(&[p]))).count())
    }
}
