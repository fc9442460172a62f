//! Construction of the structures that the planned pairs need.

use std::collections::{BTreeMap, BTreeSet};

use decimate::{CoarseSurface, DecimateError, Decimation};
use distance_field::FieldError;
use medial::{MedialDetector, MedialError, MedialParams};
use proximity::SurfaceTree;
use scene::{Body, BodyId, BodyKind, Scene};
use surface::parallel;
use surface::progress::Progress;

use crate::bone_field::BoneField;
use crate::candidates::{forced_method, unsuitable};
use crate::cost::count;
use crate::structures::{MissingStructure, Structures};
use crate::{DetectionMethod, ExclusionReason, ForcedMethod, PairPlan, PlanError, StructureKind};

/// Error that each body of a pair may contribute \[tolerances\]: both together meet it.
const TOLERANCE_SHARE: f64 = 0.5;

/// Largest fraction of its vertices that a reduced surface may keep. Below, surfaces that would
/// save time are not used; above, following them costs more than it saves.
const MAX_KEPT: f64 = 0.7;

/// Builder of structures for the pairs of one scene, at one tolerance after another.
pub(crate) struct Builder<'a> {
    scene: &'a Scene,
    margin: f64,
    forced: &'a [ForcedMethod],
    /// Decimations of earlier tolerances, which serve all.
    decimations: BTreeMap<BodyId, Result<Decimation, DecimateError>>,
}

/// Structures under construction, for pairs whose methods may still change.
struct Construction<'p> {
    pairs: &'p mut [PairPlan],
    structures: Structures,
    missing: Vec<MissingStructure>,
    tolerance: f64,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(scene: &'a Scene, margin: f64, forced: &'a [ForcedMethod]) -> Self {
        Self { scene, margin, forced, decimations: BTreeMap::new() }
    }

    /// Builds the structures that pairs need within a tolerance, and lists those that could not
    /// be built, by body.
    ///
    /// Pairs whose structure cannot be built fall back to surfaces.
    pub(crate) fn build(
        &mut self,
        pairs: &mut [PairPlan],
        tolerance: f64,
        progress: Progress<'_>,
    ) -> Result<(Structures, Vec<MissingStructure>), PlanError> {
        // Fields first: where one cannot be built, surfaces of both bodies are compared instead.
        let structures = Structures::new(self.scene.bodies().len());
        let mut made = Construction { pairs, structures, missing: Vec::new(), tolerance };
        self.build_fields(&mut made, progress.part(0.0, 0.5))?;
        self.build_coarse(&mut made, progress.part(0.5, 0.8))?;
        self.build_medials(&mut made, progress.part(0.8, 1.0))?;

        // What has no structure in its place is compared by its own faces.
        made.select_trees();
        made.missing.sort_by_key(|missing| missing.body);
        Ok((made.structures, made.missing))
    }

    /// Builds the fields of rigid bodies. Pairs whose body cannot have one fall back to surfaces.
    fn build_fields(
        &self,
        made: &mut Construction<'_>,
        progress: Progress<'_>,
    ) -> Result<(), PlanError> {
        // A field per bone, whatever the number of its pairs.
        let bones: BTreeSet<BodyId> = made.pairs.iter().filter_map(PairPlan::bone).collect();
        let bones: Vec<BodyId> = bones.into_iter().collect();
        let tolerance = TOLERANCE_SHARE * made.tolerance;
        let fields = parallel::map(bones.len(), |i| {
            let body = self.scene.body(bones[i]);
            BoneField::build(body, tolerance, self.margin, item(progress, i, &bones))
        });

        for (bone, field) in bones.into_iter().zip(fields) {
            match field {
                Ok(field) => made.structures.bodies[bone.index()].field = Some(field),
                Err(ExclusionReason::Field {
                    source: FieldError::Interrupted(interrupted),
                    ..
                }) => return Err(interrupted.into()),
                Err(reason) => self.fall_back(made, bone, reason)?,
            }
        }
        Ok(())
    }

    /// Turns the pairs of a rigid body that cannot have a field to surfaces.
    fn fall_back(
        &self,
        made: &mut Construction<'_>,
        bone: BodyId,
        reason: ExclusionReason,
    ) -> Result<(), PlanError> {
        for pair in made.pairs.iter_mut().filter(|pair| pair.bone() == Some(bone)) {
            if forced_method(self.forced, pair.pair).is_some() {
                return Err(unsuitable(self.scene, pair, reason));
            }
            pair.method = DetectionMethod::Surfaces;
            pair.fallback_reason = Some(reason.clone());
        }
        made.miss(bone, StructureKind::Field, reason);
        Ok(())
    }

    /// Builds the reduced surfaces of bodies whose vertices or faces are compared.
    fn build_coarse(
        &mut self,
        made: &mut Construction<'_>,
        progress: Progress<'_>,
    ) -> Result<(), PlanError> {
        let bodies = made.compared_bodies();
        self.decimate(&bodies, progress.part(0.0, 0.5))?;

        // Each body by itself: the coarsest surface within its share of the tolerance.
        let max_deviation = TOLERANCE_SHARE * made.tolerance;
        let progress = progress.part(0.5, 1.0);
        let built = parallel::map(bodies.len(), |i| {
            coarse_surface(&self.decimations[&bodies[i]], max_deviation, item(progress, i, &bodies))
        });

        // Bodies without one are compared by their own faces.
        for (body, built) in bodies.into_iter().zip(built) {
            let reason = match built {
                Ok(Some(coarse)) => {
                    made.structures.bodies[body.index()].coarse = Some(coarse);
                    continue;
                }
                Ok(None) => ExclusionReason::TooManyVertices { percent: 100.0 * MAX_KEPT },
                Err(DecimateError::Interrupted(interrupted)) => return Err(interrupted.into()),
                Err(error) => ExclusionReason::Decimation(error),
            };
            made.miss(body, StructureKind::Reduced, reason);
        }
        Ok(())
    }

    /// Decimates the bodies that were not decimated for an earlier tolerance.
    fn decimate(&mut self, bodies: &[BodyId], progress: Progress<'_>) -> Result<(), PlanError> {
        // Collapses do not depend on the tolerance.
        let mut bodies = bodies.to_vec();
        bodies.retain(|id| !self.decimations.contains_key(id));
        let decimations = parallel::map(bodies.len(), |i| {
            decimate(self.scene.body(bodies[i]), item(progress, i, &bodies))
        });

        // A surface that cannot be simplified is remembered as such.
        for (id, decimation) in bodies.into_iter().zip(decimations) {
            if let Err(DecimateError::Interrupted(interrupted)) = decimation {
                return Err(interrupted.into());
            }
            self.decimations.insert(id, decimation);
        }
        Ok(())
    }

    /// Builds the medial surfaces of soft bodies, with as few balls as the tolerance allows.
    fn build_medials(
        &self,
        made: &mut Construction<'_>,
        progress: Progress<'_>,
    ) -> Result<(), PlanError> {
        // Balls of soft bodies, each built once.
        let params = MedialParams::tolerance(made.tolerance);
        for pair in made.pairs.iter().filter(|pair| pair.method == DetectionMethod::Medial) {
            for id in pair.pair.bodies() {
                let body = self.scene.body(id);
                let medial = &mut made.structures.bodies[id.index()].medial;
                if medial.is_some() || body.is_rigid() {
                    continue;
                }
                let (surface, x) = (body.surface(), body.checked_positions());
                *medial = match MedialDetector::new(surface, x, self.margin, &params, progress) {
                    Ok(detector) => Some(detector),
                    Err(MedialError::Interrupted(interrupted)) => return Err(interrupted.into()),
                    Err(error) => {
                        let reason = ExclusionReason::Medial(error);
                        return Err(unsuitable(self.scene, pair, reason));
                    }
                };
            }
        }
        Ok(())
    }
}

