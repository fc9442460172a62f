//! The subcommands, one module each.

mod body_file;
mod check;
mod field;
mod joint_arguments;
mod medial;
mod motion;
mod motion_cache;
mod motion_resolve;
mod motion_until;
mod plan;
mod plan_comparison;
mod plan_document;
mod plan_frames;
mod plan_times;
mod range;
mod range_map;
mod resolve;
mod resolve_arguments;
mod resolve_files;
mod resolve_parts;
mod run_cache;
mod vector;

use clap::Subcommand;

use crate::failure::Failure;
use crate::output::Outputs;
use crate::stopwatch::Stopwatch;
use crate::terminal;

/// Subcommand with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Check(check::CheckArguments),
    Field(field::FieldArguments),
    Medial(medial::MedialArguments),
    Motion(motion::MotionArguments),
    Plan(plan::PlanArguments),
    Range(range::RangeArguments),
    Resolve(resolve::ResolveArguments),
}

/// Work of a command, before its outputs are in their places.
#[derive(Debug)]
struct Finished {
    outputs: Outputs,
    /// Report for standard output.
    text: String,
    /// True if the condition holds that the command checks.
    holds: bool,
    stopwatch: Stopwatch,
}

impl Command {
    /// Runs the command, and returns true if the condition that it checks holds.
    pub(crate) fn run(&self) -> Result<bool, Failure> {
        let finished = match self {
            Self::Check(arguments) => check::run(arguments),
            Self::Field(arguments) => field::run(arguments),
            Self::Medial(arguments) => medial::run(arguments),
            Self::Motion(arguments) => motion::run(arguments),
            Self::Plan(arguments) => plan::run(arguments),
            Self::Range(arguments) => range::run(arguments),
            Self::Resolve(arguments) => resolve::run(arguments),
        };
        let Finished { outputs, text, holds, mut stopwatch } = finished?;

        // Files come last: a full standard output, too, leaves none behind.
        let written = outputs.write_streams()?;
        stopwatch.lap("write");
        if !written.to_standard_output {
            terminal::print_report(&(text + &written.lines() + &stopwatch.line()))?;
        }
        let earlier = outputs.earlier_files();
        outputs.move_files()?;
        for files in earlier {
            terminal::print_line("warning", &files.to_string());
        }
        Ok(holds)
    }
}
