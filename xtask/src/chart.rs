//! `cargo xtask chart`: draws the pictures of `docs/chart`, with the numbers
//! behind them.

use std::path::Path;

use crate::TaskResult;
use crate::process::cargo;

/// Draws one picture, or all of them.
pub(crate) fn run(root: &Path, only: Option<&str>) -> TaskResult {
    let program = ["run", "--quiet", "--release", "--locked", "-p", "benches", "--bin", "chart"];
    let arguments = ["--", "docs/chart"].into_iter().chain(only);
    cargo(root, &program.into_iter().chain(arguments).collect::<Vec<_>>())
}
