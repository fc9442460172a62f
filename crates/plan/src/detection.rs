//! One frame of detection by a plan.

use std::ops::Range;

use distance_field::{FieldContacts, FieldFeature};
use proximity::{PairProximity, contact};
use scene::medial_detector::MedialScratch;
use scene::{BodyId, PairId, Scene};
use surface::{Contact, parallel};

use crate::structures::Structures;
use crate::{DetectionMethod, ExclusionReason, PairPlan, Plan, PlanError};

/// Result of one frame; its memory is reused for the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detection {
    contacts: Vec<Contact>,
    pairs: Vec<PairDetection>,
    out_of_range: Vec<BodyId>,
}

/// Result for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairDetection {
    /// The two bodies.
    pub pair: PairId,
    /// True if they overlap, within the measured error of the pair.
    pub overlaps: bool,
    /// Depth of the deepest vertex, `>= 0`; 0 where none is inside. With a field, all vertices of
    /// the other body count; with surfaces, the kept vertices of both.
    pub max_depth: f64,
    /// Smallest gap of a vertex's contact; `None` where no vertex is in contact.
    pub min_gap: Option<f64>,
    /// Range of the pair's contacts among all contacts.
    pub contacts: Range<usize>,
}

/// Result for one pair, with the reused memory of its detection.
#[derive(Debug, Default)]
pub(crate) struct PairScratch {
    surfaces: PairProximity,
    field: FieldContacts,
    medial: MedialScratch,
    contacts: Vec<Contact>,
    overlaps: bool,
    min_gap: Option<f64>,
}

/// Scene and structures of a frame.
#[derive(Clone, Copy)]
struct Frame<'a> {
    scene: &'a Scene,
    structures: &'a Structures,
    margin: f64,
}

impl Detection {
    /// Returns all contacts, pair after pair, with particles numbered by
    /// [`Body::particles`](scene::Body::particles). Rigid bodies are anchors, at rest.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the pairs that have contacts or overlap, in the order of the bodies.
    #[must_use]
    pub fn pairs(&self) -> &[PairDetection] {
        &self.pairs
    }

    /// Returns the bodies that moved farther than the plan allows for. Their contacts with bodies
    /// that were excluded as far apart may be missing.
    #[must_use]
    pub fn out_of_range(&self) -> &[BodyId] {
        &self.out_of_range
    }

    fn clear(&mut self) {
        self.contacts.clear();
        self.pairs.clear();
        self.out_of_range.clear();
    }

    fn add(&mut self, planned: &PairPlan, found: &PairScratch) {
        if found.contacts.is_empty() && !found.overlaps {
            return;
        }
        let start = self.contacts.len();
        self.contacts.extend_from_slice(&found.contacts);
        self.pairs.push(PairDetection {
            pair: planned.pair,
            overlaps: found.overlaps,
            max_depth: found.min_gap.map_or(0.0, |gap| (-gap).max(0.0)),
            min_gap: found.min_gap,
            contacts: start..self.contacts.len(),
        });
    }
}

impl Plan {
    /// Detects every planned pair in the scene's present state.
    ///
    /// After a few frames, nothing is allocated, but for a short list where one body has
    /// thousands of vertices near a bone, and the contacts of balls.
    ///
    /// # Errors
    ///
    /// - [`PlanError::OtherScene`] when the scene has other bodies than planned.
    /// - [`PlanError::NoPose`] where a rigid body with a field was not moved by its pose.
    /// - [`PlanError::Scene`] when a body is too large to build bounds for.
    pub fn detect(&mut self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        self.check_scene(scene)?;
        self.structures.follow(scene)?;
        let Self { pairs, scratch, structures, params, .. } = self;
        let frame = Frame { scene, structures, margin: params.margin };
        parallel::try_for_each_mut(scratch, |number, scratch| {
            scratch.detect(&pairs[number], frame)
        })?;

        out.clear();
        for (pair, found) in self.pairs.iter().zip(&self.scratch) {
            out.add(pair, found);
        }
        out.out_of_range.extend(scene.ids().filter(|&id| self.is_out_of_range(scene, id)));
        Ok(())
    }

