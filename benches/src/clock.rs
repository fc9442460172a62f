//! Time of a thread that others on the machine do not add to.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Time that this thread has been running, whoever else wants the processor; wall time where the
/// system does not tell.
#[must_use]
pub fn running() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let running = statistics.and_then(|line| line.split(' ').next()?.parse().ok());
    running.map_or_else(|| START.get_or_init(Instant::now).elapsed(), Duration::from_nanos)
}
