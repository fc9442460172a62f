//! The program `musculo-collide`: mesh and scene files in; tables, reports and pictures
//! out. It is a library only for the fuzz targets ([`fuzz`]).
//!
//! `commands` has one module per subcommand. These load a `scene`, call the library, and
//! pass its results to `report`, which builds the text of every output; `output` puts
//! files into their places.

mod commands;
mod failure;
pub mod fuzz;
mod load;
mod motion;
mod output;
mod phase;
mod picture;
mod report;
mod scene;
mod stopwatch;

use std::io::Write;
use std::num::NonZeroUsize;
use std::process::ExitCode;

use clap::Parser;

use self::commands::{Command, Outcome};
use self::failure::Failure;

/// Find where bones and soft tissues overlap or touch, and how deep
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Exit status: 0 nothing overlaps, 1 something overlaps, 2 bad input or usage."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,

    /// Number of threads; results do not depend on it [default: one per processor]
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

impl Arguments {
    fn run(&self) -> Result<Outcome, Failure> {
        let threads = self.threads.map_or(0, NonZeroUsize::get);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| self.command.run())
    }
}

/// Runs the program with the arguments of the command line.
#[must_use]
pub fn run() -> ExitCode {
    match Arguments::parse().run() {
        Ok(Outcome::Clean) => ExitCode::SUCCESS,
        Ok(Outcome::Overlaps) => ExitCode::from(1),
        Err(failure) => {
            for problem in failure.problems {
                // Without standard error there is no place to report to.
                let _ = writeln!(std::io::stderr(), "error: {problem}");
            }
            ExitCode::from(2)
        }
    }
}
