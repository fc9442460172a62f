//! Readers of files.

/// A mesh file: the first byte chooses the extension it would have.
pub fn mesh(bytes: &[u8]) {
    const EXTENSIONS: [&str; 5] = ["ply", "obj", "stl", "vtp", ""];
    let Some((first, rest)) = bytes.split_first() else { return };
    let _ = cli::fuzz::mesh_file(rest, EXTENSIONS[usize::from(*first) % EXTENSIONS.len()]);
}

/// A file of a distance field: the first byte chooses the extension it would have.
pub fn volume(bytes: &[u8]) {
    const EXTENSIONS: [&str; 2] = ["nrrd", "vti"];
    let Some((first, rest)) = bytes.split_first() else { return };
    let _ = cli::fuzz::volume_file(rest, EXTENSIONS[usize::from(*first) % EXTENSIONS.len()]);
}

/// A scene or a motion file.
pub fn scene(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let _ = cli::fuzz::scene_file(&text) || cli::fuzz::motion_file(&text);
}
