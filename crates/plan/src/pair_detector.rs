//! Detection of one pair by its method.

use distance_field::{FieldContacts, FieldFeature};
use glam::DVec3;
use kdop::Workspace;
use medial::MedialScratch;
use proximity::{ClosestPoint, PairProximity, SurfaceTree, contact};
use scene::{Body, BodyId, DepthBracket, PairId, Scene, SceneError};
use surface::{Contact, ContactSide, Term};

use crate::bone_field::MAX_DEPTH;
use crate::box_depth::max_depth_by_face_boxes;
use crate::compared::ComparedSurface;
use crate::cost::{count, far_share};
use crate::motion::LastDepth;
use crate::rounding::{check_pair_rounding, rounding};
use crate::structures::Structures;
use crate::surface_depth::{Compared, FoundDepth, SurfaceDepth};
use crate::{
    DetectionMethod, OperationCounts, PairDetection, PairPlan, PairState, PlanError, PlanParams,
};

/// Detector of one pair: its result, and memory that is reused from frame to frame.
#[derive(Debug)]
pub(crate) struct PairDetector {
    workspace: Workspace,
    surfaces: PairProximity,
    depth: SurfaceDepth,
    field: FieldContacts,
    medial: MedialScratch,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) found: PairDetection,
    /// Operations of the last detection.
    pub(crate) operations: OperationCounts,
    /// True once the operations of a frame are counted.
    pub(crate) is_counted: bool,
    /// Bound on the depth of the last detection, in frames under a budget.
    pub(crate) last: Option<LastDepth>,
}

/// Scene and structures of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) structures: &'a Structures,
    pub(crate) margin: f64,
    pub(crate) tolerance: f64,
    /// Share of the operations that are far from any cache.
    far_share: f64,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(scene: &'a Scene, structures: &'a Structures, params: &PlanParams) -> Self {
        let PlanParams { margin, tolerance, .. } = *params;
        Self { scene, structures, margin, tolerance, far_share: far_share(scene) }
    }
}

impl PairDetector {
    pub(crate) fn new(pair: PairId) -> Self {
        Self {
            workspace: Workspace::default(),
            surfaces: PairProximity::default(),
            depth: SurfaceDepth::default(),
            field: FieldContacts::default(),
            medial: MedialScratch::default(),
            contacts: Vec::new(),
            found: apart(pair),
            operations: OperationCounts::default(),
            is_counted: false,
            last: None,
        }
    }

    /// Detects a pair by its method; coarse surfaces only as far as they deviate little enough.
    pub(crate) fn detect(&mut self, planned: &PairPlan, frame: Frame<'_>) -> Result<(), PlanError> {
        self.clear(planned.method);
        // It may be ignored since it was planned.
        if frame.scene.is_ignored(planned.pair) {
            return Ok(());
        }
        match (planned.method, planned.bone) {
            (DetectionMethod::Field, Some(bone)) => {
                self.detect_by_field(bone, planned.other(bone), frame)?;
            }
            (DetectionMethod::Balls, _) => self.detect_by_balls(planned.pair, frame),
            _ if frame.structures.are_apart(planned.pair, frame.margin) => {}
            _ => {
                let is_coarse =
                    frame.structures.coarse_sides(frame.scene, planned, frame.tolerance);
                if is_coarse == [false; 2] {
                    self.found.method = DetectionMethod::Exact;
                }
                self.detect_by_surfaces(planned.pair, is_coarse, frame)?;
            }
        }
        Ok(())
    }

    /// Detects a pair by the surfaces of both bodies as they are.
    pub(crate) fn detect_exactly(
        &mut self,
        pair: PairId,
        frame: Frame<'_>,
    ) -> Result<(), PlanError> {
        self.clear(DetectionMethod::Exact);
        self.detect_by_surfaces(pair, [false; 2], frame)
    }

    /// Returns the number of vertices of each body that were projected to the other one.
    pub(crate) fn near_counts(&self) -> [f64; 2] {
        self.surfaces.sides().map(|side| count(side.near().len()))
    }

    /// Returns true if the last detection found no face of both bodies that meet, and no contact.
    pub(crate) fn holds_nothing(&self) -> bool {
        let is_apart = self.found.state == PairState::Apart;
        is_apart && self.contacts.is_empty() && self.operations.meeting_faces <= 0.0
    }

