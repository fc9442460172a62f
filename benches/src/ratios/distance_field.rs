//! Distance fields of a femur: builds, their memory and threads, and queries near the surface
//! beside exact projection (on a surface's tree, and with the feature `peers` by `parry3d`).

use std::error::Error;

use distance_field::{DistanceField, FieldParams, QueryParams, SampleBatch};
use fixtures::Mesh;
use fixtures::femur::femur;
use fixtures::sampling::points_near;
use glam::DVec3;
use kdop::Workspace;
#[cfg(feature = "peers")]
use parry3d::{
    query::PointQuery,
    shape::{TriMesh, TriMeshFlags},
};
use rayon::ThreadPool;
use surface::TriangleSurface;
use surface::progress::Progress;

#[cfg(feature = "peers")]
use super::kdop_peers::parry_points;
use crate::bodies::body;
use crate::measure::{Pace, Report, as_f64, busiest_times, pool};

/// Builds that are timed at full effort; the minimum time counts.
const BUILDS: u32 = 9;

/// Padding of the femur \[mm\] that makes its grid one of 6.4 million voxels at 1 mm, and of 51
/// million at 0.5 mm.
const WIDE_PADDING: f64 = 18.0;

/// Budget of each comparison of queries \[ms\].
const BUDGET: u64 = 1500;

/// Points of a batch query.
const POINTS: u32 = 400_000;

/// Points that are projected, which takes microseconds each.
const PROJECTED: usize = 2_000;

/// Compares builds and queries of the field of a generated femur.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let mesh = femur(2.0);
    let bone = Bone { surface: mesh.surface(), positions: &mesh.positions };
    // Everything but the comparison of threads is on one.
    let one_thread = pool(1)?;
    one_thread.install(|| {
        memory(&bone, report);
        builds(&bone, report);
        queries(&mesh, &bone, report);
    });
    threads(&bone, [one_thread, pool(2)?], report);
    Ok(())
}

/// A bone of which fields are built.
struct Bone<'a> {
    surface: TriangleSurface,
    positions: &'a [DVec3],
}

impl Bone<'_> {
    fn build(&self, params: &FieldParams) -> DistanceField {
        let x = self.surface.positions(self.positions).expect("a generated bone is finite");
        DistanceField::build(&self.surface, x, params, Progress::none()).expect("a bone fits")
    }
}

/// Compares the peak of memory during a build at 0.5 mm with the bytes of its grid.
fn memory(bone: &Bone<'_>, report: &mut Report) {
    let params =
        FieldParams { padding: WIDE_PADDING, truncation: Some(15.0), ..FieldParams::new(0.5) };
    let mut bytes = 0;
    let allocated = allocation_counter::measure(|| bytes = bone.build(&params).bytes());
    let peak = usize::try_from(allocated.bytes_max).unwrap_or(usize::MAX);
    let megabytes = [peak, bytes].map(|bytes| as_f64(bytes) / 1e6);
    report.ratio("memory to build at 0.5 mm / grid", megabytes, "MB", 3.0);
}

/// Compares builds on one thread with fixed times, and both methods with each other.
fn builds(bone: &Bone<'_>, report: &mut Report) {
    let exact = FieldParams::new(1.0);
    let wide = FieldParams { padding: WIDE_PADDING, ..exact };
    let voxel = FieldParams { samples: 0, ..FieldParams::voxel(1.0) };

    let times = report.measure(
        "build",
        Pace::long_calls(report.rounds(BUILDS)),
        [
            ("exact band", &mut || bone.build(&exact).bytes()),
            ("exact band, 6.4 million voxels", &mut || bone.build(&wide).bytes()),
            ("voxel method", &mut || bone.build(&voxel).bytes()),
        ],
    );
    let [exact, wide, voxel] = times.map(|time| time * 1e-6);
    report.ratio("exact band at 1 mm / 270 ms", [exact, 270.0], "ms", 1.0);
    report.ratio("exact band, 6.4 million voxels / 300 ms", [wide, 300.0], "ms", 1.0);
    report.ratio("voxel method at 1 mm / 250 ms", [voxel, 250.0], "ms", 1.0);
    report.ratio("exact band / voxel method", [exact, voxel], "ms", 1.8);
}

/// Compares the processor time of the busier of two threads with that of one.
fn threads(bone: &Bone<'_>, pools: [ThreadPool; 2], report: &mut Report) {
    let params = FieldParams::new(1.0);
    let [one, two] = busiest_times(report.rounds(BUILDS), &pools, || bone.build(&params));
    report.ratio("busier of two threads / one", [two, one], "ms", 1.0 / 1.7);
}

/// Compares queries with fixed times per point, and with exact projection.
fn queries(mesh: &Mesh, bone: &Bone<'_>, report: &mut Report) {
    let field = bone.build(&FieldParams { samples: 0, ..FieldParams::new(1.0) });
    let coherent = points_near(mesh, POINTS, 9.0);
    let random = shuffled(&coherent);

    // Batches in the order of the faces, and in an order without neighbors.
    let query = QueryParams::default();
    let [mut samples, mut random_samples] = [SampleBatch::default(), SampleBatch::default()];
    let times = report.interleave(
        "trilinear",
        BUDGET,
        [
            ("coherent", &mut || {
                field.query_batch(&coherent, &query, &mut samples);
                samples.distance.len()
            }),
            ("random", &mut || {
                field.query_batch(&random, &query, &mut random_samples);
                random_samples.distance.len()
            }),
        ],
    );
    let [ordered, unordered] = times.map(|time| time / f64::from(POINTS));
    report.ratio("trilinear, coherent / 20 ns", [ordered, 20.0], "ns", 1.0);
    report.ratio("trilinear, random / 45 ns", [unordered, 45.0], "ns", 1.0);

    // Distance and side of a few points, beside the closest points of faces.
    let few = &random[..PROJECTED];
    let mut by_field = || {
        field.query_batch(few, &query, &mut samples);
        samples.distance.iter().filter(|distance| **distance < 0.0).count()
    };
    let (tree, mut workspace) = (body(mesh.clone()), Workspace::default());
    let mut by_tree = || {
        let mut faces = 0;
        for &p in few {
            let closest = tree.closest_point(p, f64::INFINITY, None, &mut workspace);
            faces += closest.map_or(0, |closest| closest.face as usize);
        }
        faces
    };
    let name = "2000 points / closest points of faces";
    report.compare(name, BUDGET, 0.005, [&mut by_field, &mut by_tree]);

    #[cfg(feature = "peers")]
    {
        let vertices = parry_points(&mesh.positions);
        let solid = TriMesh::with_flags(vertices, mesh.faces.clone(), TriMeshFlags::ORIENTED)
            .expect("a closed bone");
        let projected = parry_points(few);
        let mut by_parry =
            || projected.iter().filter(|&&p| solid.project_local_point(p, false).is_inside).count();
        let name = "2000 points / parry project_point";
        report.compare(name, BUDGET, 0.01, [&mut by_field, &mut by_parry]);
    }
}

/// Returns the points in an order without neighbors: in steps of a prime.
fn shuffled(points: &[DVec3]) -> Vec<DVec3> {
    let mut shuffled = Vec::new();
    for n in 0..points.len() {
        shuffled.push(points[n * 104_729 % points.len()]);
    }
    shuffled
}
