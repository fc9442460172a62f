//! `cargo xtask tidy`: layout rules that no lint knows.

use std::fs;
use std::path::{Path, PathBuf};

use crate::TaskResult;

/// Which packages of this workspace each may depend on, lowest layer first.
/// Adding an edge is a design decision: it is made here, in the open.
///
/// Tests may use more; they make no edge.
const LAYERS: &[(&str, &[&str])] = &[
    ("crates/surface", &[]),
    ("crates/kdop", &[]),
    ("crates/ccd", &[]),
    ("crates/proximity", &["surface", "kdop", "ccd"]),
    ("crates/overlap", &["surface", "kdop", "proximity"]),
    ("crates/distance-field", &["surface", "kdop", "proximity"]),
    ("crates/medial", &["surface", "kdop", "proximity"]),
    ("crates/decimate", &["surface", "kdop", "proximity"]),
    ("crates/response", &["surface"]),
    ("crates/baselines", &["surface", "kdop"]),
    ("crates/scene", &["surface", "kdop", "ccd", "proximity", "distance-field", "medial"]),
    (
        "crates/plan",
        &[
            "surface",
            "kdop",
            "ccd",
            "proximity",
            "decimate",
            "distance-field",
            "medial",
            "response",
            "scene",
        ],
    ),
    ("crates/resolve", &["surface", "kdop", "proximity", "response", "scene"]),
    (
        "crates/musculo-collide",
        &[
            "surface",
            "kdop",
            "ccd",
            "proximity",
            "decimate",
            "distance-field",
            "medial",
            "overlap",
            "response",
            "scene",
            "plan",
            "resolve",
        ],
    ),
    ("crates/mesh-io", &["surface", "distance-field"]),
    ("crates/cli", &["musculo-collide", "mesh-io"]),
    ("fixtures", &["surface"]),
    ("fuzz/targets", &["surface", "kdop", "ccd", "distance-field", "mesh-io", "cli"]),
    ("fuzz", &["targets"]),
    ("xtask", &[]),
];

/// What no package but `benches` may depend on, not even for tests: peers, and
/// what times code.
const FOR_BENCHES_ONLY: &[&str] = &["criterion", "parry3d", "parry3d-f64", "obvhs", "del-geo-core"];

/// What only the program and the tasks may depend on: whatever reads or writes
/// files, prints, or shows progress.
const FOR_PROGRAMS_ONLY: &[&str] = &["clap", "indicatif", "plotters", "anyhow"];

/// Lines after which a file has grown a second subject.
const MAX_LINES: usize = 500;

/// Files that are longer, each with the reason why it is one subject.
const LONGER: &[(&str, &str)] = &[];

/// Words that speak of something a reader of this project does not have.
const FOREIGN: &[&str] = &["/home/", "/root/", "/tmp/", "prototype"];

/// Where `FOREIGN` is written down, and what sets up a machine.
const MAY_BE_FOREIGN: &[&str] = &["xtask/src/tidy.rs", ".ci/run"];

/// A text file of the workspace.
struct File {
    /// Its path from the root, with `/`.
    path: String,
    text: String,
}

/// What breaks one rule, a line each.
type Problems = Vec<String>;

/// Prints all problems; fails when there are any.
pub(crate) fn run(root: &Path) -> TaskResult {
    let all: Problems = problems(root).into_iter().flat_map(|(_, problems)| problems).collect();
    if all.is_empty() { Ok(()) } else { Err(all.join("\n")) }
}

/// Each rule, and what breaks it.
pub(crate) fn problems(root: &Path) -> Vec<(&'static str, Problems)> {
    let mut files = Vec::new();
    collect(root, root, &mut files);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    vec![
        ("layers of packages", layers(&files)),
        ("dependencies in their place", places_of_dependencies(&files)),
        ("module headers", headers(&files)),
        ("one subject a file", lengths(&files)),
        ("no trailing blanks", blanks(&files)),
        ("speaks of itself alone", wording(&files)),
    ]
}

/// Text files below a folder, but for what is built or hidden.
fn collect(root: &Path, folder: &Path, files: &mut Vec<File>) {
    let Ok(entries) = folder.read_dir() else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && (!name.starts_with('.') || name == ".ci" || name == ".cargo") {
                collect(root, &path, files);
            }
        } else if is_text(&path)
            && let Ok(text) = fs::read_to_string(&path)
        {
            files.push(File { path: from_root(root, &path), text });
        }
    }
}

fn is_text(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    matches!(extension, Some("rs" | "toml" | "md" | "sh")) || path.ends_with(".ci/run")
}

