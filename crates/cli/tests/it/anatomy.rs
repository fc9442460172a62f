//! The program on real anatomy, against a table of overlaps.
//!
//! Needs the folder that `MUSCULO_DATA` names; says so and passes without it.
//!
//! Volumes, areas, curves and depths of surfaces must be those of a second table, which exact
//! constructions made.
//!
//! Which pairs overlap, how many faces cross and how many vertices are inside
//! must be as the table says. Its distances are up to 1.3 % too short (they
//! carry an approximate winding number as a factor), so that each distance is
//! held twice: loosely against the table, and to rounding against every face.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use musculo_collide::glam::DVec3;
use musculo_collide::surface::closest_on_triangle;
use serde_json::Value;

/// By how much a distance of the table may differ from the exact one: a share
/// of it, and the rounding of its four digits \[mm\].
const TABLE_SHARE: f64 = 0.013;
const TABLE_ROUNDING: f64 = 6e-4;

/// A pair by its names, the lesser first.
type Pair = (String, String);

/// A row of the table: depth, vertices of the first in the second and of the
/// second in the first, smallest gap, crossing pairs of faces.
struct Row {
    depth: f64,
    inside: [u64; 2],
    gap: f64,
    crossings: u64,
}

impl Row {
    fn overlaps(&self) -> bool {
        self.crossings > 0 || self.inside != [0, 0]
    }
}

fn data() -> Option<PathBuf> {
    Some(PathBuf::from(std::env::var_os("MUSCULO_DATA")?).join("anatomy"))
}

fn ordered(a: &str, b: &str) -> Pair {
    (a.min(b).to_owned(), a.max(b).to_owned())
}

fn rows(data: &Path, set: &str) -> BTreeMap<Pair, Row> {
    let table = fs::read_to_string(data.join("pairs.csv")).expect("the table of pairs");
    let fields = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let row = |field: Vec<&str>| {
        let number = |k: usize| field[k].parse::<f64>().expect("a number");
        let count = |k: usize| field[k].parse::<u64>().expect("a count");
        let mut inside = [count(4), count(5)];
        if field[1] > field[2] {
            inside.reverse();
        }
        let row = Row { depth: number(3), inside, gap: number(6), crossings: count(9) };
        (ordered(field[1], field[2]), row)
    };
    fields.filter(|field| field[0] == set).map(row).collect()
}

/// Returns the report of some meshes as JSON.
fn check(meshes: &[PathBuf]) -> Value {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let json = folder.path().join("report.json");
    let status = Command::new(env!("CARGO_BIN_EXE_musculo-collide"))
        .arg("check")
        .args(meshes)
        .arg("--json")
        .arg(&json)
        .output()
        .expect("the program runs")
        .status;
    assert_eq!(status.code(), Some(1), "these bodies overlap");
    serde_json::from_str(&fs::read_to_string(json).expect("a report")).expect("JSON")
}

fn meshes(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of meshes");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    paths
}

/// Corners of all faces of a binary PLY file of the data folder.
fn faces(path: &Path) -> Vec<[DVec3; 3]> {
    let bytes = fs::read(path).expect("a mesh");
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).expect("a header") + end.len();
    let header = String::from_utf8_lossy(&bytes[..at]).into_owned();
    let count = |what: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(what)).expect("an element");
        line.trim().parse().expect("a count")
    };
    let (vertices, faces) = (count("element vertex "), count("element face "));
    let word = |at: usize| <[u8; 4]>::try_from(&bytes[at..at + 4]).expect("four bytes");
    let number = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    let vertex = |v: usize| DVec3::from_array([0, 4, 8].map(|k| number(at + 12 * v + k)));
    let first = at + 12 * vertices;
    let corner = |at: usize| vertex(u32::from_le_bytes(word(at)) as usize);
    (0..faces).map(|f| [1, 5, 9].map(|k| corner(first + 13 * f + k))).collect()
}

