//! From a need to methods, and from methods to what they need.

use std::collections::BTreeMap;

use decimate::{CoarseSurface, DecimateError, Decimation};
use glam::DVec3;
use kdop::Dop18;
use proximity::SurfaceTree;
use surface::progress::Progress;

use super::bone::BoneField;
use super::cost::OperationCounts;
use super::structures::Structures;
use super::{ExcludedPair, PairPlan, PlanParams, count};
use crate::{DetectionMethod, ExclusionReason, PlanError, StructureKind};
use scene::Body;
use scene::{BodyId, BodyKind, MedialDetector, PairId, Scene, SceneError};
use surface::parallel;

/// Share of the tolerance that each body of a pair may deviate by.
const SHARE: f64 = 0.5;

/// Pairs with their methods, and what was built for them.
pub(super) struct Made {
    pub(super) pairs: Vec<PairPlan>,
    pub(super) structures: Structures,
    pub(super) far: Vec<ExcludedPair>,
    pub(super) not_built: Vec<(BodyId, StructureKind, ExclusionReason)>,
    /// To follow all bodies.
    pub(super) follow: OperationCounts,
}

/// Makes plans for one scene; what does not depend on the tolerance is kept.
pub(super) struct Maker<'a> {
    scene: &'a Scene,
    params: &'a PlanParams,
    forced: &'a [(BodyId, BodyId, DetectionMethod)],
    decimations: BTreeMap<BodyId, Result<Decimation, DecimateError>>,
}

