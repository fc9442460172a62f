//! Real muscles, where the folder of `MUSCULO_DATA` holds them: how few faces do, and
//! that the deviation is what was asked for.
#![expect(clippy::print_stdout, reason = "prints a table, or that there is nothing to read")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use decimate::Decimation;
use glam::DVec3;
use surface::TriangleSurface;

/// A binary little-endian PLY file of single precision.
fn read(path: &Path) -> (TriangleSurface, Vec<DVec3>) {
    let bytes = std::fs::read(path).expect("the muscle's file can be read");
    let mark = b"end_header\n";
    let end = bytes.windows(mark.len()).position(|w| w == mark).expect("a header") + mark.len();
    let header = std::str::from_utf8(&bytes[..end]).expect("a header in text");
    let count = |what: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(what)).expect("a count");
        line.trim().parse().expect("a number")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("four bytes") };
    let number = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    let x =
        (0..vertices).map(|i| DVec3::from([0, 4, 8].map(|k| number(end + 12 * i + k)))).collect();
    let start = end + 12 * vertices;
    let face = |i: usize| [1, 5, 9].map(|k| u32::from_le_bytes(word(start + 13 * i + k)));
    let surface = TriangleSurface::new(vertices, (0..faces).map(face).collect());
    (surface.expect("valid indices"), x)
}

fn bodies(folder: &Path) -> Vec<PathBuf> {
    let entries = folder.read_dir().expect("a folder of bodies");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "ply"));
    paths.sort();
    paths
}

const DEVIATIONS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];

/// Thick and thin, smooth and noisy.
const SOME: [&str; 3] = ["muscle_pectineus", "muscle_psoas_major", "muscle_quadratus_femoris"];

#[test]
fn muscles_within_five_deviations() {
    table(|name| SOME.contains(&name));
}

#[test]
#[ignore = "takes a minute: the table of all bodies"]
fn a_thigh_within_five_deviations() {
    table(|_| true);
}

fn table(wanted: impl Fn(&str) -> bool) {
    let Some(folder) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA is not set");
        return;
    };
    let mut totals = [0; 6];
    let (mut collapsing, mut searching) = (Duration::ZERO, Duration::ZERO);
    let mut slack = 1.0_f64;
    println!("{:28} {:>6} {DEVIATIONS:?} mm", "body", "faces");
    for path in bodies(&folder.join("anatomy/vhf_left_thigh")) {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        if !wanted(&name) {
            continue;
        }
        let (surface, x) = read(&path);
        let placed = surface.positions(&x).expect("finite positions");
        let start = Instant::now();
        let decimation = match Decimation::new(&surface, placed) {
            Ok(decimation) => decimation,
            Err(error) => {
                println!("{name:28} {error}");
                continue;
            }
        };
        collapsing += start.elapsed();
        let mut faces = vec![surface.faces().len()];
        let start = Instant::now();
        for deviation in DEVIATIONS {
            let reduced = decimation.within(deviation).expect("a deviation in range");
            let bound = reduced.deviation.largest();
            assert!(bound <= deviation, "{name}: {bound} within {deviation}");
            for side in [reduced.deviation.full_to_reduced, reduced.deviation.reduced_to_full] {
                slack = slack.max(side.at_most / side.seen.max(1e-9));
            }
            faces.push(reduced.surface.faces().len());
        }
        searching += start.elapsed();
        assert!(faces[1..].is_sorted(), "{name}: {faces:?}");
        println!("{name:28} {faces:6?}");
        totals.iter_mut().zip(&faces).for_each(|(total, faces)| *total += faces);
    }
    println!("{:28} {totals:6?} {collapsing:.1?} to collapse, {searching:.1?} to search", "all");
    println!("bounds exceed what was seen by a factor of {slack:.3} at most");
    assert!(slack < 1.2 && totals[2] < totals[0] / 4, "{slack} {totals:?}");
}
