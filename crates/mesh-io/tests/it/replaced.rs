//! Files written again with other positions: everything else stays.

use glam::DVec3;
use mesh_io::{Mesh, Precision, coordinate_precision, parse_mesh, replace_positions};

use crate::meshes;
use crate::volumes::{INP, MSH_2, MSH_4};

/// Returns all positions of a file.
fn positions(mesh: &Mesh) -> Vec<DVec3> {
    match &mesh.volume {
        Some(volume) => volume.nodes.clone(),
        None => mesh.positions.clone(),
    }
}

/// Moves positions by a third of their number, which single precision rounds.
fn moved(x: &[DVec3]) -> Vec<DVec3> {
    let mut moved = x.to_vec();
    for (number, x) in (1_u32..).zip(&mut moved) {
        *x += DVec3::new(f64::from(number) / 3.0, -0.1, 1e-7);
    }
    moved
}

fn extension(name: &str) -> &str {
    name.rsplit_once('.').map_or("", |(_, extension)| extension)
}

/// Whatever the format, positions read back within the bound on rounding, and faces as they were.
fn check_moved(name: &str, bytes: &[u8]) {
    let extension = extension(name);
    let before = parse_mesh(bytes, extension).expect(name);
    let x = moved(&positions(&before));
    let file = replace_positions(bytes, extension, &x).expect(name);
    let after = parse_mesh(&file, extension).expect(name);

    let largest = x.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    let bound = coordinate_precision(bytes, extension).expect(name).max_rounding(largest);
    assert!(bound < 1e-6 * largest, "{name}: {bound}");
    for (x, expected) in positions(&after).iter().zip(&x) {
        assert!(x.distance(*expected) <= bound, "{name}: {x} for {expected}");
    }
    let topology = |mesh: Mesh| (mesh.faces, mesh.polygons_fanned, mesh.volume.map(|v| v.mesh));
    assert_eq!(topology(after), topology(before), "{name}");

    // What was read is written without any change, and so is what was written.
    let written = positions(&parse_mesh(&file, extension).expect(name));
    let again = replace_positions(&file, extension, &written);
    assert!(again.expect(name) == file, "{name}: changed by positions that are the same");
}

#[test]
fn positions_of_every_format_are_replaced() {
    for (name, bytes) in meshes::files() {
        check_moved(name, &bytes);
    }
    for (name, text) in [("a.inp", INP), ("a.msh", MSH_2), ("b.msh", MSH_4)] {
        check_moved(name, text.as_bytes());
        let x = positions(&parse_mesh(text.as_bytes(), extension(name)).unwrap());
        let same = replace_positions(text.as_bytes(), extension(name), &x).unwrap();
        assert!(same == text.as_bytes(), "{name}: the spelling of coordinates stays");
    }
}

/// Only the third vertex moves: all other bytes stay, whatever stands between and behind.
#[test]
fn attributes_and_spelling_stay() {
    let ply = "ply\nformat ascii 1.0\ncomment from a scanner\nelement vertex 3\n\
        property uchar red\nproperty list uchar int tags\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nelement face 1\nproperty list uchar int vertex_indices\nproperty int label\nend_header\n\
        7 2 5 6 0.00 1e0 0 0.5\n8 0 1 0 0 0.5\n9 1 4 0 PLACE 0.5\n3 0 1 2 42\n";
    let obj = "# from a scanner\nmtllib a.mtl\nv 0.00 1e0 0 0.9 0.1 0.1\nvn 0 0 1\nv 1 0 0\nvt 0.5 0.5\n\
        g bone\nv 0 PLACE 1.0\nf 1/1/1 2/1/1 3/1/1\n";
    let stl = "solid bone\n facet normal 0 0 0\n  outer loop\n   vertex 0.00 1e0 0\n   vertex 1 0 0\n   \
        vertex 0 PLACE\n  endloop\n endfacet\nendsolid bone\n";
    for (extension, text) in [("ply", ply), ("obj", obj), ("stl", stl)] {
        let [before, mut expected] = ["0 1", "0.25 1"].map(|yz| text.replace("PLACE", yz));
        if extension == "stl" {
            expected = expected.replace("normal 0 0 0", "NORMAL");
        }
        let mut x = parse_mesh(before.as_bytes(), extension).unwrap().positions;
        x[2].y = 0.25;
        let file = replace_positions(before.as_bytes(), extension, &x).unwrap();
        let mut file = String::from_utf8(file).unwrap();
        if extension == "stl" {
            // The normal of a facet that moves is computed anew.
            let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize();
            let written = format!("normal {:?} {:?} {:?}", normal.x, normal.y, normal.z);
            assert!(file.contains(&written), "{file}");
            file = file.replace(&written, "NORMAL");
        }
        assert_eq!(file, expected, "{extension}");
    }
}

