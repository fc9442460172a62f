//! Detection of one pair by its method.

use distance_field::{FieldContacts, FieldFeature};
use kdop::Workspace;
use medial::MedialScratch;
use proximity::{ClosestPoint, PairProximity, SurfaceTree, contact};
use scene::{Body, BodyId, PairId, Scene};
use surface::{Contact, ContactSide, Term};

use crate::structures::{ComparedSurface, Structures};
use crate::{DetectionMethod, PairPlan, PlanError};

/// Depth up to which the error of a field is [measured](distance_field::FieldReport) \[spacings\].
/// Deeper values are wrong by more along the medial axis.
const MEASURED_DEPTH: f64 = 2.0;

/// Detector of one pair: its result, and memory that is reused from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct PairDetector {
    workspace: Workspace,
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

    /// Detects a surface by the field of a bone, and the bone's own vertices by the surface.
    ///
    /// Either alone is blind: a field is queried at vertices and edges, which a bone in the middle
    /// of a large face or wholly inside is far from.
    fn detect_by_field(
        &mut self,
        bone: BodyId,
        other: BodyId,
        Frame { scene, structures, margin }: Frame<'_>,
    ) -> Result<(), PlanError> {
        // The other body, reduced or whole, against the field.
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

        // The gap of the pair is that of its vertices; deep ones are projected to the bone itself.
        let Some(bone) = ComparedSurface::whole(scene.body(bone)) else { return Ok(()) };
        let max_depth = MEASURED_DEPTH * detector.field().grid().spacing();
        for found in self.field.contacts() {
            let mut contact = found.contact;
            self.overlaps |= contact.gap < 0.0;
            if matches!(found.feature, FieldFeature::Vertex(_)) {
                if contact.gap < -max_depth {
                    contact = project(&contact, scene.body(other), bone.tree, &mut self.workspace);
                }
                lower(&mut self.min_gap, contact.gap);
            }
            self.contacts.push(contact);
        }

        // The bone's own vertices against the other body.
        self.detect_vertices(&bone, &side, margin);
        Ok(())
    }

    /// Adds the vertices of `a` against the surface of `b`, and where faces cross.
    fn detect_vertices(&mut self, a: &ComparedSurface<'_>, b: &ComparedSurface<'_>, margin: f64) {
        if !are_near(a, b, margin) {
            return;
        }
        self.surfaces.compute_first(a.tree, b.tree, margin);
        self.extend_contacts(0, [a, b]);
        self.overlaps |= self.surfaces.overlaps();
        if let Some(gap) = self.surfaces.min_gap() {
            lower(&mut self.min_gap, gap);
        }
    }

    /// Detects two surfaces, unless one of them is missing or they are apart by their bounds.
    fn detect_by_surfaces(&mut self, sides: [Option<ComparedSurface<'_>>; 2], margin: f64) {
        let [Some(a), Some(b)] = sides else { return };
        if !are_near(&a, &b, margin) {
            return;
        }

        self.surfaces.compute(a.tree, b.tree, margin);
        self.extend_contacts(0, [&a, &b]);
        self.extend_contacts(1, [&b, &a]);
        self.overlaps = self.surfaces.overlaps();
        self.min_gap = self.surfaces.min_gap();
    }

    /// Adds the contacts of one side of the compared pair with the other side.
    fn extend_contacts(&mut self, side: usize, [of, with]: [&ComparedSurface<'_>; 2]) {
        for near in self.surfaces.sides()[side].near() {
            self.contacts.push(contact(&of.contact, &with.contact, near));
        }
    }

    fn detect_by_balls(&mut self, pair: PairId, Frame { scene, structures, .. }: Frame<'_>) {
        let [a, b] = pair.bodies();
        for [body, other] in [[a, b], [b, a]] {
            let Some(balls) = &structures.bodies[other.index()].medial else { continue };
            let sides = [body, other].map(|id| scene.body(id).contact_body());
            let [Some(body), Some(own)] = sides else { continue };
            for found in balls.vertex_contacts(&body, &own, &mut self.medial) {
                lower(&mut self.min_gap, found.contact.gap);
                self.contacts.push(found.contact);
            }
        }
        self.overlaps = self.min_gap.is_some_and(|gap| gap < 0.0);
    }
}

/// Lowers the smallest gap so far to another one.
fn lower(min_gap: &mut Option<f64>, gap: f64) {
    *min_gap = Some(min_gap.map_or(gap, |min_gap| min_gap.min(gap)));
}

/// Projects the vertex of a contact inside a bone to the bone's own surface.
fn project(
    contact: &Contact,
    body: &Body,
    bone: &SurfaceTree,
    workspace: &mut Workspace,
) -> Contact {
    let Some(&Term { particle, .. }) = contact.stencil.terms().first() else { return *contact };
    let vertex = particle - body.particles().start;
    let position = body.positions()[vertex as usize];
    let closest = bone.closest_point(position, f64::INFINITY, None, workspace);
    let Some(ClosestPoint { foot, distance, .. }) = closest else { return *contact };

    // From inside, the normal points to the foot.
    let normal = (foot.point - position).try_normalize().unwrap_or(contact.normal);
    let vertex = [Term { particle, weight: 1.0 }];
    let [on_body, on_bone] = [ContactSide::Particles(&vertex), ContactSide::at_rest(foot.point)];
    Contact::between(on_body, on_bone, normal, -distance)
}

/// Returns true if the bounds of two surfaces come within the margin.
fn are_near(a: &ComparedSurface<'_>, b: &ComparedSurface<'_>, margin: f64) -> bool {
    a.tree.tree().root().inflated(margin).overlaps(&b.tree.tree().root())
}
