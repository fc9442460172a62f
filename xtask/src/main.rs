//! Tasks that check, measure and write what this workspace claims.
//!
//! Each task is a module. None needs a dependency, so that this builds in a
//! second and stands in nobody's way.
//!
//! # How a check reports a number
//!
//! A test prints a line of this form, which `verify` puts in its closing table:
//!
//! ```text
//! measured: depth on real anatomy [mm] | 0.0031 | 0.01
//! ```
//!
//! that is, a name, the value, and what is allowed: at most so much, or at least
//! with `>=` before the number. A unit belongs to the name; whatever follows a
//! number is shown and not read.
//!
//! A program of the package `benches` named `CRATE_ratios` or `CRATE_peers`
//! prints a figure as `ratio`, name, ours, the other's, their ratio, what is
//! allowed, and `ok` or `SHORT`, with tabs between (`benches::ratio`); or, in
//! columns without units, as
//!
//! ```text
//! refit, 30,000 leaves [µs]      210.0      480.0       0.44      0.50  ok
//! ```
//!
//! where `-` stands for an other's or an allowed that there is not. It is called
//! with the word `ratios`.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "programs that print")]

mod chart;
mod fixtures;
mod number;
mod process;
mod ratios;
mod table;
mod test_output;
mod tidy;
mod verify;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What a task ends with; the message says what to do about a failure.
type TaskResult = Result<(), String>;

const USAGE: &str = "\
usage: cargo xtask TASK

  verify          tests, golden files, layout and timing checks, and one table of them
  ratios [CRATE]  every speed and cost that is claimed, beside what it is compared with
  chart [PICTURE] draw the pictures of docs/chart, and write the numbers behind them
  soak            10,000 frames of a small scene, and whether memory grows
  fixtures        write the generated files of the package `fixtures` anew
  tidy            layout rules: layers, module headers, file size, wording";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let result = match args[..] {
        ["verify"] => verify::run(&root()),
        ["ratios"] => ratios::run(&root(), None),
        ["ratios", name] => ratios::run(&root(), Some(name)),
        ["chart"] => chart::run(&root(), None),
        ["chart", name] => chart::run(&root(), Some(name)),
        ["soak"] => process::cargo(
            &root(),
            &["run", "--quiet", "--release", "--locked", "-p", "benches", "--bin", "soak"],
        ),
        ["fixtures"] => fixtures::run(&root()),
        ["tidy"] => tidy::run(&root()),
        _ => Err(USAGE.to_owned()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}
