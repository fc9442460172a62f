//! `motion`: replay a motion and find who meets, frame by frame and on the way.

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{BodyId, CheckParams, PairReport, SceneError, ccd};

use super::motion_resolve::{self, Job};
use super::resolve_lengths::ResolveLengths;
use super::{Failure, Outcome, in_threads};
use crate::load::{build_scene, read_meshes};
use crate::motion::{Motion, Replay};
use crate::output::Outputs;
use crate::progress::Progress;
use crate::report::{MotionDocument, StepRecord, motion_chart, motion_table};
use crate::scene::Scene;

/// Replay a motion, and find every contact in its frames and between them
///
/// Bones follow rigid maps from rest, soft tissue a blend of these. Each frame
/// is checked as it stands; each step from one frame to the next is swept, so
/// that nothing passes through anything unseen: when a first contact begins,
/// how much of the step is free of new contact, and what the frames alone would
/// not have shown.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide motion scene.toml --chart motion.svg
  musculo-collide motion scene.toml --motion squat.json --json squat-contact.json
  musculo-collide motion scene.toml --resolve apart --json apart.json

A motion file holds 4 x 4 maps from rest by name, row by row, in the scene's unit:
  {\"skin\": {\"axis\": [0, 0, 1], \"segments\": [\"femur\", null], \"blends\": [[40, 150]]},
   \"frames\": [{\"t\": 0.0, \"femur\": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]}, ...]}
A rigid body follows the map of its name, or of its name after the first underscore.
Soft bodies go over from segment to segment along the axis, within each blend.

With --resolve frames are not swept. Each starts from how tissue was displaced in the last one.

Exit status: 0 nothing ever overlaps (with --resolve: is left to), 1 something does or meets,
2 bad input or usage.")]
pub(crate) struct MotionArguments {
    /// A scene file (.toml)
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,

    /// The motion to replay [default: the scene's]
    #[arg(long, value_name = "FILE.json")]
    motion: Option<PathBuf>,

    /// Write everything that is reported as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Draw overlap and free step over the frames
    #[arg(long, value_name = "FILE.svg", conflicts_with = "resolve")]
    chart: Option<PathBuf>,

    /// Push apart what overlaps in every frame, and write each body of each frame as VTP there
    #[arg(long, value_name = "DIR")]
    resolve: Option<PathBuf>,

    #[command(flatten)]
    lengths: ResolveLengths,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

pub(super) fn run(arguments: &MotionArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || replay(arguments))
}

fn replay(arguments: &MotionArguments) -> Result<Outcome, Failure> {
    let description = Scene::from_inputs(std::slice::from_ref(&arguments.scene))?;
    let path = arguments.motion.as_ref().or(description.motion.as_ref()).ok_or_else(|| {
        let scene = arguments.scene.display();
        Failure::new(vec![format!("{scene} names no motion; give one with --motion")])
    })?;
    let motion = Motion::read(path)?;
    let (mut scene, _) = build_scene(&description, read_meshes(&description)?)?;
    let replay = motion.bind(&scene)?;
    if let Some(folder) = &arguments.resolve {
        let job = Job {
            folder,
            json: arguments.json.as_deref(),
            params: arguments.lengths.params(description.unit),
            unit: description.unit,
            times: &motion.times,
        };
        return motion_resolve::run(&job, &mut scene, &replay);
    }

    let start = Instant::now();
    let mut walk = Walk::start(&mut scene, &replay)?;
    let progress = Progress::start("replaying", motion.frame_count() - 1);
    let mut steps = Vec::new();
    for frame in 1..motion.frame_count() {
        steps.push(walk.step(frame, motion.times[frame])?);
        progress.step();
    }
    drop(progress);
    let document = MotionDocument { unit: description.unit, steps };
    let written = write(arguments, &document)?;

    let mut text = motion_table(&document);
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    text += &walk.times_line(start.elapsed());
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(if document.is_clean() { Outcome::Clean } else { Outcome::Overlaps })
}

fn write(arguments: &MotionArguments, document: &MotionDocument) -> Result<Vec<PathBuf>, Failure> {
    let mut outputs = Outputs::default();
    if let Some(path) = &arguments.json {
        let mut json = serde_json::to_string_pretty(document)?;
        json.push('\n');
        outputs.stage(path, json.as_bytes())?;
    }
    if let Some(path) = &arguments.chart {
        outputs.stage(path, motion_chart(document)?.as_bytes())?;
    }
    Ok(outputs.commit()?)
}

/// A scene on its way through a motion.
struct Walk<'a> {
    scene: &'a mut musculo_collide::Scene,
    replay: &'a Replay<'a>,
    before: Vec<PairReport>,
    sweeping: Duration,
    checking: Duration,
}

/// Only overlap is asked of the single frames.
const OVERLAP: CheckParams = CheckParams { margin: 0.0 };

impl<'a> Walk<'a> {
    fn start(
        scene: &'a mut musculo_collide::Scene,
        replay: &'a Replay<'a>,
    ) -> Result<Self, SceneError> {
        let (sweeping, checking) = (Duration::ZERO, Duration::ZERO);
        let mut walk = Self { scene, replay, before: Vec::new(), sweeping, checking };
        let positions = replay.positions(0);
        for (id, x) in walk.ids().into_iter().zip(&positions) {
            walk.scene.move_body(id, x)?;
        }
        walk.before = walk.scene.check(&OVERLAP, musculo_collide::Progress::none())?;
        Ok(walk)
    }

    fn ids(&self) -> Vec<BodyId> {
        self.scene.ids().collect()
    }

    /// Sweeps to `frame`, moves there, and checks it.
    fn step(&mut self, frame: usize, time: Option<f64>) -> Result<StepRecord, SceneError> {
        let positions = self.replay.positions(frame);
        let ids = self.ids();
        let moves: Vec<_> = ids.iter().zip(&positions).map(|(&id, x)| (id, &x[..])).collect();
        let start = Instant::now();
        let sweep =
            self.scene.sweep(&moves, &ccd::CcdParams::EXACT, musculo_collide::Progress::none())?;
        self.sweeping += start.elapsed();
        let start = Instant::now();
        for (id, x) in moves {
            self.scene.move_body(id, x)?;
        }
        let after = self.scene.check(&OVERLAP, musculo_collide::Progress::none())?;
        self.checking += start.elapsed();
        let record = StepRecord::new((frame, time), self.scene, &sweep, [&self.before, &after]);
        self.before = after;
        Ok(record)
    }

    fn times_line(&self, whole: Duration) -> String {
        format!(
            "{:.2} s: sweep {:.2} s, check {:.2} s\n",
            whole.as_secs_f64(),
            self.sweeping.as_secs_f64(),
            self.checking.as_secs_f64()
        )
    }
}
