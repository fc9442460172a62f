//! Vertices projected to the nearest point of another surface.

use glam::DVec3;
use kdop::Workspace;
use surface::{Barycentric, ClosestOnTriangle, TriangleSurface, closest_on_triangle};

use super::direction_or;
use crate::shape::Shape;

/// A vertex that is inside the other body or within the margin of its surface, and
/// the nearest point of that surface, its foot.
///
/// `position = foot + gap * normal`, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NearVertex {
    /// The vertex.
    pub vertex: u32,
    /// Signed distance to the other surface, negative inside. Positive
    /// throughout where the other body has no inside.
    pub gap: f64,
    /// The nearest point.
    pub foot: DVec3,
    /// Face of the other surface that holds the foot; where several do, the one
    /// of the lowest number.
    pub face: u32,
    /// The foot in weights of that face's corners.
    pub barycentric: Barycentric,
    /// Unit length; points out of the other body at the foot, or to the vertex
    /// where the body has no inside.
    pub normal: DVec3,
}

/// Vertices of one surface whose faces come near the other, each with the
/// nearest of the faces that do.
///
/// Of all faces at a vertex the first stands for it: what is within the margin of a
/// vertex is within the margin of each of them.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    vertices: Vec<u32>,
    nearest: Vec<(f64, u32)>,
}

/// No face is known to be near.
pub(crate) const NO_HINT: u32 = u32::MAX;

/// Gathers the vertices of both surfaces that may be outside but within the margin;
/// without any margin, these are of the faces that meet.
pub(super) fn find_candidates(
    [(a, of_a), (b, of_b)]: [(&Shape, &mut Candidates); 2],
    (margin, meeting): (f64, &[[u32; 2]]),
    traversal: &mut Workspace,
) {
    of_a.clear(a);
    of_b.clear(b);
    let mut offer = |fa, fb| {
        of_a.offer((a, fa), (b, fb));
        of_b.offer((b, fb), (a, fa));
    };
    if margin > 0.0 {
        a.tree().pairs(b.tree(), margin, traversal, offer);
    } else {
        meeting.iter().for_each(|&[fa, fb]| offer(fa, fb));
    }
}

/// Projects the vertices of `a` that are inside `b` (ascending), and the
/// candidates within `margin`, to the surface of `b`.
pub(super) fn project(
    (a, inside): (&Shape, &[u32]),
    b: &Shape,
    margin: f64,
    candidates: &mut Candidates,
    traversal: &mut Workspace,
    out: &mut Vec<NearVertex>,
) {
    candidates.add_inside(inside);
    let Candidates { vertices, nearest: known } = candidates;
    let mut inside = inside.iter().peekable();
    let near = |&vertex: &u32| {
        let is_inside = inside.next_if_eq(&&vertex).is_some();
        let position = a.positions()[vertex as usize];
        let (distance, face) = known[vertex as usize];
        // Without any margin, the faces that were offered are not all that are near.
        let is_known = margin > 0.0 && distance <= margin;
        let (face, foot) = match (is_known, is_inside) {
            (true, _) => (face, closest_on_triangle(position, b.corners(face))),
            (false, true) => nearest(b, position, f64::INFINITY, face, traversal)?,
            (false, false) if margin > 0.0 => return None,
            (false, false) => nearest(b, position, margin, face, traversal)?,
        };
        pass_on(a.surface(), vertex, face, known);
        Some(near_vertex(b, vertex, position, is_inside, face, &foot))
    };
    out.clear();
    out.extend(vertices.iter().filter_map(near));
}

/// Makes the face found for a vertex one to look at first from those next to it
/// that know none.
fn pass_on(surface: &TriangleSurface, vertex: u32, found: u32, known: &mut [(f64, u32)]) {
    for &face in surface.vertex_faces(vertex) {
        for corner in surface.faces()[face as usize] {
            let (_, hint) = &mut known[corner as usize];
            if *hint == NO_HINT {
                *hint = found;
            }
        }
    }
}

/// The nearest point of a body's surface within `limit`, and its face; `hint`
/// is a face that is likely near.
pub(crate) fn nearest(
    body: &Shape,
    point: DVec3,
    limit: f64,
    hint: u32,
    traversal: &mut Workspace,
) -> Option<(u32, ClosestOnTriangle)> {
    let mut best: Option<(f64, u32, ClosestOnTriangle)> = None;
    let mut offer = |face: u32| {
        let foot = closest_on_triangle(point, body.corners(face));
        let distance = foot.point.distance(point);
        let better = best.is_none_or(|(least, lowest, _)| (distance, face) < (least, lowest));
        if distance <= limit && better {
            best = Some((distance, face, foot));
        }
        best.map_or(limit, |(least, ..)| least)
    };
    let within = if hint == NO_HINT { limit } else { offer(hint) };
    body.tree().nearest(point, within, traversal, |face, _| offer(face));
    best.map(|(_, face, foot)| (face, foot))
}

fn near_vertex(
    body: &Shape,
    vertex: u32,
    position: DVec3,
    is_inside: bool,
    face: u32,
    foot: &ClosestOnTriangle,
) -> NearVertex {
    let side = if is_inside { -1.0 } else { 1.0 };
    let offset = position - foot.point;
    let [p, q, r] = body.corners(face);
    let face_normal = (q - p).cross(r - p).normalize_or(DVec3::Z);
    let scale = position.abs().max(foot.point.abs()).max_element();
    NearVertex {
        vertex,
        gap: side * offset.length(),
        foot: foot.point,
        face,
        barycentric: foot.barycentric,
        normal: direction_or(side * offset, scale, face_normal),
    }
}

impl Candidates {
    fn clear(&mut self, body: &Shape) {
        self.vertices.clear();
        self.nearest.clear();
        self.nearest.resize(body.surface().vertex_count(), (f64::INFINITY, NO_HINT));
    }

    /// Offers a face to the vertices that another face stands for.
    fn offer(&mut self, (p, of_p): (&Shape, u32), (q, of_q): (&Shape, u32)) {
        for vertex in p.surface().faces()[of_p as usize] {
            if p.surface().vertex_faces(vertex).first() != Some(&of_p) {
                continue;
            }
            let position = p.positions()[vertex as usize];
            let foot = closest_on_triangle(position, q.corners(of_q));
            let offered = (foot.point.distance(position), of_q);
            let known = &mut self.nearest[vertex as usize];
            if known.1 == NO_HINT {
                self.vertices.push(vertex);
            }
            if offered < *known {
                *known = offered;
            }
        }
    }

    /// Adds vertices that are inside, and brings all into ascending order.
    fn add_inside(&mut self, inside: &[u32]) {
        self.vertices.extend_from_slice(inside);
        self.vertices.sort_unstable();
        self.vertices.dedup();
    }
}
