//! `plan`: how a scene is best looked at, and what that is worth.

use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{
    Detection, DetectionMethod, ForcedMethod, PairId, Plan, PlanParams, machine_factor,
};

use super::plan_frames::Frames;
use super::{Failure, Outcome, in_threads};
use crate::load::{build_scene, read_meshes};
use crate::motion::Motion;
use crate::progress::Progress;
use crate::scene::Scene;

/// Say how each pair of bodies is best looked at for a given accuracy
///
/// Gives each pair of bodies the cheapest method whose error is within the
/// tolerance, builds what that needs, and prints it: what was built for which
/// body, how each pair is looked at, what is left out and why, what a frame
/// should take and what it takes. Where the scene file names a motion, all its
/// frames are looked at.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide plan scene.toml --tolerance 0.5
  musculo-collide plan femur.ply vastus.ply --rigid femur --tolerance 0.1 --compare

Exit status: 0 nothing overlaps, 1 something overlaps, 2 bad input or usage.")]
pub(crate) struct PlanArguments {
    /// A scene file (.toml), or mesh files: PLY, OBJ, STL or VTP
    #[arg(required = true, value_name = "SCENE.toml | MESH")]
    inputs: Vec<PathBuf>,

    /// Treat this body as rigid (a bone); may be given more than once
    #[arg(long, value_name = "NAME")]
    rigid: Vec<String>,

    /// How wrong the gap of a contact may be, in the scene's unit
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: f64,

    /// How far outside contact is still looked for, in the scene's unit
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true)]
    reach: f64,

    /// How far bodies may go while the plan serves, in the scene's unit [default: any distance]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    travel: Option<f64>,

    /// Milliseconds that a frame may take; gives up accuracy for it
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    budget: Option<f64>,

    /// Look at this pair by this method, whatever it costs: field, surfaces or balls; may be given
    /// more than once
    #[arg(long, value_name = "A,B,METHOD")]
    force: Vec<Forced>,

    /// Compare what the plan finds with exact detection
    #[arg(long)]
    compare: bool,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
}

/// A method that was chosen for a pair.
#[derive(Clone, Debug)]
struct Forced {
    bodies: [String; 2],
    method: DetectionMethod,
}

impl FromStr for Forced {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').collect();
        let [a, b, method] = parts[..] else {
            return Err("expected two names and a method, with commas between".to_owned());
        };
        let method = match method {
            "field" => DetectionMethod::Field,
            "surfaces" => DetectionMethod::Surfaces,
            "balls" => DetectionMethod::Medial,
            other => {
                return Err(format!("no method is called {other:?}: field, surfaces or balls"));
            }
        };
        Ok(Self { bodies: [a, b].map(str::to_owned), method })
    }
}

pub(super) fn run(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || plan(arguments))
}

fn plan(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    let mut description = Scene::from_inputs(&arguments.inputs)?;
    description.set_rigid(&arguments.rigid)?;
    let meshes = read_meshes(&description)?;
    let (mut scene, _) = build_scene(&description, meshes)?;
    let motion = description.motion.as_ref().map(|path| Motion::read(path)).transpose()?;
    let need = need(arguments)?;

    let start = Instant::now();
    let mut plan = {
        let _progress = Progress::start("planning and building", 1);
        let forced = forced(&scene, &arguments.force)?;
        Plan::with_forced(&mut scene, &need, &forced, musculo_collide::Progress::none())?
    };
    let built = start.elapsed();
    let replay = motion.as_ref().map(|motion| motion.bind(&scene)).transpose()?;
    let mut detection = Detection::default();
    let frames = Frames::new(replay.as_ref());
    let measured = frames.measure(&mut plan, &mut scene, &mut detection, arguments.compare)?;

    let mut text = plan.to_string();
    text += &format!(
        "\nbuilt in {:.2} s; {} contacts, {} of {} pairs overlap{}\n",
        built.as_secs_f64(),
        detection.contacts().len(),
        detection.pairs().iter().filter(|pair| pair.overlaps).count(),
        plan.pairs().len(),
        if motion.is_some() { " in the last frame" } else { "" },
    );
    text += &measured.to_text();
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    let overlaps = detection.pairs().iter().any(|pair| pair.overlaps);
    Ok(if overlaps { Outcome::Overlaps } else { Outcome::Clean })
}

fn forced(scene: &musculo_collide::Scene, forced: &[Forced]) -> Result<Vec<ForcedMethod>, Failure> {
    let find = |name: &String| {
        let unknown = || Failure::new(vec![format!("--force: no body is called {name:?}")]);
        scene.find(name).ok_or_else(unknown)
    };
    let of_pair = |Forced { bodies: [a, b], method }: &Forced| {
        Ok(ForcedMethod { pair: PairId::new(find(a)?, find(b)?), method: *method })
    };
    forced.iter().map(of_pair).collect()
}

fn need(arguments: &PlanArguments) -> Result<PlanParams, Failure> {
    let budget = match arguments.budget {
        None => None,
        Some(milliseconds) => {
            let budget = Duration::try_from_secs_f64(milliseconds / 1e3);
            Some(budget.map_err(|_| {
                Failure::new(vec![format!("a budget of {milliseconds} ms cannot be kept to")])
            })?)
        }
    };
    let start = Instant::now();
    Ok(PlanParams {
        margin: arguments.reach,
        max_displacement: arguments.travel.unwrap_or(f64::INFINITY),
        budget,
        machine_factor: machine_factor(|| start.elapsed()),
        threads: rayon::current_num_threads(),
        ..PlanParams::with_tolerance(arguments.tolerance)
    })
}
