//! Outputs of a command: files, devices, pipes and standard output.
//!
//! Every command declares the files that it reads and writes before it begins
//! ([`FilePlan`]). A plan in which an output would replace an input or another output is
//! refused. Files are then written beside their places, and moved there once all of them
//! are complete ([`Outputs`]), so that a failure or an interruption leaves nothing behind.

mod earlier;
mod format;
mod outputs;
mod places;
mod plan;
mod unfinished;

pub(crate) use self::format::OutputFormat;
pub(crate) use self::outputs::Outputs;
pub(crate) use self::plan::FilePlan;
pub(crate) use self::unfinished::remove_unfinished;
