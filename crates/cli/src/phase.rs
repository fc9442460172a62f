//! Progress on a terminal, for phases that last longer than a second.

use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use musculo_collide::Progress;

/// Time before a bar appears: one that vanishes at once would only flicker.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two drawings of a bar.
const BEAT: Duration = Duration::from_millis(100);

/// Steps of a bar for reported progress.
const MAX_PROGRESS: usize = 1000;

/// Phase of the work with its bar, which vanishes when the phase is dropped. Without a
/// terminal on standard error no bar appears.
#[derive(Debug)]
pub(crate) struct Phase {
    bar: ProgressBar,
    over: Option<Sender<()>>,
    waiting: Option<JoinHandle<()>>,
}

impl Phase {
    /// Starts a phase whose progress is unknown.
    pub(crate) fn start(name: &'static str) -> Self {
        Self::with_style(name, 1, "{spinner} {msg} {elapsed}")
    }

    /// Starts a phase of `steps` steps.
    pub(crate) fn with_steps(name: &'static str, steps: usize) -> Self {
        Self::with_style(name, steps, "{spinner} {msg} [{bar:30}] {pos}/{len} {elapsed}")
    }

    /// Runs work that reports its progress.
    pub(crate) fn run<T>(name: &'static str, work: impl FnOnce(Progress<'_>) -> T) -> T {
        let phase = Self::with_style(name, MAX_PROGRESS, "{spinner} {msg} [{bar:30}] {elapsed}");

        // Work is not interrupted here: an interruption ends the process.
        let handler = |fraction: f64| {
            phase.bar.set_position(position(fraction));
            ControlFlow::Continue(())
        };
        work(Progress::new(&handler))
    }

    fn with_style(name: &'static str, steps: usize, template: &str) -> Self {
        let style = ProgressStyle::with_template(template);
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden())
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            .with_message(name);

        // A thread waits for the end of the phase, or for the time at which to show the bar.
        let (over, is_over) = channel();
        let shown = bar.clone();
        let waiting = thread::spawn(move || show_later(&shown, &is_over));
        Self { bar, over: Some(over), waiting: Some(waiting) }
    }

    /// Moves the bar forward by one step.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }
}

/// Shows a bar, unless its phase is over before.
fn show_later(bar: &ProgressBar, is_over: &Receiver<()>) {
    if is_over.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        bar.enable_steady_tick(BEAT);
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a float saturates when it is cast"
)]
fn position(fraction: f64) -> u64 {
    (fraction * MAX_PROGRESS as f64) as u64
}

impl Drop for Phase {
    fn drop(&mut self) {
        // The end of the channel is the sign that the phase is over.
        drop(self.over.take());
        if let Some(waiting) = self.waiting.take() {
            let _ = waiting.join();
        }
        self.bar.finish_and_clear();
    }
}
