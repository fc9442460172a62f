//! Time of each kind of operation in a plan, fitted to the times of several plans' frames.
//!
//! Each plan is timed twice: with bodies in contact, and with soft bodies far apart, where the only
//! work is to follow them. Scenes are of several sizes, generated and, where it is available, of real
//! anatomy. Each frame is predicted once more by a fit without the frames of its own scene.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fixtures::{Mesh, shapes};
use glam::DVec3;
use musculo_collide::proximity::SurfaceTree;
use musculo_collide::{
    DetectionMethod, OperationCounts, Plan, PlanParams, Progress, Scene, StructureKind,
    machine_factor,
};
use serde::Serialize;

use crate::chart::curves::machine;
use crate::chart::sheet::Sheet;
use crate::measure::{as_f64, thread_time};
use crate::regret::{NamedScene, forced_pairs, named, scenes, three_balls, time_frame};

/// Names of the kinds of operations, in the order of [`OperationCounts::to_array`].
const KINDS: [&str; COUNT] = [
    "face refitted",
    "face refitted, far from caches",
    "vertex of a compared surface",
    "pair of faces tested",
    "pair of faces that meet",
    "vertex projected",
    "vertex projected, far from caches",
    "crossing of faces in a search",
    "triangle split in a search",
    "closest point in a search",
    "vertex over a field",
    "vertex followed by balls",
    "vertex among balls",
    "face of a tree that is built",
    "face decimated",
    "face decimated, far from caches",
    "node of a field",
];

/// Number of kinds of operations.
const COUNT: usize = OperationCounts::SECONDS.to_array().len();

/// Tolerances of the plans by surfaces, by fields and by balls \[mm\]. Balls take long to build.
const TOLERANCES: [(DetectionMethod, &[f64]); 4] = [
    (DetectionMethod::Exact, &[2.0, 0.5, 0.1]),
    (DetectionMethod::Coarse, &[2.0, 0.5, 0.1]),
    (DetectionMethod::Field, &[2.0, 1.0, 0.5]),
    (DetectionMethod::Balls, &[2.0]),
];

/// Scene in which plans by fields and balls are timed.
const ALL_METHODS: &str = "three balls, 1,280 faces";

/// Halvings of balls beside those of the table of regret, and the largest that are decimated.
const HALVINGS: [u32; 4] = [2, 4, 6, 7];
const MAX_DECIMATED: usize = 800_000;

/// Rounds of a frame at least, and the time that they take at least \[s\].
const MIN_ROUNDS: u32 = 5;
const MIN_SECONDS: f64 = 0.2;

/// Distance between soft bodies that are out of contact \[mm\].
const APART: DVec3 = DVec3::new(1e4, 0.0, 0.0);

const TIME: &str = "median of several frames on the processor, over the machine factor of the same moment; of the kinds of operations, the fit to the frames of all plans";

/// Operations of a plan in a frame, and their time on the reference machine.
struct TimedFrame {
    scene: String,
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

    // The kinds of operations first, then the plans.
    let in_use = OperationCounts::SECONDS.to_array();
    let mut rows = Vec::new();
    for (kind, (fitted, in_use)) in KINDS.iter().zip(fit(&frames, "").iter().zip(in_use)) {
        rows.push(CostRow::new("", kind, [*fitted, in_use, in_use]));
    }
    let mut without = (String::new(), [0.0; COUNT]);
    for TimedFrame { scene, plan, counts, seconds, .. } in &frames {
        if without.0 != *scene {
            without = (scene.clone(), fit(&frames, scene));
        }
        let [predicted, by_others] = [in_use, without.1].map(|each| product(counts, &each));
        rows.push(CostRow::new(scene, plan, [*seconds, predicted, by_others]));
    }
    let settings = vec![("time", TIME.to_owned()), ("machine", machine())];
    Ok(Sheet::new("costs", settings, &rows)?.write(folder, None)?)
}

