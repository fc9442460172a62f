//! Contacts that are found once, at rest, and carried from frame to frame instead of being found
//! anew.

use glam::DVec3;
use musculo_collide::{BodyId, CheckParams};
use proximity::NearVertex;
use response::{GapMeasure, Margins, PermanentContacts, SurfaceCarrier};
use surface::progress::Progress;
use surface::{Contact, Stencil};

use super::super::score::Answer;
use super::super::task::{Direction, Task, both_directions};
use super::{Built, Detector, Failure};

/// Contacts that slide over the surfaces that they were found on.
struct SlidingContacts<'a> {
    task: &'a Task<'a>,
    /// Numbers of the first particles of the bodies.
    first: Vec<u32>,
    /// Positions of all particles.
    x: Vec<DVec3>,
    lists: Vec<ContactList>,
}

/// Contacts of the vertices of one body with another one.
struct ContactList {
    direction: Direction,
    vertices: Vec<u32>,
    contacts: PermanentContacts,
}

/// Finds the contacts at rest, up to a gap.
///
/// # Errors
///
/// When the scene refuses a body, or a contact cannot be kept.
pub(super) fn detector<'a>(task: &'a Task<'a>, gap: f64) -> Built<'a> {
    let (mut scene, ids) = task.scene()?;
    let first = ids.iter().map(|&id| scene.body(id).particles().start).collect();
    let x = scene.particle_positions();
    let mut detection = SlidingContacts { task, first, x, lists: Vec::new() };
    for report in scene.check(&CheckParams::without_measures(gap), Progress::none())? {
        let [forward, backward] = both_directions(report.pair.bodies().map(BodyId::index));
        detection.add(forward, &report.a_against_b.near, gap)?;
        detection.add(backward, &report.b_against_a.near, gap)?;
    }
    Ok(Box::new(detection))
}

impl SlidingContacts<'_> {
    /// Adds the contacts of the vertices of one body; a bone is of particles, too, which stay.
    fn add(&mut self, direction: Direction, near: &[NearVertex], gap: f64) -> Result<(), Failure> {
        let Direction { vertices: of, against } = direction;
        let faces = self.task.moving.bodies[against].surface().faces();
        let mut contacts =
            PermanentContacts::empty(GapMeasure::AlongNormal, Margins::new(0.0, gap)?);
        let mut vertices = Vec::new();
        for near in near {
            let corners = faces[near.face as usize].map(|corner| self.first[against] + corner);
            let vertex = self.first[of] + near.vertex;
            let contact = Contact {
                stencil: Stencil::vertex_face(vertex, corners, near.barycentric),
                anchor: None,
                normal: near.normal,
                offset: 0.0,
                gap: near.gap,
                time: None,
            };
            contacts.push(&contact, Some(near.face), &self.x)?;
            vertices.push(near.vertex);
        }
        self.lists.push(ContactList { direction, vertices, contacts });
        Ok(())
    }
}

impl Detector for SlidingContacts<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { task, first, x, lists } = self;
        for (body, &first) in first.iter().enumerate() {
            let positions = task.positions(frame, body);
            x[first as usize..][..positions.len()].copy_from_slice(positions);
        }

        for ContactList { direction, contacts, .. } in lists {
            let surface = task.moving.bodies[direction.against].surface();
            let first = first[direction.against];
            let on = surface.positions(&x[first as usize..][..surface.vertex_count()])?;
            contacts.slide(x, surface, on, SurfaceCarrier::Particles { first })?;
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        let mut directions = Vec::new();
        for ContactList { direction, vertices, contacts } in &self.lists {
            let mut inside = Vec::new();
            for (&vertex, contact) in vertices.iter().zip(contacts.contacts()) {
                if contact.gap < 0.0 {
                    inside.push((vertex, -contact.gap));
                }
            }
            directions.push((*direction, inside));
        }
        Answer::Vertices(directions)
    }
}
