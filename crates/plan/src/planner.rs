//! Making of a plan: pairs, choice of their methods, and construction of what these need.

use scene::{Body, BodyId, Scene};
use surface::parallel;
use surface::progress::Progress;

use crate::bone_field::FieldSize;
use crate::builder::{Builder, COARSE_SHARE};
use crate::candidates::{NearPair, NearPairs, unsuitable};
use crate::choice::place;
use crate::choice::{BodyOptions, Candidate, Choice, KINDS, Options, PairOptions, StructureSet};
use crate::coarse_levels::finer_shares;
use crate::coarse_size::predicted_faces;
use crate::cost::{OperationCounts, count, far_share};
use crate::pair_detector::PairDetector;
use crate::plan::PlannedBody;
use crate::rounding::check_rounding;
use crate::structures::{
    MissingStructure, Structures, coarse_construction, coarse_follow, refit, tree_construction,
};
use crate::workload::Workload;
use crate::{
    Accuracy, DetectionMethod, ForcedMethod, PairPlan, Plan, PlanError, PlanParams, StructureKind,
};

mod useless;

impl Plan {
    /// Chooses a method for each pair of bodies that may meet, and builds what they need.
    ///
    /// Of the methods whose bound is proved to be within the tolerance, those are taken that are
    /// predicted to take the least time for construction and all [frames](PlanParams::frames).
    /// Nothing else is built. Where a structure may pay at all, the exact detection of each pair is
    /// run once, and its work counted.
    ///
    /// Fields are built at the positions that rigid bodies were added with, and follow their
    /// poses. Coarse surfaces are built at the present positions and follow the vertices that
    /// they have kept; where a body is deformed until one deviates too much, a finer one takes its
    /// place in plans for many frames, and the body's own surface where none is fine enough.
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
    /// pairs, whatever their cost and bound.
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
        check_rounding(scene, params.tolerance)?;
        let near = NearPairs::find(scene, params, forced)?;
        let present = vec![StructureSet::default(); scene.bodies().len()];
        let mut planner = Planner::new(scene, params, near.planned, present);
        planner.count_work(scene, progress.part(0.0, 0.1))?;
        let made = planner.make(scene, progress.part(0.1, 1.0))?;

        let mut plan = planner.into_plan(scene, made);
        plan.excluded_pairs = near.excluded;
        plan.far_pair_count = near.far_pair_count;
        plan.forced = forced.to_vec();
        plan.begin(scene)?;
        Ok(plan)
    }

    /// Chooses anew for the frames that are left, from the work that the present state takes;
    /// returns true if that changes the plan.
    ///
    /// What is built and within its tolerance is kept, and costs nothing; all else is built where
    /// it pays over the frames that are left. Coarse surfaces that were deformed too much are
    /// built again from the present shape. The work of each pair is counted by one exact
    /// detection, so that a call pays every hundred frames or so, or after a change of scene. The
    /// choice depends on counts alone: it is the same in every run.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], and [`PlanError::OtherScene`]. The plan is then as it was.
    pub fn revise(&mut self, scene: &mut Scene, progress: Progress<'_>) -> Result<bool, PlanError> {
        self.check_scene(scene)?;

        // With few frames left, counting the work would cost more than it may save.
        let detected = u32::try_from(self.frame_count).unwrap_or(u32::MAX);
        let frames = self.params.frames.saturating_sub(detected);
        if frames < MIN_COUNTED_FRAMES {
            return Ok(false);
        }
        let params = PlanParams { frames, ..self.params };
        let near = NearPairs::find(scene, &params, &self.forced)?;

        // Deviations as they are now decide what can be kept.
        self.structures.follow(scene, &self.pairs, &params)?;
        let present = self.structures.present(&self.pairs, params.tolerance);
        let mut planner = Planner::new(scene, &params, near.planned, present);
        planner.measure_coarse(scene, &self.structures);
        planner.count_work(scene, progress.part(0.0, 0.1))?;
        let mut made = planner.make(scene, progress.part(0.1, 1.0))?;

        // Nothing fails from here on, so that what is kept can change hands.
        let is_changed = made.built > 0 || !made.is_like(&self.pairs);
        made.structures.adopt(&mut self.structures, &made.choice.structures);
        let mut plan = planner.into_plan(scene, made);
        plan.excluded_pairs = near.excluded;
        plan.far_pair_count = near.far_pair_count;
        plan.forced.clone_from(&self.forced);
        plan.motion = self.motion.take();
        *self = plan;
        self.begin(scene)?;
        Ok(is_changed)
    }

    /// Builds the trees of a plan, and lists what it has.
    fn begin(&mut self, scene: &mut Scene) -> Result<(), PlanError> {
        scene.fit(&self.structures.uses_tree)?;
        self.built = self.structures.list(scene);
        Ok(())
    }
}

