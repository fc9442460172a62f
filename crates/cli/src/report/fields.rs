//! Contact spread over the vertices and faces of one body.

use glam::DVec3;
use mesh_io::{PointValues, write_vtp};
use musculo_collide::{BodyId, PairReport, Scene, VertexReport};

/// One body's contact with some others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContactField {
    /// |V| signed distances to the nearest other surface, negative inside; no
    /// larger than the reach, which stands for everything farther away.
    pub(crate) signed_gaps: Vec<f64>,
    /// |V| depths inside the body that a vertex is deepest in; 0 outside all.
    pub(crate) depths: Vec<f64>,
    /// Faces that cross another body's, ascending.
    pub(crate) crossing: Vec<u32>,
}

impl ContactField {
    /// What `reports` say of `body`; those of other bodies are passed over.
    pub(crate) fn new<'a>(
        body: BodyId,
        scene: &Scene,
        reports: impl IntoIterator<Item = &'a PairReport>,
        reach: f64,
    ) -> Self {
        let count = scene.body(body).positions().len();
        let mut field = Self {
            signed_gaps: vec![reach; count],
            depths: vec![0.0; count],
            crossing: Vec::new(),
        };
        for report in reports {
            if report.pair.a == body {
                field.add_vertices(&report.a_against_b);
                field.crossing.extend(report.crossing_faces.iter().map(|[face, _]| face));
            } else if report.pair.b == body {
                field.add_vertices(&report.b_against_a);
                field.crossing.extend(report.crossing_faces.iter().map(|[_, face]| face));
            }
        }
        field.crossing.sort_unstable();
        field.crossing.dedup();
        field
    }

    /// Returns the body with its contact as a `.vtp` file.
    pub(crate) fn to_vtp(&self, positions: &[DVec3], faces: &[[u32; 3]]) -> String {
        let values = [
            PointValues::Scalars("signed_gap", &self.signed_gaps),
            PointValues::Scalars("penetration_depth", &self.depths),
        ];
        write_vtp(positions, faces, &values)
    }

    fn add_vertices(&mut self, report: &VertexReport) {
        for near in &report.near {
            let vertex = near.vertex as usize;
            self.signed_gaps[vertex] = self.signed_gaps[vertex].min(near.gap);
            self.depths[vertex] = self.depths[vertex].max(-near.gap);
        }
    }
}

/// Returns a surface with the displacements of its vertices as a `.vtp` file.
pub(crate) fn displacement_vtp(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    displacements: &[DVec3],
) -> String {
    let lengths: Vec<f64> = displacements.iter().map(|u| u.length()).collect();
    let values = [
        PointValues::Scalars("displacement_length", &lengths),
        PointValues::Vectors("displacement", displacements),
    ];
    write_vtp(positions, faces, &values)
}