impl<'a> Maker<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        params: &'a PlanParams,
        forced: &'a [(BodyId, BodyId, DetectionMethod)],
    ) -> Self {
        Self { scene, params, forced, decimations: BTreeMap::new() }
    }

    /// A plan for a tolerance.
    pub(super) fn make(&mut self, tolerance: f64) -> Result<Made, PlanError> {
        let mut structures = Structures::none(self.scene.bodies().len());
        let mut not_built = Vec::new();
        let (mut pairs, far) = self.candidates();
        self.check_forced(&pairs)?;
        self.build_fields(SHARE * tolerance, &mut pairs, &mut structures, &mut not_built)?;
        self.build_levels(SHARE * tolerance, &pairs, &mut structures, &mut not_built);
        self.build_medials(tolerance, &pairs, &mut structures)?;
        self.note_trees(&pairs, &mut structures, &mut not_built);
        let boxes = boxes(self.scene);
        for pair in &mut pairs {
            pair.error_bound = match pair.method {
                DetectionMethod::Field => {
                    let field = structures.fields[pair.bone.index()].as_ref();
                    let field = field.map_or(0.0, |field| field.error_bound);
                    field + structures.deviation(pair.other())
                }
                DetectionMethod::Surfaces => {
                    structures.deviation(pair.a) + structures.deviation(pair.b)
                }
                DetectionMethod::Medial => {
                    structures.medial_deviation(pair.a).max(structures.medial_deviation(pair.b))
                }
            };
            pair.work = self.pair_work(pair, &structures, &boxes);
            pair.cost = self.params.machine_factor * pair.work.seconds();
        }
        let follow = self.follow_work(&structures);
        Ok(Made { pairs, structures, far, not_built, follow })
    }

    /// Pairs to look at with the method that is best if it can be had, and those
    /// that are left out.
    fn candidates(&self) -> (Vec<PairPlan>, Vec<ExcludedPair>) {
        let (scene, boxes) = (self.scene, boxes(self.scene));
        let room = self.params.margin + 2.0 * self.params.max_displacement;
        let (mut pairs, mut far) = (Vec::new(), Vec::new());
        for a in scene.ids() {
            for b in scene.ids().skip(a.index() + 1) {
                let kinds = [a, b].map(|id| scene.body(id).kind());
                let distance = separation(&boxes[a.index()], &boxes[b.index()]);
                let reason = if scene.is_ignored(PairId::new(a, b)) {
                    Some(ExclusionReason::Ignored)
                } else if kinds == [BodyKind::Rigid; 2] && self.forced(a, b).is_none() {
                    Some(ExclusionReason::BothRigid)
                } else {
                    (distance > room).then_some(ExclusionReason::FarApart { distance })
                };
                match reason {
                    Some(reason) => far.push(ExcludedPair { a, b, reason }),
                    None => pairs.push(self.first_choice(a, b)),
                }
            }
        }
        (pairs, far)
    }

    fn first_choice(&self, a: BodyId, b: BodyId) -> PairPlan {
        let is_bone = |id: BodyId| {
            let body = self.scene.body(id);
            body.kind() == BodyKind::Rigid && body.has_inside().is_ok()
        };
        let method = self.forced(a, b);
        let default = if is_bone(a) || is_bone(b) {
            DetectionMethod::Field
        } else {
            DetectionMethod::Surfaces
        };
        let bone = if is_bone(a) { a } else { b };
        let is_open = |id: BodyId| self.scene.body(id).has_inside().is_err();
        let reason =
            if is_open(a) || is_open(b) { ExclusionReason::Open } else { ExclusionReason::NoBone };
        let fallback_reason = (default == DetectionMethod::Surfaces).then_some(reason);
        PairPlan {
            a,
            b,
            method: method.unwrap_or(default),
            bone,
            fallback_reason,
            error_bound: 0.0,
            work: OperationCounts::default(),
            cost: 0.0,
        }
    }

    fn forced(&self, a: BodyId, b: BodyId) -> Option<DetectionMethod> {
        let is_pair =
            |&&(p, q, _): &&(BodyId, BodyId, DetectionMethod)| (p.min(q), p.max(q)) == (a, b);
        self.forced.iter().find(is_pair).map(|&(.., method)| method)
    }

    fn check_forced(&self, pairs: &[PairPlan]) -> Result<(), PlanError> {
        for pair in pairs {
            let is_rigid = |id: BodyId| self.scene.body(id).kind() == BodyKind::Rigid;
            if pair.method == DetectionMethod::Field && pair.fallback_reason.is_some() {
                return Err(self.refuse(pair, ExclusionReason::NoBone));
            }
            if pair.method == DetectionMethod::Medial && is_rigid(pair.a) && is_rigid(pair.b) {
                return Err(self.refuse(pair, ExclusionReason::BothRigid));
            }
        }
        Ok(())
    }

    fn refuse(&self, pair: &PairPlan, reason: ExclusionReason) -> PlanError {
        let [a, b] = [pair.a, pair.b].map(|id| self.scene.body(id).name().to_owned());
        PlanError::Forced { a, b, method: pair.method.to_string(), reason }
    }

    /// Builds the fields of bones, and turns pairs whose bone cannot have one to
    /// surfaces.
    fn build_fields(
        &self,
        tolerance: f64,
        pairs: &mut [PairPlan],
        structures: &mut Structures,
        not_built: &mut Vec<(BodyId, StructureKind, ExclusionReason)>,
    ) -> Result<(), PlanError> {
        let of_field = pairs.iter().filter(|pair| pair.method == DetectionMethod::Field);
        let bones = ascending(of_field.map(|pair| pair.bone));
        let built = parallel::map_slice_with(
            &bones,
            || (),
            |(), &bone| BoneField::build(self.scene.body(bone), tolerance, self.params.margin),
        );
        for (&bone, built) in bones.iter().zip(built) {
            match built {
                Ok(field) => structures.fields[bone.index()] = Some(field),
                Err(reason) => {
                    let of_bone = |pair: &&mut PairPlan| {
                        pair.method == DetectionMethod::Field && pair.bone == bone
                    };
                    for pair in pairs.iter_mut().filter(of_bone) {
                        if self.forced(pair.a, pair.b).is_some() {
                            return Err(self.refuse(pair, reason));
                        }
                        pair.method = DetectionMethod::Surfaces;
                        pair.fallback_reason = Some(reason.clone());
                    }
                    not_built.push((bone, StructureKind::Field, reason));
                }
            }
        }
        Ok(())
    }

    fn build_levels(
        &mut self,
        deviation: f64,
        pairs: &[PairPlan],
        structures: &mut Structures,
        not_built: &mut Vec<(BodyId, StructureKind, ExclusionReason)>,
    ) {
        let of_surfaces = pairs.iter().filter(|pair| pair.method != DetectionMethod::Medial);
        let bodies = ascending(of_surfaces.flat_map(|pair| match pair.bone() {
            Some(_) => [pair.other(); 2],
            None => [pair.a, pair.b],
        }));
        self.decimate(&bodies);
        let decimations = &self.decimations;
        let built = parallel::map_slice_with(
            &bodies,
            || (),
            |(), id| match &decimations[id] {
                Err(error) => Err(error.clone()),
                Ok(decimation) => coarse_surface(decimation, deviation),
            },
        );
        for (&id, built) in bodies.iter().zip(built) {
            let reason = match built {
                Ok(Some(level)) => {
                    structures.levels[id.index()] = Some(level);
                    continue;
                }
                Ok(None) => ExclusionReason::SavesLittle,
                Err(error) => ExclusionReason::Decimation { reason: error.to_string() },
            };
            not_built.push((id, StructureKind::Reduced, reason));
        }
    }

    /// Builds the balls of what is not a bone, with as few as the tolerance allows.
    fn build_medials(
        &self,
        tolerance: f64,
        pairs: &[PairPlan],
        structures: &mut Structures,
    ) -> Result<(), PlanError> {
        for pair in pairs.iter().filter(|pair| pair.method == DetectionMethod::Medial) {
            let yields = |id: &BodyId| self.scene.body(*id).kind() != BodyKind::Rigid;
            for id in [pair.a, pair.b].into_iter().filter(yields) {
                let built = &mut structures.medials[id.index()];
                if built.is_some() {
                    continue;
                }
                let params = medial::MedialParams::tolerance(tolerance);
                let made = MedialDetector::new(self.scene, id, self.params.margin, &params, |_| {});
                let refuse = |error: SceneError| {
                    self.refuse(pair, ExclusionReason::Medial { reason: error.to_string() })
                };
                *built = Some(made.map_err(refuse)?);
            }
        }
        Ok(())
    }

    /// Finds the orders of collapse that are not known yet.
    fn decimate(&mut self, bodies: &[BodyId]) {
        let known = |id: &&BodyId| !self.decimations.contains_key(id);
        let missing: Vec<BodyId> = bodies.iter().filter(known).copied().collect();
        let found = parallel::map_slice_with(
            &missing,
            || (),
            |(), &id| {
                let body = self.scene.body(id);
                let full = SurfaceTree::new(body.surface().clone(), body.positions().to_vec())?;
                let is_open = body.kind() == BodyKind::Open;
                let full = if is_open { full.declared_open() } else { full };
                Decimation::new(full, Progress::none())
            },
        );
        self.decimations.extend(missing.into_iter().zip(found));
    }

    /// Which bodies need a tree over their own faces: those whose faces are looked
    /// at and that no level stands for.
    fn note_trees(
        &self,
        pairs: &[PairPlan],
        structures: &mut Structures,
        not_built: &mut Vec<(BodyId, StructureKind, ExclusionReason)>,
    ) {
        for pair in pairs {
            for id in [pair.a, pair.b] {
                let number = id.index();
                structures.trees[number] |= match pair.method {
                    DetectionMethod::Field if id == pair.bone => false,
                    DetectionMethod::Field | DetectionMethod::Surfaces => {
                        structures.levels[number].is_none()
                    }
                    DetectionMethod::Medial => true,
                };
            }
        }
        for id in self.scene.ids().filter(|id| !structures.trees[id.index()]) {
            not_built.push((id, StructureKind::Tree, ExclusionReason::NotNeeded));
        }
        not_built.sort_by_key(|&(id, ..)| id);
    }

    /// To follow the bodies.
    fn follow_work(&self, structures: &Structures) -> OperationCounts {
        let own = |(body, wanted): (&Body, &bool)| {
            if *wanted { count(body.surface().faces().len()) } else { 0.0 }
        };
        let own: f64 = self.scene.bodies().iter().zip(&structures.trees).map(own).sum();
        let levels = structures.levels.iter().flatten();
        let coarse: f64 = levels.map(|level| count(level.tree().surface().faces().len())).sum();
        let with_balls = self.scene.ids().filter(|id| structures.medials[id.index()].is_some());
        let tied_vertices = with_balls.map(|id| count(self.scene.body(id).positions().len())).sum();
        OperationCounts { refit_faces: own + coarse, tied_vertices, ..OperationCounts::default() }
    }

    fn pair_work(
        &self,
        pair: &PairPlan,
        structures: &Structures,
        boxes: &[Dop18],
    ) -> OperationCounts {
        let within = |points: &[DVec3], of: BodyId| {
            let bounds = boxes[of.index()].inflated(self.params.margin);
            let inside = |&&p: &&DVec3| bounds.overlaps(&Dop18::from_points(&[p]));
            count(points.iter().filter(inside).count())
        };
        match pair.method {
            DetectionMethod::Field => {
                let points =
                    structures.contact_surface(self.scene, pair.other()).positions.as_slice();
                OperationCounts {
                    field_vertices: within(points, pair.bone),
                    ..OperationCounts::default()
                }
            }
            DetectionMethod::Surfaces => {
                let [a, b] = [pair.a, pair.b].map(|id| structures.contact_surface(self.scene, id));
                let compared_faces = count(a.surface.faces().len() + b.surface.faces().len());
                OperationCounts { compared_faces, ..OperationCounts::default() }
            }
            DetectionMethod::Medial => {
                let near = |asked: BodyId, of: BodyId| {
                    let is_asked = structures.medials[of.index()].is_some();
                    let points = self.scene.body(asked).positions();
                    if is_asked { within(points, of) } else { 0.0 }
                };
                let ball_vertices = near(pair.a, pair.b) + near(pair.b, pair.a);
                OperationCounts { ball_vertices, ..OperationCounts::default() }
            }
        }
    }
}

