//! `plan`: how a scene is best looked at, and what that is worth.

use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{CheckParams, Detection, Need, Plan};

use super::{Failure, Outcome, in_threads};
use crate::load::{build_scene, read_meshes};
use crate::progress::Progress;
use crate::scene::Scene;

/// Say how each pair of bodies is best looked at for a given accuracy
///
/// Gives each pair of bodies the cheapest method whose error is within the
/// tolerance, builds what that needs, and prints it: what was built for which
/// body, how each pair is looked at, what is left out and why, what a frame
/// should take and what it takes.
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

    /// Compare what the plan finds with exact detection
    #[arg(long)]
    compare: bool,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
}

/// Frames that are timed, after one that takes memory.
const FRAMES: u32 = 5;

pub(super) fn run(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || plan(arguments))
}

fn plan(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    let mut description = Scene::from_inputs(&arguments.inputs)?;
    description.set_rigid(&arguments.rigid)?;
    let meshes = read_meshes(&description)?;
    let (mut scene, _) = build_scene(&description, meshes)?;
    let need = need(arguments)?;

    let start = Instant::now();
    let mut plan = {
        let _progress = Progress::start("planning and building", 1);
        Plan::new(&mut scene, &need)?
    };
    let built = start.elapsed();
    let mut detection = Detection::default();
    plan.detect(&mut scene, &mut detection)?;
    let frame = time_frames(&mut plan, &mut scene, &mut detection)?;

    let mut text = plan.to_string();
    text += &format!(
        "\nbuilt in {:.2} s; a frame takes {:.1} ms; {} contacts, {} of {} pairs overlap\n",
        built.as_secs_f64(),
        1e3 * frame.as_secs_f64(),
        detection.contacts().len(),
        detection.pairs().iter().filter(|pair| pair.overlaps).count(),
        plan.pairs().len(),
    );
    if arguments.compare {
        text += &comparison(&plan, &mut scene, &detection)?;
    }
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    let overlaps = detection.pairs().iter().any(|pair| pair.overlaps);
    Ok(if overlaps { Outcome::Overlaps } else { Outcome::Clean })
}

fn need(arguments: &PlanArguments) -> Result<Need, Failure> {
    let budget = match arguments.budget {
        None => None,
        Some(milliseconds) => {
            let budget = Duration::try_from_secs_f64(milliseconds / 1e3);
            Some(budget.map_err(|_| {
                Failure::new(vec![format!("a budget of {milliseconds} ms cannot be kept to")])
            })?)
        }
    };
    Ok(Need {
        reach: arguments.reach,
        travel: arguments.travel.unwrap_or(f64::INFINITY),
        budget,
        ..Need::within(arguments.tolerance)
    })
}

/// The shortest of some frames in which every body has moved.
fn time_frames(
    plan: &mut Plan,
    scene: &mut musculo_collide::Scene,
    detection: &mut Detection,
) -> Result<Duration, Failure> {
    let mut shortest = Duration::MAX;
    for _ in 0..FRAMES {
        let states: Vec<_> = scene
            .ids()
            .map(|id| (id, scene.body(id).pose(), scene.body(id).positions().to_vec()))
            .collect();
        let start = Instant::now();
        for (id, pose, positions) in &states {
            match pose {
                Some(pose) => scene.pose_body(*id, pose)?,
                None => scene.move_body(*id, positions)?,
            }
        }
        plan.detect(scene, detection)?;
        shortest = shortest.min(start.elapsed());
    }
    Ok(shortest)
}

/// How far depths are from exact ones, and which overlaps differ.
fn comparison(
    plan: &Plan,
    scene: &mut musculo_collide::Scene,
    detection: &Detection,
) -> Result<String, Failure> {
    let start = Instant::now();
    let exact = {
        let _progress = Progress::start("detecting exactly", 1);
        scene.check(&CheckParams { reach: 0.0 })?
    };
    let time = start.elapsed();
    let mut worst = (0.0, String::from("none"));
    let mut missed = 0;
    for pair in plan.pairs() {
        let of_exact = exact.iter().find(|report| (report.a, report.b) == (pair.a, pair.b));
        let of_plan = detection.pairs().iter().find(|found| (found.a, found.b) == (pair.a, pair.b));
        let depths = [of_exact.map_or(0.0, |e| e.max_depth), of_plan.map_or(0.0, |p| p.max_depth)];
        let difference = (depths[0] - depths[1]).abs();
        if difference > worst.0 {
            let [a, b] = [pair.a, pair.b].map(|id| scene.body(id).name());
            worst = (difference, format!("{a} and {b}, {:.4} for {:.4}", depths[1], depths[0]));
        }
        let overlaps = [of_exact.is_some_and(|e| e.overlaps), of_plan.is_some_and(|p| p.overlaps)];
        missed += usize::from(overlaps[0] && !overlaps[1]);
    }
    Ok(format!(
        "exact detection takes {:.1} ms; depths differ by {:.4} at most ({}); {missed} overlapping pairs are not seen\n",
        1e3 * time.as_secs_f64(),
        worst.0,
        worst.1,
    ))
}
