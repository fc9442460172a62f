//! Every overlapping pair of the data folder against exact constructions.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use overlap::{DepthParams, OverlapDetector, OverlapMeasures};
use proximity::SurfaceTree;

/// One line of the table of exact overlaps.
struct Row {
    names: String,
    /// Keys of the two bodies, `set/name`.
    bodies: [String; 2],
    volume: f64,
    areas: [f64; 2],
    length: f64,
    loops: usize,
    centroid: DVec3,
    depths: [f64; 2],
}

fn rows(folder: &Path) -> Vec<Row> {
    let text = std::fs::read_to_string(folder.join("overlaps.csv")).expect("the table is there");
    text.lines().skip(1).map(row).collect()
}

fn row(line: &str) -> Row {
    let fields: Vec<&str> = line.split(',').collect();
    let number = |i: usize| fields[i].parse::<f64>().expect("a column of numbers");
    Row {
        names: fields[..3].join(" "),
        bodies: [1, 2].map(|i| format!("{}/{}", fields[0], fields[i])),
        volume: number(3),
        areas: [number(4), number(5)],
        length: number(6),
        loops: fields[7].parse().expect("a count"),
        centroid: DVec3::new(number(8), number(9), number(10)),
        depths: [number(11), number(12)],
    }
}

/// Reads a body; bones of the joints are those of the thigh.
fn body(folder: &Path, key: &str) -> SurfaceTree {
    let mut path = folder.join(format!("{key}.ply"));
    if !path.exists() {
        let name = path.file_name().map(PathBuf::from).expect("a key ends in a name");
        path = folder.join("vhf_left_thigh").join(name);
    }
    let mesh = fixtures::data::mesh(&path);
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("meshes of the folder are finite")
}

#[test]
#[expect(clippy::print_stdout, reason = "figures of accuracy")]
fn measures_and_depths_are_those_of_exact_constructions() {
    let Some(folder) = fixtures::data::anatomy("overlaps of real pairs") else { return };
    let mut bodies: BTreeMap<String, SurfaceTree> = BTreeMap::new();
    let mut detector = OverlapDetector::default();
    let mut worst = [0.0_f64; 4];

    for row in rows(&folder) {
        for key in &row.bodies {
            bodies.entry(key.clone()).or_insert_with(|| body(&folder, key));
        }
        let pair = row.bodies.each_ref().map(|key| &bodies[key]);
        let overlap = detector.measure(pair[0], pair[1]);
        let errors = errors(&overlap.total, &row);
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
        check_depths(&mut detector, pair, &row);
    }

    let [volume, area, length, centroid] = worst;
    println!("measured: overlaps, volume against exact [relative] | {volume:.1e} | 1e-9");
    println!("measured: overlaps, areas against exact [relative] | {area:.1e} | 1e-10");
    println!("measured: overlaps, curve length against exact [relative] | {length:.1e} | 1e-10");
    println!("measured: overlaps, centroid against exact [mm] | {centroid:.1e} | 1e-6");
}

/// Compares the measures of one pair: errors of volume, areas, length and centroid.
fn errors(total: &OverlapMeasures, row: &Row) -> [f64; 4] {
    let relative = |measured: Option<f64>, exact: f64| {
        (measured.expect("all bodies are closed") / exact - 1.0).abs()
    };
    let volume = relative(total.volume, row.volume);
    let area = relative(total.area_of_a_inside_b, row.areas[0])
        .max(relative(total.area_of_b_inside_a, row.areas[1]));
    let length = relative(Some(total.curve_length), row.length);
    let centroid = total.centroid.expect("they overlap").distance(row.centroid);

    assert_eq!(total.curve_loops, row.loops, "{}", row.names);
    assert!(volume < if row.volume > 1.0 { 1e-10 } else { 1e-9 }, "{}: {volume}", row.names);
    assert!(area < 1e-10 && length < 1e-10, "{}: {area} {length}", row.names);
    assert!(centroid < 1e-6, "{}: {centroid}", row.names);
    [volume, area, length, centroid]
}

/// Checks that brackets are as narrow as asked and hold the table's depths, which have 7 digits.
fn check_depths(detector: &mut OverlapDetector, bodies: [&SurfaceTree; 2], row: &Row) {
    const DIGITS: f64 = 2e-7;

    for width in [1e-2, 1e-3, 1e-4] {
        let params =
            DepthParams { relative_tolerance: 0.0, tolerance: width, max_queries: 10_000_000 };
        for (depth, exact) in detector.depths(bodies, &params).into_iter().zip(row.depths) {
            let depth = depth.expect("they overlap");
            let holds = depth.lower <= exact + DIGITS && exact <= depth.upper + DIGITS;
            assert!(holds, "{}: {exact} {depth:?}", row.names);
            assert!(depth.upper - depth.lower <= width, "{}: {depth:?}", row.names);
        }
    }
}