/// Share of its vertices above which a body is used as it is.
const WORTHWHILE: f64 = 0.7;

/// Builds the coarsest surface within a deviation; `None` where that would save little.
fn coarse_surface(
    decimation: &Decimation,
    max_deviation: f64,
) -> Result<Option<CoarseSurface>, DecimateError> {
    let reduced = decimation.within(max_deviation, Progress::none())?;
    let vertices = decimation.full().surface().vertex_count();
    if count(reduced.kept.len()) > WORTHWHILE * count(vertices) {
        return Ok(None);
    }
    CoarseSurface::new(reduced, decimation.full()).map(Some)
}

fn boxes(scene: &Scene) -> Vec<Dop18> {
    scene.bodies().iter().map(|body| Dop18::from_points(body.positions())).collect()
}

/// Largest gap between two bounds along one of their directions: no two points
/// of them are nearer.
fn separation(a: &Dop18, b: &Dop18) -> f64 {
    let axis = |k: usize| {
        let [p, q] = [a, b].map(|bounds| bounds.interval(k).map(f64::from));
        (q[0] - p[1]).max(p[0] - q[1]) / kdop::norm::<9>(k)
    };
    (0..9).map(axis).fold(0.0, f64::max)
}

fn ascending(ids: impl Iterator<Item = BodyId>) -> Vec<BodyId> {
    let mut ids: Vec<BodyId> = ids.collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}
