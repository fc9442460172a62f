//! Memory of sides: a vertex inside a thin body leaves it where it came in.
//!
//! Of a vertex inside a body, the nearest face may be that of the far side. So a step
//! remembers, per vertex and body, the face of its last foot. While the vertex is inside, its
//! foot is followed from there over the surface, and where it is on another side than the
//! detector's, it replaces that. A vertex that was in no contact has the face that it was nearest
//! to in the last step, if it was outside. So a vertex that approaches by at most the thickness in
//! a step does not leave by the far side.

use glam::DVec3;
use kdop::Workspace;
use response::{ContactSet, RigidMotion, SurfaceFoot, walk_to_foot};
use surface::{Contact, ContactSide, Term, triangle};

use crate::{Body, BodyId, PairId, Scene, SceneError};

/// Faces of the last feet of vertices, from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct SideMemory {
    /// Of the last step, sorted by key.
    last: Vec<Side>,
    /// Of the present detection.
    present: Vec<Side>,
    /// Contacts inside whose vertex had no side in the last step.
    pub(crate) unknown: usize,
    /// Pairs whose contacts were kept.
    kept: Vec<PairId>,
    /// Positions of all particles at the end of the last step, those of bones too.
    positions: Vec<DVec3>,
    is_wanted: Vec<bool>,
    workspace: Workspace,
}

/// Side of a vertex at a body.
#[derive(Clone, Copy, Debug)]
struct Side {
    key: (PairId, u32),
    face: u32,
}

/// Vertex of a kept contact and the face of its foot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptSide {
    pub(crate) particle: u32,
    pub(crate) face: u32,
}

/// Contact of a vertex with a face.
struct VertexContact {
    particle: u32,
    p: DVec3,
    /// Body that holds P̄.
    on: BodyId,
}

impl SideMemory {
    /// Ends a step: the sides that were detected last are those to remember.
    pub(crate) fn end_step(&mut self, scene: &Scene) {
        self.positions.clear();
        for body in scene.bodies() {
            self.positions.extend_from_slice(body.positions());
        }
        std::mem::swap(&mut self.last, &mut self.present);
        self.last.sort_unstable_by_key(|side| side.key);
        self.present.clear();
    }

    /// Begins a detection: sides are those of the last step.
    pub(crate) fn begin_detection(&mut self) {
        self.present.clear();
        self.unknown = 0;
        self.kept.clear();
    }

    /// Takes the sides of a pair whose contacts were kept: these have not changed them.
    pub(crate) fn keep(&mut self, pair: PairId, sides: &[KeptSide]) {
        self.kept.push(pair);
        for KeptSide { particle, face } in sides {
            self.present.push(Side { key: (pair, *particle), face: *face });
        }
    }

    /// Replaces the contacts of vertices that the detector would push out of another side than
    /// they came in by.
    pub(crate) fn correct(
        &mut self,
        scene: &mut Scene,
        contacts: &mut ContactSet,
        motion_of: impl Fn(BodyId) -> RigidMotion,
    ) -> Result<(), SceneError> {
        self.fit_trees(scene, contacts)?;
        for number in 0..contacts.groups().len() {
            let group = &contacts.groups()[number];
            let (pair, range) = (pair_of(group.pair), group.contacts.clone());
            if !self.kept.contains(&pair) {
                self.correct_pair(scene, pair, &mut contacts.contacts_mut()[range], &motion_of);
            }
        }
        Ok(())
    }

    /// Replaces contacts of one pair likewise; trees must be fitted.
    pub(crate) fn correct_pair(
        &mut self,
        scene: &Scene,
        pair: PairId,
        contacts: &mut [Contact],
        motion_of: &impl Fn(BodyId) -> RigidMotion,
    ) {
        for contact in contacts {
            let Some(vertex) = VertexContact::new(scene, pair, contact) else { continue };
            self.correct_one(scene.body(vertex.on), pair, &vertex, contact, motion_of);
        }
    }

    /// Finds the face that was nearest to a vertex in the last step, if it was outside.
    fn face_before(&mut self, on: &Body, vertex: &VertexContact, contact: &Contact) -> Option<u32> {
        let tree = on.tree()?;
        let at = vertex.p - contact.gap * contact.normal;
        let nearest = tree.closest_point(at, f64::INFINITY, None, &mut self.workspace)?;

        // Where the vertex was, in the frame of the face that it is nearest to now.
        let mut before = *self.positions.get(vertex.particle as usize)?;
        for corner in on.surface().faces()[nearest.face as usize] {
            let last = *self.positions.get((on.particles().start + corner) as usize)?;
            before += (on.positions()[corner as usize] - last) / 3.0;
        }
        let found =
            tree.closest_point(before, f64::INFINITY, Some(nearest.face), &mut self.workspace)?;

        // On which side it was, in the state of that time.
        let particles = on.particles();
        let last = self.positions.get(particles.start as usize..particles.end as usize)?;
        let last = on.surface().positions(last).ok()?;
        let was_at = *self.positions.get(vertex.particle as usize)?;
        let foot = walk_to_foot(on.outward().surface(), last, found.face, was_at)?;
        (foot.height >= 0.0).then_some(foot.face)
    }

