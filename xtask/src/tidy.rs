//! `cargo xtask tidy`: layout rules beyond lints.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use crate::TaskResult;
use crate::long_tests::LONG_TESTS;

/// File with the map of packages and the edges between them.
const ARCHITECTURE: &str = "ARCHITECTURE.md";

/// Line of [`ARCHITECTURE`] before the block of edges.
const EDGES: &str = "Who may depend on whom";

/// Peers, which only `benches` may depend on, not even for tests.
const FOR_BENCHES_ONLY: &[&str] = &["boolmesh", "parry3d", "obvhs", "del-geo-core"];

/// Dependencies of programs only: for command lines, progress and pictures.
const FOR_PROGRAMS_ONLY: &[&str] = &["clap", "indicatif", "plotters", "anyhow"];

/// Lines after which a file has grown a second subject.
const MAX_LINES: usize = 500;

/// Longer files, each with the reason why it is one subject.
const LONGER: &[(&str, &str)] = &[];

/// Words about things that a reader of this project does not have.
const FOREIGN: &[&str] = &["/home/", "/root/", "/tmp/", "prototype"];

/// File that defines [`FOREIGN`], and those that set up a machine.
const MAY_BE_FOREIGN: &[&str] = &["xtask/src/tidy.rs", ".ci/run"];

/// Words that ask instead of naming an item or the result of a function.
const ASKING: &[&str] =
    &["What", "How", "Whether", "Who", "Whose", "Which", "Where", "When", "Why"];

/// A text file of the workspace.
struct File {
    /// Path from the root, with `/`.
    path: String,
    text: String,
}

/// Breaches of one rule, one line each.
type Problems = Vec<String>;

/// Prints all breaches; fails when there are any.
pub(crate) fn run(root: &Path) -> TaskResult {
    let mut all = Problems::new();
    for (_, problems) in problems(root) {
        all.extend(problems);
    }
    if all.is_empty() { Ok(()) } else { Err(all.join("\n")) }
}

/// Returns the breaches of each rule.
pub(crate) fn problems(root: &Path) -> Vec<(&'static str, Problems)> {
    let mut files = Vec::new();
    collect(root, root, &mut files);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    vec![
        ("layers of packages", layers(&files)),
        ("dependencies in their place", misplaced_dependencies(&files)),
        ("module headers", missing_headers(&files)),
        ("one subject per file", long_files(&files)),
        ("no trailing blanks", trailing_blanks(&files)),
        ("nothing foreign", foreign_words(&files)),
        ("documentation names, it does not ask", asking_docs(&files)),
        ("tests that the inner loop leaves out", absent_tests(&files, &LONG_TESTS)),
    ]
}

/// Collects text files below a folder, except built and hidden ones.
fn collect(root: &Path, folder: &Path, files: &mut Vec<File>) {
    let Ok(entries) = folder.read_dir() else { return };

    for entry in entries.flatten() {
        let path = entry.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            let is_hidden = name.starts_with('.') && ![".ci", ".cargo"].contains(&&*name);
            if name != "target" && !is_hidden {
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
    let is_known = ["rs", "toml", "md", "sh"].map(OsStr::new);
    path.extension().is_some_and(|extension| is_known.contains(&extension))
        || path.ends_with(".ci/run")
}

fn from_root(root: &Path, path: &Path) -> String {
    let below = path.strip_prefix(root).unwrap_or(path);
    below.display().to_string().replace(std::path::MAIN_SEPARATOR, "/")
}

/// Compares the dependencies of all packages with the edges in [`ARCHITECTURE`].
///
/// Tests may use more; they make no edge.
fn layers(files: &[File]) -> Problems {
    let Some(architecture) = files.iter().find(|file| file.path == ARCHITECTURE) else {
        return vec![format!("{ARCHITECTURE}: missing")];
    };
    let edges = edges(&architecture.text);
    let mut packages = BTreeSet::new();
    for (folder, _) in manifests(files) {
        packages.insert(name_of(folder));
    }

    // Packages off the map, and edges that do not go down.
    let mut problems = Vec::new();
    for (folder, file) in manifests(files) {
        let package = name_of(folder);
        if !architecture.text.contains(&format!("{package}/")) {
            problems.push(format!("{}: not on the map of {ARCHITECTURE}", file.path));
        }

        let below = below(package, &edges);
        for other in dependencies(&file.text, "[dependencies]") {
            if packages.contains(other) && !below.contains(other) {
                let path = &file.path;
                problems.push(format!("{path}: {other} is not below {package} in {ARCHITECTURE}"));
            }
        }
    }
    // Packages that are on the map only.
    let named: BTreeSet<&str> = edges.keys().chain(edges.values().flatten()).copied().collect();
    for package in named.difference(&packages) {
        problems.push(format!("{ARCHITECTURE}: there is no package {package}"));
    }
    problems
}

/// Reads the block of edges: lines `a, b ─▶ c, d`.
fn edges(architecture: &str) -> BTreeMap<&str, Vec<&str>> {
    let mut edges = BTreeMap::new();

    // The first fenced block after the line.
    let after = architecture.split_once(EDGES).map_or("", |(_, after)| after);
    let block = after.split("```").nth(1).unwrap_or("");
    for line in block.lines() {
        let Some((upper, lower)) = line.split_once("─▶") else { continue };
        let lower: Vec<&str> = lower.split(',').map(str::trim).collect();
        for package in upper.split(',') {
            edges.insert(package.trim(), lower.clone());
        }
    }
    edges
}

/// Returns all packages below one, along any number of edges.
fn below<'a>(package: &str, edges: &BTreeMap<&str, Vec<&'a str>>) -> BTreeSet<&'a str> {
    let mut below = BTreeSet::new();
    let mut open = edges.get(package).cloned().unwrap_or_default();
    while let Some(package) = open.pop() {
        if below.insert(package) {
            open.extend(edges.get(package).into_iter().flatten());
        }
    }
    below
}