fn from_root(root: &Path, path: &Path) -> String {
    let below: PathBuf = path.strip_prefix(root).unwrap_or(path).to_path_buf();
    below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

fn layers(files: &[File]) -> Problems {
    let packages: Vec<&str> = LAYERS.iter().map(|(folder, _)| name_of(folder)).collect();
    let mut problems = Vec::new();
    for (folder, file) in manifests(files).filter(|(folder, _)| *folder != "benches") {
        let Some((_, allowed)) = LAYERS.iter().find(|(known, _)| *known == folder) else {
            problems.push(format!("{}: not in LAYERS of xtask/src/tidy.rs", file.path));
            continue;
        };
        let used = dependencies(&file.text, "[dependencies]");
        for other in used.into_iter().filter(|d| packages.contains(d) && !allowed.contains(d)) {
            problems.push(format!(
                "{}: {other} is not below it in LAYERS of xtask/src/tidy.rs",
                file.path
            ));
        }
    }
    problems
}

fn places_of_dependencies(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for (folder, file) in manifests(files).filter(|(folder, _)| *folder != "benches") {
        let program = folder == "crates/cli" || folder == "xtask";
        let of_tests = dependencies(&file.text, "[dev-dependencies]");
        for name in dependencies(&file.text, "[dependencies]").into_iter().chain(of_tests) {
            if FOR_BENCHES_ONLY.contains(&name) {
                problems.push(format!("{}: {name} belongs into benches", file.path));
            }
            if FOR_PROGRAMS_ONLY.contains(&name) && !program {
                problems.push(format!("{}: {name} belongs into the program", file.path));
            }
        }
    }
    problems
}

fn headers(files: &[File]) -> Problems {
    let without = rust(files).filter(|file| !file.text.starts_with("//! "));
    without
        .map(|file| format!("{}: starts without a `//!` line that says what it is", file.path))
        .collect()
}

fn lengths(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for file in rust(files) {
        let lines = file.text.lines().count();
        let listed = LONGER.iter().any(|(path, _)| *path == file.path);
        if lines > MAX_LINES && !listed {
            problems.push(format!(
                "{}: {lines} lines, over {MAX_LINES}: split it by subject",
                file.path
            ));
        } else if lines <= MAX_LINES && listed {
            problems.push(format!(
                "{}: no longer over {MAX_LINES} lines: strike it from LONGER",
                file.path
            ));
        }
    }
    problems
}

fn blanks(files: &[File]) -> Problems {
    let trailing =
        |(number, line): (usize, &str)| line.ends_with([' ', '\t']).then_some(number + 1);
    let first = |file: &File| file.text.lines().enumerate().find_map(trailing);
    let places = files.iter().filter_map(|file| Some((file, first(file)?)));
    places.map(|(file, line)| format!("{}:{line}: ends in a blank", file.path)).collect()
}

fn wording(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for file in files.iter().filter(|file| !MAY_BE_FOREIGN.contains(&file.path.as_str())) {
        for (number, line) in file.text.lines().enumerate() {
            let line = line.to_lowercase();
            for word in FOREIGN.iter().filter(|word| line.contains(**word)) {
                problems.push(format!("{}:{}: `{word}` means nothing here", file.path, number + 1));
            }
        }
    }
    problems
}

/// Folders of packages, with their manifests.
fn manifests(files: &[File]) -> impl Iterator<Item = (&str, &File)> {
    files.iter().filter_map(|file| Some((file.path.strip_suffix("/Cargo.toml")?, file)))
}

fn rust(files: &[File]) -> impl Iterator<Item = &File> {
    files.iter().filter(|file| file.path.ends_with(".rs"))
}

fn name_of(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

/// Names in a section of a manifest.
fn dependencies<'a>(manifest: &'a str, section: &str) -> Vec<&'a str> {
    let after = manifest.lines().skip_while(|line| line.trim() != section).skip(1);
    let entries = after.take_while(|line| !line.starts_with('['));
    let key = |line: &'a str| line.split(['=', '.', ' ']).next().unwrap_or(line);
    entries.map(key).filter(|key| !key.is_empty() && !key.starts_with('#')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> File {
        File { path: path.to_owned(), text: text.to_owned() }
    }

    #[test]
    fn finds_an_edge_upwards_and_a_package_without_a_place() {
        let upwards = "[dependencies]\nglam.workspace = true\nsurface = { path = \"\" }\n";
        let for_tests = "[dependencies]\n[dev-dependencies]\nfixtures.workspace = true\n";
        let files = [
            file("crates/kdop/Cargo.toml", upwards),
            file("crates/medial/Cargo.toml", upwards),
            file("crates/ccd/Cargo.toml", for_tests),
            file("crates/new/Cargo.toml", ""),
        ];
        let problems = layers(&files);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems[0].starts_with("crates/kdop") && problems[1].starts_with("crates/new"));
    }

    #[test]
    fn finds_dependencies_out_of_place() {
        let peers = "[dependencies]\nclap = \"4\"\n[dev-dependencies]\nobvhs = \"0.2\"\n";
        let of = |folder: &str| {
            places_of_dependencies(&[file(&format!("{folder}/Cargo.toml"), peers)]).len()
        };
        assert_eq!((of("crates/kdop"), of("crates/cli"), of("benches")), (2, 1, 0));
    }

    #[test]
    fn finds_what_reads_badly() {
        let long = "//! x\n".repeat(MAX_LINES + 1);
        let files = [
            file("a.rs", "//! A module.\n"),
            file("b.rs", "use std::fs; \n"),
            file("c.rs", &long),
            file("d.md", "As the Prototype showed.\n"),
        ];
        assert_eq!(headers(&files).len(), 1);
        assert_eq!(blanks(&files), ["b.rs:1: ends in a blank"]);
        assert_eq!(lengths(&files).len(), 1);
        assert_eq!(wording(&files).len(), 1);
    }
}
