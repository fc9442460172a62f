//! Signs of life on a terminal, for what lasts longer than a second.

use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// What ends sooner than this shows no bar: one that flashes by tells nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// How often a shown bar moves.
const BEAT: Duration = Duration::from_millis(100);

/// A phase of the work; its bar goes when it is dropped. Where standard error
/// is no terminal there never is one.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    over: Option<Sender<()>>,
    waiting: Option<JoinHandle<()>>,
}

impl Progress {
    /// Starts a phase of `steps` steps, or of one that cannot be divided.
    pub(crate) fn start(what: &'static str, steps: usize) -> Self {
        let steps = u64::try_from(steps).unwrap_or(u64::MAX);
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden())
            .with_style(style(steps))
            .with_message(what);
        let (over, is_over) = channel();
        let shown = bar.clone();
        let waiting = thread::spawn(move || {
            if is_over.recv_timeout(PATIENCE).is_err_and(|error| error == TIMEOUT) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(BEAT);
            }
        });
        Self { bar, over: Some(over), waiting: Some(waiting) }
    }

    /// The steps begin anew.
    pub(crate) fn restart(&self) {
        self.bar.set_position(0);
    }

    /// One step is done.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }
}

const TIMEOUT: std::sync::mpsc::RecvTimeoutError = std::sync::mpsc::RecvTimeoutError::Timeout;

impl Drop for Progress {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(waiting) = self.waiting.take() {
            let _ = waiting.join();
        }
        self.bar.finish_and_clear();
    }
}

fn style(steps: u64) -> ProgressStyle {
    let template = if steps > 1 {
        "{spinner} {msg} [{bar:30}] {pos}/{len} {elapsed}"
    } else {
        "{spinner} {msg} {elapsed}"
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
