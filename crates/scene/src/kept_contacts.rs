//! Contacts that are kept from step to step instead of being detected again: a neighbor list
//! (Verlet list) with a skin.
//!
//! A list holds all contacts within its reach, the margin and a skin beyond it. Each step carries
//! them, sticking or sliding, in work linear in the vertices, without trees. A vertex that the list
//! does not hold was farther than the reach, and has come nearer since by no more than the
//! displacement of both bodies against each other, measured in the frame of the bone where one is
//! rigid: that bounds what the list does not hold. Where the bound exceeds the tolerance, or a contact is
//! in doubt, the pair is detected again in the same step.
//!
//! Source: L. Verlet, "Computer experiments on classical fluids I", Physical Review 159, 1967, for
//! lists with a skin; B. Gilles, PhD thesis, 2007, section 4.7.2, for permanent contacts.

use glam::DVec3;
use kdop::Workspace;
use response::{
    GapMeasure, Margins, PermanentContacts, ResponseError, Restraint, RigidMotion, SurfaceCarrier,
    walk_to_foot,
};
use surface::{Contact, ContactSide, Pose, Term, closest_on_triangle, triangle};

use crate::closest_pairs::{ActingGaps, RIDGE_COSINE};
use crate::kept_vertex::{KeptVertex, face_at, is_of_bone_vertex, is_of_vertex};
use crate::pair_frame::PairFrame;
use crate::{Body, BodyId, PairId, Scene, StepError};

/// Parameters of a pair whose contacts are kept from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PermanentParams {
    /// Way in which contacts are carried: with the same weights, or at the closest point, which is followed
    /// over the surface.
    pub restraint: Restraint,
    /// Skin of the list: gap beyond the margin up to which it holds contacts, finite and `>= 0`.
    /// A larger one holds more contacts, and is detected again less often.
    pub skin: f64,
    /// Gap beyond the clearance up to which contacts are attached when the list is detected, finite
    /// and `>= 0`, where the pair's material is [permanent](response::Material::permanent): those
    /// pull. All others are attached once they touch.
    pub attach_within: f64,
}

/// Pair whose contacts are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KeptPair {
    /// The pair.
    pub pair: PairId,
    /// Number of the step that detected its list.
    pub since: u64,
    /// Reason why it was detected in that step.
    pub renewal: Renewal,
    /// Proved bound on the depth of vertices that the list does not hold, `>= 0`. It is for lists
    /// of exact detection; other methods add what they leave out.
    pub bound: f64,
    /// Number of contacts that the list holds, those beyond the margin included.
    pub contacts: usize,
}

/// Reason why a list of kept contacts was detected again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Renewal {
    /// There was no list.
    First,
    /// The bodies moved against each other: what the list does not hold may be deeper than the
    /// tolerance.
    Displacement,
    /// A sticking contact has slid by more than the tolerance.
    Slip,
    /// A sliding contact left the faces around that where it was detected, by more than the
    /// tolerance; the same for the other reasons.
    FaceRing,
    /// A sliding contact crossed a ridge: to a face that is turned by more than 30°.
    Ridge,
    /// A sliding contact changed the side of the surface: to a face that is turned by more than 90°.
    Side,
    /// The vertices of a rigid body were moved one by one: it has no pose.
    NoPose,
}

/// List of the contacts of one pair.
#[derive(Debug)]
pub(crate) struct KeptList {
    pub(crate) report: KeptPair,
    /// Reason why it no longer holds, if any.
    pub(crate) doubt: Option<Renewal>,
    restraint: Restraint,
    /// Gap up to which all vertices are held.
    reach: f64,
    sides: [KeptSide; 2],
    /// Vertices of a bone that slide on the other body.
    bone_vertices: Vec<BoneVertex>,
    frame: PairFrame,
    /// Displacement of the bodies against each other since then, as last measured.
    displacement: f64,
    /// Gap up to which contacts touch.
    clearance: f64,
    /// Search for the faces of feet.
    workspace: Workspace,
}

/// Contact of a vertex of a bone with a face that it slides on.
#[derive(Clone, Copy, Debug)]
struct BoneVertex {
    contact: Contact,
    /// Body that it slides on.
    on: BodyId,
    start: Start,
    face: u32,
}

/// Contacts of a list whose P̄ is on one body.
#[derive(Debug)]
struct KeptSide {
    on: BodyId,
    contacts: PermanentContacts,
    starts: Vec<Start>,
}

