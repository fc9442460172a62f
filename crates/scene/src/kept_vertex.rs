//! Vertices at contacts that are kept, by which it is told whether these can touch.

use glam::DVec3;
use kdop::Workspace;
use surface::{Contact, closest_on_triangle};

use crate::closest_pairs::{ON_BORDER, SurfaceState};
use crate::{Body, BodyId, Scene};

/// Vertex at a contact, and the body that it may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptVertex {
    of: BodyId,
    vertex: u32,
    on: BodyId,
}

impl KeptVertex {
    /// Returns the vertex at a contact: P, or that of a bone under P.
    pub(crate) fn new(
        scene: &Scene,
        [of, on]: [BodyId; 2],
        contact: &Contact,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        if is_of_vertex(contact) {
            let vertex = contact.stencil.terms()[0].particle - scene.body(of).particles().start;
            return Some(Self { of, vertex, on });
        }
        if !is_of_bone_vertex(contact) {
            return None;
        }

        // P is carried by the body that is not rigid.
        let [bone, soft] = if scene.body(of).is_rigid() { [of, on] } else { [on, of] };
        let (body, point) = (scene.body(bone), contact.anchor?.point);
        let corners = body.surface().faces()[face_at(body, point, workspace)? as usize];
        let distance = |corner: &u32| body.positions()[*corner as usize].distance(point);
        let nearest = corners.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map(|vertex| Self { of: bone, vertex, on: soft })
    }

    /// Returns true if the vertex, outside, can touch the other body next. A foot on a bone is on
    /// the face given.
    pub(crate) fn may_touch(self, scene: &Scene, contact: &Contact, face: u32) -> bool {
        let (of, on) = (scene.body(self.of), scene.body(self.on));
        let normal = if of.is_rigid() { -contact.normal } else { contact.normal };
        let state = SurfaceState::of_body(on);
        SurfaceState::of_body(of).vertex(self.vertex).may_touch(normal, || {
            if on.is_rigid() {
                let foot = of.positions()[self.vertex as usize] - contact.gap * normal;
                let weights = closest_on_triangle(foot, on.corners(face)).barycentric;
                return state.is_ridge_at(face, weights, normal);
            }
            let (mut held, mut count, particles) = ([0; 3], 0, on.particles());
            for term in contact.stencil.terms() {
                if particles.contains(&term.particle) && term.weight.abs() > ON_BORDER && count < 3
                {
                    held[count] = term.particle - particles.start;
                    count += 1;
                }
            }
            state.is_ridge(&held[..count], normal)
        })
    }
}

/// Returns true if P is a vertex.
pub(crate) fn is_of_vertex(contact: &Contact) -> bool {
    let terms = contact.stencil.terms();
    terms.iter().filter(|term| term.weight.is_sign_negative()).count() == 1
}

/// Returns true if P is a point of a face under the vertex of a bone.
pub(crate) fn is_of_bone_vertex(contact: &Contact) -> bool {
    contact.anchor.is_some() && contact.stencil.terms().len() == 3
}

/// Finds the face nearest to a point of a body whose tree is up to date.
pub(crate) fn face_at(body: &Body, point: DVec3, workspace: &mut Workspace) -> Option<u32> {
    let closest = body.tree()?.closest_point(point, f64::INFINITY, None, workspace);
    closest.map(|closest| closest.face)
}
