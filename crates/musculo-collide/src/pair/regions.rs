//! Which vertices are inside another surface.
//!
//! A face that shares no point with the other surface lies wholly on one side
//! of it, so its corners are on the same side. Faces joined by corners thus
//! form regions, and counting the crossings of one ray tells where a whole
//! region is. This is exact where the predicates are: faces that touch or
//! cross the other surface join nothing, and vertices that only such faces
//! have are counted one by one.

use glam::DVec3;
use kdop::{Axis, Dop18, Workspace};
use surface::{TriangleSurface, ray_crosses_triangle, triangles_meet};

use crate::shape::Shape;

/// Memory for the regions of one surface at a time.
#[derive(Debug, Default)]
pub(super) struct Regions {
    /// Faces that come near the other surface, in the order of the tree.
    faces: Vec<u32>,
    is_cut: Vec<bool>,
    parents: Vec<u32>,
    /// By vertex: whether it may be inside.
    is_near: Vec<bool>,
    /// By the smallest vertex of each region: whether it is inside.
    sides: Vec<Option<bool>>,
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
        self.join_near(a, cut_faces, b, traversal);
        let Self { parents, is_near, sides, .. } = self;
        for vertex in (0..).zip(&*is_near).filter_map(|(vertex, near)| near.then_some(vertex)) {
            let side = &mut sides[root(parents, vertex) as usize];
            if *side.get_or_insert_with(|| is_inside(b, x[vertex as usize], traversal)) {
                out.push(vertex);
            }
        }
    }

    /// Joins what is on one side: faces that are not cut, by common corners. Only
    /// within the bounds of `b`, since what is inside has all its faces there.
    fn join_near(&mut self, a: &Shape, cut_faces: &[u32], b: &Shape, traversal: &mut Workspace) {
        let Self { faces, is_cut, parents, is_near, sides } = self;
        let (surface, vertices) = (a.surface(), a.surface().vertex_count());
        faces.clear();
        a.tree().query(&b.tree().root(), traversal, |face| faces.push(face));
        refill(is_cut, surface.faces().len(), false);
        cut_faces.iter().for_each(|&face| is_cut[face as usize] = true);
        refill(is_near, vertices, false);
        refill(sides, vertices, None);
        each_alone(parents, vertices);
        for &face in &*faces {
            let corners = surface.faces()[face as usize];
            corners.iter().for_each(|&corner| is_near[corner as usize] = true);
            if !is_cut[face as usize] {
                join_all(parents, corners);
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
