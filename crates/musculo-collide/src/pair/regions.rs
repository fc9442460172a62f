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
    parents: Vec<u32>,
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
        let surface = a.surface();
        out.clear();
        let mut is_inside_at =
            |vertex: u32| is_inside(b, a.positions()[vertex as usize], traversal);
        if cut_faces.is_empty() && !a.parts().any(&mut is_inside_at) {
            return;
        }
        let Self { parents, sides } = self;
        join_uncut_faces(surface, cut_faces, parents);
        sides.clear();
        sides.resize(surface.vertex_count(), None);
        for vertex in (0..).take(surface.vertex_count()) {
            if surface.vertex_faces(vertex).is_empty() {
                continue;
            }
            let side = &mut sides[root(parents, vertex) as usize];
            if *side.get_or_insert_with(|| is_inside_at(vertex)) {
                out.push(vertex);
            }
        }
    }
}

/// Whether a point is inside, by the parity of the faces that a ray along +x
/// crosses. Points on the surface are not inside.
fn is_inside(body: &Shape, point: DVec3, traversal: &mut Workspace) -> bool {
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
    join_uncut_faces(surface, &[], &mut parents);
    let is_first = |&vertex: &u32| {
        parents[vertex as usize] == vertex && !surface.vertex_faces(vertex).is_empty()
    };
    (0..).take(surface.vertex_count()).filter(is_first).collect()
}

fn join_uncut_faces(surface: &TriangleSurface, cut_faces: &[u32], parents: &mut Vec<u32>) {
    parents.clear();
    parents.extend((0..).take(surface.vertex_count()));
    let mut cut = cut_faces.iter().peekable();
    for (face, &[a, b, c]) in (0..).zip(surface.faces()) {
        if cut.next_if_eq(&&face).is_none() {
            join(parents, a, b);
            join(parents, b, c);
        }
    }
}

/// Joins two sets under the smaller of their roots.
fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

/// The smallest vertex of a set, halving the path to it.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        parents[vertex as usize] = parents[parents[vertex as usize] as usize];
        vertex = parents[vertex as usize];
    }
    vertex
}
