//! Which vertices are inside another surface.
//!
//! A face that shares no point with the other surface lies wholly on one side
//! of it, so its corners are on the same side. Faces joined by corners thus
//! form regions, and counting the crossings of one ray tells where a whole
//! region is. This is exact where the predicates are: faces that touch or
//! cross the other surface join nothing, and vertices that only such faces
//! have are counted one by one. A region that is inside is walked through from
//! its rim; of one outside, which may be most of a surface, the rim alone.

use glam::DVec3;
use kdop::{Axis, Dop18, Workspace};
use surface::{TriangleSurface, ray_crosses_triangle, triangles_meet};

use crate::shape::Shape;

/// Memory for the regions of one surface at a time.
#[derive(Debug, Default)]
pub(super) struct Regions {
    is_cut: Vec<bool>,
    known: Vec<Known>,
    /// Vertices whose faces are still to be looked at.
    rest: Vec<u32>,
}

/// What is known of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    Nothing,
    /// That it is a corner of a face that is cut.
    Rim,
    Side,
}

impl Regions {
    /// Writes the vertices of `a` inside `b`, ascending; `cut_faces` are the
    /// faces of `a` that share a point with `b`'s surface, ascending. Vertices
    /// without a face are left out.
    pub(super) fn inside(
        &mut self,
        (a, cut_faces): (&Shape, &[u32]),
        b: &Shape,
        traversal: &mut Workspace,
        out: &mut Vec<u32>,
    ) {
        out.clear();
        let x = a.positions();
        if cut_faces.is_empty()
            && !a.parts().any(|vertex| is_inside(b, x[vertex as usize], traversal))
        {
            return;
        }
        let corners = |face: &u32| a.surface().faces()[*face as usize];
        refill(&mut self.is_cut, a.surface().faces().len(), false);
        refill(&mut self.known, a.surface().vertex_count(), Known::Nothing);
        for face in cut_faces {
            self.is_cut[*face as usize] = true;
            corners(face).iter().for_each(|&corner| self.known[corner as usize] = Known::Rim);
        }
        for start in cut_faces.iter().flat_map(corners).chain(a.parts()) {
            if self.known[start as usize] != Known::Side {
                let is_inside = is_inside(b, x[start as usize], traversal);
                self.spread(a.surface(), start, is_inside, out);
            }
        }
        out.sort_unstable();
    }

    /// Tells the side of a vertex to those joined to it by faces that are not cut:
    /// to all of them inside; outside, to those along the rim, since others are
    /// joined to no vertex whose side is still to be found.
    fn spread(&mut self, a: &TriangleSurface, start: u32, is_inside: bool, out: &mut Vec<u32>) {
        let Self { is_cut, known, rest } = self;
        let mut tell = |vertex: u32, rest: &mut Vec<u32>| {
            let before = std::mem::replace(&mut known[vertex as usize], Known::Side);
            if before == Known::Side {
                return;
            }
            if is_inside {
                out.push(vertex);
            }
            if is_inside || before == Known::Rim {
                rest.push(vertex);
            }
        };
        tell(start, rest);
        while let Some(vertex) = rest.pop() {
            for &face in a.vertex_faces(vertex).iter().filter(|&&face| !is_cut[face as usize]) {
                a.faces()[face as usize].iter().for_each(|&corner| tell(corner, rest));
            }
        }
    }
}

fn refill<T: Clone>(values: &mut Vec<T>, count: usize, value: T) {
    values.clear();
    values.resize(count, value);
}

/// Whether a point is inside, by the parity of the faces that a ray along +x
/// crosses. Points on the surface are not inside.
pub(super) fn is_inside(body: &Shape, point: DVec3, traversal: &mut Workspace) -> bool {
    let mut odd = false;
    body.tree().ray(point, Axis::X, traversal, |face| {
        odd ^= ray_crosses_triangle(point, body.corners(face)).is_some();
    });
    odd && !is_on_surface(body, point, traversal)
}

fn is_on_surface(body: &Shape, point: DVec3, traversal: &mut Workspace) -> bool {
    let mut on_surface = false;
    body.tree().query(&Dop18::from_points(&[point]), traversal, |face| {
        on_surface |= triangles_meet([point; 3], body.corners(face)).shares_a_point();
    });
    on_surface
}

/// The first vertex of each connected part of a surface, vertices without a face
/// left out.
pub(crate) fn parts(surface: &TriangleSurface) -> Vec<u32> {
    let mut parents = Vec::new();
    each_alone(&mut parents, surface.vertex_count());
    surface.faces().iter().for_each(|&corners| join_all(&mut parents, corners));
    let is_first = |&vertex: &u32| {
        parents[vertex as usize] == vertex && !surface.vertex_faces(vertex).is_empty()
    };
    (0..).take(surface.vertex_count()).filter(is_first).collect()
}

pub(super) fn each_alone(parents: &mut Vec<u32>, count: usize) {
    parents.clear();
    parents.extend((0..).take(count));
}

pub(super) fn join_all(parents: &mut [u32], [a, b, c]: [u32; 3]) {
    join(parents, a, b);
    join(parents, b, c);
}

/// Joins two sets under the smaller of their roots.
fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// The smallest vertex of a set, halving the path to it.
pub(super) fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        parents[vertex as usize] = parents[parents[vertex as usize] as usize];
        vertex = parents[vertex as usize];
    }
    vertex
}
