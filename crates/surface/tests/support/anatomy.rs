//! Meshes and tables of the data folder that the environment variable
//! `MUSCULO_DATA` names.

use std::path::PathBuf;

use surface::TriangleSurface;
use surface::glam::DVec3;

/// The folder of meshes; without it, says that `test` is skipped.
pub(crate) fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("MUSCULO_DATA").map(|data| PathBuf::from(data).join("anatomy"));
    if folder.is_none() {
        skip(test);
    }
    folder
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn skip(test: &str) {
    eprintln!("{test}: skipped, MUSCULO_DATA is not set");
}

/// Rows of a comma-separated table as fields, without its head.
pub(crate) fn rows(path: PathBuf) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).expect("a table");
    text.lines().skip(1).map(fields).collect()
}

/// Fields of a line; commas within quotes do not part them.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields.last_mut().expect("one at least").push(c),
        }
    }
    fields
}

/// Reads a binary little-endian PLY of 32-bit floats and triangles.
pub(crate) fn read(path: PathBuf) -> (TriangleSurface, Vec<DVec3>) {
    let bytes = std::fs::read(path).expect("a mesh");
    let end = b"end_header\n";
    let head = bytes.windows(end.len()).position(|w| w == end).expect("a header") + end.len();
    let count = |element: &str| -> usize {
        let header = String::from_utf8_lossy(&bytes[..head]);
        let after = header.split(element).nth(1).expect("an element");
        after.split_whitespace().next().expect("a count").parse().expect("a number")
    };
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("four bytes") };
    let vertex_count = count("element vertex ");
    let float = |k: usize| f64::from(f32::from_le_bytes(word(head + 4 * k)));
    let x = (0..vertex_count).map(|v| DVec3::new(float(3 * v), float(3 * v + 1), float(3 * v + 2)));
    let faces_at = head + 12 * vertex_count;
    let corner = |face: usize, k: usize| u32::from_le_bytes(word(faces_at + 13 * face + 1 + 4 * k));
    let faces = (0..count("element face ")).map(|f| [corner(f, 0), corner(f, 1), corner(f, 2)]);
    (TriangleSurface::new(vertex_count, faces.collect()).expect("a surface"), x.collect())
}