impl Construction<'_> {
    fn miss(&mut self, body: BodyId, kind: StructureKind, reason: ExclusionReason) {
        self.missing.push(MissingStructure { body, kind, reason });
    }

    /// Returns the bodies whose vertices or faces are compared, ascending.
    fn compared_bodies(&self) -> Vec<BodyId> {
        let mut bodies = BTreeSet::new();
        for planned in &*self.pairs {
            match (planned.method, planned.bone()) {
                (DetectionMethod::Medial, _) => {}
                (_, Some(bone)) => bodies.extend([planned.other(bone)]),
                (_, None) => bodies.extend(planned.pair.bodies()),
            }
        }
        bodies.into_iter().collect()
    }

    /// Selects the bodies whose own faces are compared, and need a tree: bones with a field, and
    /// bodies without a reduced surface in their place.
    fn select_trees(&mut self) {
        for pair in &*self.pairs {
            for id in pair.pair.bodies() {
                let is_reduced = self.structures.coarse(id).is_some();
                self.structures.uses_tree[id.index()] |= match pair.method {
                    DetectionMethod::Field => pair.bone == Some(id) || !is_reduced,
                    DetectionMethod::Surfaces => !is_reduced,
                    DetectionMethod::Medial => true,
                };
            }
        }
    }
}

/// Computes the decimation of a body where it is.
fn decimate(body: &Body, progress: Progress<'_>) -> Result<Decimation, DecimateError> {
    progress.report(0.0)?;
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
    let reduced = decimation.within(max_deviation, progress.part(0.0, 0.9))?;

    // Following a surface of nearly as many vertices would save nothing.
    let vertex_count = decimation.full().surface().vertex_count();
    if count(reduced.kept.len()) > MAX_KEPT * count(vertex_count) {
        return Ok(None);
    }
    CoarseSurface::new(reduced, decimation.full(), progress.part(0.9, 1.0)).map(Some)
}

/// Returns the part of a progress that one of several items completes.
fn item<'a, T>(progress: Progress<'a>, number: usize, items: &[T]) -> Progress<'a> {
    let [from, to] = [number, number + 1].map(|done| count(done) / count(items.len()));
    progress.part(from, to)
}
