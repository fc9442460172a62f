//! Contact spread over the vertices and faces of one body.

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
            if report.a == body {
                field.add_vertices(&report.a_against_b);
                field.crossing.extend(report.crossing_faces.iter().map(|[face, _]| face));
            } else if report.b == body {
                field.add_vertices(&report.b_against_a);
                field.crossing.extend(report.crossing_faces.iter().map(|[_, face]| face));
            }
        }
        field.crossing.sort_unstable();
        field.crossing.dedup();
        field
    }

    fn add_vertices(&mut self, report: &VertexReport) {
        for near in &report.near {
            let vertex = near.vertex as usize;
            self.signed_gaps[vertex] = self.signed_gaps[vertex].min(near.gap);
            self.depths[vertex] = self.depths[vertex].max(-near.gap);
        }
    }
}
