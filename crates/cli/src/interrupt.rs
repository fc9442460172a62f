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
        others::handle_others();
    }
}

/// Lets writes beyond the limit of a file's size (`ulimit -f`) fail, as those on a full disk do.
/// Without a handler the system ends the process within the write.
pub(crate) fn fail_beyond_size_limit() {
    others::handle_size_limit();
}

fn exit() {
    process::exit(INTERRUPTED.into());
}

#[cfg(unix)]
mod others {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::{fs, thread};

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;

    use super::{exit, remove_unfinished};

    /// Handles the interruptions that are not ignored.
    pub(super) fn handle_others() {
        let mut handled = vec![SIGINT, SIGTERM, SIGHUP];
        let status = fs::read_to_string("/proc/self/status");
        match status.ok().as_deref().and_then(ignored) {
            Some(mask) => handled.retain(|signal| mask & (1 << (signal - 1)) == 0),
            // Which ones are ignored is unknown, but SIGTERM hardly ever is.
            None => handled = vec![SIGTERM],
        }

        let Ok(mut signals) = Signals::new(handled) else { return };
        thread::spawn(move || {
            for _ in signals.forever() {
                remove_unfinished(exit);
            }
        });
    }

    /// Handles the signal of a write beyond the limit of a file's size; the write then fails.
    pub(super) fn handle_size_limit() {
        // Where it cannot be handled, the system ends the process.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }

    /// Reads the mask of ignored signals, bit 0 for signal 1, from the status of a process on Linux.
    fn ignored(status: &str) -> Option<u64> {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    }
}

#[cfg(not(unix))]
mod others {
    pub(super) fn handle_others() {}

    pub(super) fn handle_size_limit() {}
}
