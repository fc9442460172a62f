//! Interruption by the user (Ctrl-C) or the system (SIGTERM, SIGHUP).

use std::process;

use crate::output::remove_unfinished;

/// Exit status after an interruption: 128 and the number of SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;

/// Ends the process at an interruption, and removes what is not in its place yet.
///
/// The process ends at once, whatever its threads compute or wait for. A signal that the
/// process inherited as ignored (`nohup`) stays so.
pub(crate) fn handle_interruption() {
    // Without a handler the system ends the process.
    let _ = ctrlc::try_set_handler(|| remove_unfinished(exit));
}

fn exit() {
    process::exit(INTERRUPTED.into());
}
