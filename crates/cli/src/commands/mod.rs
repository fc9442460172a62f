//! The subcommands, one module each.

mod check;
mod field;
mod medial;
mod motion;
mod motion_resolve;
mod plan;
mod plan_frames;
mod resolve;
mod resolve_arguments;

use std::io::Write;

use clap::Subcommand;

use crate::failure::Failure;
use crate::output::Outputs;

/// Subcommand with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Check(check::CheckArguments),
    Field(field::FieldArguments),
    Medial(medial::MedialArguments),
    Motion(motion::MotionArguments),
    Plan(plan::PlanArguments),
    Resolve(resolve::ResolveArguments),
}

/// Result of a command that succeeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Clean,
    Overlaps,
}

impl Outcome {
    fn of_overlaps(overlaps: bool) -> Self {
        if overlaps { Self::Overlaps } else { Self::Clean }
    }
}

impl Command {
    pub(crate) fn run(&self) -> Result<Outcome, Failure> {
        match self {
            Self::Check(arguments) => check::run(arguments),
            Self::Field(arguments) => field::run(arguments),
            Self::Medial(arguments) => medial::run(arguments),
            Self::Motion(arguments) => motion::run(arguments),
            Self::Plan(arguments) => plan::run(arguments),
            Self::Resolve(arguments) => resolve::run(arguments),
        }
    }
}

/// Maximum number of written files that are listed one by one.
const MAX_LISTED: usize = 6;

/// Moves the outputs to their places, and returns lines that name them.
fn write_all(outputs: Outputs) -> Result<String, Failure> {
    let written = outputs.commit()?;
    if let Some(last) = written.last()
        && written.len() > MAX_LISTED
    {
        let folder = last.parent().unwrap_or(last);
        return Ok(format!("wrote {} files to {}\n", written.len(), folder.display()));
    }
    Ok(written.iter().map(|path| format!("wrote {}\n", path.display())).collect())
}

/// Prints a report.
fn print(text: &str) {
    // A reader that closed standard output needs no more of it; the exit status remains.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
