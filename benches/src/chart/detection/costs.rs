//! Time of each kind of operation in a plan, fitted to the times of several plans' frames.
//!
//! Each plan is timed twice: with bodies in contact, and with bodies far apart, where the only
//! work is to follow them.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use distance_field::Pose;
use glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, Detection, DetectionMethod, ForcedMethod, OperationCounts, PairId, Plan, PlanParams,
    Progress, Scene, machine_factor,
};
use serde::Serialize;

use super::scene::{FRAMES, MovingBodies};
use super::task::{PairGroup, Task};
use crate::chart::curves::machine;
use crate::chart::sheet::Sheet;
use crate::measure::as_f64;

/// Names of the kinds of operations, in the order of [`OperationCounts::to_array`].
const KINDS: [&str; COUNT] = [
    "face refitted",
    "vertex of a compared surface",
    "pair of faces tested",
    "pair of faces that meet",
    "vertex projected",
    "face bounded in a search",
    "triangle split in a search",
    "closest point in a search",
    "vertex over a field",
    "vertex followed by balls",
    "vertex among balls",
    "face of a tree that is built",
    "face decimated",
    "node of a field",
];

/// Number of kinds of operations.
const COUNT: usize = OperationCounts::SECONDS.to_array().len();

const TOLERANCES: [f64; 5] = [2.0, 1.0, 0.5, 0.2, 0.1];

/// Plans that are timed: a method, forced on a group of pairs, at the first tolerances \[mm\].
///
/// Fields take memory and balls long to build, so there are fewer of them.
const SERIES: [(PairGroup, DetectionMethod, usize); 6] = [
    (PairGroup::Bone, DetectionMethod::Field, 3),
    (PairGroup::Bone, DetectionMethod::Exact, 5),
    (PairGroup::Muscles, DetectionMethod::Exact, 5),
    (PairGroup::Bone, DetectionMethod::Coarse, 5),
    (PairGroup::Muscles, DetectionMethod::Coarse, 5),
    (PairGroup::Muscles, DetectionMethod::Medial, 2),
];

/// Frame in which muscles are pressed on the bone most, and how often it is timed.
const PRESSED: usize = FRAMES as usize / 2;
const ROUNDS: u32 = 25;

/// Distance between muscles that are out of contact \[mm\].
const APART: DVec3 = DVec3::new(1e4, 0.0, 0.0);

const TIME: &str = "minimum of several frames, over the machine factor of the same moment; of the kinds of operations, the fit to the frames of all plans";

/// Operations of a plan in a frame, and their time on the reference machine.
struct TimedFrame {
    plan: String,
    counts: [f64; COUNT],
    seconds: f64,
}

/// Writes the time of each kind of operation, and the plans' times beside those predicted.
///
/// # Errors
///
/// When a file cannot be written, or a plan cannot be made.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let frames = pool.install(|| timed_frames().map_err(|error| error.to_string()))?;
    let fitted = fit(&frames);

    // The kinds of operations first, then the plans.
    let in_use = OperationCounts::SECONDS.to_array();
    let mut rows = Vec::new();
    for (kind, (fitted, in_use)) in KINDS.iter().zip(fitted.iter().zip(in_use)) {
        rows.push(CostRow::new(kind, *fitted, in_use));
    }
    for TimedFrame { plan, counts, seconds } in &frames {
        rows.push(CostRow::new(plan, *seconds, product(counts, &in_use)));
    }
    let settings = vec![("time", TIME.to_owned()), ("machine", machine())];
    Ok(Sheet::new("costs", settings, &rows)?.write(folder, None)?)
}

/// Time of a kind of operation or of a plan's frame: a row of the table.
#[derive(Serialize)]
struct CostRow<'a> {
    work: &'a str,
    #[serde(rename = "measured [ns]")]
    measured: f64,
    #[serde(rename = "predicted [ns]")]
    predicted: f64,
}

impl<'a> CostRow<'a> {
    fn new(work: &'a str, measured: f64, predicted: f64) -> Self {
        Self { work, measured: 1e9 * measured, predicted: 1e9 * predicted }
    }
}

fn timed_frames() -> Result<Vec<TimedFrame>, Box<dyn Error>> {
    let moving = MovingBodies::fixture();
    let mut frames = Vec::new();
    for (group, method, count) in SERIES {
        let task = Task::new(&moving, group)?;
        for tolerance in &TOLERANCES[..count] {
            frames.extend(timed_plan(&task, method, *tolerance)?);
        }
    }
    Ok(frames)
}

