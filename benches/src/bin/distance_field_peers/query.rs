//! Asking a femur's field near its surface, beside exact projection.

use std::time::Duration;

use benches::ratio::{Ratio, Report, amount, interleave};
use distance_field::{
    DistanceField, FieldParams, Interpolation, QueryParams, SampleBatch, Storage,
};
use fixtures::Mesh;
use glam::DVec3;
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};

use benches::clock::running;

/// Points that are asked at once.
const POINTS: usize = 400_000;
/// Points that stay in the nearest cache, with all that they look at.
const FEW: usize = 4096;
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
        let params = FieldParams { storage, samples: 0, ..FieldParams::new(1.0) };
        DistanceField::build(&surface, x, &params).expect("a bone fits")
    };
    let floats = field(Storage::Float);
    let steps = field(Storage::Quantized { step: 0.001 });
    println!("floats {} bytes, steps {} bytes", floats.bytes(), steps.bytes());
    let coherent = points(mesh);
    let random = shuffled(&coherent);

    let trilinear = Interpolation::Trilinear;
    for (order, points, allowed) in [("coherent", &coherent, 20.0), ("random", &random, 45.0)] {
        let [ours, alone] = beside_memory(&floats, points);
        let name = format!("trilinear, {order} / {allowed:.0} ns");
        report.add(&Ratio::new(&name, ours, allowed, "ns", 1.0));
        println!("trilinear, {order}: {ours:.1} ns, its memory alone {alone:.1} ns");
    }
    let few: Vec<DVec3> = (0..POINTS).map(|n| coherent[n % FEW]).collect();
    let [ours, alone] = beside_memory(&floats, &few);
    println!(
        "trilinear, {FEW} points again and again: {ours:.1} ns, its memory alone {alone:.1} ns"
    );
    for (name, field, interpolation) in [
        ("steps, trilinear", &steps, trilinear),
        ("smooth", &floats, Interpolation::Smooth),
        ("cubic", &floats, Interpolation::Cubic),
    ] {
        let [near, far] =
            [&coherent, &random].map(|points| nanoseconds(field, points, interpolation));
        println!("{name}: coherent {near:.1} ns, random {far:.1} ns");
    }
    beside_parry(mesh, &floats, &random, report);
}

fn nanoseconds(field: &DistanceField, points: &[DVec3], interpolation: Interpolation) -> f64 {
    let query = QueryParams { interpolation, ..QueryParams::default() };
    let mut samples = SampleBatch::default();
    let mut least = f64::INFINITY;
    for _ in 0..TURNS {
        let start = running();
        for _ in 0..ROUNDS {
            field.query_batch(points, &query, &mut samples);
        }
        least = least.min((running() - start).as_secs_f64() * 1e9);
    }
    least / amount(ROUNDS * points.len())
}

/// Nanoseconds a point of a query, and of what no query can leave out: its point read, the
/// eight numbers at its corners, its answer written. In turns, since memory is shared with
/// whatever else runs on the machine.
fn beside_memory(field: &DistanceField, points: &[DVec3]) -> [f64; 2] {
    let (grid, values) = (field.grid(), field.values());
    let [nx, ny, _] = grid.dims();
    let first = |&p: &DVec3| grid.index(grid.locate(p).expect("within the padding").node);
    let firsts: Vec<usize> = points.iter().map(first).collect();
    let [mut asked, mut read] =
        [const { SampleBatch { distance: Vec::new(), gradient: Vec::new() } }; 2];
    read.distance.resize(points.len(), 0.0);
    read.gradient.resize(points.len(), DVec3::ZERO);
    let times = interleave(
        BUDGET,
        [
            &mut || {
                field.query_batch(points, &QueryParams::default(), &mut asked);
                asked.distance.len()
            },
            &mut || {
                let answers = read.distance.iter_mut().zip(&mut read.gradient);
                for ((&first, &p), (distance, gradient)) in firsts.iter().zip(points).zip(answers) {
                    let rows = [first, first + nx, first + nx * ny, first + nx * ny + nx];
                    let sum: f32 = rows.iter().map(|&row| values[row] + values[row + 1]).sum();
                    (*distance, *gradient) = (f64::from(sum), p);
                }
                read.distance.len()
            },
        ],
    );
    times.map(|time| time.least / amount(points.len()))
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
    let mut samples = SampleBatch::default();
    let [ours, theirs] = interleave(
        BUDGET,
        [
            &mut || {
                field.query_batch(some, &QueryParams::default(), &mut samples);
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
