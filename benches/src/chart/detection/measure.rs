//! Accuracy, time and memory of all methods on one question.

use std::time::{Duration, Instant};

use super::methods::{self, Candidate, Detector, Failure, Kept, Method};
use super::question::{Pairs, Question};
use super::scene::Moving;
use super::score::Score;

/// What one method does at one setting.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// Which pairs were looked at.
    pub(super) of: Pairs,
    /// The method.
    pub(super) method: Method,
    /// Its setting.
    pub(super) setting: String,
    /// How right it is.
    pub(super) score: Score,
    /// To make its structures, once \[ms\].
    pub(super) build: f64,
    /// Bytes that these hold \[MB\].
    pub(super) held: f64,
    /// Bytes that a frame takes beyond that, at most \[MB\].
    pub(super) taken: f64,
    /// To follow the bodies to a frame and to look at all pairs there: least of several times, mean
    /// over the frames \[ms\].
    pub(super) frame: f64,
}

/// Time for all rounds of one method.
const BUDGET: Duration = Duration::from_millis(600);

/// Rounds over all frames, at least and at most.
const ROUNDS: [u32; 2] = [3, 15];

/// What was measured, and what was refused, in words.
pub(super) type All = (Vec<Measured>, Vec<String>);

/// Measures all methods, on the bone with muscles and on these with each other, on one thread.
///
/// # Errors
///
/// What a method refuses.
pub(super) fn all(moving: &Moving) -> Result<All, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|error| error.to_string())?;
    let on_this_thread = || {
        let kept = Kept::default();
        let (mut measured, mut refused) = (Vec::new(), Vec::new());
        for of in [Pairs::Bone, Pairs::Muscles] {
            let found = question(&Question::new(moving, of)?, &kept)?;
            measured.extend(found.0);
            refused.extend(found.1);
        }
        Ok((measured, refused))
    };
    // Errors of methods need not be able to leave their thread; their words are.
    pool.install(|| on_this_thread().map_err(|error: Failure| error.to_string()))
}

fn question(question: &Question<'_>, kept: &Kept) -> Result<All, Failure> {
    let candidates = methods::all(question, kept);
    let mut runs = Vec::new();
    let mut refused = Vec::new();
    for candidate in &candidates {
        match Run::new(candidate, question) {
            Ok(run) => runs.push(run),
            Err(error) => refused.push(candidate.refusal(&*error)),
        }
    }
    for round in 0..ROUNDS[1] {
        for run in &mut runs {
            if round < ROUNDS[0] || run.spent < BUDGET {
                run.time()?;
            }
        }
    }
    Ok((runs.into_iter().map(Run::finish).collect(), refused))
}

/// A method at work.
struct Run<'a> {
    measured: Measured,
    detector: Box<dyn Detector + 'a>,
    /// By frame \[ms\].
    least: Vec<f64>,
    spent: Duration,
}

impl<'a> Run<'a> {
    fn new(candidate: &Candidate<'a>, question: &Question<'_>) -> Result<Self, Failure> {
        let mut detector = None;
        let start = Instant::now();
        let of_build = allocation_counter::measure(|| detector = Some((candidate.build)()));
        let build = milliseconds(start);
        let mut detector = detector.ok_or("nothing was built")??;
        let build = build + detector.built_before();
        let frames = question.truth.len();
        // Once around, for those that learn from the frames before.
        for frame in 0..frames {
            detector.step(frame)?;
        }
        let mut score = Score::default();
        let mut taken = 0.0_f64;
        for (frame, truth) in question.truth.iter().enumerate() {
            let mut done = Ok(());
            let of_frame = allocation_counter::measure(|| done = detector.step(frame));
            done?;
            taken = taken.max(megabytes(of_frame.bytes_max));
            score.add(truth, &detector.told());
        }
        let held = megabytes(u64::try_from(of_build.bytes_current).unwrap_or(0));
        let Candidate { method, setting, .. } = candidate;
        let (of, method, setting) = (question.of, *method, setting.clone());
        let measured = Measured { of, method, setting, score, build, held, taken, frame: 0.0 };
        Ok(Self { measured, detector, least: vec![f64::INFINITY; frames], spent: Duration::ZERO })
    }

    /// Goes around once; first to the last frame, so that caches are warm for the first.
    fn time(&mut self) -> Result<(), Failure> {
        self.detector.step(self.least.len() - 1)?;
        for (frame, least) in self.least.iter_mut().enumerate() {
            let start = Instant::now();
            self.detector.step(frame)?;
            *least = least.min(milliseconds(start));
            self.spent += start.elapsed();
        }
        Ok(())
    }

    fn finish(self) -> Measured {
        let mean = self.least.iter().sum::<f64>() / crate::ratio::amount(self.least.len());
        Measured { frame: mean, ..self.measured }
    }
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

#[expect(clippy::cast_precision_loss, reason = "a size for a table")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
