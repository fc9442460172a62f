//! Checks in other length units: the same report to the bit, with lengths, areas and volumes in the
//! new unit.

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere, octasphere, tetrahedron};
use glam::DVec3;
use scene::{BodyKind, CheckParams, Coincidence, DepthBracket, PairReport, Progress, Scene};

/// Lengths of a unit in other ones: powers of 2, by which all numbers are multiplied exactly.
const UNITS: [f64; 4] = [1.0 / 1_048_576.0, 1.0 / 1024.0, 1024.0, 1_048_576.0];

/// A cube of 10 whose faces are split in two, in halves along an edge.
fn split_cube() -> Mesh {
    let whole = cube(10.0);
    let mut split = Mesh { faces: Vec::new(), ..whole.clone() };
    for (number, &[p, q, r]) in (8_u32..).zip(&whole.faces) {
        let [q_at, r_at] = [q, r].map(|corner| whole.positions[corner as usize]);
        split.positions.push(0.5 * (q_at + r_at));
        split.faces.extend([[p, q, number], [p, number, r]]);
    }
    split
}

/// Bodies that are the same, share a part of a side, touch, cross by edges, and are near each other.
fn bodies() -> Vec<(BodyKind, Mesh)> {
    let flush = cube(4.0).translated(DVec3::new(3.0, 1.0, 0.0));
    let edge = cube(6.0).rotated(DVec3::X, 0.125).translated(DVec3::new(-4.0, 0.0, 8.7));
    let bodies = [
        (BodyKind::Rigid, cube(10.0)),
        (BodyKind::Deformable, split_cube()),
        (BodyKind::Deformable, flush),
        (BodyKind::Deformable, cube(4.0).translated(DVec3::new(7.0, 2.0, 1.0))),
        (BodyKind::Rigid, edge),
        (BodyKind::Deformable, icosphere(3.0, 1).translated(DVec3::new(0.0, -7.5, 1.0))),
        (BodyKind::Open, octasphere(2.0, 1).translated(DVec3::new(0.0, 0.5, -6.5))),
        (BodyKind::Deformable, tetrahedron(2.0).translated(DVec3::new(0.0, 0.0, 5.25))),
    ];
    bodies.into()
}

fn check(unit: f64) -> Vec<PairReport> {
    let mut scene = Scene::new();
    for (number, (kind, mesh)) in bodies().into_iter().enumerate() {
        let x = mesh.positions.iter().map(|x| unit * *x).collect();
        scene.add(number.to_string(), kind, mesh.surface(), x).expect("a body");
    }
    let depth_tolerance = Some(1e-3 * unit);
    let params = CheckParams { depth_tolerance, ..CheckParams::new(0.75 * unit) };
    scene.check(&params, Progress::none()).expect("a check")
}

/// Returns a report with its lengths, areas and volumes in another unit.
fn converted(mut report: PairReport, unit: f64) -> PairReport {
    let (area, volume) = (unit * unit, unit * unit * unit);
    report.max_vertex_depth *= unit;
    report.min_gap = report.min_gap.map(|gap| unit * gap);
    report.distance = report.distance.map(|distance| unit * distance);
    for near in report.a_against_b.near.iter_mut().chain(&mut report.b_against_a.near) {
        near.gap *= unit;
        near.foot *= unit;
    }
    for bracket in report.near_areas.iter_mut().flatten() {
        bracket.lower *= area;
        bracket.upper *= area;
    }

    let Some(overlap) = &mut report.overlap else { return report };
    let measures = &mut overlap.measures;
    for measured in measures.regions.iter_mut().chain([&mut measures.total]) {
        measured.volume = measured.volume.map(|it| volume * it);
        measured.centroid = measured.centroid.map(|it| unit * it);
        measured.area_of_a_inside_b = measured.area_of_a_inside_b.map(|it| area * it);
        measured.area_of_b_inside_a = measured.area_of_b_inside_a.map(|it| area * it);
        measured.touching_area *= area;
        measured.flush_area *= area;
        measured.curve_length *= unit;
    }
    for depth in [&mut overlap.depth_of_a_in_b, &mut overlap.depth_of_b_in_a] {
        let Some(depth) = depth else { continue };
        depth.lower *= unit;
        depth.upper *= unit;
        depth.point *= unit;
        depth.foot *= unit;
    }
    for edge in &mut overlap.edge_overlaps {
        let DepthBracket { lower, upper } = edge.depth;
        edge.depth = DepthBracket { lower: unit * lower, upper: unit * upper };
        edge.point.at *= unit;
        edge.foot.at *= unit;
    }
    report
}

#[test]
fn the_length_unit_changes_no_bit_of_a_report() {
    let reports = check(1.0);
    let coincidences: Vec<Option<Coincidence>> =
        reports.iter().map(|report| report.coincidence).collect();
    let flush = |report: &PairReport| {
        report.overlap.as_ref().is_some_and(|overlap| overlap.measures.total.flush_area > 0.0)
    };
    assert_eq!(coincidences.iter().flatten().count(), 1, "{coincidences:?}");
    assert!(reports.iter().filter(|report| flush(report)).count() > 1, "parts of sides, too");
    assert!(reports.iter().any(|report| !report.overlaps && report.overlap.is_some()), "a touch");
    assert!(reports.iter().any(|report| report.near_areas.is_some()), "near each other");

    for unit in UNITS {
        let found = check(unit);
        assert_eq!(found.len(), reports.len());
        for (found, report) in found.into_iter().zip(&reports) {
            assert_eq!(found, converted(report.clone(), unit), "in units of {unit}");
        }
    }
}
