//! `motion`: contact in the frames of a motion, and between them.

use std::path::PathBuf;

use clap::Args;
use musculo_collide::{
    BodyId, BodyMove, CheckParams, JointContactParams, PairReport, Progress, Scene, ccd,
};

use super::Finished;
use super::joint_arguments::{JointArgs, joint_contacts};
use super::motion_resolve::{Job, frame_files};
use super::resolve_arguments::ResolveArgs;
use crate::failure::Failure;
use crate::load::{LoadedScene, files_of};
use crate::motion::{Motion, Replay};
use crate::output::{FilePlan, Outputs};
use crate::phase::Phase;
use crate::report::{
    FileFolder, FrameRecord, MotionDocument, PairContact, StepRecord, motion_chart,
    stage_contact_files,
};
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

    #[command(flatten)]
    joint: JointArgs,

    /// Write the faces in joint contact of each frame as VTP, with gap and pressure
    #[arg(long, value_name = "DIR", requires = "joint_contact")]
    vtp: Option<PathBuf>,

    /// Push overlapping bodies apart in every frame, and write each body of each frame as VTP
    #[arg(long, value_name = "DIR", conflicts_with = "joint_contact")]
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
    let joint = arguments.joint.params(&mut loaded)?;
    stopwatch.lap("load");
    if let Some(folder) = &arguments.resolve {
        let (json, params) = (arguments.json.as_deref(), arguments.params.params(&loaded));
        let job = Job { folder, json, params, unit: loaded.description.unit };
        return job.run(&mut loaded.scene, &replay, outputs, stopwatch);
    }

    // Walk through all frames, and report them.
    let folder = arguments.vtp.as_deref().map(|path| FileFolder::new(path, []));
    let mut walk = Walk {
        scene: &mut loaded.scene,
        replay: &replay,
        joint: joint.map(|params| JointFrames { params, folder }),
        outputs: &mut outputs,
        stopwatch: &mut stopwatch,
    };
    let document = MotionDocument {
        unit: loaded.description.unit,
        resting: replay.resting().to_vec(),
        joint_contact: joint,
        frames: walk.frames()?,
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
            .writing_into(self.vtp.as_ref(), [])
            .writing_into(self.resolve.as_ref(), frame_files(&loaded.scene, frames))
    }
}

/// Walk through the frames of a motion.
struct Walk<'a> {
    scene: &'a mut Scene,
    replay: &'a Replay,
    joint: Option<JointFrames>,
    outputs: &'a mut Outputs,
    stopwatch: &'a mut Stopwatch,
}

/// Joint contact of frames, with the folder of its files.
struct JointFrames {
    params: JointContactParams,
    folder: Option<FileFolder>,
}

impl Walk<'_> {
    /// Checks each frame, and sweeps from each to the next.
    fn frames(&mut self) -> Result<Vec<FrameRecord>, Failure> {
        let phase = Phase::with_steps("replaying", self.replay.frame_count() - 1);
        let ids: Vec<BodyId> = self.scene.ids().collect();
        let (first, mut before) = self.frame(0)?;
        let mut frames = vec![first];

        for frame in 1..self.replay.frame_count() {
            // A sweep starts at the state of the scene, and leaves it there.
            let positions = self.replay.positions(frame);
            let moves: Vec<BodyMove<'_>> = ids
                .iter()
                .zip(&positions)
                .map(|(&body, positions)| BodyMove { body, positions })
                .collect();
            let sweep = self.scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none())?;
            self.stopwatch.lap("sweep");

            let (mut record, after) = self.frame(frame)?;
            record.step = Some(StepRecord::new(self.scene, &sweep, &before, &after));
            frames.push(record);
            before = after;
            phase.step();
        }
        Ok(frames)
    }

    /// Moves all bodies to a frame, and checks them for overlap, and for joint contact where that is
    /// asked for.
    fn frame(&mut self, frame: usize) -> Result<(FrameRecord, Vec<PairReport>), Failure> {
        // Near pairs are not reported: their gaps would take most of the time.
        self.replay.place(self.scene, frame)?;
        let reports = self.scene.check(&CheckParams::new(0.0), Progress::none())?;
        let mut record = FrameRecord::new(self.scene, frame, self.replay.time(frame), &reports);
        self.stopwatch.lap("check");

        if let Some(joint) = &mut self.joint {
            let contacts = joint.measure(frame, self.scene, self.outputs)?;
            record.add_joint_contacts(&contacts, self.scene);
            self.stopwatch.lap("joint contact");
        }
        Ok((record, reports))
    }
}

impl JointFrames {
    /// Measures the contact of all pairs in a frame, and writes its files if there is a folder.
    fn measure(
        &mut self,
        frame: usize,
        scene: &mut Scene,
        outputs: &mut Outputs,
    ) -> Result<Vec<PairContact>, Failure> {
        let pairs = scene.close_pairs(self.params.margin)?;
        let contacts = joint_contacts(scene, &pairs, &self.params, Progress::none())?;
        if let Some(folder) = &mut self.folder {
            stage_contact_files(&contacts, &format!("_{frame:04}"), scene, folder, outputs)?;
        }
        Ok(contacts)
    }
}
