//! Interruption by the user (Ctrl-C) or the system (SIGTERM, SIGHUP).

use std::process;

use crate::output::remove_unfinished;

/// Exit status after an interruption: 128 and the number of SIGINT.
pub(crate) const INTERRUPTED: u8 = 130;

/// Ends the process at an interruption, and removes what is not in its place yet.
///
/// The process ends at once, whatever its threads compute or wait for. A signal that the
/// process inherited as ignored stays so: SIGHUP of `nohup`, SIGINT in the background of a script.
pub(crate) fn handle_interruption() {
    // One signal that is ignored keeps this handler from all of them.
    if ctrlc::try_set_handler(|| remove_unfinished(exit)).is_err() {
        handle_termination();
    }
}

/// Handles SIGTERM alone. Without a handler the system ends the process.
#[cfg(unix)]
fn handle_termination() {
    use signal_hook::consts::SIGTERM;
    use signal_hook::iterator::Signals;

    let Ok(mut signals) = Signals::new([SIGTERM]) else { return };
    std::thread::spawn(move || {
        for _ in signals.forever() {
            remove_unfinished(exit);
        }
    });
}

#[cfg(not(unix))]
fn handle_termination() {}

fn exit() {
    process::exit(INTERRUPTED.into());
}
