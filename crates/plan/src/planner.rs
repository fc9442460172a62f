//! Choice of a method for each pair, and construction of the structures that it needs.

use std::collections::{BTreeMap, BTreeSet};

use decimate::{CoarseSurface, DecimateError, Decimation};
use distance_field::FieldError;
use glam::DVec3;
use kdop::Dop18;
use medial::MedialParams;
use proximity::SurfaceTree;
use scene::{Body, BodyId, BodyKind, MedialDetector, PairId, Scene};
use surface::parallel;
use surface::progress::Progress;

use crate::bone_field::BoneField;
use crate::cost::{OperationCounts, count};
use crate::detection::PairScratch;
use crate::plan::PlannedBody;
use crate::structures::Structures;
use crate::{
    DetectionMethod, ExcludedPair, ExclusionReason, ForcedMethod, MissingStructure, PairPlan, Plan,
    PlanError, PlanParams, StructureKind,
};

/// Error that each body of a pair may contribute \[tolerances\]: both together meet it.
const TOLERANCE_SHARE: f64 = 0.5;

/// Largest fraction of its vertices that a reduced surface may keep. Below, surfaces that would
/// save time are not used; above, following them costs more than it saves.
const MAX_KEPT: f64 = 0.7;

/// Factor from one tolerance to the next that is tried under a budget. Below, more plans are
/// built; above, more accuracy is given up than the budget needs.
const COARSENING: f64 = 1.5;

/// Number of tolerances that are tried under a budget.
const MAX_COARSENINGS: u32 = 10;

impl Plan {
    /// Chooses a method for each pair of bodies where they are, and builds what they need.
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
        let mut planner = Planner::new(scene, params, forced);
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
    forced: &'a [ForcedMethod],
    /// Bounds of each body.
    bounds: Vec<Dop18>,
    decimations: BTreeMap<BodyId, Result<Decimation, DecimateError>>,
}

impl<'a> Planner<'a> {
    fn new(scene: &'a Scene, params: &'a PlanParams, forced: &'a [ForcedMethod]) -> Self {
        let bounds = scene.bodies().iter().map(|body| Dop18::from_points(body.positions()));
        Self { scene, params, forced, bounds: bounds.collect(), decimations: BTreeMap::new() }
    }

    /// Makes a plan for a tolerance.
    fn plan(&mut self, tolerance: f64, progress: Progress<'_>) -> Result<Plan, PlanError> {
        let mut plan = Plan {
            params: *self.params,
            tolerance,
            pairs: Vec::new(),
            excluded_pairs: Vec::new(),
            structures: Structures::new(self.bounds.len()),
            built: Vec::new(),
            missing: Vec::new(),
            follow: OperationCounts::default(),
            bodies: self.scene.bodies().iter().map(PlannedBody::new).collect(),
            scratch: Vec::new(),
        };
        self.choose_methods(&mut plan)?;
        plan.scratch.resize_with(plan.pairs.len(), PairScratch::default);

        self.build_fields(&mut plan, progress.part(0.0, 0.5))?;
        self.build_coarse(&mut plan, progress.part(0.5, 0.8))?;
        self.build_medials(&mut plan, progress.part(0.8, 1.0))?;
        self.select_trees(&mut plan);

        plan.follow = self.follow_operations(&plan.structures);
        for pair in &mut plan.pairs {
            pair.measured_error = plan.structures.measured_error(pair);
            pair.operations = self.pair_operations(pair, &plan.structures);
            pair.cost = self.params.machine_factor * pair.operations.seconds();
        }
        Ok(plan)
    }

    /// Chooses for each pair the method that is cheapest if its structures can be built.
    fn choose_methods(&self, plan: &mut Plan) -> Result<(), PlanError> {
        for a in self.scene.ids() {
            for b in self.scene.ids().skip(a.index() + 1) {
                let pair = PairId::new(a, b);
                match self.exclusion(pair) {
                    Some(reason) => plan.excluded_pairs.push(ExcludedPair { pair, reason }),
                    None => plan.pairs.push(self.choose_method(pair)?),
                }
            }
        }
        Ok(())
    }

    /// Returns the reason why a pair is not detected, if there is one.
    fn exclusion(&self, pair: PairId) -> Option<ExclusionReason> {
        if self.scene.is_ignored(pair) {
            return Some(ExclusionReason::Ignored);
        }
        if self.are_rigid(pair) && self.forced_method(pair).is_none() {
            return Some(ExclusionReason::BothRigid);
        }
        let [a, b] = pair.bodies().map(|id| &self.bounds[id.index()]);
        let distance = separation(a, b);
        let max_distance = self.params.margin + 2.0 * self.params.max_displacement;
        (distance > max_distance).then_some(ExclusionReason::FarApart { distance })
    }

