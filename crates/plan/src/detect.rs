//! A frame of detection as planned.

use std::ops::Range;

use distance_field::FieldContacts;
use surface::Contact;

use super::structures::Structures;
use super::{PairPlan, Plan};
use crate::{DetectionMethod, ExclusionReason, PlanError};
use proximity::{PairProximity, contact};
use scene::medial_detector::MedialScratch;
use scene::{BodyId, FieldFeature, Scene};
use surface::parallel;

/// What was found in one frame; its memory is used again for the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detection {
    contacts: Vec<Contact>,
    pairs: Vec<PairDetection>,
    out_of_range: Vec<BodyId>,
}

/// What was found between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairDetection {
    /// The first body.
    pub a: BodyId,
    /// The second body, of the higher number.
    pub b: BodyId,
    /// Whether they overlap, by what the plan knows of them.
    pub overlaps: bool,
    /// Depth of the deepest vertex, `>= 0`; 0 where none is inside. By a bone's
    /// field, of all of the other body's vertices in the bone; by surfaces, of those
    /// of both that are looked at.
    pub max_depth: f64,
    /// Smallest gap of a contact; `None` where there is no contact.
    pub min_gap: Option<f64>,
    /// Which of the contacts are of this pair.
    pub contacts: Range<usize>,
}

/// What one pair found, and the memory for that.
#[derive(Debug, Default)]
pub(super) struct PairWork {
    surfaces: PairProximity,
    field: FieldContacts,
    medial: MedialScratch,
    contacts: Vec<Contact>,
    overlaps: bool,
    min_gap: Option<f64>,
}

/// What all pairs of a frame are looked at with.
struct Frame<'a> {
    scene: &'a Scene,
    structures: &'a Structures,
    margin: f64,
}

impl Detection {
    /// All contacts, pair after pair, with particles numbered by
    /// [`Body::particles`](scene::Body::particles). Rigid bodies are anchors, at
    /// rest.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The pairs that have contacts or overlap, in the order of the bodies.
    #[must_use]
    pub fn pairs(&self) -> &[PairDetection] {
        &self.pairs
    }

    /// Bodies that went farther than the plan allows for: contacts of theirs
    /// with bodies that were left out as far apart may be missing.
    #[must_use]
    pub fn out_of_range(&self) -> &[BodyId] {
        &self.out_of_range
    }

    fn clear(&mut self) {
        self.contacts.clear();
        self.pairs.clear();
        self.out_of_range.clear();
    }

    fn add(&mut self, pair: &PairPlan, work: &PairWork) {
        if work.contacts.is_empty() && !work.overlaps {
            return;
        }
        let start = self.contacts.len();
        self.contacts.extend_from_slice(&work.contacts);
        self.pairs.push(PairDetection {
            a: pair.a,
            b: pair.b,
            overlaps: work.overlaps,
            max_depth: work.min_gap.map_or(0.0, |gap| (-gap).max(0.0)),
            min_gap: work.min_gap,
            contacts: start..self.contacts.len(),
        });
    }
}

impl Plan {
    /// Looks at every planned pair in the scene's present state. Once the memory
    /// of a few frames has been taken, nothing is allocated, but for a short list
    /// where one body has thousands of vertices near a bone, and what balls find.
    ///
    /// # Errors
    ///
    /// - [`PlanError::OtherScene`] when the scene has other bodies than planned.
    /// - [`PlanError::NoPose`] where a bone was not moved by its pose.
    /// - [`PlanError::Scene`] when a body is too large to build bounds for.
    pub fn detect(&mut self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        self.check_scene(scene)?;
        self.structures.follow(scene)?;
        let scene = &*scene;
        let Self { pairs, work, structures, params, .. } = self;
        let frame = Frame { scene, structures, margin: params.margin };
        parallel::try_for_each_mut(work, |number, work| work.look(&pairs[number], &frame))?;
        out.clear();
        for (pair, work) in self.pairs.iter().zip(&self.work) {
            out.add(pair, work);
        }
        out.out_of_range.extend(scene.ids().filter(|&id| self.is_out_of_range(scene, id)));
        Ok(())
    }

    /// Whether a body has left the room that keeps it from pairs left out.
    fn is_out_of_range(&self, scene: &Scene, id: BodyId) -> bool {
        let is_far = |reason: &ExclusionReason| matches!(reason, ExclusionReason::FarApart { .. });
        let of_body = self.excluded_pairs.iter().filter(|pair| pair.a == id || pair.b == id);
        let mut far = of_body.filter(|pair| is_far(&pair.reason));
        far.next().is_some() && {
            let [lo, hi] = self.bodies[id.index()].start;
            let (lo, hi) = (lo - self.params.max_displacement, hi + self.params.max_displacement);
            let outside = |p: &glam::DVec3| p.cmplt(lo).any() || p.cmpgt(hi).any();
            scene.body(id).positions().iter().any(outside)
        }
    }
}

impl PairWork {
    fn look(&mut self, pair: &PairPlan, frame: &Frame<'_>) -> Result<(), PlanError> {
        self.contacts.clear();
        (self.overlaps, self.min_gap) = (false, None);
        match pair.method {
            DetectionMethod::Field => self.ask_field(pair, frame),
            DetectionMethod::Surfaces => {
                self.compare_surfaces([pair.a, pair.b], frame);
                Ok(())
            }
            DetectionMethod::Medial => {
                self.ask_balls([pair.a, pair.b], frame);
                Ok(())
            }
        }
    }

    fn ask_balls(&mut self, [a, b]: [BodyId; 2], frame: &Frame<'_>) {
        let Frame { scene, structures, .. } = *frame;
        for [asked, of] in [[a, b], [b, a]] {
            let Some(balls) = &structures.medials[of.index()] else { continue };
            let found = balls.contacts(scene, asked, &mut self.medial);
            self.contacts.extend(found.iter().map(|found| found.contact));
        }
        self.min_gap = self.contacts.iter().map(|contact| contact.gap).min_by(f64::total_cmp);
        self.overlaps = self.min_gap.is_some_and(|gap| gap < 0.0);
    }

    fn ask_field(&mut self, pair: &PairPlan, frame: &Frame<'_>) -> Result<(), PlanError> {
        let Frame { scene, structures, .. } = *frame;
        let bone = (pair.bone, scene.body(pair.bone));
        let Some((detector, state)) = structures.detector(bone)? else {
            return Ok(());
        };
        let other = pair.other();
        let Some(tree) = structures.tree(scene, other) else { return Ok(()) };
        let particles = structures.contact_surface(scene, other).particles;
        self.field.compute(detector, &state, tree, particles);
        if let Some(level) = structures.level(other) {
            // A deepest vertex may be one that the level has not kept.
            let whole = scene.body(other).contact_surface();
            let attached = |face| level.attached_to(face);
            self.field.add_deepest(detector, &state, whole.positions, whole.particles, attached);
        }

        let found = self.field.contacts();
        self.contacts.extend(found.iter().map(|found| found.contact));
        self.overlaps = found.iter().any(|found| found.contact.gap < 0.0);
        let of_vertices =
            found.iter().filter(|found| matches!(found.feature, FieldFeature::Vertex(_)));
        self.min_gap = of_vertices.map(|found| found.contact.gap).min_by(f64::total_cmp);
        Ok(())
    }

    fn compare_surfaces(&mut self, [a, b]: [BodyId; 2], frame: &Frame<'_>) {
        let Frame { scene, structures, margin } = *frame;
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
}
