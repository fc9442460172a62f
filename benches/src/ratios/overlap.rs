//! Overlap of two spheres: growth with the number of faces, beside the depths of vertices, and with
//! the feature `peers` beside the boolean mesh of `boolmesh`.

use std::error::Error;

use ::overlap::{DepthParams, Overlap, OverlapDetector};
#[cfg(feature = "peers")]
use boolmesh::prelude::{OpType, compute_boolean};
use fixtures::Mesh;
use fixtures::shapes::icosphere;
use glam::DVec3;
use proximity::{PairProximity, SurfaceTree};

use crate::bodies::body;
use crate::measure::Report;
#[cfg(feature = "peers")]
use crate::peers::boolean::{manifold, volume};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 1000;

/// Budget of one between calls of half a millisecond and of fourteen \[ms\]: the long ones take most of
/// it, and the short ones have to find a moment without other load.
const BUDGET_OF_SHORT_CALLS: u64 = 3000;

/// Radius of both spheres, and the way from one center to the other \[mm\].
const RADIUS: f64 = 30.0;
const APART: DVec3 = DVec3::new(45.0, 3.1, 2.3);

/// Compares measures and depths of spheres of 20,480 and of 327,680 faces.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let small = spheres(5);
    let large = spheres(7);
    growth([&small, &large].map(|meshes| meshes.clone().map(body)), report);
    #[cfg(feature = "peers")]
    boolean_mesh(&small, report)?;
    vertex_depths(small.map(body), report);
    Ok(())
}

fn spheres(level: u32) -> [Mesh; 2] {
    let sphere = icosphere(RADIUS, level);
    [sphere.clone(), sphere.translated(APART)]
}

/// Measures an overlap in memory that is reused; returns the number of regions.
fn measure([a, b]: &[SurfaceTree; 2], detector: &mut OverlapDetector, out: &mut Overlap) -> usize {
    detector.measure_into([a, b], out);
    out.regions.len()
}

/// Compares the growth of the time per face, with sixteen times as many faces, with that of a sum
/// over all corners, which larger meshes slow down, too: they leave the caches.
fn growth([small, large]: [[SurfaceTree; 2]; 2], report: &mut Report) {
    // Four measurements in turns, so that load falls on all of them.
    let [mut first, mut second] = <[OverlapDetector; 2]>::default();
    let (mut many, mut few) = (Overlap::default(), Overlap::default());
    let [large_time, small_time, large_sum, small_sum] = report.interleave(
        "growth",
        BUDGET,
        [
            ("655k faces", &mut || measure(&large, &mut first, &mut many)),
            ("41k faces", &mut || measure(&small, &mut second, &mut few)),
            ("655k faces, plain sum", &mut || faces_of_positive_volume(&large)),
            ("41k faces, plain sum", &mut || faces_of_positive_volume(&small)),
        ],
    );
    let growth = [large_time / small_time, large_sum / small_sum];
    report.ratio("growth from 41k to 655k faces / plain sum", growth, "x", 1.3);
}

/// Counts the faces whose volume about the origin is positive, over both bodies.
fn faces_of_positive_volume(bodies: &[SurfaceTree; 2]) -> usize {
    let mut count = 0;
    for body in bodies {
        for &face in body.surface().faces() {
            let [a, b, c] = body.positions().corners(face);
            count += usize::from(a.dot(b.cross(c)) > 0.0);
        }
    }
    count
}

/// Compares the measures with a boolean mesh, which has to be built and summed for them.
#[cfg(feature = "peers")]
fn boolean_mesh(meshes: &[Mesh; 2], report: &mut Report) -> Result<(), Box<dyn Error>> {
    let bodies = meshes.clone().map(body);
    let [a, b] = [manifold(&meshes[0])?, manifold(&meshes[1])?];
    let (mut detector, mut overlap) = <(OverlapDetector, Overlap)>::default();
    report.compare(
        "measures, 41k faces / boolmesh",
        BUDGET,
        0.05,
        [&mut || measure(&bodies, &mut detector, &mut overlap), &mut || {
            compute_boolean(&a, &b, OpType::Intersect).map_or(0, |mesh| mesh.nf)
        }],
    );

    // Both answers have the same volume.
    let shared = compute_boolean(&a, &b, OpType::Intersect)?;
    let own = overlap.total.volume.unwrap_or(f64::NAN);
    let difference = (own / volume(&shared) - 1.0).abs();
    report.cost("volume, relative difference from boolmesh", difference, "", 1e-9);
    Ok(())
}

/// Compares measures, and certified depths of whole surfaces, with the depths of vertices alone.
fn vertex_depths(bodies: [SurfaceTree; 2], report: &mut Report) {
    let [a, b] = &bodies;
    let params = DepthParams::with_floor(1e-6 * RADIUS);
    let [mut detector, mut measured] = <[OverlapDetector; 2]>::default();
    let (mut overlap, mut pair) = (measured.measure(a, b), PairProximity::default());
    let [measures, depths, vertices] = report.interleave(
        "41k faces",
        BUDGET_OF_SHORT_CALLS,
        [
            ("measures", &mut || measure(&bodies, &mut detector, &mut overlap)),
            ("depths", &mut || measured.depths([a, b], &params).into_iter().flatten().count()),
            ("depths of vertices", &mut || {
                pair.compute(a, b, 0.0).expect("few faces are near");
                pair.sides()[0].inside_vertices().len()
            }),
        ],
    );
    report.times("measures, 41k faces / depths of vertices", [measures, vertices], 0.02);
    report.times("certified depths, 41k faces / of vertices", [depths, vertices], 0.3);
}