    fn choose_method(&self, pair: PairId) -> Result<PairPlan, PlanError> {
        let has_inside = |id: BodyId| self.scene.body(id).has_inside().is_ok();
        let is_bone = |id: &BodyId| self.scene.body(*id).is_rigid() && has_inside(*id);
        let bone = pair.bodies().into_iter().find(is_bone);
        let fallback_reason = match bone {
            Some(_) => None,
            None if pair.bodies().into_iter().all(has_inside) => Some(ExclusionReason::NoBone),
            None => Some(ExclusionReason::Open),
        };
        let cheapest =
            if bone.is_some() { DetectionMethod::Field } else { DetectionMethod::Surfaces };
        let planned = PairPlan {
            pair,
            method: self.forced_method(pair).unwrap_or(cheapest),
            bone,
            fallback_reason,
            measured_error: 0.0,
            operations: OperationCounts::default(),
            cost: 0.0,
        };

        if planned.method == DetectionMethod::Field && bone.is_none() {
            return Err(self.unsuitable(&planned, ExclusionReason::NoBone));
        }
        if planned.method == DetectionMethod::Medial && self.are_rigid(pair) {
            return Err(self.unsuitable(&planned, ExclusionReason::BothRigid));
        }
        Ok(planned)
    }

    fn are_rigid(&self, pair: PairId) -> bool {
        pair.bodies().into_iter().all(|id| self.scene.body(id).is_rigid())
    }

    fn forced_method(&self, pair: PairId) -> Option<DetectionMethod> {
        self.forced.iter().find(|forced| forced.pair == pair).map(|forced| forced.method)
    }

    fn unsuitable(&self, planned: &PairPlan, reason: ExclusionReason) -> PlanError {
        let [a, b] = planned.pair.bodies().map(|id| self.scene.body(id).name().to_owned());
        PlanError::Forced { a, b, method: planned.method, reason }
    }

    /// Builds the fields of rigid bodies. Pairs whose body cannot have one fall back to surfaces.
    fn build_fields(&self, plan: &mut Plan, progress: Progress<'_>) -> Result<(), PlanError> {
        let tolerance = TOLERANCE_SHARE * plan.tolerance;
        let bones: BTreeSet<BodyId> = plan.pairs.iter().filter_map(PairPlan::bone).collect();
        let bones: Vec<BodyId> = bones.into_iter().collect();
        let margin = self.params.margin;
        let fields = parallel::map(bones.len(), |i| {
            let body = self.scene.body(bones[i]);
            BoneField::build(body, tolerance, margin, item(progress, i, &bones))
        });

        for (bone, field) in bones.into_iter().zip(fields) {
            match field {
                Ok(field) => plan.structures.bodies[bone.index()].field = Some(field),
                Err(ExclusionReason::Field {
                    source: FieldError::Interrupted(interrupted),
                    ..
                }) => return Err(interrupted.into()),
                Err(reason) => self.fall_back(plan, bone, reason)?,
            }
        }
        Ok(())
    }

    /// Turns the pairs of a rigid body that cannot have a field to surfaces.
    fn fall_back(
        &self,
        plan: &mut Plan,
        bone: BodyId,
        reason: ExclusionReason,
    ) -> Result<(), PlanError> {
        for pair in plan.pairs.iter_mut().filter(|pair| pair.bone() == Some(bone)) {
            if self.forced_method(pair.pair).is_some() {
                return Err(self.unsuitable(pair, reason));
            }
            pair.method = DetectionMethod::Surfaces;
            pair.fallback_reason = Some(reason.clone());
        }
        plan.missing.push(MissingStructure { body: bone, kind: StructureKind::Field, reason });
        Ok(())
    }

    /// Builds the reduced surfaces of bodies whose vertices or faces are compared.
    fn build_coarse(&mut self, plan: &mut Plan, progress: Progress<'_>) -> Result<(), PlanError> {
        let mut bodies = BTreeSet::new();
        for planned in &plan.pairs {
            match (planned.method, planned.bone()) {
                (DetectionMethod::Medial, _) => {}
                (_, Some(bone)) => bodies.extend([planned.other(bone)]),
                (_, None) => bodies.extend(planned.pair.bodies()),
            }
        }
        let bodies: Vec<BodyId> = bodies.into_iter().collect();
        self.decimate(&bodies, progress.part(0.0, 0.5))?;

        let max_deviation = TOLERANCE_SHARE * plan.tolerance;
        let progress = progress.part(0.5, 1.0);
        let built = parallel::map(bodies.len(), |i| {
            coarse_surface(&self.decimations[&bodies[i]], max_deviation, item(progress, i, &bodies))
        });
        for (body, built) in bodies.into_iter().zip(built) {
            let reason = match built {
                Ok(Some(coarse)) => {
                    plan.structures.bodies[body.index()].coarse = Some(coarse);
                    continue;
                }
                Ok(None) => ExclusionReason::TooManyVertices { percent: 100.0 * MAX_KEPT },
                Err(DecimateError::Interrupted(interrupted)) => return Err(interrupted.into()),
                Err(error) => ExclusionReason::Decimation(error),
            };
            plan.missing.push(MissingStructure { body, kind: StructureKind::Reduced, reason });
        }
        Ok(())
    }

