//! Long calls: without the interpreter's lock, on the threads asked for, with progress and Ctrl-C.

use std::fmt::Display;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use musculo_collide::Progress;
use pyo3::prelude::*;

use crate::error::{interrupted, refused};
use crate::threads::Threads;

/// Time between two looks at signals and two calls of a progress function. Shorter costs time in
/// the interpreter; longer delays the end of an interrupted call.
const INTERVAL: Duration = Duration::from_millis(50);

/// Nanoseconds that calls have computed for, on all threads together.
static COMPUTED: AtomicU64 = AtomicU64::new(0);

/// Returns the seconds that the library has computed for in this process. What calls take beyond
/// them is the way from Python and back.
#[pyfunction]
pub(crate) fn computed_seconds() -> f64 {
    Duration::from_nanos(COMPUTED.load(Ordering::Relaxed)).as_secs_f64()
}

/// Computes, and counts the time of it.
fn timed<T>(compute: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let result = compute();
    let nanoseconds = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
    COMPUTED.fetch_add(nanoseconds, Ordering::Relaxed);
    result
}

/// Threads and observer of a long call.
#[derive(Debug)]
pub(crate) struct Call {
    threads: Threads,
    /// Function that is given the finished share.
    progress: Option<Py<PyAny>>,
}

impl Call {
    /// Prepares a call on a number of threads: all where it is `None`, the caller's own for 1.
    pub(crate) fn new(threads: Option<i64>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        Ok(Self { threads: Threads::new(threads)?, progress })
    }

    /// Returns the number of threads.
    pub(crate) fn thread_count(&self) -> usize {
        self.threads.count()
    }

    /// Computes without the interpreter's lock.
    ///
    /// Ctrl-C, and exceptions of the progress function, end the call with their exception.
    pub(crate) fn run<T: Send, E: Display + Send>(
        &self,
        py: Python<'_>,
        compute: impl FnOnce(Progress<'_>) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let observer = Observer::new(self.progress.as_ref());
        let compute = |progress: Progress<'_>| timed(|| compute(progress));
        let result = py.detach(|| match &self.threads {
            Threads::Own => {
                let handler = |fraction| observer.observe_now_and_then(fraction);
                self.threads.compute(|| compute(Progress::new(&handler)))
            }
            // Threads of a pool hand the work to each other; this one waits.
            threads => observer.compute_beside(|progress| threads.compute(|| compute(progress))),
        });

        match observer.exception() {
            Some(exception) => Err(exception),
            None => result.map_err(refused),
        }
    }

    /// Computes without the interpreter's lock what is soon done: nothing interrupts it.
    pub(crate) fn run_short<T: Send, E: Display + Send>(
        &self,
        py: Python<'_>,
        compute: impl FnOnce() -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let result = py.detach(|| self.threads.compute(|| timed(compute)));
        result.map_err(refused)
    }
}

/// Returns a number of things, which Python may give as any whole number.
pub(crate) fn count(number: i64, what: &str) -> PyResult<u32> {
    let refuse = |_| refused(format!("{what} is {number}, but must be from 0 to {}", u32::MAX));
    u32::try_from(number).map_err(refuse)
}

/// Computes what is soon done on all threads, without the interpreter's lock.
pub(crate) fn short<T: Send, E: Display + Send>(
    py: Python<'_>,
    compute: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    Call::new(None, None)?.run_short(py, compute)
}

/// Link between a computation and the interpreter.
struct Observer<'a> {
    progress: Option<&'a Py<PyAny>>,
    /// Bits of the largest fraction that the computation has reported.
    fraction: AtomicU64,
    is_interrupted: AtomicBool,
    exception: Mutex<Option<PyErr>>,
    last_look: Mutex<Instant>,
}

impl<'a> Observer<'a> {
    fn new(progress: Option<&'a Py<PyAny>>) -> Self {
        Self {
            progress,
            fraction: AtomicU64::new(0),
            is_interrupted: AtomicBool::new(false),
            exception: Mutex::new(None),
            last_look: Mutex::new(Instant::now()),
        }
    }

    /// Computes on another thread, while this one looks at signals and calls the progress function.
    fn compute_beside<T: Send, E: Send>(
        &self,
        compute: impl FnOnce(Progress<'_>) -> Result<T, E> + Send,
    ) -> Result<T, E> {
        let (sender, receiver) = channel();
        let handler = |fraction: f64| {
            self.advance(fraction);
            self.flow()
        };
        thread::scope(|scope| {
            let worker = scope.spawn(move || {
                let result = compute(Progress::new(&handler));
                // A receiver that is gone needs no result.
                let _ = sender.send(());
                result
            });
            while let Err(RecvTimeoutError::Timeout) = receiver.recv_timeout(INTERVAL) {
                self.observe(f64::from_bits(self.fraction.load(Ordering::Relaxed)));
            }
            worker.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    }

    /// Observes a computation on the calling thread, unless it was just observed.
    fn observe_now_and_then(&self, fraction: f64) -> ControlFlow<()> {
        let is_due = {
            let mut last_look = self.last_look.lock().unwrap_or_else(PoisonError::into_inner);
            let is_due = last_look.elapsed() >= INTERVAL;
            if is_due {
                *last_look = Instant::now();
            }
            is_due
        };
        let fraction = self.advance(fraction);
        if is_due {
            self.observe(fraction);
        }
        self.flow()
    }

    /// Takes a fraction that a thread reports, and returns the largest so far.
    ///
    /// Threads report out of order, but a share that was shown never falls. Bits of numbers that
    /// are not negative have the order of the numbers.
    fn advance(&self, fraction: f64) -> f64 {
        let bits = fraction.max(0.0).to_bits();
        f64::from_bits(self.fraction.fetch_max(bits, Ordering::Relaxed).max(bits))
    }

    /// Looks at signals and calls the progress function; an exception interrupts the computation.
    fn observe(&self, fraction: f64) {
        if self.is_interrupted.load(Ordering::Relaxed) {
            return;
        }
        let observed = Python::attach(|py| {
            py.check_signals()?;
            match self.progress {
                Some(progress) => progress.call1(py, (fraction,)).map(|_| ()),
                None => Ok(()),
            }
        });
        if let Err(exception) = observed {
            let mut held = self.exception.lock().unwrap_or_else(PoisonError::into_inner);
            *held = Some(exception);
            self.is_interrupted.store(true, Ordering::Relaxed);
        }
    }

    fn flow(&self) -> ControlFlow<()> {
        if self.is_interrupted.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Takes the exception that interrupted the computation.
    fn exception(&self) -> Option<PyErr> {
        let is_interrupted = self.is_interrupted.load(Ordering::Relaxed);
        let mut held = self.exception.lock().unwrap_or_else(PoisonError::into_inner);
        is_interrupted.then(|| held.take().unwrap_or_else(interrupted))
    }
}