    /// Returns true if a face of a soft body looks the other way than at the end of the last step, as
    /// faces do that a correction has crushed.
    fn has_turned_over(&self, on: &Body, face: u32) -> bool {
        let first = on.particles().start;
        let mut last = [DVec3::ZERO; 3];
        for (last, corner) in last.iter_mut().zip(on.surface().faces()[face as usize]) {
            let Some(position) = self.positions.get((first + corner) as usize) else {
                return false;
            };
            *last = *position;
        }
        !on.is_rigid() && triangle::normal(last).dot(triangle::normal(on.corners(face))) < 0.0
    }

    /// Brings the trees of bodies in contact to their present state.
    fn fit_trees(&mut self, scene: &mut Scene, contacts: &ContactSet) -> Result<(), SceneError> {
        self.is_wanted.clear();
        self.is_wanted.resize(scene.bodies().len(), false);
        for group in contacts.groups() {
            let pair = pair_of(group.pair);
            for body in pair.bodies() {
                self.is_wanted[body.index()] |= !self.kept.contains(&pair);
            }
        }
        scene.fit(&self.is_wanted)
    }

    fn correct_one(
        &mut self,
        on: &Body,
        pair: PairId,
        vertex: &VertexContact,
        contact: &mut Contact,
        motion_of: &impl Fn(BodyId) -> RigidMotion,
    ) {
        // The foot on the side of the last step, and whether the detector's is on another.
        let key = (pair, vertex.particle);
        let last = match self.last.binary_search_by_key(&key, |side| side.key) {
            Ok(number) => Some(self.last[number].face),
            Err(_) => None,
        };
        let (surface, x) = (on.outward().surface(), on.checked_positions());
        let mut start = last;
        if start.is_none() && contact.gap < 0.0 {
            start = self.face_before(on, vertex, contact);
        }
        let foot = start.and_then(|face| walk_to_foot(surface, x, face, vertex.p));
        if let Some(foot) = foot {
            let is_behind = foot.height < 0.0 && foot.normal.dot(contact.normal) < 0.0;
            // A vertex that the detector has outside is behind a face only if that has not turned over.
            let is_outside = contact.gap >= 0.0 && self.has_turned_over(on, foot.face);
            if is_behind && !is_outside {
                *contact = at_foot(on, vertex, &foot, &motion_of(vertex.on));
                self.present.push(Side { key, face: foot.face });
                return;
            }
        }
        if contact.gap < 0.0 && foot.is_none() {
            self.unknown += 1;
        }

        // The side of the detector's foot.
        let Some(tree) = on.tree() else { return };
        let at = vertex.p - contact.gap * contact.normal;
        let nearest = tree.closest_point(at, f64::INFINITY, last, &mut self.workspace);
        if let Some(nearest) = nearest {
            self.present.push(Side { key, face: nearest.face });
        }
    }
}

impl VertexContact {
    /// Returns the vertex of a contact; `None` where P is no single vertex, or the objects are
    /// thicker than their surfaces.
    fn new(scene: &Scene, pair: PairId, contact: &Contact) -> Option<Self> {
        let terms = contact.stencil.terms();
        let (first, rest) = terms.split_first()?;

        // The sign of a weight decides its side, also that of a zero.
        let is_vertex =
            first.weight <= -1.0 && rest.iter().all(|term| term.weight.is_sign_positive());
        if !is_vertex || contact.offset > 0.0 {
            return None;
        }
        let holds = |id: &BodyId| scene.body(*id).particles().contains(&first.particle);
        let [of_p, on] = if holds(&pair.a) { [pair.a, pair.b] } else { [pair.b, pair.a] };
        let body = scene.body(of_p);
        let vertex = first.particle.checked_sub(body.particles().start)?;
        let p = *body.positions().get(vertex as usize)?;
        Some(Self { particle: first.particle, p, on })
    }
}

/// Returns the contact of a vertex with a foot.
fn at_foot(on: &Body, vertex: &VertexContact, foot: &SurfaceFoot, motion: &RigidMotion) -> Contact {
    let p = [Term { particle: vertex.particle, weight: 1.0 }];
    let p = ContactSide::Particles(&p);
    if on.is_rigid() {
        let anchor = ContactSide::Rigid(motion.at(foot.point));
        return Contact::between(p, anchor, foot.normal, foot.height);
    }
    let corners = on.outward().surface().faces()[foot.face as usize];
    let first = on.particles().start;
    let term = |k: usize| Term { particle: first + corners[k], weight: foot.barycentric[k] };
    let terms = [0, 1, 2].map(term);
    Contact::between(p, ContactSide::Particles(&terms), foot.normal, foot.height)
}

/// Returns the key of a pair in a set of contacts.
pub(crate) fn key_of(pair: PairId) -> u64 {
    u64::from(pair.a.0) << 32 | u64::from(pair.b.0)
}

/// Returns the pair of a key.
#[expect(clippy::cast_possible_truncation, reason = "both halves have 32 bits")]
fn pair_of(key: u64) -> PairId {
    PairId::new(BodyId((key >> 32) as u32), BodyId(key as u32))
}
