//! The subcommands, one module each.

mod check;

use clap::Subcommand;

use crate::output::OutputError;
use crate::scene::SceneError;

/// What the program is asked to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Check(check::CheckArguments),
}

/// How a command that worked ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Clean,
    Overlaps,
}

/// Why a command did not work: every problem found, each on a line of its own.
#[derive(Debug)]
pub(crate) struct Failure(Vec<String>);

impl Command {
    pub(crate) fn run(&self) -> Result<Outcome, Failure> {
        match self {
            Self::Check(arguments) => check::run(arguments),
        }
    }
}

impl Failure {
    pub(crate) fn problems(&self) -> &[String] {
        &self.0
    }
}

macro_rules! failures {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self(vec![error.to_string()])
            }
        })*
    };
}

failures!(SceneError, OutputError, musculo_collide::SceneError, std::io::Error, serde_json::Error,);
