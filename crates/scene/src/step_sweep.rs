//! Contacts of a step that are met between its positions and those at the end of the move.

use ccd::CcdParams;
use glam::DVec3;
use kdop::Workspace;
use proximity::{ContactKind, SweptContact};
use response::StepLength;
use surface::progress::Progress;
use surface::{Contact, ContactSide, Term, triangle};

use crate::pair_contacts::Bones;
use crate::{Body, BodyId, BodyMove, PairContacts, PairId, Scene, SceneError};

/// Memory of the ends of a move.
#[derive(Clone, Debug, Default)]
pub(crate) struct MoveEnds {
    /// Positions at the end, of all particles.
    x: Vec<DVec3>,
    is_moving: Vec<bool>,
}

/// Point of a body that meets another one.
struct SweptPoint<'a> {
    id: BodyId,
    body: &'a Body,
    /// Particles, with weights that sum to 1.
    terms: Vec<Term>,
    /// Place at the start.
    point: DVec3,
    /// Outer unit normals of the faces that hold the point, when it meets the other one; none for a body without
    /// an inside.
    normals: Vec<DVec3>,
}

impl MoveEnds {
    /// Adds the contacts that bodies meet on the way to x + h v, bones by their motions.
    pub(crate) fn sweep(
        &mut self,
        scene: &mut Scene,
        v: &[DVec3],
        h: StepLength,
        params: &CcdParams,
        contacts: &mut PairContacts<'_>,
    ) -> Result<(), SceneError> {
        let bones = contacts.bones;
        self.set(scene, v, h, bones);

        // Bodies that rest are swept against as they are.
        let mut moves = Vec::new();
        for id in scene.ids() {
            if !self.is_moving[id.index()] {
                continue;
            }
            let range = scene.body(id).particles();
            let positions = &self.x[range.start as usize..range.end as usize];
            moves.push(BodyMove { body: id, positions });
        }
        let is_soft = |pair: PairId| pair.bodies().iter().any(|&id| bones.motion(id).is_none());
        let report = scene.sweep_among(&moves, params, is_soft, Progress::none())?;

        // As contacts of the present state.
        let mut found = Vec::new();
        for pair in &report.pairs {
            found.clear();
            for swept in &pair.contacts {
                found.extend(self.contact_at_start(scene, pair.pair, swept, bones));
            }
            contacts.add(pair.pair, &found);
        }
        Ok(())
    }

    /// Computes the ends of the move, and which bodies move.
    fn set(&mut self, scene: &Scene, v: &[DVec3], h: StepLength, bones: &Bones) {
        self.x.clear();
        self.is_moving.clear();
        for (id, body) in scene.ids().zip(scene.bodies()) {
            let first = self.x.len();
            for (x, v) in body.positions().iter().zip(&v[first..]) {
                let velocity = bones.motion(id).map_or(*v, |motion| motion.at(*x).velocity);
                self.x.push(*x + h.get() * velocity);
            }
            self.is_moving.push(self.x[first..] != *body.positions());
        }
    }

    /// Measures a contact of the move at its start. `None` for those that were there at the start,
    /// which static detection has, and for vertices that leave a body.
    fn contact_at_start(
        &self,
        scene: &Scene,
        pair: PairId,
        swept: &SweptContact,
        bones: &Bones,
    ) -> Option<Contact> {
        let SweptContact { contact, kind, at_start, .. } = swept;
        // P and P̄, as points of their bodies.
        let count_of_p = if *kind == ContactKind::VertexFace { 1 } else { 2 };
        let (p, on) = contact.stencil.terms().split_at(count_of_p);
        let time = contact.time.unwrap_or(0.0);
        let [p, on] = [p, on].map(|terms| self.point(scene, pair, terms, time));

        let leaves = match kind {
            ContactKind::VertexFace => p.leaves(&on, contact.normal),
            ContactKind::EdgeEdge => {
                p.leaves(&on, contact.normal) && on.leaves(&p, -contact.normal)
            }
        };
        if *at_start || leaves {
            return None;
        }

        // The gap that the velocities may close.
        let apart = p.point - on.point;
        let normal = match kind {
            ContactKind::VertexFace => contact.normal,
            ContactKind::EdgeEdge => edge_normal(&p, &on, contact.normal, apart),
        };
        let gap = apart.dot(normal) - contact.offset;
        let found = Contact::between(p.side(bones), on.side(bones), normal, gap);
        Some(Contact { offset: contact.offset, time: contact.time, ..found })
    }

