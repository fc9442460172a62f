//! Number of faces that a coarse surface will have, predicted from curvature.

use glam::DVec3;
use scene::Body;
use surface::triangle;

use crate::cost::count;

/// Deviation of a patch over the product of its area and the sum of its principal curvatures, for
/// patches as decimation makes them.
///
/// A triangle of circumradius r on a sphere of radius R deviates by r²/(2 R): 0.19 of its area times
/// 2/R. Decimation to vertices of the surface itself makes 0.2 on ellipsoids, 0.45 on spheres. Smaller predicts
/// more faces, and builds less.
const DEVIATION: f64 = 0.3;

/// Predicts the number of faces of a body's surface within a deviation.
///
/// The integral of the curvature over a face is half that over its edges: their lengths by the
/// angles that the surface turns by across them.
pub(crate) fn predicted_faces(body: &Body, deviation: f64) -> f64 {
    let surface = body.surface();
    let mut curvature = vec![0.0; surface.faces().len()];
    for (edge, &[from, to]) in (0..).zip(surface.edges()) {
        let &[p, q] = surface.edge_faces(edge) else { continue };
        let [normal_p, normal_q] = [p, q].map(|face| unit_normal(body, face));
        let length = body.positions()[from as usize].distance(body.positions()[to as usize]);
        let turned = 0.5 * length * normal_p.angle_between(normal_q);
        curvature[p as usize] += turned;
        curvature[q as usize] += turned;
    }

    // No face is divided: at most one for each.
    let mut faces = 0.0;
    for curvature in curvature {
        faces += (DEVIATION * curvature / deviation).min(1.0);
    }
    faces.clamp(4.0, count(surface.faces().len()).max(4.0))
}

fn unit_normal(body: &Body, face: u32) -> DVec3 {
    triangle::normal(body.corners(face)).normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use decimate::Decimation;
    use fixtures::{Mesh, shapes};
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
        for mesh in [muscle, ball] {
            for deviation in [0.8, 0.4, 0.2, 0.1] {
                let ratio = ratio(&mesh, deviation);
                assert!((0.4..2.5).contains(&ratio), "{ratio} at {deviation}");
            }
        }
    }
}
