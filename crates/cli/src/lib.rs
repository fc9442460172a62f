//! The program `musculo-collide`: mesh and scene files in; tables, reports and pictures
//! out. It is a library only for the fuzz targets ([`fuzz`]).
//!
//! `commands` has one module per subcommand. These load a `scene`, call the library, and
//! pass its results to `report`, which builds the text of every output; `output` puts
//! files into their places, `terminal` prints the text.

mod commands;
mod conditions;
mod failure;
mod file_id;
pub mod fuzz;
mod interrupt;
mod load;
mod motion;
mod output;
mod phase;
mod report;
mod scene;
mod shared_nodes;
mod stopwatch;
mod terminal;

use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::thread;

use clap::{CommandFactory, FromArgMatches, Parser};

use self::commands::Command;
use self::failure::{Failure, FailureKind};

/// Find where bones and soft tissues overlap or touch, and how deep
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,

    /// Number of threads, up to four per processor or 64; results do not depend on it [default:
    /// one per processor]
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

/// End of every help text.
const STATUS_HELP: &str = "\
The file '-' of an output is standard output, which then has no table. Outputs replace other
files once all of them are complete, but never an input. Inputs have at most 4 GiB, or 256 MiB
where they are pipes or devices.

Exit status:
  0    the condition holds: nothing overlaps, the gap is reached, errors are within bounds
  1    it does not
  2    input or usage is wrong
  3    an output cannot be written
  130  interrupted
With 2 and above no file is changed but a --cache.";

/// Runs the program with the arguments of the command line.
#[must_use]
pub fn run() -> ExitCode {
    interrupt::handle_interruption();
    interrupt::fail_beyond_size_limit();

    // A mistake in the arguments is found before anything is read.
    let arguments = match Arguments::read() {
        Ok(arguments) => arguments,
        Err(error) => return print_usage(&error),
    };

    match arguments.run() {
        Ok(holds) => ExitCode::from(u8::from(!holds)),
        Err(failure) => print_failure(&failure),
    }
}

impl Arguments {
    /// Reads the command line; every help text has the exit statuses at its end.
    fn read() -> Result<Self, clap::Error> {
        let command = Self::command().mut_subcommands(with_status_help);
        let mut command = with_status_help(command);

        let mut matches = command.try_get_matches_from_mut(std::env::args_os())?;
        Self::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
    }

    /// Runs the command, and returns true if the condition that it checks holds.
    fn run(&self) -> Result<bool, Failure> {
        // The pool of this process, in which all parallel work of the command runs.
        let threads = self.thread_count()?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| self.command.run())
    }

    /// Returns the number of threads, 0 for one per processor.
    ///
    /// More than a few threads per processor only cost memory and time; thousands take
    /// longer to start than the work.
    fn thread_count(&self) -> Result<usize, Failure> {
        let Some(threads) = self.threads else { return Ok(0) };
        let processors = thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let max = 64.max(4 * processors);
        if threads.get() > max {
            let problem = format!(
                "--threads is {threads}, but must be at most {max}, the larger of 64 and four per \
                 processor"
            );
            return Err(Failure::new(problem));
        }
        Ok(threads.get())
    }
}

/// Appends the exit statuses to a help text.
fn with_status_help(command: clap::Command) -> clap::Command {
    let help = match command.get_after_help() {
        Some(examples) => format!("{examples}\n\n{STATUS_HELP}"),
        None => STATUS_HELP.to_owned(),
    };
    command.after_help(help)
}

/// Prints help to standard output, or a mistake in the arguments to standard error.
fn print_usage(error: &clap::Error) -> ExitCode {
    let printed = terminal::unless_closed(error.print());

    // Without standard error there is no place to report to.
    if error.use_stderr() {
        return exit_code(FailureKind::Input);
    }
    match printed {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => print_failure(&Failure::in_standard_output(&problem)),
    }
}

fn print_failure(failure: &Failure) -> ExitCode {
    for problem in &failure.problems {
        terminal::print_line("error", problem);
    }
    exit_code(failure.kind)
}

fn exit_code(kind: FailureKind) -> ExitCode {
    match kind {
        FailureKind::Input => ExitCode::from(2),
        FailureKind::Output => ExitCode::from(3),
    }
}