    /// Returns the point of some terms, whose body is one of the pair and meets another one at a time.
    fn point<'a>(
        &self,
        scene: &'a Scene,
        pair: PairId,
        terms: &[Term],
        time: f64,
    ) -> SweptPoint<'a> {
        let holds = |id: &BodyId| scene.body(*id).particles().contains(&terms[0].particle);
        let id = if holds(&pair.a) { pair.a } else { pair.b };
        let body = scene.body(id);
        let first = body.particles().start;
        let (mut point, mut own) = (DVec3::ZERO, Vec::new());
        for &Term { particle, weight } in terms {
            own.push(Term { particle, weight: weight.abs() });
            point += weight.abs() * body.positions()[(particle - first) as usize];
        }

        // One face, two at an edge, all around a vertex.
        let at_time = |vertex: u32| {
            let start = body.positions()[vertex as usize];
            start.lerp(self.x[(first + vertex) as usize], time)
        };
        let mut normals = Vec::new();
        if body.has_inside().is_ok() {
            let surface = body.surface();
            for &face in surface.vertex_faces(own[0].particle - first) {
                let corners = surface.faces()[face as usize];
                if own.iter().all(|term| corners.contains(&(term.particle - first))) {
                    let normal = triangle::normal(corners.map(at_time)).normalize_or_zero();
                    normals.push(body.orientation() * normal);
                }
            }
        }
        SweptPoint { id, body, terms: own, point, normals }
    }
}

/// Returns the normal of two edges that meet, between the normals of the faces beside each; `apart` is
/// how far they are from each other at the start.
///
/// Perpendicular to both edges, it may lean over: against an edge in a flat part it would push
/// aside. There, the flatter of the two decides, if the edges come nearer by more along its normal.
fn edge_normal(p: &SweptPoint<'_>, on: &SweptPoint<'_>, normal: DVec3, apart: DVec3) -> DVec3 {
    let (of_p, of_on) = (-p.outward(), on.outward());

    // Between two unit normals, the cosine to their sum is at least half its length.
    let is_between = |sum: DVec3| normal.dot(sum) >= 0.5 * sum.length_squared() - IN_CONE;
    if is_between(of_p) && is_between(of_on) {
        return normal;
    }
    let flatter = if of_p.length() > of_on.length() { of_p } else { of_on };
    let flatter = flatter.try_normalize().unwrap_or(normal);
    if apart.dot(flatter) >= apart.dot(normal) { flatter } else { normal }
}

/// Rounding of cosines.
const IN_CONE: f64 = 1e-9;

impl SweptPoint<'_> {
    /// Returns true if the point starts in the body of another one, and meets it from there, against `normal`: from behind
    /// all faces that hold the other one.
    fn leaves(&self, other: &Self, normal: DVec3) -> bool {
        let is_behind = |outward: &DVec3| outward.dot(normal) < -IN_CONE;
        let is_from_inside = !other.normals.is_empty() && other.normals.iter().all(is_behind);
        is_from_inside
            && other
                .body
                .tree()
                .is_some_and(|tree| tree.contains(self.point, &mut Workspace::default()))
    }

    /// Computes the sum of the outer unit normals.
    fn outward(&self) -> DVec3 {
        self.normals.iter().sum()
    }

    /// Returns the side of a contact at this point, with the motion of a bone.
    fn side(&self, bones: &Bones) -> ContactSide<'_> {
        match bones.motion(self.id) {
            None => ContactSide::Particles(&self.terms),
            Some(motion) => ContactSide::Rigid(motion.at(self.point)),
        }
    }
}
