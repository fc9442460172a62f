//! Accuracy, time and memory of all methods on one task.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::methods::{Detector, Failure, METHODS, Method};
use super::scene::MovingBodies;
use super::score::{Errors, Score};
use super::task::{PairGroup, Task};
use crate::measure::{as_f64, nanoseconds};

/// Accuracy, time and memory of a method at one setting: a row of the table.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Measurement {
    /// Title of the group of pairs.
    pairs: &'static str,
    method: &'static str,
    setting: String,
    #[serde(flatten)]
    errors: Errors,
    /// Time to follow the bodies to a frame and to detect all pairs there: minimum over the
    /// rounds, mean over the frames.
    #[serde(rename = "frame [ms]")]
    frame: f64,
    /// Time to build its structures once.
    #[serde(rename = "build [ms]")]
    build: f64,
    /// Size of the structures.
    #[serde(rename = "held [MB]")]
    held: f64,
    /// Maximum of the memory that a frame allocates beyond that.
    #[serde(rename = "allocated in a frame [MB]")]
    allocated: f64,
}

/// Time for all rounds of one method; the round that exceeds it is the last.
const BUDGET: Duration = Duration::from_millis(400);

/// Maximum of the rounds over all frames.
const MAX_ROUNDS: u32 = 15;

/// Measurements, and the refusals for the caption.
#[derive(Debug, Default)]
pub(super) struct Measurements {
    pub(super) rows: Vec<Measurement>,
    pub(super) refusals: Vec<String>,
}

/// Measures all methods on both groups of pairs, on one thread.
///
/// # Errors
///
/// When a method fails in a frame.
pub(super) fn measure_all(moving: &MovingBodies) -> Result<Measurements, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let measured = pool.install(|| {
        let mut measurements = Measurements::default();
        for group in [PairGroup::Bone, PairGroup::Muscles] {
            let task = Task::new(moving, group).map_err(|error| error.to_string())?;
            // Errors of methods cannot leave their thread, but their texts can.
            measurements.add(&task).map_err(|error| error.to_string())?;
        }
        Ok::<_, String>(measurements)
    });
    Ok(measured?)
}

impl Measurements {
    /// Adds all methods on one task, timed in turns.
    fn add(&mut self, task: &Task<'_>) -> Result<(), Failure> {
        // A method that refuses a body is named in the caption.
        let mut runs = Vec::new();
        for method in METHODS.iter().filter(|method| method.detects(task.group)) {
            for &setting in method.settings {
                match Run::new(method, setting, task) {
                    Ok(run) => runs.push(run),
                    Err(error) => self.refuse(method, setting, &*error),
                }
            }
        }

        // Slow methods end after fewer rounds.
        for _ in 0..MAX_ROUNDS {
            for run in &mut runs {
                if run.spent < BUDGET {
                    run.time_round()?;
                }
            }
        }
        self.rows.extend(runs.into_iter().map(Run::finish));
        Ok(())
    }

    fn refuse(&mut self, method: &Method, setting: f64, error: &dyn std::error::Error) {
        let text = format!("{}, {}: {error}", method.key.name, method.text_of(setting));
        if !self.refusals.contains(&text) {
            self.refusals.push(text);
        }
    }
}

/// A detector with its times.
struct Run<'a> {
    measurement: Measurement,
    detector: Box<dyn Detector + 'a>,
    /// Minimum time per frame \[ms\].
    least: Vec<f64>,
    spent: Duration,
}

impl<'a> Run<'a> {
    /// Builds a detector and compares its answers with the exact ones.
    fn new(method: &Method, setting: f64, task: &'a Task<'a>) -> Result<Self, Failure> {
        // Memory that is left after the build is that of the structures.
        let mut detector = Err("the detector was not built".into());
        let start = Instant::now();
        let build_memory = allocation_counter::measure(|| detector = (method.build)(task, setting));
        let build = start.elapsed().as_secs_f64() * 1e3;
        let mut detector = detector?;

        // One round before, for methods that keep contacts from frame to frame.
        let frames = task.truth.len();
        for frame in 0..frames {
            detector.step(frame)?;
        }

        // Memory and errors of each frame.
        let mut score = Score::default();
        let mut allocated = 0.0_f64;
        for (frame, truth) in task.truth.iter().enumerate() {
            let mut outcome = Ok(());
            let memory = allocation_counter::measure(|| outcome = detector.step(frame));
            outcome?;
            allocated = allocated.max(megabytes(memory.bytes_max));
            score.add(truth, &detector.answer());
        }

        let measurement = Measurement {
            pairs: task.group.title(),
            method: method.key.name,
            setting: method.text_of(setting),
            errors: score.errors(),
            frame: f64::NAN,
            build,
            held: megabytes(u64::try_from(build_memory.bytes_current).unwrap_or(0)),
            allocated,
        };
        let least = vec![f64::INFINITY; frames];
        Ok(Self { measurement, detector, least, spent: Duration::ZERO })
    }

    /// Times all frames once, after the last one, so that caches are warm for the first.
    fn time_round(&mut self) -> Result<(), Failure> {
        self.detector.step(self.least.len() - 1)?;

        // A failed step would be quick: its outcome leaves the timed call.
        let start = Instant::now();
        for (frame, least) in self.least.iter_mut().enumerate() {
            let mut outcome = Ok(());
            let time = nanoseconds(|| {
                outcome = self.detector.step(frame);
                frame
            });
            outcome?;
            *least = least.min(time * 1e-6);
        }
        self.spent += start.elapsed();
        Ok(())
    }

    fn finish(self) -> Measurement {
        let frame = self.least.iter().sum::<f64>() / as_f64(self.least.len());
        Measurement { frame, ..self.measurement }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a size for a table")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
