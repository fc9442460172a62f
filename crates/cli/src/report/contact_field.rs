//! Contact of one body, per vertex.

use glam::DVec3;
use mesh_io::{PointValues, Space, write_vtp, write_vtu};
use musculo_collide::volume_mesh::VolumeMesh;
use musculo_collide::{BodyId, PairReport, Scene, VertexReport};

/// Contact of one body with others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContactField {
    /// |V| signed distances to the nearest other surface, negative inside, at most the
    /// margin.
    pub(crate) signed_gaps: Vec<f64>,
    /// |V| depths inside the body where the vertex is deepest, 0 outside all.
    pub(crate) depths: Vec<f64>,
}

impl ContactField {
    /// Collects the contact of `body` from the reports of its pairs.
    pub(crate) fn new(body: BodyId, scene: &Scene, reports: &[PairReport], margin: f64) -> Self {
        let count = scene.body(body).positions().len();
        let (signed_gaps, depths) = (vec![margin; count], vec![0.0; count]);
        let mut field = Self { signed_gaps, depths };
        for report in reports {
            if report.pair.a == body {
                field.add_vertices(&report.a_against_b);
            } else if report.pair.b == body {
                field.add_vertices(&report.b_against_a);
            }
        }
        field
    }

    fn add_vertices(&mut self, report: &VertexReport) {
        for near in &report.near {
            let vertex = near.vertex as usize;
            self.signed_gaps[vertex] = self.signed_gaps[vertex].min(near.gap);
            self.depths[vertex] = self.depths[vertex].max(-near.gap);
        }
    }

    /// Returns the body with its contact as a `.vtp` file.
    pub(crate) fn to_vtp(
        &self,
        positions: &[DVec3],
        faces: &[[u32; 3]],
        space: Option<Space>,
    ) -> String {
        let values = [
            PointValues::Scalars("signed_gap", &self.signed_gaps),
            PointValues::Scalars("penetration_depth", &self.depths),
        ];
        write_vtp(positions, faces, &values, space)
    }
}

/// Returns a body with the depth of its vertices inside others as a `.vtp` file.
pub(crate) fn depth_vtp(
    body: BodyId,
    scene: &Scene,
    reports: &[PairReport],
    space: Option<Space>,
) -> String {
    let ContactField { depths, .. } = ContactField::new(body, scene, reports, 0.0);
    let body = scene.body(body);
    let values = [PointValues::Scalars("penetration_depth", &depths)];
    write_vtp(body.positions(), body.surface().faces(), &values, space)
}

/// Returns a surface with the displacements of its vertices as a `.vtp` file.
pub(crate) fn displacement_vtp(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    displacements: &[DVec3],
    space: Option<Space>,
) -> String {
    let lengths: Vec<f64> = displacements.iter().map(|u| u.length()).collect();
    write_vtp(positions, faces, &displacement_values(&lengths, displacements), space)
}

/// Returns a volume mesh with the displacements of its nodes as a `.vtu` file.
pub(crate) fn displacement_vtu(
    nodes: &[DVec3],
    mesh: &VolumeMesh,
    displacements: &[DVec3],
    space: Option<Space>,
) -> String {
    let lengths: Vec<f64> = displacements.iter().map(|u| u.length()).collect();
    write_vtu(nodes, mesh, &displacement_values(&lengths, displacements), space)
}

/// Returns displacements as values at points, active by their length.
fn displacement_values<'a>(lengths: &'a [f64], displacements: &'a [DVec3]) -> [PointValues<'a>; 2] {
    [
        PointValues::Scalars("displacement_length", lengths),
        PointValues::Vectors("displacement", displacements),
    ]
}