/// Row of the table of exact overlaps.
struct ExactOverlap {
    names: [String; 2],
    volume: f64,
    /// Area of the first in the second, and of the second in the first.
    areas: [f64; 2],
    curve_length: f64,
    curve_loops: u64,
    /// Depth of the first in the second, and of the second in the first.
    depths: [f64; 2],
}

fn exact_overlaps(data: &Path, set: &str) -> Vec<ExactOverlap> {
    let table = fs::read_to_string(data.join("overlaps.csv")).expect("the table of overlaps");
    let fields = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let row = |field: Vec<&str>| {
        let number = |k: usize| field[k].parse::<f64>().expect("a number");
        ExactOverlap {
            names: [field[1].to_owned(), field[2].to_owned()],
            volume: number(3),
            areas: [number(4), number(5)],
            curve_length: number(6),
            curve_loops: field[7].parse().expect("a count"),
            depths: [number(11), number(12)],
        }
    };
    fields.filter(|field| field[0] == set).map(row).collect()
}

/// Compares the pair of a row with its report; returns the largest relative difference.
fn compare_overlap(report: &Value, row: &ExactOverlap) -> f64 {
    /// Digits of the table's depths \[mm\].
    const DIGITS: f64 = 2e-7;

    let [first, second] = &row.names;
    let key = ordered(first, second);
    let pairs = report["pairs"].as_array().expect("pairs");
    let is_pair = |pair: &&Value| {
        let name = |side: &str| pair[side].as_str().expect("a name");
        ordered(name("a"), name("b")) == key
    };
    let pair = pairs.iter().find(is_pair).expect("every row overlaps");
    let overlap = &pair["overlap"];

    // The program names bodies in the order of the files, the table in its own.
    let mut areas = ["area_of_a_inside_b", "area_of_b_inside_a"].map(|side| &overlap[side]);
    let mut depths = ["depth_of_a_in_b", "depth_of_b_in_a"].map(|side| &pair[side]);
    if pair["a"] != first.as_str() {
        areas.reverse();
        depths.reverse();
    }
    let mut worst: f64 = 0.0;
    let figures = [
        (&overlap["volume"], row.volume),
        (areas[0], row.areas[0]),
        (areas[1], row.areas[1]),
        (&overlap["curve_length"], row.curve_length),
    ];
    for (ours, exact) in figures {
        worst = worst.max((ours.as_f64().expect("a figure") / exact - 1.0).abs());
    }
    assert_eq!(overlap["curve_loops"].as_u64(), Some(row.curve_loops), "{key:?}");
    for (depth, exact) in depths.into_iter().zip(row.depths) {
        let [lower, upper] = ["lower", "upper"].map(|end| depth[end].as_f64().expect("a depth"));
        let holds = lower <= exact + DIGITS && exact <= upper + DIGITS;
        assert!(holds, "{key:?}: {exact} is not in {lower} to {upper}");
        assert!(upper - lower <= (0.0101 * upper).max(0.01), "{key:?}: {lower} to {upper}");
    }
    worst
}

/// How far distances are from the table at most, and those of the nearest
/// vertices from what every face gives.
#[derive(Default)]
struct Worst {
    depth: f64,
    gap: f64,
    exact: f64,
}

fn compare(report: &Value, rows: &BTreeMap<Pair, Row>, meshes: &[PathBuf]) -> Worst {
    let files: BTreeMap<String, &PathBuf> = meshes
        .iter()
        .map(|path| (path.file_stem().expect("a stem").to_string_lossy().into_owned(), path))
        .collect();
    let mut seen = BTreeSet::new();
    let mut worst = Worst::default();
    for pair in report["pairs"].as_array().expect("pairs") {
        let name = |side: &str| pair[side].as_str().expect("a name");
        let key = ordered(name("a"), name("b"));
        let Some(row) = rows.get(&key) else {
            assert_eq!(pair["overlaps"], false, "{key:?} overlap and are not in the table");
            continue;
        };
        compare_pair(pair, &key, row, &mut worst);
        let gap = pair["min_gap"].as_f64().expect("a gap");
        let exact = distance_of_nearest_vertex(pair, &files);
        worst.exact = worst.exact.max((gap.abs() - exact).abs());
        seen.insert(key);
    }
    for (key, row) in rows {
        assert!(seen.contains(key) || !row.overlaps(), "{key:?} is missing");
    }
    worst
}

