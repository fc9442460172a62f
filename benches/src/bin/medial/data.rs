//! Which muscles there are, and where.

use std::path::{Path, PathBuf};

use benches::bodies::{self, Body};
use fixtures::data;

/// The folder of the bodies, if the environment names one.
pub(crate) fn folder() -> Option<PathBuf> {
    Some(data::anatomy("medial surfaces of muscles")?.join("vhf_left_thigh"))
}

/// Names of all muscles, in order.
pub(crate) fn muscles(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_prefix("muscle_")?.strip_suffix(".ply")?.to_owned()))
        .collect();
    names.sort_unstable();
    names
}

/// Reads a muscle.
pub(crate) fn muscle(folder: &Path, name: &str) -> Body {
    bodies::read(&folder.join(format!("muscle_{name}.ply")))
}