/// Time of a kind of operation or of a plan's frame: a row of the table.
#[derive(Serialize)]
struct CostRow<'a> {
    scene: &'a str,
    work: &'a str,
    #[serde(rename = "measured [ns]")]
    measured: f64,
    #[serde(rename = "predicted [ns]")]
    predicted: f64,
    /// Predicted by the times that are fitted without the scene.
    #[serde(rename = "by other scenes [ns]")]
    by_others: f64,
}

impl<'a> CostRow<'a> {
    fn new(scene: &'a str, work: &'a str, seconds: [f64; 3]) -> Self {
        let [measured, predicted, by_others] = seconds.map(|seconds| 1e9 * seconds);
        Self { scene, work, measured, predicted, by_others }
    }
}

fn timed_frames() -> Result<Vec<TimedFrame>, Box<dyn Error>> {
    let mut all = scenes()?;
    for halvings in HALVINGS {
        all.push(named(&format!("three balls, {halvings} halvings"), three_balls(halvings))?);
    }
    for squares in [20, 60] {
        all.push(named(&format!("two sheets, {squares} squares"), two_sheets(squares))?);
    }

    let mut frames = Vec::new();
    for mut named in all {
        for (method, tolerances) in TOLERANCES {
            let is_surface = matches!(method, DetectionMethod::Exact | DetectionMethod::Coarse);
            let is_large = face_count(&named.scene) > MAX_DECIMATED;
            if is_large && method != DetectionMethod::Exact
                || !is_surface && named.name != ALL_METHODS
            {
                continue;
            }
            for &tolerance in tolerances {
                frames.extend(timed_plan(&mut named, method, tolerance)?);
            }
        }
    }
    Ok(frames)
}

/// Returns two bodies whose wavy sides nearly fit: bounds of many faces overlap, and few faces meet.
fn two_sheets(squares: u32) -> Vec<(String, Mesh)> {
    let waves = |p: DVec3| p + DVec3::Z * (p.x / 7.0).sin() * (p.y / 9.0).cos();
    let sheet = shapes::plate(DVec3::new(60.0, 60.0, 10.0), [squares, squares]).mapped(waves);
    let above = sheet.clone().translated(DVec3::new(0.5, 0.5, 10.02));
    let tilted = |mesh: Mesh| mesh.rotated(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.13);
    vec![("lower".to_owned(), tilted(sheet)), ("upper".to_owned(), tilted(above))]
}

fn face_count(scene: &Scene) -> usize {
    scene.bodies().iter().map(|body| body.surface().faces().len()).sum()
}

/// Times frames of one plan, in contact and apart.
fn timed_plan(
    named: &mut NamedScene,
    method: DetectionMethod,
    tolerance: f64,
) -> Result<[TimedFrame; 3], Box<dyn Error>> {
    let NamedScene { name, scene } = named;
    let forced = forced_pairs(scene, method, tolerance)?;

    // Displacements have no limit, since bodies are moved far apart below.
    let params =
        PlanParams { max_displacement: f64::INFINITY, ..PlanParams::with_tolerance(tolerance) };
    let start = thread_time();
    let mut plan = Plan::with_forced(scene, &params, &forced, Progress::none())?;
    let mut built = (thread_time() - start).as_secs_f64() / factor();

    // Trees are there already: those of exact plans are timed by themselves.
    let is_exact = method == DetectionMethod::Exact;
    if is_exact {
        built = tree_seconds(scene)?;
    }
    let mut construction = OperationCounts::default();
    for structure in plan.structures() {
        if is_exact || structure.kind != StructureKind::Tree {
            construction = construction + structure.operations;
        }
    }

    // Operations are counted in the first frame. Apart, the only ones are those of no pair.
    let near = frame_seconds(&mut plan, scene)?;
    let all = plan.operations().to_array();
    let of_pairs =
        plan.pairs().iter().fold(OperationCounts::default(), |sum, pair| sum + pair.operations);
    let of_pairs = of_pairs.to_array();
    let following = std::array::from_fn(|kind| all[kind] - of_pairs[kind]);
    move_soft(scene, APART)?;
    let far = frame_seconds(&mut plan, scene);
    move_soft(scene, -APART)?;

    let frame = |state: &str, counts, seconds| TimedFrame {
        scene: name.clone(),
        plan: format!("by {method} within {tolerance} mm, {state}"),
        counts,
        seconds,
    };
    Ok([
        frame("construction", construction.to_array(), built),
        frame("in contact", all, near),
        frame("apart", following, far?),
    ])
}

