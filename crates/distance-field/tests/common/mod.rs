//! What the tests share: fields and exact distances.

#![allow(dead_code, reason = "each test binary uses a part")]

use distance_field::{DistanceField, FieldError, FieldMethod, FieldParams, NodeValues};
use fixtures::Mesh;
use kdop::{Leaves, Tree, Workspace};
use surface::closest_on_triangle;
use surface::glam::DVec3;

/// Builds the field of a mesh.
pub(crate) fn build(mesh: &Mesh, options: &FieldParams) -> Result<DistanceField, FieldError> {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("generated positions are finite");
    DistanceField::build(&surface, x, options)
}

/// The exact band of 3 with nodes that hold exact distances.
pub(crate) const INTERPOLATING: FieldMethod =
    FieldMethod::ExactBand { band: 3.0, relax: false, node_values: NodeValues::Interpolating };

/// Exact closest points by a tree of boxes.
pub(crate) struct Exact<'a> {
    mesh: &'a Mesh,
    tree: Tree,
    workspace: Workspace<9>,
}

impl<'a> Exact<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        let tree = Tree::build(Leaves::Triangles(&mesh.faces), &mesh.positions)
            .expect("a mesh has leaves");
        Self { mesh, tree, workspace: Workspace::default() }
    }

    /// The closest point of the surface.
    pub(crate) fn closest(&mut self, p: DVec3) -> DVec3 {
        let mut best = (f64::INFINITY, DVec3::ZERO);
        self.tree.nearest(p, f64::INFINITY, &mut self.workspace, |face, _| {
            let foot = closest_on_triangle(p, self.mesh.corners(face as usize)).point;
            if foot.distance(p) < best.0 {
                best = (foot.distance(p), foot);
            }
            best.0
        });
        best.1
    }

    pub(crate) fn distance(&mut self, p: DVec3) -> f64 {
        self.closest(p).distance(p)
    }
}
