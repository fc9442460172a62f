//! Ways out of shallow overlaps whose corners go in and out in turns.
//!
//! Where two ridges stand side by side, a corner of either is just below the top of the other. Its nearest way out
//! leads over that top, and takes the other corner in. The sides follow from the overlap as a whole: the vector area of
//! the curve in which faces cross, ½ ∮ x × dx, is the gradient of the overlap's volume under a translation (divergence
//! theorem). Along it the volume falls fastest, and the way out is short. From the round on in
//! which a particle is pushed back, the faces that cross there come apart in that direction.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use scene::Body;
use surface::{Contact, UnionFind, triangle};

use crate::edge_contacts::{FaceSide, contact_along};

/// Cosine between two pushes of a particle of which the second takes the first back. Below, tissue that is pressed
/// from two sides counts; above, corners that are pushed back at an angle do not.
const MAX_TURNED_COSINE: f64 = -0.7;

/// Share of the area of a curve that its vector area keeps at least. Below, tissue that embraces a bone leaves it to one
/// side; above, curves around a corner have no direction.
const MIN_AREA_SHARE: f64 = 0.4;

/// Pushes of the particles of a pair in earlier rounds.
#[derive(Clone, Debug, Default)]
pub(crate) struct PushMemory {
    /// Directions in which particles were pushed last.
    last: BTreeMap<u32, DVec3>,
    /// Particles that were pushed back once.
    turned: BTreeSet<u32>,
}

impl PushMemory {
    /// Remembers the pushes by contacts, and directs those of overlaps whose particles were pushed back.
    pub(crate) fn direct(
        &mut self,
        bodies: [&Body; 2],
        crossing_faces: &[[u32; 2]],
        contacts: &mut Vec<Contact>,
    ) {
        self.remember(contacts);
        if self.turned.is_empty() {
            return;
        }
        let sides = FaceSide::of_pair(bodies);
        for faces in connected(crossing_faces) {
            let particles = particles(bodies, &faces);
            if particles.is_disjoint(&self.turned) {
                continue;
            }
            let Some(direction) = way_out(bodies, &faces) else { continue };
            contacts.retain(|contact| {
                let mut terms = contact.stencil.terms().iter();
                contact.gap >= 0.0 || !terms.any(|term| particles.contains(&term.particle))
            });
            contacts.extend(faces.iter().filter_map(|pair| contact_along(sides, *pair, direction)));
        }
    }

    /// Remembers the directions in which contacts push particles, and those that are pushed back.
    fn remember(&mut self, contacts: &[Contact]) {
        for contact in contacts.iter().filter(|contact| contact.gap < 0.0) {
            for term in contact.stencil.terms().iter().filter(|term| term.weight.abs() > 0.5) {
                let push = -term.weight.signum() * contact.normal;
                let last = self.last.insert(term.particle, push);
                if last.is_some_and(|last| last.dot(push) < MAX_TURNED_COSINE) {
                    self.turned.insert(term.particle);
                }
            }
        }
    }
}

/// Splits pairs of crossing faces into those of each curve, joined by common faces.
fn connected(crossing_faces: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
    let mut sets = UnionFind::new(crossing_faces.len());
    for side in 0..2 {
        let mut first_of: BTreeMap<u32, u32> = BTreeMap::new();
        for (number, faces) in (0..).zip(crossing_faces) {
            sets.join(*first_of.entry(faces[side]).or_insert(number), number);
        }
    }
    let mut curves: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for (number, faces) in (0..).zip(crossing_faces) {
        curves.entry(sets.find(number)).or_default().push(*faces);
    }
    curves.into_values().collect()
}

/// Collects the particles of faces of both bodies.
fn particles(bodies: [&Body; 2], faces: &[[u32; 2]]) -> BTreeSet<u32> {
    let mut particles = BTreeSet::new();
    for pair in faces {
        for (body, face) in bodies.into_iter().zip(pair) {
            let numbers = body.particle_numbers();
            let corners = body.surface().faces()[*face as usize];
            particles.extend(corners.map(|vertex| numbers.particle(vertex)));
        }
    }
    particles
}

/// Computes the direction of the vector area of the curve in which faces cross, out of the second body; `None` where
/// the overlap is embraced from all sides.
fn way_out(bodies: [&Body; 2], faces: &[[u32; 2]]) -> Option<DVec3> {
    let segments: Vec<[DVec3; 2]> =
        faces.iter().filter_map(|pair| crossing_segment(bodies, *pair)).collect();

    // About the center of the curve, so that gaps in it count for little.
    let mut sum = DVec3::ZERO;
    let mut length = 0.0;
    for [from, to] in &segments {
        sum += from.distance(*to) * from.midpoint(*to);
        length += from.distance(*to);
    }
    let center = sum / length;

    // The areas of its triangles there, added as vectors and as numbers.
    let (mut vector, mut area) = (DVec3::ZERO, 0.0);
    for [from, to] in segments {
        let doubled = (from - center).cross(to - center);
        vector += doubled;
        area += doubled.length();
    }
    (vector.length() >= MIN_AREA_SHARE * area).then(|| vector.try_normalize()).flatten()
}