/// State of a contact when it was detected.
#[derive(Clone, Copy, Debug)]
struct Start {
    face: u32,
    /// Vertex at the contact; `None` for points of edges.
    vertex: Option<KeptVertex>,
    /// True once it pulls, where the material is permanent.
    is_attached: bool,
}

/// Contacts of a pair as detected, with what the detection covers.
#[derive(Clone, Copy)]
pub(crate) struct DetectedList<'a> {
    pub(crate) contacts: &'a [Contact],
    /// Gap up to which all vertices were found.
    pub(crate) reach: f64,
    /// Gap up to which contacts are attached.
    pub(crate) attach_gap: f64,
    pub(crate) margins: Margins,
}

impl KeptList {
    /// Returns a list that does not hold: it was never detected.
    pub(crate) fn new(pair: PairId, params: &PermanentParams, margins: Margins) -> Self {
        let renewal = Renewal::First;
        Self {
            report: KeptPair { pair, since: 0, renewal, bound: 0.0, contacts: 0 },
            doubt: Some(renewal),
            restraint: params.restraint,
            reach: 0.0,
            sides: [pair.a, pair.b].map(|on| KeptSide::new(on, margins)),
            bone_vertices: Vec::new(),
            frame: PairFrame::default(),
            displacement: 0.0,
            clearance: margins.clearance(),
            workspace: Workspace::default(),
        }
    }

    /// Replaces the contacts by those that a step has detected at the positions `x` of all
    /// particles; the memory is kept.
    pub(crate) fn renew(
        &mut self,
        scene: &Scene,
        step_number: u64,
        detected: DetectedList<'_>,
        x: &[DVec3],
    ) -> Result<(), StepError> {
        for side in &mut self.sides {
            side.starts.clear();
            side.contacts.clear(detected.margins);
        }
        self.bone_vertices.clear();

        let pair = self.report.pair;
        for contact in detected.contacts {
            // P̄ is on the other body, but for the vertices of a bone, which slide.
            let first = contact.stencil.terms()[0].particle;
            let is_of_a = scene.body(pair.a).particles().contains(&first);
            let [of, on] = if is_of_a { [pair.a, pair.b] } else { [pair.b, pair.a] };
            if self.restraint == Restraint::Sliding && is_of_bone_vertex(contact) {
                // P is the foot, a point of a face.
                let foot = point_of(contact, x);
                let start =
                    Start::new(scene, [on, of], contact, foot, &detected, &mut self.workspace);
                let vertex = BoneVertex { contact: *contact, on: of, start, face: start.face };
                self.bone_vertices.push(vertex);
            } else {
                let foot = foot_of(contact, x);
                let start =
                    Start::new(scene, [of, on], contact, foot, &detected, &mut self.workspace);
                let side = &mut self.sides[usize::from(is_of_a)];
                side.contacts.push(contact, Some(start.face), x)?;
                side.starts.push(start);
            }
        }

        // From now on it holds, until a contact is in doubt.
        self.report = KeptPair {
            since: step_number,
            renewal: self.doubt.take().unwrap_or(Renewal::First),
            bound: 0.0,
            contacts: detected.contacts.len(),
            pair,
        };
        self.frame.renew(scene, pair);
        self.reach = detected.reach;
        self.displacement = 0.0;
        self.clearance = detected.margins.clearance();
        Ok(())
    }

    /// Carries the contacts to the positions `x` of all particles; returns a reason to detect them
    /// again.
    pub(crate) fn carry(
        &mut self,
        scene: &Scene,
        x: &[DVec3],
        tolerance: f64,
    ) -> Result<Option<Renewal>, StepError> {
        // What the list does not hold has come nearer by this at most.
        let Some(displacement) = self.frame.displacement(scene, self.report.pair) else {
            return Ok(Some(Renewal::NoPose));
        };
        self.report.bound = (displacement - self.reach).max(0.0);

        // By the end of the move that follows, too, if it is as long as the last one.
        let coming = displacement + (displacement - self.displacement).max(0.0);
        self.displacement = displacement;
        if coming - self.reach > tolerance {
            return Ok(Some(Renewal::Displacement));
        }

        // All contacts, until one is in doubt.
        let motion = self.frame.follow_bone(scene);
        for side in &mut self.sides {
            let doubt = match self.restraint {
                Restraint::Sticking => side.stick(x, motion, tolerance)?,
                Restraint::Sliding => side.slide(scene, x, tolerance)?,
            };
            if doubt.is_some() {
                return Ok(doubt);
            }
        }

        // Vertices of the bone itself, over the other body.
        for vertex in &mut self.bone_vertices {
            let doubt = vertex.slide(scene, motion, tolerance);
            if doubt.is_some() {
                return Ok(doubt);
            }
        }
        self.attach();
        Ok(None)
    }

