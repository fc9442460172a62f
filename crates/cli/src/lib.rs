//! The program `musculo-collide`: mesh and scene files in; tables, reports and
//! pictures out. A library only so that [`fuzz`] can reach its readers.
//!
//! `commands` holds one module for each subcommand. They read through `scene`
//! and `read`, ask the library, and hand what it found to `report`, which
//! builds the text of every output; `output` puts files in their places.

mod commands;
pub mod fuzz;
mod load;
mod motion;
mod output;
mod picture;
mod progress;
mod report;
mod scene;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use self::commands::{Command, Outcome};

/// Finds where bones and soft tissues overlap or touch, and says how deep.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit status: 0 nothing overlaps, 1 something overlaps, 2 bad input or usage."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// Does what the program's arguments say.
#[must_use]
pub fn run() -> ExitCode {
    match Arguments::parse().command.run() {
        Ok(Outcome::Clean) => ExitCode::SUCCESS,
        Ok(Outcome::Overlaps) => ExitCode::from(1),
        Err(failure) => {
            for problem in failure.problems() {
                // Nobody is left to tell if standard error is gone.
                let _ = writeln!(std::io::stderr(), "error: {problem}");
            }
            ExitCode::from(2)
        }
    }
}
