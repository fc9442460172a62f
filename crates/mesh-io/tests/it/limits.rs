//! Files that are too large, or never end.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use mesh_io::{MAX_FILE_BYTES, MAX_STREAM_BYTES, ReadError, read_file, read_mesh, read_text};

/// A sparse file has a length without taking space.
#[test]
fn a_file_above_the_limit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.stl");
    File::create(&path).unwrap().set_len(MAX_FILE_BYTES + 1).unwrap();
    let error = read_mesh(&path).unwrap_err().to_string();
    let expected =
        "huge.stl: cannot be read: it has more than 4294967296 bytes, the limit for a file";
    assert!(error.ends_with(expected), "{error}");
}

/// The number of vertices itself is below 2^32.
#[test]
fn the_maximum_number_of_vertices_is_allowed() {
    let message = ReadError::TooManyVertices(1 << 32).to_string();
    assert_eq!(message, "has 4294967296 vertices, but at most 4294967295 are allowed");
}

#[test]
fn a_device_without_end_is_refused() {
    let path = Path::new("/dev/zero");
    if !path.exists() {
        return;
    }
    let error = read_file(path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::FileTooLarge);
    let expected =
        format!("it has more than {MAX_STREAM_BYTES} bytes, the limit for a pipe or device");
    assert_eq!(error.to_string(), expected);
}

#[test]
fn text_is_utf_8() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, b"unit = \"mm\"\xff").unwrap();
    let error = read_text(&path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidData);
    assert_eq!(error.to_string(), "it is not UTF-8 text from byte 11 on");
    for mark in ["", "\u{feff}"] {
        std::fs::write(&path, format!("{mark}unit = \"µm\"")).unwrap();
        assert_eq!(read_text(&path).unwrap(), "unit = \"µm\"");
    }
    std::fs::write(&path, "# a\r\rb = 1\r\nc = 2\r\r\nd = 3\r").unwrap();
    assert_eq!(read_text(&path).unwrap(), "# a\n\nb = 1\nc = 2\nd = 3\n");
}
