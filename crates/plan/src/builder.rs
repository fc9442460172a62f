//! Construction of the structures that chosen methods need.

use decimate::{CoarseSurface, DecimateError, Decimation};
use distance_field::FieldError;
use medial::{MedialDetector, MedialError, MedialParams};
use proximity::SurfaceTree;
use scene::{Body, BodyId, BodyKind, Scene};
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use crate::bone_field::BoneField;
use crate::choice::{Choice, StructureSet};
use crate::coarse_levels::{CoarseLevels, finer_shares};
use crate::cost::count;
use crate::structures::{MissingStructure, Structures};
use crate::{ExclusionReason, PlanError, PlanParams, StructureKind};

/// Deviation of a coarse surface \[tolerances\]. Two of them leave a fifth of the tolerance for
/// deformation. Smaller keeps more faces; larger, searches for depths take longer and bodies that
/// deform are compared by their own surfaces sooner: in a walk of 25 bodies, 0.35 and 0.45 are both
/// slower.
pub(crate) const COARSE_SHARE: f64 = 0.4;

/// Largest fraction of its faces that a coarse surface may keep where it was not forced. Above,
/// following it costs more than it saves.
const MAX_KEPT: f64 = 0.7;

/// Builder of structures for one scene.
pub(crate) struct Builder<'a> {
    scene: &'a Scene,
    params: &'a PlanParams,
    /// One per body: structures that an earlier plan has built.
    present: Vec<StructureSet>,
    structures: Structures,
    built: usize,
}

/// Structure to build.
#[derive(Clone, Copy)]
struct Task {
    body: BodyId,
    kind: StructureKind,
    is_forced: bool,
}

/// Structure that was built.
enum Built {
    Coarse(CoarseLevels),
    Field(Box<BoneField>),
    Medial(Box<MedialDetector>),
}

/// Failure to build a structure.
enum BuildError {
    Interrupted(Interrupted),
    Excluded(ExclusionReason),
}

impl<'a> Builder<'a> {
    pub(crate) fn new(
        scene: &'a Scene,
        params: &'a PlanParams,
        present: Vec<StructureSet>,
    ) -> Self {
        let structures = Structures::new(scene.bodies().len());
        Self { scene, params, present, structures, built: 0 }
    }

    /// Builds the structures of a choice that do not exist yet, and lists those that cannot be
    /// built.
    pub(crate) fn build(
        &mut self,
        choice: &Choice,
        forced: &[StructureSet],
        progress: Progress<'_>,
    ) -> Result<Vec<MissingStructure>, PlanError> {
        // Structures in any thread.
        let tasks = self.tasks(choice, forced);
        let built = parallel::map(tasks.len(), |number| {
            let [from, to] = [number, number + 1].map(|done| count(done) / count(tasks.len()));
            self.build_one(tasks[number], progress.part(from, to))
        });

        // Each to its body, or among the missing with the reason, in the order of the tasks.
        let mut missing = Vec::new();
        self.built += tasks.len();
        for (&Task { body, kind, .. }, built) in tasks.iter().zip(built) {
            let of_body = &mut self.structures.bodies[body.index()];
            match built {
                Ok(Built::Coarse(coarse)) => of_body.coarse = Some(coarse),
                Ok(Built::Field(field)) => of_body.field = Some(*field),
                Ok(Built::Medial(medial)) => of_body.medial = Some(*medial),
                Err(BuildError::Interrupted(interrupted)) => return Err(interrupted.into()),
                Err(BuildError::Excluded(reason)) => {
                    missing.push(MissingStructure { body, kind, reason });
                }
            }
        }
        Ok(missing)
    }

    /// Returns the structures that were built for a choice, without those that it does not need, and
    /// the number of all that were built.
    pub(crate) fn finish(self, choice: &Choice) -> (Structures, usize) {
        let mut structures = self.structures;
        for (number, set) in choice.structures.iter().enumerate() {
            let of_body = &mut structures.bodies[number];
            structures.uses_tree[number] = set.has(StructureKind::Tree);
            if !set.has(StructureKind::Coarse) {
                of_body.coarse = None;
            }
            of_body.field.take_if(|_| !set.has(StructureKind::Field));
        }
        (structures, self.built)
    }