    /// Attaches the contacts that touch.
    fn attach(&mut self) {
        for side in &mut self.sides {
            for (contact, start) in side.contacts.contacts().iter().zip(&mut side.starts) {
                start.is_attached |= contact.gap <= self.clearance;
            }
        }
        for BoneVertex { contact, start, .. } in &mut self.bone_vertices {
            start.is_attached |= contact.gap <= self.clearance;
        }
    }

    /// Adds the contacts that act: those within `gaps`, which touch or can touch next; without
    /// gaps, where contacts pull, the attached ones. Calls `side` with each vertex and the face of
    /// its foot.
    pub(crate) fn extend(
        &self,
        scene: &Scene,
        gaps: Option<ActingGaps>,
        out: &mut Vec<Contact>,
        mut side: impl FnMut(u32, u32),
    ) {
        // A vertex has the side from which it came in.
        for of_body in &self.sides {
            let contacts = of_body.contacts.contacts();
            for (number, (contact, start)) in contacts.iter().zip(&of_body.starts).enumerate() {
                let face = of_body.contacts.face(number).unwrap_or(start.face);
                if is_of_vertex(contact) {
                    side(contact.stencil.terms()[0].particle, face);
                }
                if start.acts(scene, contact, face, gaps) {
                    out.push(*contact);
                }
            }
        }

        for BoneVertex { contact, start, face, .. } in &self.bone_vertices {
            if start.acts(scene, contact, *face, gaps) {
                out.push(*contact);
            }
        }
    }
}

impl KeptSide {
    /// Returns a side without contacts.
    fn new(on: BodyId, margins: Margins) -> Self {
        let contacts = PermanentContacts::empty(GapMeasure::AlongNormal, margins);
        Self { on, contacts, starts: Vec::new() }
    }

    /// Carries contacts with the same weights; they are in doubt once they have slid.
    fn stick(
        &mut self,
        x: &[DVec3],
        motion: Option<[Pose; 2]>,
        tolerance: f64,
    ) -> Result<Option<Renewal>, ResponseError> {
        if self.starts.is_empty() {
            return Ok(None);
        }
        self.move_anchors(motion);
        self.contacts.stick(x)?;

        // By the part of P_c in the tangent plane, which was 0 at first.
        for contact in self.contacts.contacts() {
            let separation = contact.separation(|particle| x[particle as usize]);
            let along = separation.dot(contact.normal) * contact.normal;
            if separation.distance(along) > tolerance {
                return Ok(Some(Renewal::Slip));
            }
        }
        Ok(None)
    }

    /// Carries contacts over the surface.
    fn slide(
        &mut self,
        scene: &Scene,
        x: &[DVec3],
        tolerance: f64,
    ) -> Result<Option<Renewal>, ResponseError> {
        if self.starts.is_empty() {
            return Ok(None);
        }
        let body = scene.body(self.on);
        let (surface, on) = (body.outward().surface(), body.checked_positions());
        let carrier = if body.is_rigid() {
            SurfaceCarrier::Rigid(RigidMotion::default())
        } else {
            SurfaceCarrier::Particles { first: body.particles().start }
        };
        self.contacts.slide(x, surface, on, carrier)?;

        // Walks are local: far from where a contact was detected, a nearer face may be beyond them.
        for (number, start) in self.starts.iter().enumerate() {
            let face = self.contacts.face(number).unwrap_or(start.face);
            let foot = foot_of(&self.contacts.contacts()[number], x);
            let doubt = start.doubt(body, face, foot, tolerance);
            if doubt.is_some() {
                return Ok(doubt);
            }
        }
        Ok(None)
    }

    /// Moves anchors and their normals from one pose of the bone to another.
    fn move_anchors(&mut self, motion: Option<[Pose; 2]>) {
        let Some(motion) = motion else { return };
        let [from, to] = motion;
        self.contacts.move_anchors(|_, anchor, normal| {
            anchor.point = to.transform_point(from.inverse_transform_point(anchor.point));
            *normal = turn(motion, *normal);
        });
    }
}

