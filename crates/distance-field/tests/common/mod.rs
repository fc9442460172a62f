//! What the tests share: exact distances, a stream of numbers.

#![allow(dead_code, reason = "each test binary uses a part")]

use distance_field::{BuildOptions, DistanceField, FieldError, Method, NodeValues};
use fixtures::Mesh;
use kdop::{Leaves, Tree, Workspace};
use surface::closest_on_triangle;
use surface::glam::DVec3;

/// Builds the field of a mesh.
pub(crate) fn build(mesh: &Mesh, options: &BuildOptions) -> Result<DistanceField, FieldError> {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("generated positions are finite");
    DistanceField::build(&surface, x, options)
}

/// The exact band of 3 with nodes that hold exact distances.
pub(crate) const INTERPOLATING: Method =
    Method::ExactBand { band: 3.0, relax: false, nodes: NodeValues::Interpolating };

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

/// The `n`th of points that fill the unit cube evenly (Roberts 2018).
pub(crate) fn spread(n: u32) -> DVec3 {
    let g = 1.220_744_084_605_76;
    (DVec3::new(1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g)) * (f64::from(n) + 0.5)).fract()
}

/// Points spread evenly over the area of a mesh, at heights spread evenly over
/// `-reach..=reach`; with the corners of the face each is over.
pub(crate) fn points_near(mesh: &Mesh, count: u32, reach: f64) -> Vec<DVec3> {
    let area = |face: usize| {
        let [a, b, c] = mesh.corners(face);
        (b - a).cross(c - a)
    };
    let total: f64 = (0..mesh.faces.len()).map(|face| area(face).length()).sum();
    let mut points = Vec::new();
    let (mut passed, mut next) = (0.0, 0);
    for face in 0..mesh.faces.len() {
        passed += area(face).length();
        while next < count && passed > total * (f64::from(next) + 0.5) / f64::from(count) {
            let s = spread(next);
            let [a, b, c] = mesh.corners(face);
            let (u, v) = if s.x + s.y > 1.0 { (1.0 - s.x, 1.0 - s.y) } else { (s.x, s.y) };
            let on = a + u * (b - a) + v * (c - a);
            points.push(on + (2.0 * s.z - 1.0) * reach * area(face).normalize());
            next += 1;
        }
    }
    points
}
