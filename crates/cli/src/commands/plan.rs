//! `plan`: cheapest detection method per pair, with its times.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{
    BodyId, Detection, DetectionMethod, ForcedMethod, PairDetection, PairId, PairState, Plan,
    PlanParams, Scene, machine_factor,
};

use super::Finished;
use super::plan_comparison::Comparison;
use super::plan_document::PlanDocument;
use super::plan_frames::{FrameSource, time_pairs};
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::motion::{Motion, MotionParams};
use crate::phase::Phase;
use crate::report::{fixed, rest_text};
use crate::stopwatch::Stopwatch;

/// Select the cheapest detection method for each pair of bodies at a given accuracy
///
/// Selects for each pair the method that takes the least time for a number of frames, among
/// those whose error is proved to be within the tolerance, and builds the structures that it
/// needs. The report lists the structures per body, the methods per pair, and the predicted and
/// measured times per frame. If the scene file names a motion, detection runs on all its frames.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide plan scene.toml --tolerance 0.5 --frames 10000 --json plan.json
  musculo-collide plan femur.ply vastus.ply --rigid femur --tolerance 0.1 --compare")]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Largest error of a depth or of a contact's gap, in the scene's unit
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: f64,

    /// Largest gap of a contact, in the scene's unit
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,

    /// Largest displacement of a vertex that the plan prepares for, in the scene's unit: pairs that
    /// come near by more are detected by their surfaces
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true)]
    max_displacement: f64,

    /// Number of frames that the plan is for: structures are built where they pay over so many
    #[arg(long, value_name = "N", default_value_t = 1)]
    frames: u32,

    /// Maximum time per frame in milliseconds: pairs that may be deepest are detected first, and
    /// those that are left out are listed with bounds on their depths
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    budget: Option<f64>,

    /// Use this method for a pair, whatever its cost and bound: exact, coarse, field or
    /// balls; may be given several times
    #[arg(long, value_name = "A,B,METHOD")]
    force: Vec<ForcedPair>,

    /// Compare the depths with those of exact detection
    #[arg(long)]
    compare: bool,

    /// Write structures, methods, bounds, depths and times as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Method for a pair of bodies, by their names.
#[derive(Clone, Debug)]
struct ForcedPair {
    a: String,
    b: String,
    method: DetectionMethod,
}

impl FromStr for ForcedPair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Two names and a method.
        let parts: Vec<&str> = text.split(',').collect();
        let [a, b, method] = parts[..] else {
            return Err("expected two names and a method, separated by commas".to_owned());
        };
        if a == b {
            return Err(format!("pairs '{a}' with itself, but a pair has two bodies"));
        }

        // Methods have the names of the report.
        let method = match method {
            "exact" => DetectionMethod::Exact,
            "coarse" => DetectionMethod::Coarse,
            "field" => DetectionMethod::Field,
            "balls" => DetectionMethod::Balls,
            other => {
                return Err(format!(
                    "unknown method {other:?}: expected exact, coarse, field or balls"
                ));
            }
        };
        Ok(Self { a: a.to_owned(), b: b.to_owned(), method })
    }
}

pub(super) fn run(arguments: &PlanArguments) -> Result<Finished, Failure> {
    // Read the scene, and its motion if it names one.
    let mut stopwatch = Stopwatch::start();
    let description = arguments.scene.describe()?;
    let files = arguments.scene.plan(&description).writing(arguments.json.as_ref());
    let mut outputs = files.open()?;
    let mut loaded = LoadedScene::load(description)?;
    let motion = loaded.description.motion.as_deref();
    let params = MotionParams::of_scene(&loaded.description);
    let replay = motion.map(|path| Motion::replay(path, &params, &loaded.scene));
    let mut replay = replay.transpose()?;
    if let Some(replay) = &mut replay {
        loaded.follow_attached(replay)?;
    }
    stopwatch.lap("load");

    // Select the methods, and build what they need.
    let params = arguments.params();
    let forced = arguments.forced(&loaded.scene)?;
    let mut plan = Phase::run("planning and building", |progress| {
        Plan::with_forced(&mut loaded.scene, &params, &forced, progress).map_err(Failure::from)
    })?;
    stopwatch.lap("build");

    // Detect contact in every frame.
    let frames = FrameSource::new(replay.as_ref(), arguments.frames, arguments.budget()?);
    let mut comparison = arguments.compare.then(Comparison::default);
    let mut detection = Detection::default();
    let times = frames.detect(&mut plan, &mut loaded.scene, &mut detection, comparison.as_mut())?;
    stopwatch.lap("detect");

    let mut text = format!("{plan}\n");
    text += &replay.as_ref().map_or_else(String::new, |replay| rest_text(replay.resting()));
    text += &detection_text(&detection, &plan, replay.is_some());
    text += &format!("frame: {times}\n");
    if let Some(comparison) = &comparison {
        text += &comparison.text(&loaded.scene);
    }

    // Pairs are timed one by one, in a frame of their own.
    if arguments.json.is_some() {
        time_pairs(&mut plan, &mut loaded.scene)?;
        let document =
            PlanDocument::new(&loaded.scene, &plan, &detection, &times, comparison.as_ref());
        outputs.stage_json(arguments.json.as_deref(), &document)?;
    }
    let is_free = !detection.pairs().iter().any(overlaps_or_may);
    let keeps_bounds = comparison.is_none_or(|comparison| comparison.exceeded() == 0);
    let holds = is_free && keeps_bounds && detection.left_out().is_empty();
    Ok(Finished { outputs, text, holds, stopwatch })
}

