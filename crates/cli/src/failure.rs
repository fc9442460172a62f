//! Failure of a command.

use std::fmt::Display;
use std::io;
use std::path::Path;

/// Problems that ended a command, one per line.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) kind: FailureKind,
    pub(crate) problems: Vec<String>,
}

/// Side of a command on which it fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FailureKind {
    /// Wrong input or usage.
    Input,
    /// Output that cannot be written.
    Output,
}

impl Failure {
    /// Returns the failure to use an input.
    pub(crate) fn new(problem: impl Into<String>) -> Self {
        Self { kind: FailureKind::Input, problems: vec![problem.into()] }
    }

    /// Returns the failure to use a file.
    pub(crate) fn in_file(path: &Path, problem: impl Display) -> Self {
        Self::new(format!("{}: {problem}", path.display()))
    }

    /// Returns the failure to write a file.
    pub(crate) fn in_output(path: &Path, problem: &io::Error) -> Self {
        Self::in_named_output(&path.display(), problem)
    }

    /// Returns the failure to write to standard output.
    pub(crate) fn in_standard_output(problem: &io::Error) -> Self {
        Self::in_named_output(&"standard output", problem)
    }

    fn in_named_output(name: &dyn Display, problem: &io::Error) -> Self {
        let problem = format!("{name}: cannot be written: {problem}");
        Self { kind: FailureKind::Output, problems: vec![problem] }
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::new(error.to_string())
    }
}