    /// Lists the structures of a choice that do not exist yet, in the order of the bodies.
    fn tasks(&self, choice: &Choice, forced: &[StructureSet]) -> Vec<Task> {
        let mut tasks = Vec::new();
        for (number, body) in self.scene.ids().enumerate() {
            let (set, built) = (choice.structures[number], &self.structures.bodies[number]);
            let has_balls = built.medial.is_some() || self.scene.body(body).is_rigid();
            for (kind, is_built) in [
                (StructureKind::Coarse, built.coarse.is_some()),
                (StructureKind::Field, built.field.is_some()),
                (StructureKind::Medial, has_balls),
            ] {
                if set.has(kind) && !is_built && !self.present[number].has(kind) {
                    tasks.push(Task { body, kind, is_forced: forced[number].has(kind) });
                }
            }
        }
        tasks
    }

    /// Builds the coarse surfaces of a body where it is: the coarsest, and finer ones that have few
    /// enough faces.
    fn coarse_levels(
        &self,
        body: &Body,
        progress: Progress<'_>,
    ) -> Result<CoarseLevels, DecimateError> {
        progress.report(0.0)?;
        let full = SurfaceTree::new(body.surface().clone(), body.positions().to_vec())?;
        let full = if body.kind() == BodyKind::Open { full.declared_open() } else { full };
        let max_deviation = COARSE_SHARE * self.params.tolerance;
        let decimation = Decimation::up_to(full, max_deviation, progress.part(0.0, 0.4))?;

        let max_faces = MAX_KEPT * count(body.surface().faces().len());
        let within = |share: f64, progress| {
            let reduced = decimation.within(share * max_deviation, progress)?;
            CoarseSurface::new(reduced, decimation.full())
        };
        let coarsest = within(1.0, progress.part(0.4, 0.6))?;
        let mut finer = Vec::new();
        for &share in finer_shares(body, self.params.frames) {
            let coarse = within(share, progress.part(0.6, 1.0))?;
            if count(coarse.tree().surface().faces().len()) <= max_faces {
                finer.push(coarse);
            }
        }
        Ok(CoarseLevels::new(coarsest, finer))
    }

    fn build_one(&self, task: Task, progress: Progress<'_>) -> Result<Built, BuildError> {
        let body = self.scene.body(task.body);
        let PlanParams { tolerance, margin, .. } = *self.params;
        match task.kind {
            StructureKind::Field => {
                let field = BoneField::build(body, tolerance, margin, progress)?;
                Ok(Built::Field(Box::new(field)))
            }
            StructureKind::Medial => {
                let (surface, x) = (body.surface(), body.checked_positions());
                let params = MedialParams::tolerance(tolerance);
                let balls = MedialDetector::new(surface, x, margin, &params, progress);
                Ok(Built::Medial(Box::new(balls?)))
            }
            StructureKind::Coarse | StructureKind::Tree => {
                let coarse = self.coarse_levels(body, progress)?;
                let faces = coarse.present().tree().surface().faces().len();
                // Following too many faces costs more than it saves; forced ones are kept.
                if !task.is_forced && count(faces) > MAX_KEPT * count(body.surface().faces().len())
                {
                    let percent = 100.0 * MAX_KEPT;
                    return Err(BuildError::Excluded(ExclusionReason::TooManyFaces { percent }));
                }
                Ok(Built::Coarse(coarse))
            }
        }
    }
}

impl From<DecimateError> for BuildError {
    fn from(error: DecimateError) -> Self {
        match error {
            DecimateError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Excluded(ExclusionReason::Decimation(error)),
        }
    }
}

impl From<MedialError> for BuildError {
    fn from(error: MedialError) -> Self {
        match error {
            MedialError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Excluded(ExclusionReason::Medial(error)),
        }
    }
}

impl From<ExclusionReason> for BuildError {
    fn from(reason: ExclusionReason) -> Self {
        match reason {
            ExclusionReason::Field { source: FieldError::Interrupted(interrupted), .. } => {
                Self::Interrupted(interrupted)
            }
            reason => Self::Excluded(reason),
        }
    }
}
