//! `cargo xtask fixtures`: writes the generated files of the package `fixtures`.
//!
//! Its tests compare the files with what the generators make, so this is run,
//! and the difference looked at, after a generator has changed.

use std::path::Path;

use crate::TaskResult;
use crate::process::cargo;

pub(crate) fn run(root: &Path) -> TaskResult {
    cargo(root, &["run", "--quiet", "--locked", "-p", "fixtures", "--example", "write"])
}