    /// Decimates the bodies that were not decimated for an earlier tolerance.
    fn decimate(&mut self, bodies: &[BodyId], progress: Progress<'_>) -> Result<(), PlanError> {
        let mut bodies = bodies.to_vec();
        bodies.retain(|id| !self.decimations.contains_key(id));
        let decimations = parallel::map(bodies.len(), |i| {
            decimate(self.scene.body(bodies[i]), item(progress, i, &bodies))
        });
        for (id, decimation) in bodies.into_iter().zip(decimations) {
            if let Err(DecimateError::Interrupted(interrupted)) = decimation {
                return Err(interrupted.into());
            }
            self.decimations.insert(id, decimation);
        }
        Ok(())
    }

    /// Builds the medial surfaces of soft bodies, with as few balls as the tolerance allows.
    fn build_medials(&self, plan: &mut Plan, progress: Progress<'_>) -> Result<(), PlanError> {
        let params = MedialParams::tolerance(plan.tolerance);
        let margin = self.params.margin;
        for pair in plan.pairs.iter().filter(|pair| pair.method == DetectionMethod::Medial) {
            for id in pair.pair.bodies() {
                let medial = &mut plan.structures.bodies[id.index()].medial;
                if medial.is_some() || self.scene.body(id).is_rigid() {
                    continue;
                }
                progress.report(0.0)?;
                let detector = MedialDetector::new(self.scene, id, margin, &params, |_| {});
                let unsuitable = |error| self.unsuitable(pair, ExclusionReason::Medial(error));
                *medial = Some(detector.map_err(unsuitable)?);
            }
        }
        Ok(())
    }

    /// Selects the bodies whose own faces are compared, and need a tree: those without a reduced
    /// surface in their place.
    fn select_trees(&self, plan: &mut Plan) {
        for pair in &plan.pairs {
            for id in pair.pair.bodies() {
                let is_reduced = plan.structures.coarse(id).is_some();
                plan.structures.uses_tree[id.index()] |= match pair.method {
                    DetectionMethod::Field => pair.bone != Some(id) && !is_reduced,
                    DetectionMethod::Surfaces => !is_reduced,
                    DetectionMethod::Medial => true,
                };
            }
        }
        for body in self.scene.ids().filter(|id| !plan.structures.uses_tree[id.index()]) {
            let reason = ExclusionReason::NotNeeded;
            plan.missing.push(MissingStructure { body, kind: StructureKind::Tree, reason });
        }
        plan.missing.sort_by_key(|missing| missing.body);
    }

    /// Counts the operations that refit the structures of all bodies.
    fn follow_operations(&self, structures: &Structures) -> OperationCounts {
        let mut operations = OperationCounts::default();
        for (number, body) in self.scene.bodies().iter().enumerate() {
            if structures.uses_tree[number] {
                operations.refit_faces += count(body.surface().faces().len());
            }
            if let Some(coarse) = &structures.bodies[number].coarse {
                operations.refit_faces += count(coarse.tree().surface().faces().len());
            }
            if structures.bodies[number].medial.is_some() {
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
                let side = structures.contact_surface(self.scene, pair.other(bone));
                operations.field_vertices = self.count_near(side.positions.as_slice(), bone);
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

/// Computes the decimation of a body where it is.
fn decimate(body: &Body, progress: Progress<'_>) -> Result<Decimation, DecimateError> {
    let full = SurfaceTree::new(body.surface().clone(), body.positions().to_vec())?;
    let is_open = body.kind() == BodyKind::Open;
    Decimation::new(if is_open { full.declared_open() } else { full }, progress)
}

/// Builds the coarsest surface within a deviation; `None` where that keeps too many vertices.
fn coarse_surface(
    decimation: &Result<Decimation, DecimateError>,
    max_deviation: f64,
    progress: Progress<'_>,
) -> Result<Option<CoarseSurface>, DecimateError> {
    let decimation = decimation.as_ref().map_err(DecimateError::clone)?;
    let reduced = decimation.within(max_deviation, progress)?;
    let vertex_count = decimation.full().surface().vertex_count();
    if count(reduced.kept.len()) > MAX_KEPT * count(vertex_count) {
        return Ok(None);
    }
    CoarseSurface::new(reduced, decimation.full()).map(Some)
}

/// Returns the part of a progress that one of several items completes.
fn item<'a, T>(progress: Progress<'a>, number: usize, items: &[T]) -> Progress<'a> {
    let [from, to] = [number, number + 1].map(|done| count(done) / count(items.len()));
    progress.part(from, to)
}

/// Computes the largest gap between two bounds along one of their directions, a lower bound of
/// the distance between their points.
fn separation(a: &Dop18, b: &Dop18) -> f64 {
    let mut separation: f64 = 0.0;
    for axis in 0..9 {
        let [p, q] = [a, b].map(|bounds| bounds.interval(axis).map(f64::from));
        let gap = (q[0] - p[1]).max(p[0] - q[1]) / kdop::norm::<9>(axis);
        separation = separation.max(gap);
    }
    separation
}
