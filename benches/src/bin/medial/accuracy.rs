//! How near a medial surface comes, by number of balls.

use std::path::Path;

use benches::ratio::{Ratio, Report};
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{Ball, Generated, Params, PrimitiveTree, Topology, generate};
use surface::{Pseudonormals, closest_on_triangle};

use crate::data::{Body, muscle, processor_seconds};

/// Numbers of balls, with the error \[mm\] that the hip's muscles may have.
const ROWS: [(usize, Option<f64>); 5] =
    [(25, None), (50, None), (100, Some(0.4)), (200, Some(0.2)), (400, Some(0.12))];

/// Fresh samples for each bound.
const SAMPLES: u64 = 100_000;

/// Prints a row for each muscle and number of balls.
pub(crate) fn run(folder: &Path, names: &[String], hip: &[&str], report: &mut Report) {
    println!(
        "muscle\tfaces\tballs\tslabs\trms\tp95\tsurface to medial\tfresh\tmedial to surface\tfresh\ttopology\tseconds"
    );
    for name in names {
        let body = muscle(folder, name);
        for (balls, allowed) in ROWS {
            let seconds = row(name, &body, balls, report);
            if let (Some(allowed), true) = (allowed, hip.contains(&name.as_str())) {
                let title = format!("{name} {balls} balls, rms / um");
                report.add(&Ratio::new(&title, seconds.0 * 1e3, allowed * 1e3, "um", 1.0));
            }
            if balls == 100 {
                let allowed = if body.surface.faces().len() > 6500 { 6.0 } else { 1.0 };
                let title = format!("{name} 100 balls, time");
                report.add(&Ratio::new(&title, seconds.1, allowed, "s", 1.0));
            }
        }
    }
}

/// Prints one row; returns the error and the time.
fn row(name: &str, body: &Body, balls: usize, report: &mut Report) -> (f64, f64) {
    let x = body.surface.positions(&body.x).expect("finite positions");
    let start = processor_seconds();
    let made = generate(&body.surface, x, &Params::balls(balls), |_| {}).expect("a closed muscle");
    let seconds = processor_seconds() - start;
    let [out, over] = fresh(body, &made);
    let deviation = &made.deviation;
    let inside = Topology::of_inside(&body.surface, x).expect("closed");
    let topology = Topology::of_union(&made.medial, 1.0).expect("a fitting grid");
    let same = if topology == inside { "same".to_owned() } else { format!("{topology:?}") };
    println!(
        "{name}\t{}\t{}\t{}\t{:.3}\t{:.3}\t{:.3}\t{out:.3}\t{:.3}\t{over:.3}\t{same}\t{seconds:.2}",
        body.surface.faces().len(),
        made.medial.balls().len(),
        made.medial.slabs().len(),
        deviation.rms,
        deviation.p95,
        deviation.surface_to_medial.at_most,
        deviation.medial_to_surface.at_most,
    );
    for (what, sampled, bound) in [
        ("surface to medial", out, deviation.surface_to_medial.at_most),
        ("medial to surface", over, deviation.medial_to_surface.at_most),
    ] {
        if sampled > bound {
            let title = format!("{name} {balls} balls, {what} beyond its bound");
            report.add(&Ratio::new(&title, sampled, bound, "mm", 1.0));
        }
    }
    (deviation.rms, seconds)
}

/// The largest deviations at fresh samples, in both directions.
fn fresh(body: &Body, made: &Generated) -> [f64; 2] {
    let medial = &made.medial;
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
    let depth = Depth::new(body);
    let mut over = 0.0_f64;
    for _ in 0..SAMPLES {
        let primitive = random.below(medial.primitives().len());
        let primitive = u32::try_from(primitive).expect("few primitives");
        let ball = Ball::interpolate(&medial.primitive_balls(primitive), random.weights());
        over = over.max(ball.radius - depth.at(ball.center, workspace));
    }
    [out, over]
}

/// Depth in a body, apart from how `medial` computes it.
struct Depth<'a> {
    body: &'a Body,
    normals: Pseudonormals,
    tree: Tree,
}

impl<'a> Depth<'a> {
    fn new(body: &'a Body) -> Self {
        let x = body.surface.positions(&body.x).expect("finite positions");
        let leaves = Leaves::Triangles(body.surface.faces());
        let tree = Tree::build(leaves, &body.x).expect("finite positions");
        Self { body, normals: Pseudonormals::new(&body.surface, x), tree }
    }

    fn at(&self, p: DVec3, workspace: &mut Workspace) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        self.tree.nearest(p, f64::INFINITY, workspace, |face, _| {
            let corners = self.body.surface.faces()[face as usize];
            let foot = closest_on_triangle(p, corners.map(|v| self.body.x[v as usize]));
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
