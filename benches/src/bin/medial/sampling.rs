//! Depths and the largest deviations at fresh samples, apart from how `medial`
//! computes them.

use std::collections::BTreeMap;

use benches::bodies::{Body, Depth};
use fixtures::random::Random;
use glam::DVec3;
use kdop::Workspace;
use medial::{Ball, MedialSurface, PrimitiveTree};

/// Fresh samples for each bound.
pub(crate) const SAMPLES: u64 = 100_000;

/// How far samples of the surface are outside of the balls, and balls outside of the
/// surface.
pub(crate) fn fresh(body: &Body, depth: &Depth<'_>, medial: &MedialSurface) -> [f64; 2] {
    let tree = PrimitiveTree::new(medial).expect("finite balls");
    let workspace = &mut Workspace::default();
    let mut random = Random(1);
    let mut out = 0.0_f64;
    for _ in 0..SAMPLES {
        let face = body.surface.faces()[random.below(body.surface.faces().len())];
        let [u, v, w] = random.weights();
        let [a, b, c] = face.map(|vertex| body.x[vertex as usize]);
        let p = u * a + v * b + w * c;
        out = out.max(tree.nearest(medial, p, workspace).foot.distance);
    }
    let mut over = 0.0_f64;
    for _ in 0..SAMPLES {
        let primitive = random.below(medial.primitives().len());
        let primitive = u32::try_from(primitive).expect("few primitives");
        let ball = Ball::interpolate(&medial.primitive_balls(primitive), random.weights());
        over = over.max(ball.radius - depth.at(ball.center, f64::INFINITY, workspace));
    }
    [out, over]
}

/// Vertices of one body that are inside another, with their depths.
pub(crate) fn inside(points: &Body, of: &Body) -> BTreeMap<u32, f64> {
    let ([low, high], depth) = (of.bounds(), Depth::new(of));
    let workspace = &mut Workspace::default();
    let boxed = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
    let near = (0_u32..).zip(&points.x).filter(|&(_, &p)| boxed(p));
    let depths = near.map(|(vertex, &p)| (vertex, depth.at(p, f64::INFINITY, workspace)));
    depths.filter(|&(_, depth)| depth > 0.0).collect()
}