/// Computes the segment in which two faces cross. The part of the second face that is inside the first body is on
/// its left, seen from outside the second one.
fn crossing_segment(bodies: [&Body; 2], faces: [u32; 2]) -> Option<[DVec3; 2]> {
    let corners = [0, 1].map(|side| bodies[side].corners(faces[side]));
    let normals = [0, 1].map(|side: usize| {
        let normal = triangle::unit_normal(corners[side]);
        if bodies[side].is_inside_out() { -normal } else { normal }
    });
    let along = normals[1].cross(normals[0]).try_normalize()?;

    // Each face meets the plane of the other one in a segment; the line in which the planes meet holds both.
    let mut ends = [None, None];
    for side in 0..2 {
        let (plane, on_plane) = (normals[1 - side], corners[1 - side][0]);
        let heights = corners[side].map(|corner| (corner - on_plane).dot(plane));
        for k in 0..3 {
            let next = (k + 1) % 3;
            if (heights[k] < 0.0) != (heights[next] < 0.0) {
                let share = heights[k] / (heights[k] - heights[next]);
                let point = corners[side][k].lerp(corners[side][next], share);
                let [low, high] = ends[side].get_or_insert([point; 2]);
                if point.dot(along) < low.dot(along) {
                    *low = point;
                } else {
                    *high = point;
                }
            }
        }
    }
    let [[low, high], [other_low, other_high]] = [ends[0]?, ends[1]?];
    let from = if other_low.dot(along) > low.dot(along) { other_low } else { low };
    let to = if other_high.dot(along) < high.dot(along) { other_high } else { high };
    ((to - from).dot(along) > 0.0).then_some([from, to])
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use scene::{CheckParams, Scene};
    use surface::progress::Progress;

    use super::*;

    /// Adds a rigid body and a soft one; returns the faces that cross.
    fn crossing(bone: Mesh, muscle: Mesh) -> (Scene, Vec<[u32; 2]>) {
        let mut scene = crate::test_scenes::bone_and_muscle(bone, muscle);
        let params = CheckParams::without_measures(0.0);
        let reports = scene.check(&params, Progress::none()).expect("a check");
        (scene, reports[0].crossing_faces.clone())
    }

    #[test]
    fn corners_leave_each_other_where_they_cover_each_other_least() {
        // Two blocks side by side, the second .1 higher and .4 to the left of where they touch.
        let muscle = shapes::cube(6.0).translated(DVec3::new(5.6, 1.0, 0.1));
        for bone in [shapes::cube(6.0), shapes::cube(6.0).flipped()] {
            let (scene, faces) = crossing(bone, muscle.clone());
            let bodies = [&scene.bodies()[0], &scene.bodies()[1]];
            let [curve] = &connected(&faces)[..] else { panic!("one curve: {faces:?}") };
            let out_of_muscle = way_out(bodies, curve).expect("a direction");
            assert!(out_of_muscle.x < -0.97, "{out_of_muscle}");
            let back = curve.iter().map(|&[a, b]| [b, a]).collect::<Vec<_>>();
            let out_of_bone = way_out([bodies[1], bodies[0]], &back).expect("a direction");
            assert!((out_of_bone + out_of_muscle).length() < 1e-9, "{out_of_bone}");
        }
    }

    #[test]
    fn faces_of_two_curves_are_apart_and_what_is_embraced_has_no_way_out() {
        // A rod through a cube: a curve where it enters, and one where it leaves.
        let rod = shapes::plate(DVec3::new(20.0, 1.0, 1.0), [20, 1])
            .translated(DVec3::new(0.1, 0.6, 0.3));
        let (scene, faces) = crossing(rod, shapes::cube(6.0));
        let bodies = [&scene.bodies()[0], &scene.bodies()[1]];
        let curves = connected(&faces);
        assert_eq!(curves.len(), 2, "{curves:?}");
        assert_eq!(curves.iter().map(Vec::len).sum::<usize>(), faces.len());
        let [of_one, of_both] = [&curves[0], &faces].map(|curve| way_out(bodies, curve));
        let along = of_one.expect("a direction").dot(DVec3::X).abs();
        assert!(along > 0.99 && of_both.is_none(), "{of_one:?} {of_both:?}");
    }

    #[test]
    fn particles_that_are_pushed_back_are_remembered() {
        let [pushed, back] = [DVec3::Z, -DVec3::Z].map(|normal| {
            let stencil = surface::Stencil::vertex_face(7, [0, 1, 2], [0.3, 0.3, 0.4]);
            Contact { stencil, anchor: None, normal, offset: 0.0, gap: -1.0, time: None }
        });
        let mut memory = PushMemory::default();
        memory.remember(&[pushed, Contact { gap: 0.5, ..back }]);
        assert!(memory.turned.is_empty(), "what is apart pushes nothing");
        memory.remember(&[pushed]);
        assert!(memory.turned.is_empty());
        memory.remember(&[back]);
        assert_eq!(memory.turned, BTreeSet::from([7]), "corners of the face are not its own");
    }

    /// A push of a vertex out of a face is one of the face the other way.
    #[test]
    fn corners_of_a_face_are_pushed_against_the_normal() {
        let contact = |normal, vertex, face| {
            let stencil = surface::Stencil::vertex_face(vertex, face, [0.8, 0.1, 0.1]);
            Contact { stencil, anchor: None, normal, offset: 0.0, gap: -1.0, time: None }
        };
        let mut memory = PushMemory::default();
        memory.remember(&[contact(DVec3::Z, 7, [0, 1, 2])]);
        memory.remember(&[contact(-DVec3::Z, 8, [7, 3, 4])]);
        assert!(memory.turned.is_empty(), "pushed up, and up again: {memory:?}");
        memory.remember(&[contact(DVec3::Z, 9, [7, 3, 4])]);
        assert_eq!(memory.turned, BTreeSet::from([7]));
    }
}
