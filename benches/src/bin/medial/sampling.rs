//! Depths and the largest deviations at fresh samples, apart from how `medial`
//! computes them.

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{Ball, MedialSurface, PrimitiveTree};
use surface::{Pseudonormals, closest_on_triangle};

use crate::data::Body;

/// Fresh samples for each bound.
pub(crate) const SAMPLES: u64 = 100_000;

/// How far samples of the surface are outside of the balls, and balls outside of the
/// surface.
pub(crate) fn fresh(depth: &Depth<'_>, medial: &MedialSurface) -> [f64; 2] {
    let body = depth.body;
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
        over = over.max(ball.radius - depth.at(ball.center, workspace));
    }
    [out, over]
}

/// Depth in a body.
pub(crate) struct Depth<'a> {
    body: &'a Body,
    normals: Pseudonormals,
    tree: Tree,
}

impl<'a> Depth<'a> {
    pub(crate) fn new(body: &'a Body) -> Self {
        let x = body.surface.positions(&body.x).expect("finite positions");
        let leaves = Leaves::Triangles(body.surface.faces());
        let tree = Tree::build(leaves, &body.x).expect("finite positions");
        Self { body, normals: Pseudonormals::new(&body.surface, x), tree }
    }

    /// Vertices of another body that are inside, with their depths.
    pub(crate) fn inside(&self, points: &Body) -> BTreeMap<u32, f64> {
        let [low, high] = self.body.bounds();
        let workspace = &mut Workspace::default();
        let boxed = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
        let near = (0_u32..).zip(&points.x).filter(|&(_, &p)| boxed(p));
        let depths = near.map(|(vertex, &p)| (vertex, self.at(p, workspace)));
        depths.filter(|&(_, depth)| depth > 0.0).collect()
    }

    fn at(&self, p: DVec3, workspace: &mut Workspace) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        self.tree.nearest(p, f64::INFINITY, workspace, |face, _| {
            let foot = closest_on_triangle(p, self.body.corners(face));
            let distance = foot.point.distance(p);
            if distance < best.0 {
                let signed = self.normals.signed_distance(&self.body.surface, p, face, &foot);
                best = (distance, -signed);
            }
            best.0
        });
        best.1
    }
}

/// A sequence without visible order (Steele et al., `SplitMix64`).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        f64::from(u32::try_from(self.next() >> 32).unwrap_or(0)) / f64::from(u32::MAX)
    }

    fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % u64::try_from(count).unwrap_or(1)).unwrap_or(0)
    }

    fn weights(&mut self) -> [f64; 3] {
        let (u, v) = (self.unit(), self.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        [1.0 - u - v, u, v]
    }
}