/// Smallest number of frames for which work is counted. Counting is exact detection of each pair,
/// once: for fewer frames it would cost more than the tenth that it may save.
const MIN_COUNTED_FRAMES: u32 = 10;

/// Choice for which everything is built.
struct Made {
    choice: Choice,
    options: Options,
    /// Structures that were built for it.
    structures: Structures,
    /// Number of structures that were built.
    built: usize,
}

impl Made {
    /// Returns true if the chosen methods are those of some planned pairs.
    fn is_like(&self, planned: &[PairPlan]) -> bool {
        let chosen = self.options.pairs.iter().zip(&self.choice.candidates);
        let mut pairs = chosen.zip(planned);
        let is_same = |((options, &chosen), planned): ((&PairOptions, &usize), &PairPlan)| {
            let Candidate { method, is_coarse, .. } = options.candidates[chosen];
            let is_pair = options.pair == planned.pair;
            is_pair && method == planned.method && is_coarse == planned.is_coarse
        };
        self.options.pairs.len() == planned.len() && pairs.all(is_same)
    }
}

/// Maker of a plan.
struct Planner<'a> {
    params: &'a PlanParams,
    pairs: Vec<NearPair>,
    /// One per body: structures that an earlier plan has built.
    present: Vec<StructureSet>,
    /// Work of each pair; nothing where no structure may pay.
    workloads: Vec<Workload>,
    /// One per body: structures that are not considered for free pairs, since they cannot pay.
    useless: Vec<StructureSet>,
    /// One per body: structures that cannot be built.
    excluded: Vec<StructureSet>,
    missing: Vec<MissingStructure>,
    /// One per body: structures that forced methods need.
    forced: Vec<StructureSet>,
    /// One per body: faces of its coarse surface over its own.
    kept: Vec<f64>,
    /// Share of the operations that are far from any cache.
    far_share: f64,
    field_sizes: Vec<Option<FieldSize>>,
}

const COARSE: StructureSet = StructureSet::of(StructureKind::Coarse);
const FIELD: StructureSet = StructureSet::of(StructureKind::Field);

impl<'a> Planner<'a> {
    fn new(
        scene: &Scene,
        params: &'a PlanParams,
        pairs: Vec<NearPair>,
        present: Vec<StructureSet>,
    ) -> Self {
        let none = vec![StructureSet::default(); scene.bodies().len()];
        let mut planner = Self {
            params,
            workloads: vec![Workload::default(); pairs.len()],
            useless: none.clone(),
            excluded: none.clone(),
            missing: Vec::new(),
            forced: none,
            kept: vec![1.0; scene.bodies().len()],
            far_share: far_share(scene),
            field_sizes: vec![None; scene.bodies().len()],
            pairs,
            present,
        };
        planner.find_useless(scene);
        planner
    }

    /// Chooses, and builds what the choice needs and is not there. A structure that cannot be built
    /// takes its candidates with it.
    fn make(&mut self, scene: &Scene, progress: Progress<'_>) -> Result<Made, PlanError> {
        let mut builder = Builder::new(scene, self.params, self.present.clone());
        loop {
            let options = self.options(scene)?;
            let choice = options.choose();
            let missing = builder.build(&choice, &self.forced, progress)?;
            if missing.is_empty() {
                let (structures, built) = builder.finish(&choice);
                self.measure_coarse(scene, &structures);
                return Ok(Made { choice, options, structures, built });
            }
            self.exclude(missing);
        }
    }

    /// Counts the work of all pairs, unless every one is free and has the exact candidate alone.
    fn count_work(&mut self, scene: &mut Scene, progress: Progress<'_>) -> Result<(), PlanError> {
        if self.params.frames < MIN_COUNTED_FRAMES {
            self.useless.fill(COARSE.with(FIELD));
            return Ok(());
        }

        // Work matters only if a pair is forced, or a structure of one may pay.
        let mut is_member = vec![false; scene.bodies().len()];
        let mut may_pay = false;
        for pair in &self.pairs {
            for id in pair.pair.bodies() {
                is_member[id.index()] = true;
                let useless = self.useless[id.index()];
                let both = useless.has(StructureKind::Coarse) && useless.has(StructureKind::Field);
                may_pay |= pair.forced.is_some() || !both;
            }
        }
        if !may_pay {
            return Ok(());
        }

        scene.fit(&is_member)?;
        self.workloads = Workload::count_all(scene, &self.pairs, self.params, progress)?;
        self.find_useless_by_work(scene);

        // Sizes of coarse surfaces, where one may pay.
        let scene = &*scene;
        let deviation = COARSE_SHARE * self.params.tolerance;
        self.kept = parallel::map(scene.bodies().len(), |number| {
            let body = &scene.bodies()[number];
            let is_built = self.present[number].has(StructureKind::Coarse);
            if !is_member[number] || is_built || self.useless[number].has(StructureKind::Coarse) {
                return self.kept[number];
            }
            predicted_faces(body, deviation) / count(body.surface().faces().len())
        });
        Ok(())
    }

