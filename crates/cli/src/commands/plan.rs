//! `plan`: cheapest detection method per pair, with its times.

use std::str::FromStr;
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{
    BodyId, Detection, DetectionMethod, ForcedMethod, PairId, Plan, PlanParams, Scene,
    machine_factor,
};

use super::Finished;
use super::plan_frames::{Comparison, FrameSource};
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::motion::Motion;
use crate::phase::Phase;
use crate::report::rest_text;
use crate::stopwatch::Stopwatch;

/// Select the cheapest detection method for each pair of bodies at a given accuracy
///
/// Selects for each pair the cheapest method whose error is within the tolerance, and
/// builds the structures that it needs. The report lists the structures per body, the
/// methods per pair, the numbers of other pairs, and the predicted and measured
/// times per frame. If the scene file names a motion, detection runs on all its frames.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide plan scene.toml --tolerance 0.5
  musculo-collide plan femur.ply vastus.ply --rigid femur --tolerance 0.1 --compare")]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Largest error of a contact's gap, in the scene's unit
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: f64,

    /// Largest gap of a contact, in the scene's unit
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,

    /// Largest displacement of a vertex that the plan prepares for, in the scene's unit: pairs that
    /// come near by more are detected by their surfaces
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true)]
    max_displacement: f64,

    /// Maximum time per frame in milliseconds, for which accuracy is reduced
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    budget: Option<f64>,

    /// Use this method for a pair, whatever its cost: field, surfaces or balls; may be given
    /// several times
    #[arg(long, value_name = "A,B,METHOD")]
    force: Vec<ForcedPair>,

    /// Compare the results with exact detection
    #[arg(long)]
    compare: bool,
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
            "field" => DetectionMethod::Field,
            "surfaces" => DetectionMethod::Surfaces,
            "balls" => DetectionMethod::Medial,
            other => {
                return Err(format!("unknown method {other:?}: expected field, surfaces or balls"));
            }
        };
        Ok(Self { a: a.to_owned(), b: b.to_owned(), method })
    }
}

pub(super) fn run(arguments: &PlanArguments) -> Result<Finished, Failure> {
    // Read the scene, and its motion if it names one.
    let mut stopwatch = Stopwatch::start();
    let description = arguments.scene.describe()?;
    let outputs = arguments.scene.plan(&description).open()?;
    let mut loaded = LoadedScene::load(description)?;
    let motion = loaded.description.motion.as_deref();
    let replay = motion.map(|path| Motion::replay(path, &loaded.scene)).transpose()?;
    stopwatch.lap("load");

    // Select the methods, and build what they need.
    let params = arguments.params()?;
    let forced = arguments.forced(&loaded.scene)?;
    let mut plan = Phase::run("planning and building", |progress| {
        Plan::with_forced(&mut loaded.scene, &params, &forced, progress).map_err(Failure::from)
    })?;
    stopwatch.lap("build");

    // Detect contact in every frame.
    let frames = FrameSource::new(replay.as_ref());
    let mut comparison = arguments.compare.then(Comparison::default);
    let mut detection = Detection::default();
    let times = frames.detect(&mut plan, &mut loaded.scene, &mut detection, comparison.as_mut())?;
    stopwatch.lap("detect");

    let rests = replay.as_ref().map_or_else(String::new, |replay| rest_text(replay.resting()));
    let overlapping = detection.pairs().iter().filter(|pair| pair.overlaps).count();
    let text = format!(
        "{plan}\n{rests}{} contacts, {overlapping} of {} pairs overlap{}\nframe: {times}\n{}",
        detection.contacts().len(),
        plan.pairs().len(),
        if replay.is_some() { " in the last frame" } else { "" },
        comparison.map_or_else(String::new, |comparison| comparison.to_string()),
    );
    Ok(Finished { outputs, text, holds: overlapping == 0, stopwatch })
}

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
            forced.push(ForcedMethod { pair, method: *method });
        }
        Ok(forced)
    }

    fn params(&self) -> Result<PlanParams, Failure> {
        let budget = match self.budget {
            None => None,
            Some(milliseconds) => {
                let budget = Duration::try_from_secs_f64(milliseconds / 1e3);
                let problem = format!("budget is {milliseconds} ms, but must be at least 0");
                Some(budget.map_err(|_| Failure::new(problem))?)
            }
        };

        // Libraries read no clock: predictions are scaled by this machine's measured factor.
        let start = Instant::now();
        Ok(PlanParams {
            margin: self.margin,
            max_displacement: self.max_displacement,
            budget,
            machine_factor: machine_factor(|| start.elapsed()),
            threads: rayon::current_num_threads(),
            ..PlanParams::with_tolerance(self.tolerance)
        })
    }
}
