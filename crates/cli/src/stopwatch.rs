//! Times of the phases of a command.

use std::time::{Duration, Instant};

/// Stopwatch that adds up the times of named phases.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    start: Instant,
    last: Instant,
    phases: Vec<(&'static str, Duration)>,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, phases: Vec::new() }
    }

    /// Adds the time since the last call to a phase, and returns it.
    pub(crate) fn lap(&mut self, phase: &'static str) -> Duration {
        let now = Instant::now();
        let time = now - self.last;
        self.last = now;

        // A phase that comes back, as in each frame, adds to its time.
        match self.phases.iter_mut().find(|(known, _)| *known == phase) {
            Some((_, sum)) => *sum += time,
            None => self.phases.push((phase, time)),
        }
        time
    }

    /// Writes the whole time and that of each phase.
    pub(crate) fn line(&self) -> String {
        let mut phases = Vec::new();
        for (phase, time) in &self.phases {
            phases.push(format!("{phase} {:.2} s", time.as_secs_f64()));
        }
        format!("{:.2} s: {}\n", self.start.elapsed().as_secs_f64(), phases.join(", "))
    }
}