/// Returns the time that the trees of all bodies take to build, over the machine factor.
fn tree_seconds(scene: &Scene) -> Result<f64, Box<dyn Error>> {
    let mut seconds = 0.0;
    for body in scene.bodies() {
        let (surface, positions) = (body.surface().clone(), body.positions().to_vec());
        let start = thread_time();
        SurfaceTree::new(surface, positions)?;
        seconds += (thread_time() - start).as_secs_f64();
    }
    Ok(seconds / factor())
}

/// Moves soft bodies, each by another multiple of a shift.
fn move_soft(scene: &mut Scene, shift: DVec3) -> Result<(), Box<dyn Error>> {
    let ids: Vec<_> = scene.ids().collect();
    for (number, id) in ids.into_iter().enumerate() {
        if !scene.body(id).is_rigid() {
            let by = as_f64(number + 1) * shift;
            let x: Vec<DVec3> = scene.body(id).positions().iter().map(|p| *p + by).collect();
            scene.move_body(id, &x)?;
        }
    }
    Ok(())
}

/// Returns the machine factor of this moment.
fn factor() -> f64 {
    let start = Instant::now();
    machine_factor(|| start.elapsed())
}

/// Returns the median time of a frame, over the machine factor.
fn frame_seconds(plan: &mut Plan, scene: &mut Scene) -> Result<f64, Box<dyn Error>> {
    let (mut times, mut sum) = (Vec::new(), 0.0);
    for round in 0.. {
        if round >= MIN_ROUNDS && sum >= MIN_SECONDS {
            break;
        }
        let seconds = time_frame(scene, plan, round)?;
        sum += seconds;
        times.push(seconds);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2] / factor())
}

/// Fits nonnegative times of the kinds of operations to the frames of all scenes but one, by least
/// squares of the relative errors (Gauss–Seidel sweeps).
fn fit(frames: &[TimedFrame], without: &str) -> [f64; COUNT] {
    const SWEEPS: u32 = 20_000;

    // Counts over the time of their frame, so that errors are relative; then the normal equations.
    let mut products = [[0.0; COUNT]; COUNT];
    let mut sums = [0.0; COUNT];
    for frame in frames.iter().filter(|frame| frame.scene != without) {
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
        let (mut count, mut beyond, mut beyond_by_others) = (0_u32, 0, 0);
        for row in numbers.lines() {
            let is_free = row.contains("by exact") || row.contains("by coarse");
            if !is_free || !row.contains("in contact") {
                continue;
            }
            let mut values = row.rsplit(',').map(str::parse);
            let [by_others, predicted, measured]: [f64; 3] =
                std::array::from_fn(|_| values.next().expect("a value").expect("a number"));
            let is_off =
                |time: f64, factor: f64| !(1.0 / factor..factor).contains(&(time / measured));
            count += 1;
            beyond += u32::from(is_off(predicted, 1.5));
            beyond_by_others += u32::from(is_off(by_others, 2.0));
        }
        assert!(count >= 51, "{count} frames of generated scenes, more of real anatomy");
        assert!(20 * beyond <= count, "{beyond} of {count} are off by half");
        assert!(10 * beyond_by_others <= count, "{beyond_by_others} of {count} are off by others");
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
                let seconds = product(&counts, &planted);
                let scene = format!("scene {}", row % 4);
                TimedFrame { scene, plan: String::new(), counts, seconds }
            })
            .collect();

        // Frames of a scene that is left out have no part in it.
        let mut wrong = frames;
        for frame in wrong.iter_mut().filter(|frame| frame.scene == "scene 3") {
            frame.seconds *= 2.0;
        }
        for (fitted, planted) in fit(&wrong, "scene 3").iter().zip(planted) {
            assert!((fitted - planted).abs() < 1e-11, "{fitted} for {planted}");
        }
    }
}
