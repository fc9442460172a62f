//! Distances between a surface and its balls at random samples, computed apart from `medial`'s
//! own bounds.

use fixtures::random::Random;
use kdop::Workspace;
use medial::{Ball, MedialSurface, PrimitiveTree};
use proximity::SurfaceTree;

use crate::bodies::depth;

/// Samples per direction.
const SAMPLES: u64 = 100_000;

/// Maximum distances between a surface and its balls, in both directions.
#[derive(Clone, Copy)]
pub(super) struct SampledDistances {
    /// Distance of the surface outside of the balls.
    pub(super) surface_to_balls: f64,
    /// Distance of the balls outside of the surface.
    pub(super) balls_to_surface: f64,
}

/// Samples the distances between a surface and its balls.
pub(super) fn sampled_distances(body: &SurfaceTree, medial: &MedialSurface) -> SampledDistances {
    let tree = PrimitiveTree::new(medial).expect("finite balls");
    let workspace = &mut Workspace::default();
    let mut random = Random(1);

    // Points of the surface, outside of the balls.
    let mut surface_to_balls = 0.0_f64;
    let faces = body.surface().faces();
    for _ in 0..SAMPLES {
        let face = faces[random.below(faces.len())];
        let [u, v, w] = random.weights();
        let [a, b, c] = body.positions().corners(face);
        let p = u * a + v * b + w * c;
        let nearest = tree.nearest(medial, p, workspace);
        surface_to_balls = surface_to_balls.max(nearest.foot.distance);
    }

    // Balls anywhere in cones and slabs, outside of the surface.
    let mut balls_to_surface = 0.0_f64;
    for _ in 0..SAMPLES {
        let primitive = random.below(medial.primitives().len());
        let primitive = u32::try_from(primitive).expect("few primitives");
        let ball = Ball::interpolate(&medial.primitive_balls(primitive), random.weights());
        balls_to_surface = balls_to_surface.max(ball.radius - depth(body, ball.center, workspace));
    }
    SampledDistances { surface_to_balls, balls_to_surface }
}
