//! Point containment by ray parity, and the vertices of one surface inside another.
//!
//! A face that shares no point with the other surface lies wholly on one side of it, so its
//! corners are on the same side. Faces joined by corners thus form regions, and one ray decides
//! for a whole region. This is exact where the predicates are: faces that touch or cross the
//! other surface join nothing, and vertices that only such faces have are decided one by one.
//!
//! Parity is undefined for a surface with holes. What it surrounds as a whole is inside by winding numbers.
//!
//! Source: A. Jacobson, L. Kavan and O. Sorkine-Hornung, "Robust inside-outside segmentation using generalized
//! winding numbers", ACM Transactions on Graphics 32(4), 2013, for these.

use glam::DVec3;
use kdop::{Axis, Dop18, Workspace};
use surface::{TriangleSurface, ray_crosses_triangle, triangles_meet, winding_number};

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

    /// Returns true if the surface surrounds another one that it does not meet, though it has holes: by the generalized
    /// winding numbers of vertices, which are 1 but for the part of all directions that a hole takes.
    pub(crate) fn surrounds(&self, other: &Self) -> bool {
        /// Number of vertices that are tested, all over the other surface. With more, some that reach out of a hole by
        /// little are left out.
        const MAX_TESTED: usize = 16;

        let faces = other.surface().faces();
        let step = faces.len().div_ceil(MAX_TESTED).max(1);
        let mut tested = faces.iter().step_by(step).map(|&[vertex, ..]| other.position(vertex));
        let is_surrounded = |x| winding_number(self.surface(), self.positions(), x).abs() > 0.5;
        !faces.is_empty() && tested.all(is_surrounded)
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
    /// Per face and per vertex: false and unvisited between searches, since most of a surface is far
    /// from any cut.
    is_cut: Vec<bool>,
    labels: Vec<Label>,
    /// Vertices with another label.
    touched: Vec<u32>,
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
        extend(&mut self.is_cut, surface.faces().len(), false);
        extend(&mut self.labels, surface.vertex_count(), Label::Unvisited);
        for &face in cut_faces {
            self.is_cut[face as usize] = true;
            for corner in surface.faces()[face as usize] {
                self.set_label(corner, Label::Rim);
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

        // Only what was set is reset.
        for vertex in self.touched.drain(..) {
            self.labels[vertex as usize] = Label::Unvisited;
        }
        for &face in cut_faces {
            self.is_cut[face as usize] = false;
        }
    }

    /// Sets the label of a vertex, and returns the one before.
    fn set_label(&mut self, vertex: u32, label: Label) -> Label {
        let previous = std::mem::replace(&mut self.labels[vertex as usize], label);
        if previous == Label::Unvisited {
            self.touched.push(vertex);
        }
        previous
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
        let previous = self.set_label(vertex, Label::Visited);
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

/// Extends values to a count, unless there are as many.
fn extend<T: Clone>(values: &mut Vec<T>, count: usize, value: T) {
    if values.len() < count {
        values.resize(count, value);
    }
}