    /// Lists the candidates of all pairs and the costs of their structures.
    fn options(&mut self, scene: &Scene) -> Result<Options, PlanError> {
        let frames = f64::from(self.params.frames);
        let mut pairs = Vec::new();
        self.forced.fill(StructureSet::default());
        for number in 0..self.pairs.len() {
            let candidates = self.candidates(scene, number)?;
            let pair = self.pairs[number].pair;
            // The needs of a forced method are forced on both bodies.
            if let (Some(_), [only]) = (self.pairs[number].forced, &candidates[..]) {
                for (id, needs) in pair.bodies().into_iter().zip(only.needs(pair)) {
                    self.forced[id.index()] = self.forced[id.index()].with(needs);
                }
            }
            pairs.push(PairOptions { pair, candidates });
        }

        let bodies = scene.bodies().iter().enumerate();
        let bodies = bodies.map(|(number, body)| self.body_options(number, body)).collect();
        Ok(Options { frames, bodies, pairs })
    }

    /// Lists the candidates of a pair: the forced one, or exact detection and what may pay.
    fn candidates(&self, scene: &Scene, number: usize) -> Result<Vec<Candidate>, PlanError> {
        let (NearPair { pair, forced, bone }, work) = (self.pairs[number], &self.workloads[number]);
        let bodies = pair.bodies();
        let kept = bodies.map(|id| self.kept[id.index()]);
        let exact = work.predict(DetectionMethod::Exact, pair, [false; 2], None, kept);
        let can = |id: BodyId, kind| !self.excluded[id.index()].has(kind);

        // A forced method, as far as its structures can be built.
        if let Some(method) = forced {
            let is_coarse = match method {
                DetectionMethod::Coarse => bodies.map(|id| can(id, StructureKind::Coarse)),
                _ => [false; 2],
            };
            let bone = bone.filter(|_| method == DetectionMethod::Field);
            let lacks_structure = match method {
                DetectionMethod::Exact => false,
                DetectionMethod::Coarse => is_coarse == [false; 2],
                DetectionMethod::Field => bone.is_some_and(|id| !can(id, StructureKind::Field)),
                DetectionMethod::Balls => bodies.iter().any(|&id| !can(id, StructureKind::Medial)),
            };
            if lacks_structure {
                let missing = self.missing.iter().find(|missing| pair.contains(missing.body));
                let reason = missing.map(|missing| missing.reason.clone());
                return match reason {
                    Some(reason) => Err(unsuitable(scene, pair, method, reason)),
                    None => Ok(vec![exact]),
                };
            }
            return Ok(vec![work.predict(method, pair, is_coarse, bone, kept)]);
        }

        // Free methods: exact, coarse on either side, field.
        let mut candidates = vec![exact];
        let is_useful = |id: BodyId, kind| can(id, kind) && !self.useless[id.index()].has(kind);
        for is_coarse in [[true, false], [false, true], [true, true]] {
            let suits = [0, 1]
                .iter()
                .all(|&side| !is_coarse[side] || is_useful(bodies[side], StructureKind::Coarse));
            if suits {
                let method = DetectionMethod::Coarse;
                candidates.push(work.predict(method, pair, is_coarse, None, kept));
            }
        }
        if bone.is_some_and(|id| is_useful(id, StructureKind::Field)) {
            let method = DetectionMethod::Field;
            candidates.push(work.predict(method, pair, [false; 2], bone, kept));
        }
        Ok(candidates)
    }

