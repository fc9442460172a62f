//! Tasks that check, measure and write what this workspace claims.
//!
//! # How a test reports a number
//!
//! A test prints a line of this form, which `verify` puts in its closing table:
//!
//! ```text
//! measured: depth on real anatomy [mm] | 0.0031 | 0.01
//! ```
//!
//! that is, a name, the value and its upper bound, or a lower bound with `>=` before the number. A
//! unit belongs to the name; text after a number is shown and not read.
//!
//! # How the program `benches` reports a figure
//!
//! One line of JSON: the crate, a name, our cost, the other cost or `null`, their unit, the ratio of
//! both (our cost, without another), its upper bound or `null`, and `ok` or `SHORT`.
//!
//! ```text
//! {"group":"kdop","name":"refit 80k / parry","ours":210.0,"other":480.0,"unit":"us","measured":0.44,"allowed":0.5,"verdict":"ok"}
//! ```

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "programs that print")]

mod compiler;
mod figures;
mod long_tests;
mod number;
mod process;
mod table;
mod test_output;
mod test_programs;
mod tidy;
mod verify;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::process::cargo;
use crate::verify::Extent;

/// Outcome of a task; the message names the remedy of a failure.
type TaskResult = Result<(), String>;

const USAGE: &str = "\
usage: cargo xtask TASK

  verify           tests, golden files, layout and figures, and one table of them
  verify --quick   tests of at most seconds, golden files and layout: a minute, once built
  ratios [--only TEXT] [CRATE]
                   every claimed speed and cost, beside what it is compared with; also `motion`,
                   `plan` and `stability`; with a text, the figures whose names begin with it
  ratios --quick [CRATE]...
                   those that need no chart, in half a minute, with bounds twice as wide
  chart [PICTURE]  the pictures of docs/chart, and the numbers behind them
  soak             10,000 frames of a small scene, and the memory left behind
  fixtures         the generated files of the package `fixtures`
  tidy             layout rules: layers, module headers, file size, wording";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(status) = compiler::run(&arguments) {
        return status;
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&root(), &arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(root: &Path, arguments: &[&str]) -> TaskResult {
    match arguments {
        ["verify"] => verify::run(root, Extent::Full),
        ["verify", "--quick"] => verify::run(root, Extent::Quick),
        ["ratios", "--quick", names @ ..] => figures::quick_ratios(root, names),
        ["ratios", names @ ..] => figures::ratios(root, names),
        ["chart", names @ ..] => charts(root, names),
        ["soak"] => figures::soak(root),
        ["fixtures"] => {
            cargo(root, &["run", "--quiet", "--locked", "-p", "fixtures", "--example", "write"])
        }
        ["tidy"] => tidy::run(root),
        _ => Err(USAGE.to_owned()),
    }
}

/// Draws the named pictures, or all.
fn charts(root: &Path, names: &[&str]) -> TaskResult {
    let run = ["run", "--quiet", "--release", "--locked", "-p=benches", "--features=peers", "--"];
    cargo(root, &[run.as_slice(), &["chart", "docs/chart"], names].concat())
}

/// Returns the folder of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}
