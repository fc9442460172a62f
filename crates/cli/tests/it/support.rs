//! Runs of the program in a folder of their own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fixtures::Mesh;

/// Temporary folder, removed when the test ends.
pub(crate) struct Workshop(tempfile::TempDir);

/// Result of a run.
pub(crate) struct Run {
    pub(crate) status: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Workshop {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a written file");
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect("a readable file")
    }

    /// Lists all files and folders below, ascending.
    pub(crate) fn listing(&self) -> Vec<String> {
        let mut names = Vec::new();
        list(self.0.path(), "", &mut names);
        names.sort();
        names
    }

    /// Runs `musculo-collide check` with this folder as the working directory.
    pub(crate) fn check(&self, arguments: &[&str]) -> Run {
        self.run("check", arguments)
    }

    /// Runs a command with this folder as the working directory.
    pub(crate) fn run(&self, command: &str, arguments: &[&str]) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_musculo-collide"))
            .arg(command)
            .args(arguments)
            .current_dir(self.0.path())
            .output()
            .expect("the program runs");
        Run::from(output)
    }

    /// Runs a command with each list of arguments, separated by spaces, and returns a table:
    /// the input, the exit status, the error in words, and the files that are new or changed.
    pub(crate) fn outcomes(&self, command: &str, inputs: &[&str]) -> String {
        let mut table = String::new();
        for input in inputs {
            let before = self.contents();
            let run = self.run(command, &input.split_whitespace().collect::<Vec<_>>());
            let mut after = self.contents();
            after.retain(|file| !before.contains(file));
            let written: Vec<String> = after.into_iter().map(|(name, _)| name).collect();

            table += &format!("{command} {input}\n  exit status {}\n", run.status);
            for line in run.stderr.lines().filter(|line| !line.is_empty()) {
                table += &format!("  {line}\n");
            }
            table += &format!("  new on disk: [{}]\n", written.join(", "));
        }
        table
    }

    /// Returns all files and folders with their contents, ascending.
    fn contents(&self) -> Vec<(String, Vec<u8>)> {
        let mut contents = Vec::new();
        for name in self.listing() {
            let content = fs::read(self.path(&name)).unwrap_or_default();
            contents.push((name, content));
        }
        contents
    }

    /// Checks that a command refuses each case, with further arguments that name outputs: the
    /// message has the expected words, and nothing is written.
    pub(crate) fn refuses(&self, command: &str, cases: &[(&[&str], &str)], outputs: &[&str]) {
        let before = self.listing();
        for &(arguments, expected) in cases {
            let run = self.run(command, &[arguments, outputs].concat());
            let is_output = run.stderr.contains(": cannot be written: ");
            assert_eq!(run.status, if is_output { 3 } else { 2 }, "{arguments:?}: {}", run.stdout);
            assert!(run.stderr.contains(expected), "{arguments:?}: {}", run.stderr);
            assert_eq!(self.listing(), before, "{arguments:?}");
        }
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            status: output.status.code().expect("an exit status"),
            stdout: String::from_utf8(output.stdout).expect("text"),
            stderr: String::from_utf8(output.stderr).expect("text"),
        }
    }
}

fn list(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            list(&entry.path(), &format!("{name}/"), names);
        }
        names.push(name);
    }
}

/// Ends of the edges of a hexahedron, in the order of their nodes in the middle.
pub(crate) const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// Returns a tetrahedron as an OBJ file: its right angle at (`x`, 0, 0), legs of `size`.
pub(crate) fn tetrahedron(x: f64, size: f64) -> String {
    format!(
        "v {x} 0 0\nv {} 0 0\nv {x} {size} 0\nv {x} 0 {size}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
        x + size
    )
}

/// Writes a mesh as an OBJ file.
pub(crate) fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.faces {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text
}
