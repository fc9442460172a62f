//! Asking a femur's field near its surface, beside exact projection.

use std::time::Duration;

use benches::ratio::{Ratio, Report, amount, interleave};
use distance_field::{BuildOptions, DistanceField, Interpolation, Query, Samples, Storage};
use fixtures::Mesh;
use glam::DVec3;
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};

use benches::clock::running;

/// Points that are asked at once.
const POINTS: usize = 400_000;
/// Points that are projected; parry takes microseconds for each.
const PROJECTED: usize = 2_000;
const BUDGET: Duration = Duration::from_millis(1500);
/// Turns of all points, of which the quickest counts, and rounds in a turn.
const TURNS: usize = 7;
const ROUNDS: usize = 4;

pub(crate) fn beside_projection(mesh: &Mesh, report: &mut Report) {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("a generated bone is finite");
    let field = |storage| {
        let options = BuildOptions { storage, samples: 0, ..BuildOptions::default() };
        DistanceField::build(&surface, x, &options).expect("a bone fits")
    };
    let dense = field(Storage::Dense);
    let bricks = field(Storage::Bricks { step: 0.001 });
    println!("dense {} bytes, bricks {} bytes", dense.bytes(), bricks.bytes());
    let coherent = points(mesh);
    let random = shuffled(&coherent);

    let nanoseconds = |field: &DistanceField, points: &[DVec3], interpolation| {
        let query = Query { interpolation, ..Query::default() };
        let mut samples = Samples::default();
        let mut least = f64::INFINITY;
        for _ in 0..TURNS {
            let start = running();
            for _ in 0..ROUNDS {
                field.ask_all(points, &query, &mut samples);
            }
            least = least.min((running() - start).as_secs_f64() * 1e9);
        }
        least / amount(ROUNDS * points.len())
    };
    let trilinear = Interpolation::Trilinear;
    let ours = nanoseconds(&dense, &coherent, trilinear);
    report.add(&Ratio::new("trilinear, coherent / 20 ns", ours, 20.0, "ns", 1.0));
    let ours = nanoseconds(&dense, &random, trilinear);
    report.add(&Ratio::new("trilinear, random / 45 ns", ours, 45.0, "ns", 1.0));
    for (name, field, interpolation) in [
        ("bricks, trilinear", &bricks, trilinear),
        ("smooth", &dense, Interpolation::Smooth),
        ("cubic", &dense, Interpolation::Cubic),
    ] {
        let [near, far] =
            [&coherent, &random].map(|points| nanoseconds(field, points, interpolation));
        println!("{name}: coherent {near:.1} ns, random {far:.1} ns");
    }
    beside_parry(mesh, &dense, &random, report);
}

/// The same points, both sides in turns.
fn beside_parry(mesh: &Mesh, field: &DistanceField, points: &[DVec3], report: &mut Report) {
    let single = |p: DVec3| {
        let p = p.as_vec3();
        Vector::new(p.x, p.y, p.z)
    };
    let vertices = mesh.positions.iter().map(|&p| single(p)).collect();
    let solid = TriMesh::with_flags(vertices, mesh.faces.clone(), TriMeshFlags::ORIENTED)
        .expect("a closed bone");
    let some = &points[..PROJECTED];
    let projected: Vec<Vector> = some.iter().map(|&p| single(p)).collect();
    let mut samples = Samples::default();
    let [ours, theirs] = interleave(
        BUDGET,
        [
            &mut || {
                field.ask_all(some, &Query::default(), &mut samples);
                samples.distance.iter().filter(|distance| **distance < 0.0).count()
            },
            &mut || {
                projected.iter().filter(|&&p| solid.project_local_point(p, false).is_inside).count()
            },
        ],
    );
    report.add(&Ratio::of_times("2000 points / parry project_point", ours, theirs, 0.01));
}

/// Points within 9 mm of the surface, over one face after the other.
fn points(mesh: &Mesh) -> Vec<DVec3> {
    let faces = mesh.faces.len();
    let height = |n: usize| 18.0 * (amount(n) * 0.618_033_988_75).fract() - 9.0;
    let face = |n: usize| n * faces / POINTS;
    (0..POINTS).map(|n| mesh.centroid(face(n)) + height(n) * mesh.normal(face(n))).collect()
}

/// The same in an order without neighbours: steps of a prime through the list.
fn shuffled(points: &[DVec3]) -> Vec<DVec3> {
    (0..points.len()).map(|n| points[n * 104_729 % points.len()]).collect()
}
