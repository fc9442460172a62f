//! Parts of a surface whose faces look to the wrong side: outward about a cavity, or inward in the open.
//!
//! A part separates a place from one that is covered once more, or once less. In a body that covers
//! places once these are 0 and 1 times. The exact winding number of all other parts about vertices of a
//! part says how often its outer place is covered, and whether an odd number of parts is around it: of
//! such a part faces look inward.

use glam::DVec3;
use kdop::{Axis, Dop18, Tree, Workspace};
use surface::{Positions, TriangleSurface, ray_crosses_triangle, triangle, triangles_meet};

/// Inverted parts of a surface, as one state of it has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct InvertedParts {
    /// The smallest vertex of each, ascending.
    pub(crate) roots: Vec<u32>,
    /// One per vertex: true for those of parts beside a place that is covered neither once nor not at
    /// all; empty without such a part.
    pub(crate) is_beside_doubled: Vec<bool>,
}

/// Stands for a vertex without a face.
const NO_PART: u32 = u32::MAX;

/// Connected parts of a surface.
struct SurfaceParts<'a> {
    surface: &'a TriangleSurface,
    x: Positions<'a>,
    tree: &'a Tree,
    /// One per vertex: its part, in the order of the smallest vertices, or [`NO_PART`].
    of_vertices: Vec<u32>,
    /// Vertices of all parts, part after part.
    vertices: Vec<u32>,
    /// One per part, and one more: where its vertices begin.
    starts: Vec<usize>,
}

impl InvertedParts {
    /// Finds the inverted parts of a closed, oriented surface with a tree over its faces.
    pub(crate) fn find(surface: &TriangleSurface, x: Positions<'_>, tree: &Tree) -> Self {
        let roots = surface.component_roots();
        if roots.len() < 2 {
            return Self::default();
        }
        let parts = SurfaceParts::of(surface, x, tree);
        let volumes = parts.volumes();
        let mut workspace = Workspace::default();
        let mut inverted = Self::default();
        for (part, &root) in (0..).zip(roots) {
            let volume = volumes[part as usize];
            let Some(winding) = parts.wrong_winding(part, volume, &mut workspace) else { continue };
            if (winding % 2 == 0) == (volume < 0.0) {
                inverted.roots.push(root);
            }
            inverted.is_beside_doubled.resize(surface.vertex_count(), false);
            for &vertex in parts.vertices(part) {
                inverted.is_beside_doubled[vertex as usize] = true;
            }
        }
        inverted
    }
}

impl<'a> SurfaceParts<'a> {
    /// Lists the vertices of each part, by flood fill.
    fn of(surface: &'a TriangleSurface, x: Positions<'a>, tree: &'a Tree) -> Self {
        let of_vertices = vec![NO_PART; surface.vertex_count()];
        let (vertices, starts) = (Vec::new(), vec![0]);
        let mut parts = Self { surface, x, tree, of_vertices, vertices, starts };
        for (part, &root) in (0..).zip(surface.component_roots()) {
            parts.fill(part, root);
            parts.starts.push(parts.vertices.len());
        }
        parts
    }

    /// Lists the vertices of a part; those from the last start on are the ones still to be left.
    fn fill(&mut self, part: u32, root: u32) {
        let mut next = self.vertices.len();
        self.of_vertices[root as usize] = part;
        self.vertices.push(root);
        while let Some(&at) = self.vertices.get(next) {
            next += 1;
            for &face in self.surface.vertex_faces(at) {
                for corner in self.surface.faces()[face as usize] {
                    let known = std::mem::replace(&mut self.of_vertices[corner as usize], part);
                    if known == NO_PART {
                        self.vertices.push(corner);
                    }
                }
            }
        }
    }

    fn vertices(&self, part: u32) -> &[u32] {
        &self.vertices[self.starts[part as usize]..self.starts[part as usize + 1]]
    }

    fn part_of_face(&self, face: u32) -> u32 {
        let [first, ..] = self.surface.faces()[face as usize];
        self.of_vertices[first as usize]
    }

    fn corners(&self, face: u32) -> [DVec3; 3] {
        self.x.corners(self.surface.faces()[face as usize])
    }

    /// Returns the volume that each part encloses, negative where its faces look inward; 0 within the
    /// rounding of coordinates.
    fn volumes(&self) -> Vec<f64> {
        let mut sums = vec![(0.0_f64, 0.0_f64); self.starts.len() - 1];
        for face in (0..).take(self.surface.faces().len()) {
            let part = self.part_of_face(face);
            let origin = self.x.at(self.vertices(part)[0]);
            let (volume, area) = &mut sums[part as usize];
            let corners = self.corners(face);
            *volume += triangle::signed_volume([corners], origin);
            *area += triangle::area(corners);
        }
        let largest = self.x.as_slice().iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
        let is_certain = |volume: f64, area: f64| volume.abs() > f64::EPSILON * largest * area;
        let certain = |&(volume, area)| if is_certain(volume, area) { volume } else { 0.0 };
        sums.iter().map(certain).collect()
    }

    /// Returns the winding number of the other parts about a part that separates other places than
    /// those covered 0 times and once; `None` for a part as it should be.
    ///
    /// All vertices that are tested have to agree: parts that cross each other are not in each other.
    fn wrong_winding(&self, part: u32, volume: f64, workspace: &mut Workspace) -> Option<i32> {
        /// Number of vertices that are tested, all over the part. Fewer take parts that cross by little
        /// for parts in each other; more only take longer.
        const MAX_TESTED: usize = 64;

        let expected = match volume {
            volume if volume > 0.0 => 0,
            volume if volume < 0.0 => 1,
            _ => return None,
        };
        let vertices = self.vertices(part);
        let mut found = None;
        for &vertex in vertices.iter().step_by(vertices.len().div_ceil(MAX_TESTED)) {
            if self.is_on_others(part, vertex, workspace) {
                continue;
            }
            let winding = self.winding_of_others(part, vertex, workspace);
            if winding == expected {
                return None;
            }
            found = found.or(Some(winding));
        }
        found
    }

    fn is_on_others(&self, part: u32, vertex: u32, workspace: &mut Workspace) -> bool {
        let point = self.x.at(vertex);
        let mut is_on = false;
        self.tree.query(&Dop18::from_points(&[point]), workspace, |face| {
            is_on |= self.part_of_face(face) != part
                && triangles_meet([point; 3], self.corners(face)).shares_a_point();
        });
        is_on
    }

    fn winding_of_others(&self, part: u32, vertex: u32, workspace: &mut Workspace) -> i32 {
        let point = self.x.at(vertex);
        let mut winding = 0;
        self.tree.ray(point, Axis::X, workspace, |face| {
            if self.part_of_face(face) != part {
                winding += ray_crosses_triangle(point, self.corners(face)).unwrap_or(0);
            }
        });
        winding
    }
}
