//! Detection of one pair by each method.

use decimate::CoarseSurface;
use glam::DVec3;
use proximity::{ContactSurface, ParticleNumbers, SurfaceTree, contact};
use surface::RigidState;

use super::{DetectorScratch, FallbackReason, StepDetectors};
use crate::medial_contacts::{follow, medial_error};
use crate::{Body, BodyId, PairId, Scene, StepError};

/// Gap up to which all vertices were detected, or the reason against the method.
type Detected = Result<f64, FallbackReason>;

/// Surface of a body as it is compared.
#[derive(Clone, Copy)]
struct ComparedSurface<'a> {
    tree: &'a SurfaceTree,
    contact: ContactSurface<'a>,
}

impl StepDetectors {
    /// Detects the vertices of both bodies by surfaces; returns the gap up to which all are found.
    pub(super) fn detect_surfaces(
        &mut self,
        scene: &Scene,
        pair: PairId,
        is_coarse: [bool; 2],
        reach: f64,
    ) -> f64 {
        let [a, b] = pair.bodies();
        let sides = [(a, is_coarse[0]), (b, is_coarse[1])].map(|(id, is_coarse)| {
            let coarse = self.bodies.get(id.index()).and_then(|own| own.coarse.as_ref());
            ComparedSurface::new(scene.body(id), coarse.filter(|_| is_coarse))
        });
        let [Some(a), Some(b)] = sides else { return reach };

        // Vertices of each against the other.
        let DetectorScratch { surfaces, found, .. } = &mut self.scratch;
        surfaces.compute(a.tree, b.tree, reach);
        for (near, [of, on]) in surfaces.sides().into_iter().zip([[a, b], [b, a]]) {
            for near in near.near() {
                found.push(contact(&of.contact, &on.contact, near));
            }
        }
        reach
    }

    /// Detects a pair by coarse surfaces of one body or both.
    pub(super) fn detect_coarse(
        &mut self,
        scene: &Scene,
        pair: PairId,
        reach: f64,
    ) -> Result<Detected, StepError> {
        let mut is_coarse = [false; 2];
        for (id, is_coarse) in pair.bodies().into_iter().zip(&mut is_coarse) {
            let (body, allowed) = (scene.body(id), self.params.tolerance);
            let Some(coarse) = &mut self.structures(id).coarse else { continue };
            *is_coarse = true;
            if let Err(source) = coarse.follow(body.positions()) {
                return Err(StepError::Coarse { name: body.name().to_owned(), source });
            }

            // Vertices leave the points that they follow where the body deforms.
            let measured = largest_distance(coarse, body.positions());
            if measured > allowed {
                let reason = FallbackReason::CoarseDeviation { body: id, measured, allowed };
                return Ok(Err(reason));
            }
        }
        if is_coarse == [false; 2] {
            return Ok(Err(FallbackReason::NoStructure));
        }
        let found = self.detect_surfaces(scene, pair, is_coarse, reach);
        Ok(Ok(found - self.params.tolerance))
    }

    /// Detects a pair by the field of one body.
    pub(super) fn detect_field(&mut self, scene: &Scene, pair: PairId, reach: f64) -> Detected {
        // The first rigid body that has one.
        let [a, b] = pair.bodies();
        let has_field = |id: &BodyId| scene.body(*id).is_rigid() && self.field(*id).is_some();
        let Some(bone) = [a, b].into_iter().find(has_field) else {
            return Err(FallbackReason::NoStructure);
        };
        let pose = scene.body(bone).pose().ok_or(FallbackReason::NoPose)?;
        let other = if bone == a { b } else { a };
        let sides = [bone, other].map(|id| ComparedSurface::new(scene.body(id), None));
        let [Some(bone_side), Some(side)] = sides else { return Ok(reach) };

        // Vertices and edges by the field, and the bone's own vertices, which it does not see.
        let structures = &self.bodies[bone.index()];
        let detector = structures.field.as_ref().ok_or(FallbackReason::NoStructure)?;
        let DetectorScratch { surfaces, field, found, .. } = &mut self.scratch;
        field.compute(detector, &RigidState::at_rest(pose), side.tree, side.contact.particles);
        for of_field in field.contacts() {
            found.push(of_field.contact);
        }
        surfaces.compute_first(bone_side.tree, side.tree, reach);
        for near in surfaces.sides()[0].near() {
            found.push(contact(&bone_side.contact, &side.contact, near));
        }
        Ok(reach.min(detector.margin()))
    }

    /// Detects the vertices of bodies by the balls of the other.
    pub(super) fn detect_balls(
        &mut self,
        scene: &Scene,
        pair: PairId,
        reach: f64,
    ) -> Result<Detected, StepError> {
        // Where both have balls that can be trusted, before anything is added.
        let tolerance = self.params.tolerance;
        let (mut has_balls, mut held) = (false, reach);
        for id in pair.bodies() {
            let body = scene.body(id);
            let Some(balls) = &mut self.structures(id).balls else { continue };
            has_balls = true;
            follow(balls, body)?;
            let allowed = balls.margin() + tolerance;
            let bound = balls.surface_bound(body.surface(), allowed);
            let bound = bound.map_err(|error| medial_error(body, error))?;
            if bound > allowed {
                return Ok(Err(FallbackReason::BallDeviation { body: id, bound, allowed }));
            }
            held = held.min(balls.margin() - bound);
        }
        if !has_balls {
            return Ok(Err(FallbackReason::NoStructure));
        }

        // Balls are trusted: they select, surfaces measure.
        let [a, b] = pair.bodies();
        for [of, on] in [[a, b], [b, a]] {
            let Some(balls) = &self.bodies[on.index()].balls else { continue };
            let sides = [of, on].map(|id| scene.body(id).contact_body());
            let [Some(of), Some(on)] = sides else { continue };
            let DetectorScratch { medial, found, .. } = &mut self.scratch;
            balls.surface_contacts(&of, &on, reach, medial, found);
        }
        Ok(Ok(held))
    }
}

impl<'a> ComparedSurface<'a> {
    /// Returns a body by its coarse surface, where one is given, or by its own; `None` where the
    /// body's tree is not up to date.
    fn new(body: &'a Body, coarse: Option<&'a CoarseSurface>) -> Option<Self> {
        let whole = body.contact_surface();
        let Some(coarse) = coarse else {
            return body.tree().map(|tree| Self { tree, contact: whole });
        };

        // Contacts of a coarse surface are of the vertices that it has kept.
        let tree = coarse.tree();
        let particles = ParticleNumbers { kept: Some(&coarse.reduced().kept), ..whole.particles };
        let (surface, positions) = (tree.surface(), tree.positions());
        let contact = ContactSurface { surface, positions, particles, is_rigid: whole.is_rigid };
        Some(Self { tree, contact })
    }
}

/// Measures how far vertices are from the points of a coarse surface that they follow.
fn largest_distance(coarse: &CoarseSurface, x: &[DVec3]) -> f64 {
    let mut largest: f64 = 0.0;
    for (vertex, p) in (0..).zip(x) {
        let mut led = DVec3::ZERO;
        for (leader, weight) in coarse.leaders(vertex) {
            led += weight * x[leader as usize];
        }
        largest = largest.max(led.distance_squared(*p));
    }
    largest.sqrt()
}