    fn clear(&mut self, method: DetectionMethod) {
        self.contacts.clear();
        self.operations = OperationCounts::default();
        self.found = PairDetection { method, ..apart(self.found.pair) };
    }

    /// Detects two surfaces, each whole or coarse.
    fn detect_by_surfaces(
        &mut self,
        pair: PairId,
        is_coarse: [bool; 2],
        frame: Frame<'_>,
    ) -> Result<(), PlanError> {
        let Frame { scene, structures, margin, tolerance, far_share } = frame;
        let bodies = pair.bodies();
        let [a, b] = [0, 1].map(|i| structures.compared(scene, bodies[i], is_coarse[i]));
        let [Some(a), Some(b)] = [a, b] else { return Ok(()) };
        let deviations = structures.deviations(pair, is_coarse);

        // What is apart by its bounds is as deep as the surfaces deviate, at most.
        if !are_near(&a, &b, margin) {
            self.found.depth.upper = deviations[0] + deviations[1];
            return Ok(());
        }
        check_pair_rounding([a.tree, b.tree], tolerance)?;
        let computed = self.surfaces.compute(a.tree, b.tree, margin);
        computed.map_err(|error| SceneError::of_pair(scene.names(pair), error))?;
        self.extend_contacts(0, [&a, &b]);
        self.extend_contacts(1, [&b, &a]);
        self.found.min_gap = self.surfaces.min_gap();
        self.count_surfaces([&a, &b], far_share);
        self.measure_depth(Compared { bodies: [a.tree, b.tree], deviations }, tolerance);
        Ok(())
    }

    /// Measures the depth of the compared surfaces.
    fn measure_depth(&mut self, compared: Compared<'_>, tolerance: f64) {
        let operations = &mut self.operations;
        let depth = self.depth.find(&self.surfaces, compared, tolerance, operations);
        let rounding = rounding(compared.bodies);
        let is_overlapping = self.surfaces.overlaps() || depth.bracket.lower > rounding;
        self.decide(is_overlapping, depth, tolerance);
    }

    /// Sets the result from the depth of a pair.
    fn decide(&mut self, is_overlapping: bool, found: FoundDepth, tolerance: f64) {
        let upper = found.bracket.upper;
        self.found.max_depth = found.depth;
        self.found.depth = found.bracket;
        self.found.state = if is_overlapping {
            PairState::Overlapping
        } else if upper <= tolerance {
            PairState::Apart
        } else {
            PairState::Undecided { upper }
        };
    }

