//! A real muscle, where the folder of `MUSCULO_DATA` holds it: how near a hundred
//! balls come, and that both bounds hold.
#![expect(clippy::print_stdout, reason = "says when there is nothing to read")]

use std::path::PathBuf;

use glam::DVec3;
use kdop::Workspace;
use medial::{Params, PrimitiveTree, Topology, generate};
use surface::TriangleSurface;

/// A binary little-endian PLY file of single precision.
fn read(path: PathBuf) -> (TriangleSurface, Vec<DVec3>) {
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

#[test]
fn a_hundred_balls_are_a_psoas() {
    let Some(folder) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA is not set");
        return;
    };
    let (surface, x) = read(folder.join("anatomy/vhf_left_thigh_lo/muscle_psoas_major.ply"));
    let x = surface.positions(&x).unwrap();
    let made = generate(&surface, x, &Params::balls(100), |_| {}).unwrap();
    assert!(made.deviation.rms < 0.4, "{:?}", made.deviation);
    let tree = PrimitiveTree::new(&made.medial).unwrap();
    let workspace = &mut Workspace::default();
    for corners in surface.faces() {
        let [a, b, c] = x.corners(*corners);
        let found = tree.nearest(&made.medial, (a + b + c) / 3.0, workspace);
        assert!(found.foot.distance <= made.deviation.surface_to_medial.at_most);
    }
    let inside = Topology::of_inside(&surface, x).unwrap();
    assert_eq!(Topology::of_union(&made.medial, 1.0).unwrap(), inside);
}
