//! Closed bodies: read from files, and how deep a point is in one.

use std::path::Path;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use surface::{Pseudonormals, TriangleSurface, closest_on_triangle};

use crate::ratio::amount;

/// A closed surface where it is.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its connectivity.
    pub surface: TriangleSurface,
    /// Its vertices.
    pub x: Vec<DVec3>,
}

impl Body {
    /// Mean of the vertices.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.x.iter().sum::<DVec3>() / amount(self.x.len())
    }

    /// Lowest and highest corner of the box around it.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.x.iter().fold(empty, |[low, high], p| [low.min(*p), high.max(*p)])
    }

    /// Diagonal of that box.
    #[must_use]
    pub fn extent(&self) -> f64 {
        let [low, high] = self.bounds();
        low.distance(high)
    }

    /// The same body elsewhere.
    #[must_use]
    pub fn moved(&self, by: DVec3) -> Self {
        let x = self.x.iter().map(|p| *p + by).collect();
        Self { surface: self.surface.clone(), x }
    }

    /// Corners of a face.
    #[must_use]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.x[vertex as usize])
    }
}

/// How deep points are in a body: the closest point by a tree over its faces, the side by the
/// normal there.
#[derive(Debug)]
pub struct Depth<'a> {
    body: &'a Body,
    normals: Pseudonormals,
    tree: Tree,
}

impl<'a> Depth<'a> {
    /// Looks at a body.
    ///
    /// # Panics
    ///
    /// When its vertices are not finite.
    #[must_use]
    pub fn new(body: &'a Body) -> Self {
        let x = body.surface.positions(&body.x).expect("finite positions");
        let leaves = Leaves::Triangles(body.surface.faces());
        let tree = Tree::build(leaves, &body.x).expect("finite positions");
        Self { body, normals: Pseudonormals::new(&body.surface, x), tree }
    }

    /// Depth of a point, negative outside; `-within` where the surface is not nearer than that.
    #[must_use]
    pub fn at(&self, p: DVec3, within: f64, workspace: &mut Workspace) -> f64 {
        self.foot(p, within, workspace).map_or(-within, |(_, depth)| depth)
    }

    /// The closest point of the surface, and the depth below it; none where the surface is not
    /// nearer than `within`.
    #[must_use]
    pub fn foot(&self, p: DVec3, within: f64, workspace: &mut Workspace) -> Option<(DVec3, f64)> {
        let (mut nearest, mut best) = (within, None);
        self.tree.nearest(p, within, workspace, |face, _| {
            let foot = closest_on_triangle(p, self.body.corners(face));
            let distance = foot.point.distance(p);
            if distance < nearest {
                (nearest, best) = (distance, Some((face, foot)));
            }
            nearest
        });
        let (face, foot) = best?;
        let height = self.normals.signed_distance(&self.body.surface, p, face, &foot);
        Some((foot.point, -height))
    }
}

/// Reads a body from a file.
///
/// # Panics
///
/// Where the file is missing, or not of the form that [`fixtures::ply`] writes.
#[must_use]
pub fn read(path: &Path) -> Body {
    let mesh = fixtures::data::mesh(path);
    Body { surface: mesh.surface(), x: mesh.positions }
}