impl Start {
    /// Keeps a contact of body `of` with its foot at a point of body `on`.
    fn new(
        scene: &Scene,
        [of, on]: [BodyId; 2],
        contact: &Contact,
        point: DVec3,
        detected: &DetectedList<'_>,
        workspace: &mut Workspace,
    ) -> Self {
        let face = face_at(scene.body(on), point, workspace).unwrap_or(0);
        let vertex = KeptVertex::new(scene, [of, on], contact, workspace);
        Self { face, vertex, is_attached: contact.gap <= detected.attach_gap }
    }

    /// Returns true if a contact acts whose foot is on a face: see [`KeptList::extend`].
    fn acts(&self, scene: &Scene, contact: &Contact, face: u32, gaps: Option<ActingGaps>) -> bool {
        let Some(gaps) = gaps else { return self.is_attached };
        let may_touch = |vertex: KeptVertex| vertex.may_touch(scene, contact, face);
        contact.gap <= gaps.touch
            || (contact.gap <= gaps.margin && self.vertex.is_none_or(may_touch))
    }

    /// Returns a reason to doubt a contact that has slid to a face, with its foot at `point`.
    fn doubt(&self, body: &Body, face: u32, point: DVec3, tolerance: f64) -> Option<Renewal> {
        // On an edge, rounding decides which face has the foot.
        let nearest = closest_on_triangle(point, body.corners(self.face)).point;
        if face == self.face || nearest.distance(point) <= tolerance {
            return None;
        }

        // Normals of both faces now. A normal at the foot itself jumps where the gap is rounding.
        let [first, now] = [self.face, face].map(|face| triangle::normal(body.corners(face)));
        let cosine = first.normalize_or_zero().dot(now.normalize_or_zero());
        if cosine < 0.0 {
            return Some(Renewal::Side);
        }
        if cosine < RIDGE_COSINE {
            return Some(Renewal::Ridge);
        }

        // Faces around the first one share a corner with it.
        let [first, now] = [self.face, face].map(|face| body.surface().faces()[face as usize]);
        let is_in_ring = first.iter().any(|corner| now.contains(corner));
        (!is_in_ring).then_some(Renewal::FaceRing)
    }
}

impl BoneVertex {
    /// Follows the closest point of the surface under the vertex.
    fn slide(
        &mut self,
        scene: &Scene,
        motion: Option<[Pose; 2]>,
        tolerance: f64,
    ) -> Option<Renewal> {
        // The vertex moves with its bone.
        let mut vertex = self.contact.anchor.map_or(DVec3::ZERO, |anchor| anchor.point);
        if let Some([from, to]) = motion {
            vertex = to.transform_point(from.inverse_transform_point(vertex));
        }

        let body = scene.body(self.on);
        let (surface, on) = (body.outward().surface(), body.checked_positions());
        let foot = walk_to_foot(surface, on, self.face, vertex)?;

        // Normals point out of the bone.
        let (corners, first) = (surface.faces()[foot.face as usize], body.particles().start);
        let term = |k: usize| Term { particle: first + corners[k], weight: foot.barycentric[k] };
        let p = [0, 1, 2].map(term);
        let (p, anchor) = (ContactSide::Particles(&p), ContactSide::at_rest(vertex));
        self.contact = Contact::between(p, anchor, -foot.normal, foot.height);
        self.face = foot.face;
        self.start.doubt(body, foot.face, foot.point, tolerance)
    }
}

/// Rotates a normal from one pose to another.
fn turn([from, to]: [Pose; 2], normal: DVec3) -> DVec3 {
    to.rotation() * (from.rotation().transpose() * normal)
}

/// Computes P of a contact, a combination of particles.
fn point_of(contact: &Contact, x: &[DVec3]) -> DVec3 {
    let mut point = DVec3::ZERO;
    for term in contact.stencil.terms() {
        point -= term.weight * x[term.particle as usize];
    }
    point
}

/// Computes P̄ of a contact.
fn foot_of(contact: &Contact, x: &[DVec3]) -> DVec3 {
    let mut foot = contact.anchor.map_or(DVec3::ZERO, |anchor| anchor.point);
    for term in contact.stencil.terms() {
        if term.weight.is_sign_positive() {
            foot += term.weight * x[term.particle as usize];
        }
    }
    foot
}