/// Returns true if a pair overlaps, or the method cannot exclude that it does.
fn overlaps_or_may(found: &PairDetection) -> bool {
    found.state != PairState::Apart
}

/// Describes the result of the last frame.
fn detection_text(detection: &Detection, plan: &Plan, is_motion: bool) -> String {
    let (mut overlapping, mut undecided) = (0, 0);
    for found in detection.pairs() {
        match found.state {
            PairState::Apart => (),
            PairState::Overlapping => overlapping += 1,
            PairState::Undecided { .. } => undecided += 1,
        }
    }

    // Pairs that were not decided, or not compared, belong to the result.
    let mut text = format!(
        "{} contacts, {overlapping} of {} pairs overlap",
        detection.contacts().len(),
        plan.pairs().len(),
    );
    if undecided > 0 {
        text += &format!(", {undecided} are undecided");
    }
    if let Some(first) = detection.left_out().first() {
        let upper = fixed(first.upper, 4);
        let count = detection.left_out().len();
        text += &format!(", {count} are left out by the budget, at most {upper} deep");
    }
    text += if is_motion { " in the last frame\n" } else { "\n" };
    text
}

/// Largest budget in milliseconds, which a duration holds.
const MAX_BUDGET: f64 = 1e20;

/// Finds a body that `--force` names.
fn find_forced(scene: &Scene, name: &str) -> Result<BodyId, Failure> {
    let unknown = || Failure::new(format!("--force: no body is named '{name}'"));
    scene.find(name).ok_or_else(unknown)
}

impl PlanArguments {
    fn forced(&self, scene: &Scene) -> Result<Vec<ForcedMethod>, Failure> {
        // Names are looked up once the scene is read.
        let mut forced = Vec::new();
        for ForcedPair { a, b, method } in &self.force {
            let pair = PairId::new(find_forced(scene, a)?, find_forced(scene, b)?);
            if forced.iter().any(|other: &ForcedMethod| other.pair == pair) {
                let [a, b] = scene.names(pair);
                let problem = format!("--force: the pair {a} and {b} is given more than once");
                return Err(Failure::new(problem));
            }
            forced.push(ForcedMethod { pair, method: *method });
        }
        Ok(forced)
    }

    /// Returns the budget of a frame.
    fn budget(&self) -> Result<Option<Duration>, Failure> {
        let Some(milliseconds) = self.budget else { return Ok(None) };
        match Duration::try_from_secs_f64(milliseconds / 1e3) {
            Ok(budget) if milliseconds <= MAX_BUDGET => Ok(Some(budget)),
            _ => {
                let problem =
                    format!("budget is {milliseconds} ms, but must be at least 0 and at most 1e20");
                Err(Failure::new(problem))
            }
        }
    }

    fn params(&self) -> PlanParams {
        // Libraries read no clock: predictions are scaled by this machine's measured factor.
        let start = Instant::now();
        PlanParams {
            margin: self.margin,
            max_displacement: self.max_displacement,
            frames: self.frames,
            machine_factor: machine_factor(|| start.elapsed()),
            threads: rayon::current_num_threads(),
            ..PlanParams::with_tolerance(self.tolerance)
        }
    }
}
