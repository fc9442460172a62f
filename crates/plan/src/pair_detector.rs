//! Detection of one pair by its method.

use distance_field::{FieldContacts, FieldFeature};
use proximity::{PairProximity, contact};
use scene::medial_detector::MedialScratch;
use scene::{BodyId, PairId, Scene};
use surface::Contact;

use crate::structures::{ComparedSurface, Structures};
use crate::{DetectionMethod, PairPlan, PlanError};

/// Detector of one pair: its result, and memory that is reused from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct PairDetector {
    surfaces: PairProximity,
    field: FieldContacts,
    medial: MedialScratch,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) overlaps: bool,
    pub(crate) min_gap: Option<f64>,
}

/// Scene and structures of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) structures: &'a Structures,
    pub(crate) margin: f64,
}

impl PairDetector {
    /// Detects a pair by its method.
    pub(crate) fn detect(&mut self, planned: &PairPlan, frame: Frame<'_>) -> Result<(), PlanError> {
        self.clear();
        match (planned.method, planned.bone()) {
            (DetectionMethod::Field, None) => {}
            (DetectionMethod::Field, Some(bone)) => {
                self.detect_by_field(bone, planned.other(bone), frame)?;
            }
            (DetectionMethod::Surfaces, _) => {
                let [a, b] = planned.pair.bodies();
                let sides = [a, b].map(|id| frame.structures.compared(frame.scene, id));
                self.detect_by_surfaces(sides, frame.margin);
            }
            (DetectionMethod::Medial, _) => self.detect_by_balls(planned.pair, frame),
        }
        Ok(())
    }

    /// Detects a pair that is not in the plan, by the surfaces of both bodies as they are.
    pub(crate) fn detect_unplanned(&mut self, pair: PairId, scene: &Scene, margin: f64) {
        self.clear();
        let sides = pair.bodies().map(|id| ComparedSurface::whole(scene.body(id)));
        self.detect_by_surfaces(sides, margin);
    }

    fn clear(&mut self) {
        self.contacts.clear();
        (self.overlaps, self.min_gap) = (false, None);
    }

    fn detect_by_field(
        &mut self,
        bone: BodyId,
        other: BodyId,
        Frame { scene, structures, .. }: Frame<'_>,
    ) -> Result<(), PlanError> {
        let detector = structures.field_detector(scene, bone)?;
        let Some((detector, state)) = detector else { return Ok(()) };
        let Some(side) = structures.compared(scene, other) else { return Ok(()) };
        self.field.compute(detector, &state, side.tree, side.contact.particles);

        // The deepest vertex may be one that the reduced surface has not kept.
        if let Some(coarse) = structures.coarse(other) {
            let whole = scene.body(other).contact_surface();
            let represented = |face| coarse.attached_to(face);
            let (fine, particles) = (whole.positions, whole.particles);
            self.field.add_deepest(detector, &state, fine, particles, represented);
        }

        // The gap of the pair is that of its vertices.
        let mut min_gap = f64::INFINITY;
        for found in self.field.contacts() {
            self.contacts.push(found.contact);
            self.overlaps |= found.contact.gap < 0.0;
            if matches!(found.feature, FieldFeature::Vertex(_)) {
                min_gap = min_gap.min(found.contact.gap);
            }
        }
        self.min_gap = (min_gap < f64::INFINITY).then_some(min_gap);
        Ok(())
    }

    /// Detects two surfaces, unless one of them is missing or they are apart by their bounds.
    fn detect_by_surfaces(&mut self, sides: [Option<ComparedSurface<'_>>; 2], margin: f64) {
        let [Some(a), Some(b)] = sides else { return };
        if !a.tree.tree().root().inflated(margin).overlaps(&b.tree.tree().root()) {
            return;
        }

        self.surfaces.compute(a.tree, b.tree, margin);
        let [of_a, of_b] = self.surfaces.sides();
        self.contacts.extend(of_a.near().iter().map(|near| contact(&a.contact, &b.contact, near)));
        self.contacts.extend(of_b.near().iter().map(|near| contact(&b.contact, &a.contact, near)));
        self.overlaps = self.surfaces.overlaps();
        self.min_gap = self.surfaces.min_gap();
    }

    fn detect_by_balls(&mut self, pair: PairId, Frame { scene, structures, .. }: Frame<'_>) {
        let [a, b] = pair.bodies();
        for [body, other] in [[a, b], [b, a]] {
            let Some(balls) = &structures.bodies[other.index()].medial else { continue };
            let found = balls.contacts(scene, body, &mut self.medial);
            self.contacts.extend(found.iter().map(|found| found.contact));
        }
        self.min_gap = self.contacts.iter().map(|contact| contact.gap).min_by(f64::total_cmp);
        self.overlaps = self.min_gap.is_some_and(|gap| gap < 0.0);
    }
}
