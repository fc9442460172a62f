//! The subcommands, one module each.

mod check;
mod field;
mod medial;
mod motion;
mod motion_resolve;
mod plan;
mod plan_frames;
mod resolve;
mod resolve_lengths;

use std::num::NonZeroUsize;

use clap::Subcommand;

use crate::motion::MotionError;
use crate::output::OutputError;
use crate::scene::SceneError;

/// What the program is asked to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Check(check::CheckArguments),
    Field(field::FieldArguments),
    Medial(medial::MedialArguments),
    Motion(motion::MotionArguments),
    Plan(plan::PlanArguments),
    Resolve(resolve::ResolveArguments),
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
            Self::Field(arguments) => field::run(arguments),
            Self::Medial(arguments) => medial::run(arguments),
            Self::Motion(arguments) => motion::run(arguments),
            Self::Plan(arguments) => plan::run(arguments),
            Self::Resolve(arguments) => resolve::run(arguments),
        }
    }
}

impl Failure {
    /// Of several problems, each worth a line.
    pub(crate) fn new(problems: Vec<String>) -> Self {
        Self(problems)
    }

    pub(crate) fn problems(&self) -> &[String] {
        &self.0
    }
}

/// Runs `work` in as many threads as were asked for, or one a processor.
fn in_threads<T: Send>(
    threads: Option<NonZeroUsize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let threads = threads.map_or(0, NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure(vec![format!("no threads: {error}")]))?;
    pool.install(work)
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

failures!(
    SceneError,
    MotionError,
    mesh_io::FileError,
    OutputError,
    musculo_collide::PlanError,
    musculo_collide::ResolveError,
    musculo_collide::SceneError,
    std::io::Error,
    serde_json::Error,
);