    /// Computes the costs of a body's structures: construction, and following it in all frames.
    fn body_options(&self, number: usize, body: &Body) -> BodyOptions {
        let frames = f64::from(self.params.frames);
        let follow = self.follow(number, body);
        let built = if body.tree().is_some() { 0.0 } else { tree_construction(body).seconds() };
        let mut seconds = [0.0; KINDS];
        seconds[place(StructureKind::Tree)] = built;
        seconds[place(StructureKind::Coarse)] = self.coarse_construction(number, body).seconds();
        let field = self.field_sizes[number].map_or(f64::INFINITY, field_seconds);
        seconds[place(StructureKind::Field)] = field;

        // Structures that are built already cost nothing but following their body.
        for kind in [StructureKind::Tree, StructureKind::Coarse, StructureKind::Field] {
            if self.present[number].has(kind) {
                seconds[place(kind)] = 0.0;
            }
        }
        for kind in 0..KINDS {
            seconds[kind] += frames * follow[kind].seconds();
        }
        BodyOptions { seconds }
    }

    /// Counts the operations that build a body's coarse surfaces.
    fn coarse_construction(&self, number: usize, body: &Body) -> OperationCounts {
        let finer = finer_shares(body, self.params.frames).len();
        coarse_construction(body, self.kept[number], finer, self.far_share)
    }

    /// Counts the operations by which each kind of structure follows its body.
    fn follow(&self, number: usize, body: &Body) -> [OperationCounts; KINDS] {
        let faces = count(body.surface().faces().len());
        let tied_vertices = count(body.positions().len());
        let mut follow = [OperationCounts::default(); KINDS];
        follow[place(StructureKind::Tree)] = refit(faces, self.far_share);
        follow[place(StructureKind::Coarse)] =
            coarse_follow(body, self.kept[number] * faces, self.far_share);
        follow[place(StructureKind::Medial)] =
            OperationCounts { tied_vertices, ..OperationCounts::default() };
        follow
    }

    /// Excludes structures that could not be built.
    fn exclude(&mut self, missing: Vec<MissingStructure>) {
        for missing in &missing {
            let set = &mut self.excluded[missing.body.index()];
            *set = set.with(StructureSet::of(missing.kind));
        }
        self.missing.extend(missing);
    }

    /// Replaces predicted sizes of coarse surfaces by those that were built.
    fn measure_coarse(&mut self, scene: &Scene, structures: &Structures) {
        for id in scene.ids() {
            if let Some(coarse) = structures.coarse(id) {
                let faces = scene.body(id).surface().faces().len();
                self.kept[id.index()] = count(coarse.tree().surface().faces().len()) / count(faces);
            }
        }
    }

    /// Makes the plan of a choice whose structures were built.
    fn into_plan(mut self, scene: &Scene, made: Made) -> Plan {
        let Made { choice, options, structures, .. } = made;
        let mut pairs = Vec::new();
        for (number, &chosen) in choice.candidates.iter().enumerate() {
            let PairOptions { pair, candidates } = &options.pairs[number];
            let Candidate { method, is_coarse, bone, .. } = candidates[chosen];

            // Predicted again, from the sizes as they were built.
            let kept = pair.bodies().map(|id| self.kept[id.index()]);
            let work = &self.workloads[number];
            let operations = work.predict(method, *pair, is_coarse, bone, kept).operations;
            let cost = self.params.machine_factor * operations.seconds();
            let mut planned = PairPlan {
                pair: *pair,
                method,
                is_coarse,
                bone,
                accuracy: Accuracy::EXACT,
                operations,
                cost,
                measured_seconds: None,
            };
            planned.accuracy = structures.accuracy(scene, &planned, self.params.tolerance);
            pairs.push(planned);
        }

        // Following is counted per body, since pairs share structures.
        let mut follow = OperationCounts::default();
        for (number, body) in scene.bodies().iter().enumerate() {
            let of_body = self.follow(number, body);
            for kind in [StructureKind::Tree, StructureKind::Coarse, StructureKind::Medial] {
                if choice.structures[number].has(kind) {
                    follow = follow + of_body[place(kind)];
                }
            }
        }
        self.missing.sort_by_key(|missing| missing.body);
        Plan {
            params: *self.params,
            detectors: pairs.iter().map(|planned| PairDetector::new(planned.pair)).collect(),
            pairs,
            excluded_pairs: Vec::new(),
            far_pair_count: 0,
            structures,
            built: Vec::new(),
            missing: self.missing,
            forced: Vec::new(),
            follow,
            bodies: scene.bodies().iter().map(PlannedBody::new).collect(),
            motion: None,
            frame_count: 0,
        }
    }
}

/// Returns the time of construction of a field \[s\].
fn field_seconds(size: FieldSize) -> f64 {
    OperationCounts { field_nodes: size.nodes, ..OperationCounts::default() }.seconds()
}

#[cfg(test)]
mod tests;