/// Times frames of one plan, in contact and apart.
fn timed_plan(
    task: &Task<'_>,
    method: DetectionMethod,
    tolerance: f64,
) -> Result<[TimedFrame; 3], Box<dyn Error>> {
    let (mut scene, ids) = task.scene()?;
    for muscle in task.muscles() {
        scene.move_body(ids[muscle], task.positions(PRESSED, muscle))?;
    }
    let mut forced = Vec::new();
    for &[a, b] in &task.pairs {
        forced.push(ForcedMethod { pair: PairId::new(ids[a], ids[b]), method });
    }

    // Displacements have no limit, since muscles are moved far apart below.
    let params =
        PlanParams { max_displacement: f64::INFINITY, ..PlanParams::with_tolerance(tolerance) };

    // Divided by the machine factor, times are those of the reference machine.
    let start = Instant::now();
    let mut plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none())?;
    let built = start.elapsed().as_secs_f64() / machine_factor(|| start.elapsed());
    let mut construction = OperationCounts::default();
    for structure in plan.structures() {
        construction = construction + structure.operations;
    }

    // Operations are counted in the first frame. Apart, the only ones are those of no pair.
    let title = format!("plan by {method} within {tolerance} mm");
    let near = frame_seconds(&mut plan, &mut scene, task, &ids, DVec3::ZERO)?;
    let all = plan.operations().to_array();
    let of_pairs =
        plan.pairs().iter().fold(OperationCounts::default(), |sum, pair| sum + pair.operations);
    let of_pairs = of_pairs.to_array();
    let following = std::array::from_fn(|kind| all[kind] - of_pairs[kind]);
    let far = frame_seconds(&mut plan, &mut scene, task, &ids, APART)?;
    let construction = construction.to_array();
    Ok([
        TimedFrame { plan: format!("{title}, construction"), counts: construction, seconds: built },
        TimedFrame { plan: format!("{title}, in contact"), counts: all, seconds: near },
        TimedFrame { plan: format!("{title}, apart"), counts: following, seconds: far },
    ])
}

/// Returns the minimum time of a frame, over the machine factor.
fn frame_seconds(
    plan: &mut Plan,
    scene: &mut Scene,
    task: &Task<'_>,
    ids: &[BodyId],
    shift: DVec3,
) -> Result<f64, Box<dyn Error>> {
    let mut detection = Detection::default();
    let (mut seconds, mut factor) = (f64::INFINITY, f64::INFINITY);
    for round in 0..ROUNDS {
        // Tiny moves back and forth, so that everything has to follow.
        let offset = f64::from(1 + round % 2) * 1e-6;
        scene.pose_body(ids[0], &Pose::new(DQuat::IDENTITY, DVec3::splat(offset)))?;
        for muscle in task.muscles() {
            let by = as_f64(muscle) * shift + offset;
            let mut x = task.positions(PRESSED, muscle).to_vec();
            for p in &mut x {
                *p += by;
            }
            scene.move_body(ids[muscle], &x)?;
        }

        let start = Instant::now();
        plan.detect(scene, &mut detection)?;
        seconds = seconds.min(start.elapsed().as_secs_f64());
        factor = factor.min(machine_factor(|| start.elapsed()));
    }
    Ok(seconds / factor)
}

/// Fits nonnegative times of the kinds of operations to the frames, by least squares of the
/// relative errors (Gauss–Seidel sweeps).
fn fit(frames: &[TimedFrame]) -> [f64; COUNT] {
    const SWEEPS: u32 = 100_000;

    // Counts over the time of their frame, so that errors are relative; then the normal equations.
    let mut products = [[0.0; COUNT]; COUNT];
    let mut sums = [0.0; COUNT];
    for frame in frames {
        let row = frame.counts.map(|count| count / frame.seconds);
        for (kind, of_kind) in row.into_iter().enumerate() {
            sums[kind] += of_kind;
            for (sum, other) in products[kind].iter_mut().zip(row) {
                *sum += of_kind * other;
            }
        }
    }

    // Each sweep minimizes over one kind after the other.
    let mut seconds = [0.0; COUNT];
    for _ in 0..SWEEPS {
        for kind in 0..COUNT {
            let squares = products[kind][kind];
            if squares > 0.0 {
                let rest = sums[kind] - product(&products[kind], &seconds);
                seconds[kind] = (seconds[kind] + rest / squares).max(0.0);
            }
        }
    }
    seconds
}

fn product(a: &[f64; COUNT], b: &[f64; COUNT]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`OperationCounts::SECONDS`] are to follow new measurements, after which this may fail.
    ///
    /// Kinds of operations that occur together are not told apart by the fit, so that frames are
    /// compared: those by surfaces, which a free choice decides between.
    #[test]
    fn plans_predict_by_the_measured_times() {
        let numbers = include_str!("../../../../docs/chart/costs.csv");
        let mut ratios: Vec<f64> = Vec::new();
        for row in numbers.lines() {
            let is_free = row.contains("by exact") || row.contains("by coarse");
            if !is_free || !row.contains("in contact") {
                continue;
            }
            let mut values = row.rsplit(',').map(str::parse);
            let [predicted, measured]: [f64; 2] =
                std::array::from_fn(|_| values.next().expect("a value").expect("a number"));
            ratios.push(predicted / measured);
        }
        ratios.sort_by(f64::total_cmp);
        assert_eq!(ratios.len(), 20);
        let median = ratios[ratios.len() / 2];
        assert!((0.67..1.5).contains(&median), "{ratios:?}");
    }

    #[test]
    fn planted_times_are_fitted() {
        let planted: [f64; COUNT] = std::array::from_fn(|kind| 1e-8 * as_f64(kind % 5));
        let frames: Vec<TimedFrame> = (0..40_u32)
            .map(|row| {
                let count = |kind: u32| {
                    f64::from((7 * row * row + (11 * kind + 5) * row + 3 * kind * kind) % 41) * 1e3
                };
                let counts = std::array::from_fn(|kind| count(u32::try_from(kind).unwrap_or(0)));
                TimedFrame { plan: String::new(), counts, seconds: product(&counts, &planted) }
            })
            .collect();
        for (fitted, planted) in fit(&frames).iter().zip(planted) {
            assert!((fitted - planted).abs() < 1e-12, "{fitted} for {planted}");
        }
    }
}
