//! Fields of meshes, and exact distances, that the tests share.

use distance_field::{DistanceField, FieldError, FieldGrid, FieldMethod, FieldParams, NodeValues};
use fixtures::Mesh;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::glam::DVec3;
use surface::progress::Progress;

/// Builds the field of a mesh.
pub(crate) fn build(mesh: &Mesh, params: &FieldParams) -> Result<DistanceField, FieldError> {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("generated positions are finite");
    DistanceField::build(&surface, x, params, Progress::none())
}

/// The exact band of 3 spacings, with exact distances at its nodes.
pub(crate) const INTERPOLATING: FieldMethod =
    FieldMethod::ExactBand { band: 3.0, node_values: NodeValues::Interpolating };

/// Returns all nodes of a grid with these dimensions.
pub(crate) fn nodes([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

/// Returns the lowest node of the cell that contains a point of the grid.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the grid")]
pub(crate) fn lowest_node(grid: &FieldGrid, p: DVec3) -> [usize; 3] {
    let cell = ((p - grid.origin()) / grid.spacing()).floor().to_array();
    std::array::from_fn(|axis| (cell[axis] as usize).min(grid.dims()[axis] - 2))
}

/// Exact closest points of a mesh.
pub(crate) struct Exact {
    tree: SurfaceTree,
    workspace: Workspace,
}

impl Exact {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let tree = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a mesh");
        Self { tree, workspace: Workspace::default() }
    }

    /// Returns the closest point of the surface.
    pub(crate) fn closest(&mut self, p: DVec3) -> DVec3 {
        let found = self.tree.closest_point(p, f64::INFINITY, None, &mut self.workspace);
        found.expect("a mesh has faces").foot.point
    }

    pub(crate) fn distance(&mut self, p: DVec3) -> f64 {
        self.closest(p).distance(p)
    }
}
