//! `motion`: contact in the frames of a motion, and between them.

use std::path::PathBuf;

use clap::Args;
use musculo_collide::{BodyId, BodyMove, CheckParams, PairReport, Progress, Scene, ccd};

use super::Finished;
use super::motion_resolve::{Job, frame_files};
use super::resolve_arguments::ResolveArgs;
use crate::failure::Failure;
use crate::load::{LoadedScene, files_of};
use crate::motion::{Motion, Replay};
use crate::output::FilePlan;
use crate::phase::Phase;
use crate::report::{FrameRecord, MotionDocument, StepRecord, motion_chart};
use crate::scene::SceneDescription;
use crate::stopwatch::Stopwatch;

/// Replay a motion, and find every contact in its frames and between them
///
/// Bones follow rigid maps from rest, soft bodies a blend of these. Each frame is checked
/// as it stands, the first one too. Each step to the next frame is swept, so that no contact
/// on the way is missed: the report has the fraction of the step before the first contact of
/// pairs that did not overlap already, and the contacts that no frame shows.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide motion scene.toml --chart motion.svg
  musculo-collide motion scene.toml --motion squat.json --json squat-contact.json
  musculo-collide motion scene.toml --resolve apart --json apart.json

A motion file has 4 x 4 maps from rest by name, row by row, in the scene's unit:
  {\"skin\": {\"axis\": [0, 0, 1], \"segments\": [\"femur\", null], \"blends\": [[40, 150]]},
   \"frames\": [{\"t\": 0.0, \"femur\": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]}, ...]}
A rigid body follows the map of its name, or of its name after the first underscore. A map
that moves nothing while a rigid body rests is refused, unless the file has its name in a list
\"ignore\". Times \"t\" must rise.
Soft bodies blend from segment to segment along the axis, within each interval of blends;
without a skin they rest.

With --resolve frames are not swept. Each starts from the tissue displacements of the last one.")]
pub(crate) struct MotionArguments {
    /// Scene file (.toml)
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,

    /// Motion to replay [default: the scene's]
    #[arg(long, value_name = "FILE.json")]
    motion: Option<PathBuf>,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Draw overlap and free step over the frames
    #[arg(long, value_name = "FILE.svg", conflicts_with = "resolve")]
    chart: Option<PathBuf>,

    /// Push overlapping bodies apart in every frame, and write each body of each frame as VTP
    #[arg(long, value_name = "DIR")]
    resolve: Option<PathBuf>,

    #[command(flatten)]
    params: ResolveArgs,
}

pub(super) fn run(arguments: &MotionArguments) -> Result<Finished, Failure> {
    // Describe the scene and find its motion.
    let mut stopwatch = Stopwatch::start();
    let description = SceneDescription::from_inputs(std::slice::from_ref(&arguments.scene))?;
    let Some(path) = arguments.motion.clone().or_else(|| description.motion.clone()) else {
        let problem = "names no motion: add a key `motion`, or use --motion";
        return Err(Failure::in_file(&arguments.scene, problem));
    };

    // Read meshes and motion, and bind them to each other.
    let mut loaded = LoadedScene::load(description)?;
    let replay = Motion::replay(&path, &loaded.scene)?;
    let mut outputs = arguments.plan(path, &loaded, replay.frame_count()).open()?;
    stopwatch.lap("load");
    if let Some(folder) = &arguments.resolve {
        let (json, params) = (arguments.json.as_deref(), arguments.params.params(&loaded));
        let job = Job { folder, json, params, unit: loaded.description.unit };
        return job.run(&mut loaded.scene, &replay, outputs, stopwatch);
    }

    // Walk through all frames, and report them.
    let document = MotionDocument {
        unit: loaded.description.unit,
        resting: replay.resting().to_vec(),
        frames: walk(&mut loaded.scene, &replay, &mut stopwatch)?,
    };

    outputs.stage_json(arguments.json.as_deref(), &document)?;
    if let Some(path) = &arguments.chart {
        let chart = motion_chart(&document).map_err(|error| Failure::new(error.to_string()))?;
        outputs.stage(path, chart)?;
    }
    Ok(Finished { outputs, text: document.to_text(), holds: document.is_clean(), stopwatch })
}

impl MotionArguments {
    fn plan(&self, motion: PathBuf, loaded: &LoadedScene, frames: usize) -> FilePlan {
        let mut inputs = files_of(&loaded.description);
        inputs.extend([self.scene.clone(), motion]);
        FilePlan::reading(inputs)
            .writing(self.json.as_ref())
            .writing(self.chart.as_ref())
            .writing_into(self.resolve.as_ref(), frame_files(&loaded.scene, frames))
    }
}

/// Checks each frame, and sweeps from each to the next.
fn walk(
    scene: &mut Scene,
    replay: &Replay,
    stopwatch: &mut Stopwatch,
) -> Result<Vec<FrameRecord>, Failure> {
    let phase = Phase::with_steps("replaying", replay.frame_count() - 1);
    let ids: Vec<BodyId> = scene.ids().collect();
    let mut before = overlaps_at(scene, replay, 0)?;
    let mut frames = vec![FrameRecord::new(scene, 0, replay.time(0), &before)];

    for frame in 1..replay.frame_count() {
        // A sweep starts at the state of the scene, and leaves it there.
        let positions = replay.positions(frame);
        let moves: Vec<BodyMove<'_>> = ids
            .iter()
            .zip(&positions)
            .map(|(&body, positions)| BodyMove { body, positions })
            .collect();
        stopwatch.lap("check");
        let sweep = scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none())?;
        stopwatch.lap("sweep");

        let after = overlaps_at(scene, replay, frame)?;
        let mut record = FrameRecord::new(scene, frame, replay.time(frame), &after);
        record.step = Some(StepRecord::new(scene, &sweep, &before, &after));
        frames.push(record);
        before = after;
        phase.step();
    }
    stopwatch.lap("check");
    Ok(frames)
}

/// Moves all bodies to a frame, and checks them for overlap alone.
fn overlaps_at(
    scene: &mut Scene,
    replay: &Replay,
    frame: usize,
) -> Result<Vec<PairReport>, Failure> {
    // Near pairs are not reported: their gaps would take most of the time.
    replay.place(scene, frame)?;
    Ok(scene.check(&CheckParams::new(0.0), Progress::none())?)
}
