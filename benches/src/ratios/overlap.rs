//! Overlap of two spheres: growth with the number of faces, and beside the boolean mesh of
//! `boolmesh` and beside the depths of vertices.

use std::error::Error;

use ::overlap::{DepthParams, Overlap, OverlapDetector};
use boolmesh::prelude::{Manifold, OpType, compute_boolean};
use fixtures::Mesh;
use fixtures::shapes::icosphere;
use glam::DVec3;
use proximity::{PairProximity, SurfaceTree};

use crate::bodies::body;
use crate::measure::{Report, as_f64};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 1000;

/// Radius of both spheres, and the way from one center to the other \[mm\].
const RADIUS: f64 = 30.0;
const APART: DVec3 = DVec3::new(45.0, 3.1, 2.3);

/// Compares measures and depths of spheres of 20,480 and of 327,680 faces.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let small = spheres(5);
    let large = spheres(7);
    growth([&small, &large].map(|meshes| meshes.clone().map(body)), report);
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

/// Compares the time per face with sixteen times as many faces.
fn growth([small, large]: [[SurfaceTree; 2]; 2], report: &mut Report) {
    let (mut detector, mut overlap) = <(OverlapDetector, Overlap)>::default();
    let (mut other_detector, mut other_overlap) = <(OverlapDetector, Overlap)>::default();
    let times = report.interleave(
        BUDGET,
        [&mut || measure(&large, &mut detector, &mut overlap), &mut || {
            measure(&small, &mut other_detector, &mut other_overlap)
        }],
    );
    let counts = [&large, &small].map(|[a, _]| 2.0 * as_f64(a.surface().faces().len()));
    let per_face = [times[0] / counts[0], times[1] / counts[1]];
    report.ratio("measures per face, 655k / 41k faces", per_face, "ns", 1.3);
}

/// Compares the measures with a boolean mesh, which has to be built and summed for them.
fn boolean_mesh(meshes: &[Mesh; 2], report: &mut Report) -> Result<(), Box<dyn Error>> {
    let bodies = meshes.clone().map(body);
    let [a, b] = [manifold(&meshes[0])?, manifold(&meshes[1])?];
    let (mut detector, mut overlap) = <(OverlapDetector, Overlap)>::default();
    report.compare(
        "measures, 41k faces / boolmesh",
        BUDGET,
        0.1,
        [&mut || measure(&bodies, &mut detector, &mut overlap), &mut || {
            compute_boolean(&a, &b, OpType::Intersect).map_or(0, |mesh| mesh.nf)
        }],
    );

    // Both answers have the same volume.
    let shared = compute_boolean(&a, &b, OpType::Intersect)?;
    let mut six_volumes = 0.0_f64;
    for face in shared.hs.chunks_exact(3) {
        let [p, q, r] = [0, 1, 2].map(|corner| shared.ps[face[corner].tail]);
        six_volumes += p.dot(q.cross(r));
    }
    let volume = overlap.total.volume.unwrap_or(f64::NAN);
    let difference = (6.0 * volume / six_volumes - 1.0).abs();
    report.cost("volume, relative difference from boolmesh", difference, "", 1e-9);
    Ok(())
}

fn manifold(mesh: &Mesh) -> Result<Manifold, String> {
    let mut coordinates = Vec::new();
    for position in &mesh.positions {
        coordinates.extend(position.to_array());
    }
    let mut corners = Vec::new();
    for face in &mesh.faces {
        corners.extend(face.map(|vertex| vertex as usize));
    }
    Manifold::new(&coordinates, &corners)
}

/// Compares measures, and certified depths of whole surfaces, with the depths of vertices alone.
fn vertex_depths([a, b]: [SurfaceTree; 2], report: &mut Report) {
    let mut pair = PairProximity::default();
    let (mut detector, mut overlap) = <(OverlapDetector, Overlap)>::default();
    detector.measure_into([&a, &b], &mut overlap);
    let params = DepthParams::with_floor(1e-6 * RADIUS);

    let mut depth_detector = OverlapDetector::default();
    depth_detector.measure_into([&a, &b], &mut overlap);
    let [measures, depths, vertices] = report.interleave(
        BUDGET,
        [
            &mut || {
                detector.measure_into([&a, &b], &mut overlap);
                overlap.regions.len()
            },
            &mut || depth_detector.depths([&a, &b], &params).into_iter().flatten().count(),
            &mut || {
                pair.compute(&a, &b, 0.0);
                pair.sides()[0].inside_vertices().len()
            },
        ],
    );
    report.times("measures, 41k faces / depths of vertices", [measures, vertices], 1.0);
    report.times("certified depths, 41k faces / of vertices", [depths, vertices], 1.0);
}