fn compare_pair(pair: &Value, key: &Pair, row: &Row, worst: &mut Worst) {
    assert_eq!(pair["overlaps"], row.overlaps(), "{key:?}");
    assert_eq!(pair["crossing_face_pairs"].as_u64(), Some(row.crossings), "{key:?}");
    let mut inside = ["vertices_of_a_inside_b", "vertices_of_b_inside_a"]
        .map(|side| pair[side].as_u64().expect("closed bodies have an inside"));
    if pair["a"] != key.0.as_str() {
        inside.reverse();
    }
    assert_eq!(inside, row.inside, "{key:?}");
    let number = |field: &str| pair[field].as_f64().expect("a length");
    let lengths = [
        (number("max_vertex_depth"), row.depth, &mut worst.depth),
        (number("min_gap"), row.gap, &mut worst.gap),
    ];
    for (ours, table, worst) in lengths {
        let deviation = (ours - table).abs();
        let allowed = TABLE_SHARE * ours.abs() + TABLE_ROUNDING;
        assert!(deviation <= allowed, "{key:?}: {ours}, and {table} in the table");
        *worst = worst.max(deviation);
    }
}

fn distance_of_nearest_vertex(pair: &Value, files: &BTreeMap<String, &PathBuf>) -> f64 {
    let nearest = &pair["nearest_vertex"];
    let at = nearest["at"].as_array().expect("a place");
    let at: Vec<f64> = at.iter().map(|x| x.as_f64().expect("a coordinate")).collect();
    let at = DVec3::from_slice(&at);
    let (a, b) = (pair["a"].as_str().expect("a name"), pair["b"].as_str().expect("a name"));
    let other = if nearest["body"] == a { b } else { a };
    let each = faces(files[other]).into_iter();
    each.map(|face| closest_on_triangle(at, face).point.distance(at)).fold(f64::INFINITY, f64::min)
}

#[expect(clippy::print_stdout, reason = "the test prints what it skips or measures")]
fn holds_against_the_table(set: &str, with: &[&str]) {
    let Some(data) = data() else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let sets = || [set].into_iter().chain(with.iter().copied());
    let meshes: Vec<PathBuf> = sets().flat_map(|set| meshes(&data.join(set))).collect();
    let rows: BTreeMap<Pair, Row> = sets().flat_map(|set| rows(&data, set)).collect();
    let report = check(&meshes);
    let Worst { depth, gap, exact } = compare(&report, &rows, &meshes);
    let overlaps: Vec<ExactOverlap> = sets().flat_map(|set| exact_overlaps(&data, set)).collect();
    let mut overlap: f64 = 0.0;
    for row in &overlaps {
        overlap = overlap.max(compare_overlap(&report, row));
    }
    let count = overlaps.len();
    println!("measured: {set}: {count} overlaps against exact [relative] | {overlap:.1e} | 1e-9");
    assert!(count > 0 && overlap <= 1e-9, "{count} overlaps, {overlap}");
    println!("measured: {set}: depth against the table [mm] | {depth:.4} | 0.05");
    println!("measured: {set}: gap against the table [mm] | {gap:.4} | 0.05");
    println!("measured: {set}: nearest vertices against every face [mm] | {exact:.1e} | 1e-10");
    assert!(exact <= 1e-10, "a nearest vertex is off by {exact}");
}

#[test]
fn thigh() {
    holds_against_the_table("vhf_left_thigh", &[]);
}

#[test]
fn decimated_thigh() {
    holds_against_the_table("vhf_left_thigh_lo", &[]);
}

#[test]
fn joints_beside_the_thigh() {
    holds_against_the_table("vhf_left_joints", &["vhf_left_thigh"]);
}
