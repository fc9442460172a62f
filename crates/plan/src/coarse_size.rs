//! Number of faces that a coarse surface will have, predicted from curvature.

use std::f64::consts::TAU;

use scene::Body;
use surface::triangle;

use crate::cost::count;

/// Faces times their deviation over the integral of the root of the Gaussian curvature.
///
/// On a sphere of radius R, a triangle of circumradius r deviates by r²/(2 R): the ratio is 0.38 for
/// the best triangles. Decimation to vertices of the surface itself makes 0.4 on muscles and bones, 0.7
/// on ellipsoids and 0.8 on spheres and rods. Smaller builds coarse surfaces that do not pay; larger leaves out some that do.
const FACES: f64 = 0.5;

/// Faces of the coarsest surface that is predicted: those of a cube.
const MIN_FACES: f64 = 12.0;

/// Predicts the number of faces of a body's surface within a deviation.
///
/// Best faces are long where one principal curvature is small, so that their number goes with the
/// root of the product of both: with the angles that are missing to a full turn at the vertices.
pub(crate) fn predicted_faces(body: &Body, deviation: f64) -> f64 {
    // Angle and a third of the area around each vertex.
    let surface = body.surface();
    let mut around = vec![(0.0, 0.0); surface.vertex_count()];
    for (face, &vertices) in (0..).zip(surface.faces()) {
        let corners = body.corners(face);
        let area = triangle::area(corners);
        for (corner, vertex) in vertices.into_iter().enumerate() {
            let [p, q, r] = [0, 1, 2].map(|k| corners[(corner + k) % 3]);
            let (angle, third) = &mut around[vertex as usize];
            *angle += (q - p).angle_between(r - p);
            *third += area / 3.0;
        }
    }

    // No face is divided: at most one for each.
    let mut faces = 0.0;
    for vertices in surface.faces() {
        let mut curvature = 0.0;
        for &vertex in vertices {
            let (angle, area): (f64, f64) = around[vertex as usize];
            let shared_by = count(surface.vertex_faces(vertex).len());
            curvature += ((TAU - angle).abs() * area).sqrt() / shared_by;
        }
        faces += (FACES * curvature / deviation).min(1.0);
    }
    faces.max(MIN_FACES).min(count(surface.faces().len()))
}

#[cfg(test)]
mod tests {
    use decimate::Decimation;
    use fixtures::{Mesh, shapes};
    use glam::DVec3;
    use proximity::SurfaceTree;
    use scene::{BodyKind, Scene};
    use surface::progress::Progress;

    use super::*;

    /// Returns the predicted number of faces over that of decimation.
    fn ratio(mesh: &Mesh, deviation: f64) -> f64 {
        let mut scene = Scene::new();
        let id = scene.add("body", BodyKind::Deformable, mesh.surface(), mesh.positions.clone());
        let predicted = predicted_faces(scene.body(id.expect("a body")), deviation);
        let full = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a tree");
        let decimation = Decimation::new(full, Progress::none()).expect("a decimation");
        let reduced = decimation.within(deviation, Progress::none()).expect("a surface");
        predicted / count(reduced.surface.faces().len())
    }

    #[test]
    fn predictions_are_near_what_decimation_makes() {
        let muscle = shapes::ellipsoid(DVec3::new(15.0, 10.0, 90.0), 5);
        let ball = shapes::icosphere(30.0, 5);
        let rod = shapes::capsule(5.0, 60.0, 64);
        for mesh in [muscle, ball, rod] {
            for deviation in [0.8, 0.4, 0.2, 0.1] {
                let ratio = ratio(&mesh, deviation);
                assert!((0.3..3.0).contains(&ratio), "{ratio} at {deviation}");
            }
        }
    }
}