fn misplaced_dependencies(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for (folder, File { path, text }) in manifests(files) {
        if folder == "benches" {
            continue;
        }

        // Tests count here, since they build too.
        let is_program = folder == "crates/cli" || folder == "xtask";
        let mut names = dependencies(text, "[dependencies]");
        names.extend(dependencies(text, "[dev-dependencies]"));

        for name in names {
            if FOR_BENCHES_ONLY.contains(&name) {
                problems.push(format!("{path}: {name} belongs into benches"));
            }
            if FOR_PROGRAMS_ONLY.contains(&name) && !is_program {
                problems.push(format!("{path}: {name} belongs into the program"));
            }
        }
    }
    problems
}

fn missing_headers(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for File { path, text } in rust(files) {
        if !text.starts_with("//! ") {
            problems.push(format!("{path}: starts without a `//!` line"));
        }
    }
    problems
}

fn long_files(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for File { path, text } in rust(files) {
        let lines = text.lines().count();
        let is_listed = LONGER.iter().any(|(longer, _)| longer == path);

        // An exception that is no longer needed is a breach, too.
        if lines > MAX_LINES && !is_listed {
            problems.push(format!("{path}: {lines} lines, over {MAX_LINES}: split it by subject"));
        } else if lines <= MAX_LINES && is_listed {
            problems
                .push(format!("{path}: no longer over {MAX_LINES} lines: strike it from LONGER"));
        }
    }
    problems
}

fn trailing_blanks(files: &[File]) -> Problems {
    breaches(files, |line| line.ends_with([' ', '\t']).then(|| "ends in a blank".to_owned()))
}

fn foreign_words(files: &[File]) -> Problems {
    breaches(files, |line| {
        let line = line.to_lowercase();
        let word = FOREIGN.iter().find(|word| line.contains(**word))?;
        Some(format!("`{word}` means nothing here"))
    })
}

/// Finds documentation that begins with a word of [`ASKING`].
fn asking_docs(files: &[File]) -> Problems {
    let mut problems = Vec::new();
    for File { path, text } in rust(files) {
        if !path.contains("src/") {
            continue;
        }

        // Only the first line of a block of documentation counts.
        let mut is_inside = false;
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim_start();
            let doc = line.strip_prefix("///").or(line.strip_prefix("//!"));
            let first = doc.and_then(|doc| doc.split_whitespace().next()).unwrap_or_default();
            if !is_inside && ASKING.contains(&first) {
                problems.push(format!("{path}:{number}: begin with a noun or a verb: {line}"));
            }
            is_inside = doc.is_some();
        }
    }
    problems
}

/// Finds tests, by the beginning of their names, that no file has: those that took their place would
/// not be left out.
fn absent_tests(files: &[File], names: &[&str]) -> Problems {
    let mut problems = Vec::new();
    for name in names {
        let (module, test) = name.rsplit_once("::").unwrap_or(("", name));
        let (module, function) = (format!("{module}.rs"), format!("fn {test}"));
        let mut is_there = false;
        for file in rust(files) {
            is_there |= file.path.ends_with(&module) && file.text.contains(&function);
        }
        if !is_there {
            problems.push(format!("xtask/src/long_tests.rs: no test begins with `{name}`"));
        }
    }
    problems
}

