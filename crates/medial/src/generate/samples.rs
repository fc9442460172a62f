//! Samples of a surface that balls are fitted to.

use glam::DVec3;
use surface::triangle;

use crate::real;
use crate::surface_distance::SurfaceDistance;

/// Vertices and face centers, thinned out evenly in their order.
pub(super) struct Samples {
    pub(super) points: Vec<DVec3>,
    /// A face that each is on.
    pub(super) faces: Vec<u32>,
    /// Importance of each: its share of the area, relative to the mean share.
    pub(super) importance: Vec<f64>,
}

/// Sample with its area.
#[derive(Clone, Copy)]
struct Sample {
    p: DVec3,
    face: u32,
    area: f64,
}

/// Returns the number of samples that a surface has.
pub(super) fn sample_count(distance: &SurfaceDistance<'_>) -> usize {
    distance.surface.faces().len() + distance.surface.vertex_count()
}

impl Samples {
    /// Selects `count` samples, up to twice as many; all, if there are fewer.
    pub(super) fn new(distance: &SurfaceDistance<'_>, count: usize) -> Self {
        let all = all_samples(distance);
        let interval = (all.len() / count).max(1);
        let mut chosen = Self { points: Vec::new(), faces: Vec::new(), importance: Vec::new() };
        for sample in all.iter().step_by(interval) {
            chosen.points.push(sample.p);
            chosen.faces.push(sample.face);
            chosen.importance.push(sample.area);
        }

        // In units of the mean share.
        let mean = chosen.importance.iter().sum::<f64>() / real(chosen.importance.len());
        for importance in &mut chosen.importance {
            *importance /= mean;
        }
        chosen
    }
}

/// Returns the face centers, then the vertices. Half of the area of a face belongs to its center,
/// half to its corners.
fn all_samples(distance: &SurfaceDistance<'_>) -> Vec<Sample> {
    let at_vertex = |&p: &DVec3| Sample { p, face: 0, area: 0.0 };
    let mut at_vertices: Vec<Sample> = distance.x.as_slice().iter().map(at_vertex).collect();

    let mut samples = Vec::with_capacity(sample_count(distance));
    for (face, vertices) in (0_u32..).zip(distance.surface.faces()) {
        let [a, b, c] = distance.corners(face);
        let area = triangle::area([a, b, c]);
        samples.push(Sample { p: (a + b + c) / 3.0, face, area: 0.5 * area });
        for &vertex in vertices {
            let sample = &mut at_vertices[vertex as usize];
            sample.face = face;
            sample.area += area / 6.0;
        }
    }
    samples.append(&mut at_vertices);
    samples
}
