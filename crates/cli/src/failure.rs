//! Failure of a command.

use std::fmt::Display;
use std::path::Path;

/// Problems that ended a command, one per line.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) problems: Vec<String>,
}

impl Failure {
    pub(crate) fn new(problem: impl Into<String>) -> Self {
        Self { problems: vec![problem.into()] }
    }

    /// Returns the failure to use a file.
    pub(crate) fn in_file(path: &Path, problem: impl Display) -> Self {
        Self::new(format!("{}: {problem}", path.display()))
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::new(error.to_string())
    }
}