#[test]
fn numbers_of_abaqus_fit_into_twenty_characters() {
    let x = vec![DVec3::new(-1.0 / 3.0 * 1e-90, 2.0 / 3.0, -123_456.123_456_789); 9];
    let file = String::from_utf8(replace_positions(INP.as_bytes(), "inp", &x).unwrap()).unwrap();
    let nodes = file.lines().skip(4).take(9);
    for number in nodes.flat_map(|line| line.split(',').skip(1).map(str::trim)) {
        assert!(number.len() <= 20, "{number}");
    }
    let read = parse_mesh(file.as_bytes(), "inp").unwrap().volume.unwrap();
    assert!((read.nodes[0] - x[0]).abs().max_element() < 1e-12 * 123_457.0);
}

#[test]
fn another_number_of_positions_is_refused() {
    for (name, bytes) in meshes::files() {
        let x = vec![DVec3::ZERO; 3];
        let error = replace_positions(&bytes, extension(name), &x).expect_err(name).to_string();
        assert!(error.contains("position"), "{name}: {error}");
    }
}

#[test]
fn positions_beyond_the_range_of_the_files_numbers_are_refused() {
    for (name, bytes) in meshes::files() {
        let mut x = positions(&parse_mesh(&bytes, extension(name)).expect(name));
        let precision = coordinate_precision(&bytes, extension(name)).expect(name);
        let is_single = precision == Precision::Single;
        for (coordinate, is_refused) in [(1e39, is_single), (f64::INFINITY, true), (f64::NAN, true)]
        {
            x[2].y = coordinate;
            let replaced = replace_positions(&bytes, extension(name), &x);
            let message = replaced.err().map(|error| error.to_string());
            let names_vertex = message.as_ref().is_some_and(|text| text.contains("vertex 2"));
            assert_eq!(names_vertex, is_refused, "{name}, {coordinate}: {message:?}");
        }
    }
}

/// Some editors write one before text, even before that of another, and it shifts every place in a file.
#[test]
fn marks_of_utf_8_are_no_content_and_stay() {
    let files = meshes::files();
    for ((name, bytes), count) in files.iter().flat_map(|file| [1, 2, 3].map(|count| (file, count)))
    {
        let mark = b"\xef\xbb\xbf".repeat(count);
        let marked = [&mark[..], bytes].concat();
        check_moved(name, &marked);
        let [with, without] = [&marked, bytes].map(|file| parse_mesh(file, extension(name)));
        let (with, without) = (with.expect(name), without.expect(name));
        assert_eq!((&with.positions, &with.faces), (&without.positions, &without.faces), "{name}");
        let x = positions(&with);
        let [with, without] =
            [&marked, bytes].map(|file| replace_positions(file, extension(name), &x).expect(name));
        assert!(with == [mark, without].concat(), "{name}: {count} marks stay");
    }
}

#[test]
fn binary_files_cut_within_the_last_position_are_refused() {
    let files = meshes::files();
    let (_, bytes) = files.iter().find(|(name, _)| *name == "little.ply").expect("a binary file");
    let mesh = parse_mesh(bytes, "ply").expect("a mesh");
    let marker = b"end_header\n";
    let header = bytes.windows(marker.len()).position(|bytes| bytes == marker).expect("a header");

    // Faces stand behind the positions, and are not read.
    let end = header + marker.len() + 12 * mesh.positions.len();
    assert!(replace_positions(&bytes[..end], "ply", &mesh.positions).is_ok());
    for cut in 1..=12 {
        let replaced = replace_positions(&bytes[..end - cut], "ply", &mesh.positions);
        assert!(replaced.is_err(), "{cut} bytes less");
    }
}