    /// Counts the operations of the last comparison of two surfaces.
    fn count_surfaces(&mut self, sides: [&ComparedSurface<'_>; 2], far_share: f64) {
        for side in sides {
            self.operations.listed_vertices += count(side.tree.surface().vertex_count());
        }
        let [near_a, near_b] = self.near_counts();
        let near_vertices = near_a + near_b;
        self.operations.tested_faces += count(self.surfaces.tested_faces());
        self.operations.meeting_faces += count(self.surfaces.meeting_faces().len());
        self.operations.near_vertices += near_vertices;
        self.operations.far_near_vertices += far_share * near_vertices;
    }

    /// Detects a surface by the field of a bone, and the bone's own vertices by the surface.
    ///
    /// Either alone is blind: a field is queried at vertices and edges, which a bone in the middle
    /// of a large face or wholly inside is far from.
    fn detect_by_field(
        &mut self,
        bone: BodyId,
        other: BodyId,
        frame: Frame<'_>,
    ) -> Result<(), PlanError> {
        let Frame { scene, structures, margin, tolerance, far_share } = frame;
        let Some((detector, state)) = structures.field_detector(scene, bone)? else {
            return Ok(());
        };
        let sides = [bone, other].map(|id| ComparedSurface::whole(scene.body(id)));
        let [Some(bone), Some(side)] = sides else { return Ok(()) };
        if !are_near(&bone, &side, margin) {
            return Ok(());
        }
        check_pair_rounding([bone.tree, side.tree], tolerance)?;

        // Deep points are projected to the bone itself: there the field has no proved bound.
        self.field.compute(detector, &state, side.tree, side.contact.particles);
        let max_depth = MAX_DEPTH * detector.field().grid().spacing();
        for found in self.field.contacts() {
            let mut contact = found.contact;
            if contact.gap < -max_depth {
                contact = project(&contact, scene.body(other), bone.tree, &mut self.workspace);
            }
            // Contacts of edges are between vertices that are farther out.
            if matches!(found.feature, FieldFeature::Vertex(_)) {
                lower(&mut self.found.min_gap, contact.gap);
            }
            self.contacts.push(contact);
        }
        self.operations.field_vertices += count(self.field.contacts().len());

        // The bone's own vertices, and depth by the surfaces, which are exact.
        let computed = self.surfaces.compute(bone.tree, side.tree, margin);
        computed.map_err(|error| SceneError::of_pair(scene.names(self.found.pair), error))?;
        self.extend_contacts(0, [&bone, &side]);
        if let Some(gap) = self.surfaces.min_gap() {
            lower(&mut self.found.min_gap, gap);
        }
        self.count_surfaces([&bone, &side], far_share);
        let bodies = [bone.tree, side.tree];
        self.measure_depth(Compared { bodies, deviations: [0.0; 2] }, tolerance);
        Ok(())
    }

    /// Adds the contacts of one side of the compared pair with the other side.
    fn extend_contacts(&mut self, side: usize, [of, with]: [&ComparedSurface<'_>; 2]) {
        for near in self.surfaces.sides()[side].near() {
            self.contacts.push(contact(&of.contact, &with.contact, near));
        }
    }

    /// Detects the vertices of both bodies by the balls of the other. Overlap by edges and faces is
    /// not seen, so that a pair without contacts is as deep as its boxes allow, at most.
    fn detect_by_balls(&mut self, pair: PairId, frame: Frame<'_>) {
        let Frame { scene, structures, tolerance, .. } = frame;
        let [a, b] = pair.bodies();
        for [body, other] in [[a, b], [b, a]] {
            let Some(balls) = &structures.bodies[other.index()].medial else { continue };
            let sides = [body, other].map(|id| scene.body(id).contact_body());
            let [Some(body), Some(own)] = sides else { continue };
            self.operations.ball_vertices += count(body.tree.surface().vertex_count());
            for found in balls.vertex_contacts(&body, &own, &mut self.medial) {
                lower(&mut self.found.min_gap, found.contact.gap);
                self.contacts.push(found.contact);
            }
        }

        let depth = self.found.min_gap.map_or(0.0, |gap| (-gap).max(0.0));
        let upper = max_depth_by_face_boxes(scene, pair);
        let bracket = DepthBracket { lower: 0.0, upper };
        let found = FoundDepth { depth: depth.min(upper), bracket };
        self.decide(depth > 0.0, found, tolerance);
    }
}

/// Returns the result of a pair that is apart.
fn apart(pair: PairId) -> PairDetection {
    PairDetection {
        pair,
        method: DetectionMethod::Exact,
        state: PairState::Apart,
        max_depth: 0.0,
        depth: DepthBracket::default(),
        min_gap: None,
        contacts: 0..0,
    }
}

/// Lowers the smallest gap so far to another one.
fn lower(min_gap: &mut Option<f64>, gap: f64) {
    *min_gap = Some(min_gap.map_or(gap, |min_gap| min_gap.min(gap)));
}

/// Projects the point of a contact inside a bone to the bone's own surface.
fn project(
    contact: &Contact,
    body: &Body,
    bone: &SurfaceTree,
    workspace: &mut Workspace,
) -> Contact {
    // A vertex or a point of an edge, whose terms the stencil holds with a negative sign.
    let first = body.particles().start;
    let mut terms = [Term { particle: 0, weight: 0.0 }; 2];
    let mut point = DVec3::ZERO;
    let stencil = contact.stencil.terms();
    for (own, &Term { particle, weight }) in terms.iter_mut().zip(stencil) {
        *own = Term { particle, weight: -weight };
        point -= weight * body.positions()[(particle - first) as usize];
    }
    let terms = &terms[..stencil.len().min(2)];
    let closest = bone.closest_point(point, f64::INFINITY, None, workspace);
    let Some(ClosestPoint { foot, distance, .. }) = closest else { return *contact };

    // From inside, the normal points to the foot.
    let normal = (foot.point - point).try_normalize().unwrap_or(contact.normal);
    let [on_body, on_bone] = [ContactSide::Particles(terms), ContactSide::at_rest(foot.point)];
    Contact::between(on_body, on_bone, normal, -distance)
}

/// Returns true if the bounds of two surfaces come within the margin.
fn are_near(a: &ComparedSurface<'_>, b: &ComparedSurface<'_>, margin: f64) -> bool {
    a.tree.tree().root().inflated(margin).overlaps(&b.tree.tree().root())
}
