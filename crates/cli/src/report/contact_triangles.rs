//! Parts of surfaces inside other bodies as small triangles with depths, for pictures.

use glam::DVec3;
use musculo_collide::kdop::Workspace;
use musculo_collide::proximity::SurfaceTree;
use musculo_collide::surface::{Aabb, closest_on_triangle, triangle};
use musculo_collide::{Body, PatchFace};

use picture::{ContactPoint, ContactTriangle};

/// Longest edge of a triangle, relative to the diagonal of all: depth is interpolated along it.
const MAX_EDGE: f64 = 1.0 / 40.0;

/// Largest number of splits of one triangle: some thousand triangles.
const MAX_SPLITS: u32 = 5;

/// Divides the parts of a body's surface inside another into triangles.
///
/// `normals` are those of the body's vertices. The depth is exact at every corner.
pub(super) fn contact_triangles(
    patches: &[PatchFace],
    body: &Body,
    normals: &[DVec3],
    other: &SurfaceTree,
) -> Vec<ContactTriangle> {
    let points = patches.iter().flat_map(|patch| patch.part.loops.iter().flatten().copied());
    let max_edge = MAX_EDGE * Aabb::of_points(points).diagonal();
    let mut depths = DepthQuery { other, hint: None, workspace: Workspace::default() };
    let mut triangles = Vec::new();
    for PatchFace { part, .. } in patches {
        let corners = body.corners(part.face);
        let ends = body.surface().faces()[part.face as usize];
        let face = Face { corners, normals: ends.map(|vertex| normals[vertex as usize]) };
        for triangle in part.triangles(triangle::normal(corners)) {
            let points = triangle.map(|at| face.point(at, &mut depths));
            divide(points, &face, max_edge, MAX_SPLITS, &mut depths, &mut triangles);
        }
    }
    triangles
}

/// Splits a triangle in four until its edges are short.
fn divide(
    [a, b, c]: ContactTriangle,
    face: &Face,
    max_edge: f64,
    splits: u32,
    depths: &mut DepthQuery<'_>,
    out: &mut Vec<ContactTriangle>,
) {
    let longest = a.at.distance(b.at).max(b.at.distance(c.at)).max(c.at.distance(a.at));
    if longest <= max_edge || splits == 0 {
        out.push([a, b, c]);
        return;
    }
    let middles = [[a.at, b.at], [b.at, c.at], [c.at, a.at]];
    let [ab, bc, ca] = middles.map(|[p, q]| face.point(0.5 * (p + q), depths));
    for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        divide(part, face, max_edge, splits - 1, depths, out);
    }
}

/// Face that holds the triangles.
struct Face {
    corners: [DVec3; 3],
    normals: [DVec3; 3],
}

impl Face {
    /// Computes normal and depth at a point of the face.
    fn point(&self, at: DVec3, depths: &mut DepthQuery<'_>) -> ContactPoint {
        let weights = closest_on_triangle(at, self.corners).barycentric;
        let mut normal = DVec3::ZERO;
        for (weight, corner) in weights.into_iter().zip(self.normals) {
            normal += weight * corner;
        }
        ContactPoint { at, normal, depth: depths.at(at) }
    }
}

/// Distances from the other surface, each found from the face of the one before.
struct DepthQuery<'a> {
    other: &'a SurfaceTree,
    hint: Option<u32>,
    workspace: Workspace,
}

impl DepthQuery<'_> {
    fn at(&mut self, point: DVec3) -> f64 {
        let Self { other, hint, workspace } = self;
        let found = other.closest_point(point, f64::INFINITY, *hint, workspace);
        *hint = found.map(|found| found.face);
        found.map_or(0.0, |found| found.distance)
    }
}
