//! Point containment by ray parity, and the vertices of one surface inside another.
//!
//! A face that shares no point with the other surface lies wholly on one side of it, so its
//! corners are on the same side. Faces joined by corners thus form regions, and one ray decides
//! for a whole region. This is exact where the predicates are: faces that touch or cross the
//! other surface join nothing, and vertices that only such faces have are decided one by one.

use glam::DVec3;
use kdop::{Axis, Dop18, Workspace};
use surface::{TriangleSurface, ray_crosses_triangle, triangles_meet};

use crate::SurfaceTree;

impl SurfaceTree {
    /// Returns true if the point is inside, by the parity of the faces that a ray along +x
    /// crosses. Points on the surface are not inside.
    ///
    /// Meaningful where [`has_inside`](Self::has_inside) holds.
    #[must_use]
    pub fn contains(&self, point: DVec3, workspace: &mut Workspace) -> bool {
        let mut is_odd = false;
        self.tree().ray(point, Axis::X, workspace, |face| {
            is_odd ^= ray_crosses_triangle(point, self.corners(face)).is_some();
        });
        is_odd && !self.is_on_surface(point, workspace)
    }

    fn is_on_surface(&self, point: DVec3, workspace: &mut Workspace) -> bool {
        let mut is_on = false;
        self.tree().query(&Dop18::from_points(&[point]), workspace, |face| {
            is_on |= triangles_meet([point; 3], self.corners(face)).shares_a_point();
        });
        is_on
    }
}

/// Labels of the vertices of one surface, in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct InsideVertices {
    is_cut: Vec<bool>,
    labels: Vec<Label>,
    /// Vertices whose faces are still to be visited.
    stack: Vec<u32>,
}

/// Progress of the flood fill at one vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Label {
    Unvisited,
    /// Corner of a cut face, not yet visited.
    Rim,
    Visited,
}

impl InsideVertices {
    /// Writes the vertices of `a` inside `b`, ascending; vertices without a face are left out.
    ///
    /// `cut_faces` are the faces of `a` that share a point with `b`.
    pub(crate) fn find(
        &mut self,
        a: &SurfaceTree,
        cut_faces: &[u32],
        b: &SurfaceTree,
        workspace: &mut Workspace,
        inside: &mut Vec<u32>,
    ) {
        inside.clear();

        // Without a cut, each component is on one side: mostly outside, and then all is done.
        let components = a.surface().component_roots();
        if cut_faces.is_empty()
            && !components.iter().any(|&vertex| b.contains(a.position(vertex), workspace))
        {
            return;
        }

        // Cut faces join nothing, and their corners begin the search.
        let surface = a.surface();
        refill(&mut self.is_cut, surface.faces().len(), false);
        refill(&mut self.labels, surface.vertex_count(), Label::Unvisited);
        for &face in cut_faces {
            self.is_cut[face as usize] = true;
            for corner in surface.faces()[face as usize] {
                self.labels[corner as usize] = Label::Rim;
            }
        }

        // One ray per region, from the rim of the cut or from any vertex of a whole component.
        let rim = cut_faces.iter().flat_map(|&face| surface.faces()[face as usize]);
        for start in rim.chain(components.iter().copied()) {
            if self.labels[start as usize] != Label::Visited {
                let is_inside = b.contains(a.position(start), workspace);
                self.flood(surface, start, is_inside, inside);
            }
        }
        inside.sort_unstable();
    }

    /// Flood-fills the side of `start` over faces that are not cut.
    ///
    /// An inside region is visited whole, since all of its vertices are reported. An outside
    /// region, which may be most of a surface, is only followed along the rim of the cut: no
    /// vertex still to be decided is reachable through its other vertices alone.
    fn flood(
        &mut self,
        surface: &TriangleSurface,
        start: u32,
        is_inside: bool,
        inside: &mut Vec<u32>,
    ) {
        self.visit(start, is_inside, inside);
        while let Some(vertex) = self.stack.pop() {
            for &face in surface.vertex_faces(vertex) {
                if self.is_cut[face as usize] {
                    continue;
                }
                for corner in surface.faces()[face as usize] {
                    self.visit(corner, is_inside, inside);
                }
            }
        }
    }

    fn visit(&mut self, vertex: u32, is_inside: bool, inside: &mut Vec<u32>) {
        let label = &mut self.labels[vertex as usize];
        let previous = std::mem::replace(label, Label::Visited);
        if previous == Label::Visited {
            return;
        }
        if is_inside {
            inside.push(vertex);
        }
        if is_inside || previous == Label::Rim {
            self.stack.push(vertex);
        }
    }
}

fn refill<T: Clone>(values: &mut Vec<T>, count: usize, value: T) {
    values.clear();
    values.resize(count, value);
}