    /// Returns true if a body has left the bounds that keep it apart from excluded pairs.
    fn is_out_of_range(&self, scene: &Scene, id: BodyId) -> bool {
        let is_far = |reason: &ExclusionReason| matches!(reason, ExclusionReason::FarApart { .. });
        let mut excluded = self.excluded_pairs.iter().filter(|excluded| excluded.pair.contains(id));
        if !excluded.any(|excluded| is_far(&excluded.reason)) {
            return false;
        }
        let bounds = self.bodies[id.index()].bounds.inflate(self.params.max_displacement);
        scene.body(id).positions().iter().any(|&p| !bounds.contains(p))
    }
}

impl PairScratch {
    /// Detects a pair by its method.
    fn detect(&mut self, planned: &PairPlan, frame: Frame<'_>) -> Result<(), PlanError> {
        self.contacts.clear();
        (self.overlaps, self.min_gap) = (false, None);
        match (planned.method, planned.bone()) {
            (DetectionMethod::Field, None) => {}
            (DetectionMethod::Field, Some(bone)) => {
                self.detect_by_field(bone, planned.other(bone), frame)?;
            }
            (DetectionMethod::Surfaces, _) => self.detect_by_surfaces(planned.pair, frame),
            (DetectionMethod::Medial, _) => self.detect_by_balls(planned.pair, frame),
        }
        Ok(())
    }

    fn detect_by_field(
        &mut self,
        bone: BodyId,
        other: BodyId,
        Frame { scene, structures, .. }: Frame<'_>,
    ) -> Result<(), PlanError> {
        let detector = structures.field_detector(scene, bone)?;
        let Some((detector, state)) = detector else { return Ok(()) };
        let Some(tree) = structures.tree(scene, other) else { return Ok(()) };
        let particles = structures.contact_surface(scene, other).particles;
        self.field.compute(detector, &state, tree, particles);
        if let Some(coarse) = structures.coarse(other) {
            // The deepest vertex may be one that the reduced surface has not kept.
            let whole = scene.body(other).contact_surface();
            let represented = |face| coarse.attached_to(face);
            let (fine, particles) = (whole.positions, whole.particles);
            self.field.add_deepest(detector, &state, fine, particles, represented);
        }

        let mut min_vertex_gap = f64::INFINITY;
        for found in self.field.contacts() {
            self.contacts.push(found.contact);
            self.overlaps |= found.contact.gap < 0.0;
            if matches!(found.feature, FieldFeature::Vertex(_)) {
                min_vertex_gap = min_vertex_gap.min(found.contact.gap);
            }
        }
        self.min_gap = (min_vertex_gap < f64::INFINITY).then_some(min_vertex_gap);
        Ok(())
    }

    fn detect_by_surfaces(
        &mut self,
        PairId { a, b, .. }: PairId,
        Frame { scene, structures, margin }: Frame<'_>,
    ) {
        let trees = structures.tree(scene, a).zip(structures.tree(scene, b));
        let Some((tree_a, tree_b)) = trees else { return };
        let bounds = tree_a.tree().root().inflated(margin);
        if !bounds.overlaps(&tree_b.tree().root()) {
            return;
        }

        self.surfaces.compute(tree_a, tree_b, margin);
        let [of_a, of_b] = self.surfaces.sides();
        let [a, b] = [a, b].map(|id| structures.contact_surface(scene, id));
        self.contacts.extend(of_a.near().iter().map(|near| contact(&a, &b, near)));
        self.contacts.extend(of_b.near().iter().map(|near| contact(&b, &a, near)));
        self.overlaps = self.surfaces.overlaps();
        self.min_gap = self.surfaces.min_gap();
    }

    fn detect_by_balls(
        &mut self,
        PairId { a, b, .. }: PairId,
        Frame { scene, structures, .. }: Frame<'_>,
    ) {
        for [body, other] in [[a, b], [b, a]] {
            let Some(balls) = &structures.bodies[other.index()].medial else { continue };
            let found = balls.contacts(scene, body, &mut self.medial);
            self.contacts.extend(found.iter().map(|found| found.contact));
        }
        self.min_gap = self.contacts.iter().map(|contact| contact.gap).min_by(f64::total_cmp);
        self.overlaps = self.min_gap.is_some_and(|gap| gap < 0.0);
    }
}