/// Applies a rule to every line, but not to those that define the rules.
fn breaches(files: &[File], rule: impl Fn(&str) -> Option<String>) -> Problems {
    let mut problems = Vec::new();
    for File { path, text } in files {
        for (number, line) in (1..).zip(text.lines()) {
            if let Some(problem) = rule(line)
                && !MAY_BE_FOREIGN.contains(&path.as_str())
            {
                problems.push(format!("{path}:{number}: {problem}"));
            }
        }
    }
    problems
}

/// Returns the folders of packages with their manifests.
fn manifests(files: &[File]) -> impl Iterator<Item = (&str, &File)> {
    files.iter().filter_map(|file| Some((file.path.strip_suffix("/Cargo.toml")?, file)))
}

fn rust(files: &[File]) -> impl Iterator<Item = &File> {
    files.iter().filter(|file| file.path.ends_with(".rs"))
}

fn name_of(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

/// Returns the names in a section of a manifest.
fn dependencies<'a>(manifest: &'a str, section: &str) -> Vec<&'a str> {
    let mut names = Vec::new();
    let mut is_inside = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            is_inside = line.trim() == section;
        } else if is_inside && line.starts_with(|c: char| c.is_ascii_alphabetic()) {
            names.extend(line.split(['=', '.', ' ']).next());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: &str) -> File {
        File { path: path.to_owned(), text: text.to_owned() }
    }

    #[test]
    fn edges_upward_and_packages_off_the_map_are_found() {
        let map = "kdop/\nmedial/\nsurface/\nccd/\nWho may depend on whom:\n\n```\n\
                   medial ─▶ kdop\nkdop, ccd ─▶ surface\n```\n";
        let upward = "[dependencies]\nglam.workspace = true\nmedial = { path = \"\" }\n";
        let downward = "[dependencies]\nkdop.workspace = true\nsurface.workspace = true\n";
        let for_tests = "[dependencies]\n[dev-dependencies]\nmedial.workspace = true\n";
        let files = [
            file(ARCHITECTURE, map),
            file("crates/ccd/Cargo.toml", for_tests),
            file("crates/kdop/Cargo.toml", upward),
            file("crates/medial/Cargo.toml", downward),
            file("crates/new/Cargo.toml", ""),
            file("crates/surface/Cargo.toml", ""),
        ];
        let problems = layers(&files);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems[0].starts_with("crates/kdop") && problems[1].starts_with("crates/new"));
        assert_eq!(layers(&files[..4]).len(), 2, "surface is named and missing");
    }

    #[test]
    fn dependencies_out_of_place_are_found() {
        let peers = "[dependencies]\nclap = \"4\"\n[dev-dependencies]\nobvhs = \"0.2\"\n";
        let of = |folder: &str| {
            misplaced_dependencies(&[file(&format!("{folder}/Cargo.toml"), peers)]).len()
        };
        assert_eq!((of("crates/kdop"), of("crates/cli"), of("benches")), (2, 1, 0));
    }

    #[test]
    fn files_that_read_badly_are_found() {
        let long = "//! x\n".repeat(MAX_LINES + 1);
        let files = [
            file(
                "src/a.rs",
                "//! A module.\n\n/// Whether it is.\n/// What follows is no start.\n",
            ),
            file("src/b.rs", "use std::fs; \n"),
            file("src/c.rs", &long),
            file("d.md", "As the Prototype showed.\n"),
        ];
        assert_eq!(missing_headers(&files).len(), 1);
        assert_eq!(trailing_blanks(&files), ["src/b.rs:1: ends in a blank"]);
        assert_eq!(long_files(&files).len(), 1);
        assert_eq!(foreign_words(&files).len(), 1);
        assert_eq!(asking_docs(&files).len(), 1);
    }

    #[test]
    fn tests_that_are_gone_are_found() {
        let files = [file("tests/it/walks.rs", "#[test]\nfn a_long_walk() {}\n")];
        let names = ["walks::a_long", "a_long_walk", "walks::", "walks::a_short", "runs::a_long"];
        let problems = absent_tests(&files, &names);
        assert_eq!(problems.len(), 2, "{problems:?}");
        assert!(problems[0].contains("a_short") && problems[1].contains("runs::"), "{problems:?}");
    }
}
