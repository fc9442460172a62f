//! `motion`: contact in the frames of a motion, and between them.

use std::path::{Path, PathBuf};

use clap::Args;
use musculo_collide::{
    BodyId, CheckParams, JointContactParams, PairReport, PathMove, Progress, Scene, SceneError,
    SweepReport, ccd,
};

use super::Finished;
use super::joint_arguments::{JointArgs, joint_contacts};
use super::motion_cache::{FrameCache, KeptFrame};
use super::motion_resolve::{Job, frame_file, frame_files};
use super::motion_until::first_contacts;
use super::resolve_arguments::ResolveArgs;
use crate::failure::Failure;
use crate::load::{LoadedScene, files_of};
use crate::motion::{Motion, MotionArgs, Replay};
use crate::output::{FilePlan, OutputFormat, Outputs};
use crate::phase::Phase;
use crate::report::{
    FileFolder, FrameRecord, LongTable, MotionDocument, PairContact, PairJointContact, PairRecord,
    Recording, Series, StepRecord, TableFrame, depth_vtp, motion_chart, motion_page,
    stage_contact_files,
};
use crate::scene::SceneDescription;
use crate::stopwatch::Stopwatch;
use crate::terminal;

/// Options of a run that checks frames and sweeps from each to the next.
///
/// An option that requires another one is passed over where that is excluded: it has to exclude the same.
const OF_FRAMES: [&str; 6] = ["chart", "joint_contact", "vtp", "report", "table", "cache"];

/// Options of other runs.
const OF_OTHERS: [&str; 2] = ["until_contact", "resolve"];

/// Replay a motion, and find every contact in its frames and between them
///
/// Bones follow rigid maps from rest, and turn on arcs from frame to frame; soft bodies follow a
/// blend of these. Each frame is checked
/// as it stands, the first one too. Each step to the next frame is swept, so that no contact
/// on the way is missed: the report has the fraction of the step before the first contact of
/// pairs that did not overlap already, and the contacts that no frame shows.
#[derive(Debug, Args)]
#[command(mut_group("ResolveArgs", |group| group.requires("resolve").conflicts_with_all(OF_FRAMES).conflicts_with("until_contact")))]
#[command(mut_arg("joint_resolution", |arg| arg.conflicts_with_all(OF_OTHERS)))]
#[command(mut_arg("foundation", |arg| arg.conflicts_with_all(OF_OTHERS)))]
#[command(mut_arg("foundation_law", |arg| arg.conflicts_with_all(OF_OTHERS)))]
#[command(after_help = "\
Examples:
  musculo-collide motion scene.toml --chart motion.svg --report motion.html
  musculo-collide motion scene.toml --motion squat.json --json squat-contact.json
  musculo-collide motion scene.toml --resolve apart --json apart.json
  musculo-collide motion scene.toml --until-contact
  musculo-collide motion model.osim walk_BodyKinematics_pos_global.sto --report walk.html

A motion file has 4 x 4 maps from rest by name, row by row, in the scene's unit:
  {\"skin\": {\"axis\": [0, 0, 1], \"segments\": [\"femur\", null], \"blends\": [[40, 150]]},
   \"frames\": [{\"t\": 0.0, \"femur\": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]}, ...]}
A rigid body follows the map of its name, or of its name after the first underscore. A map
that moves nothing while a rigid body rests is refused, unless the file has its name in a list
\"ignore\". Times \"t\" must rise.
Soft bodies blend from segment to segment along the axis, within each interval of blends;
without a skin they move with the bone that they are tied to or share nodes with, or between two, by
their distances from both; others rest.

A table of poses (.csv) has a row per body and time, in any order of columns; r11 to r33 may stand for
the quaternion:
  time,body,qw,qx,qy,qz,x,y,z
OpenSim tables (.sto, .mot) are those of its analysis BodyKinematics. With --meshes first-pose the
meshes of the scene stand as the first row has them; with --meshes body they stand in the frames of
their bodies, whose origins are taken to be the positions of the table: without a model, mass centers.

Of an OpenSim model the meshes are taken that hang on bodies, with their scale and offset, where they
are at hand beside the model or in its folder Geometry. Each follows its body of the table, whose
positions are those of mass centers.

With --resolve frames are not swept. Each starts from the tissue displacements of the last one.")]
pub(crate) struct MotionArguments {
    /// Scene file (.toml), or OpenSim model (.osim) whose meshes are at hand
    #[arg(value_name = "SCENE.toml | MODEL.osim")]
    scene: PathBuf,

    /// The same as --motion
    #[arg(value_name = "MOTION", conflicts_with = "motion")]
    motion_file: Option<PathBuf>,

    /// Motion to replay [default: the scene's]
    ///
    /// Maps from rest (.json), or poses of bodies (.sto and .mot of OpenSim's body kinematics, .csv)
    #[arg(long, value_name = "FILE")]
    motion: Option<PathBuf>,

    #[command(flatten)]
    follow: MotionArgs,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Draw overlap and free step over the frames
    #[arg(long, value_name = "FILE.svg", conflicts_with = "resolve")]
    chart: Option<PathBuf>,

    #[command(flatten)]
    joint: JointArgs,

    /// Write each body of each frame as VTP with the depth of its vertices, the faces in joint
    /// contact with gap and pressure, and the list `frames.pvd`, which ParaView opens as a series
    #[arg(long, value_name = "DIR")]
    vtp: Option<PathBuf>,

    /// Write the motion as one HTML file: bodies that turn and move, with overlaps in color, chart
    /// and table
    #[arg(long, value_name = "FILE.html", conflicts_with = "resolve")]
    report: Option<PathBuf>,

    /// Write every number of the pairs that overlap, meet or are in joint contact, frame by frame, as a long
    /// table (.csv): subject, frame, time, a, b, measure, value
    #[arg(long, value_name = "FILE.csv", conflicts_with = "resolve")]
    table: Option<PathBuf>,

    /// Subject in the table [default: the scene file]
    #[arg(long, value_name = "TEXT", requires = "table", conflicts_with_all = OF_OTHERS)]
    subject: Option<String>,

    /// Find the first contact of each pair that does not overlap in the first frame: its time,
    /// never later than the true one, and its place
    #[arg(long, conflicts_with_all = OF_FRAMES, conflicts_with = "resolve")]
    until_contact: bool,

    /// Keep finished frames in this file, and take those of an interrupted run from it
    #[arg(long, value_name = "FILE", conflicts_with = "resolve")]
    cache: Option<PathBuf>,

    /// Push overlapping bodies apart in every frame, and write each body of each frame as VTP, and
    /// the list `frames.pvd`
    #[arg(long, value_name = "DIR", conflicts_with_all = ["joint_contact", "vtp"])]
    resolve: Option<PathBuf>,

    #[command(flatten)]
    params: ResolveArgs,
}

pub(super) fn run(arguments: &MotionArguments) -> Result<Finished, Failure> {
    // Describe the scene and find its motion.
    let mut stopwatch = Stopwatch::start();
    let description = SceneDescription::from_inputs(std::slice::from_ref(&arguments.scene))?;
    let given = arguments.motion.as_ref().or(arguments.motion_file.as_ref());
    let Some(path) = given.or(description.motion.as_ref()).cloned() else {
        let problem = "names no motion: add a key `motion`, or use --motion";
        return Err(Failure::in_file(&arguments.scene, problem));
    };

    // Read meshes and motion, and bind them to each other.
    let mut loaded = LoadedScene::load(description)?;
    let motion = arguments.follow.params(&loaded.description)?;
    let mut replay = Motion::replay(&path, &motion, &loaded.scene)?;
    loaded.follow_attached(&mut replay)?;
    if let Some(warning) = motion.mass_center_warning(&path, &loaded.description) {
        terminal::print_line("warning", &warning);
    }
    if arguments.report.is_some() && replay.max_maps() > Recording::MAX_MAPS {
        let (segments, most) = (replay.max_maps(), Recording::MAX_MAPS);
        let problem = format!("the skin has {segments} segments, but a page shows {most} at most");
        return Err(Failure::in_file(&path, problem));
    }
    let inputs = arguments.inputs(path, &loaded);
    let plan = arguments.plan(inputs.clone(), &loaded, replay.frame_count());
    let mut outputs = plan.reading_too(arguments.cache.clone()).open()?;
    let joint = arguments.joint.params(&mut loaded)?;
    stopwatch.lap("load");
    if let Some(folder) = &arguments.resolve {
        let json = arguments.json.as_deref();
        let params = arguments.params.params(&mut loaded)?;
        let (unit, conditions) = (loaded.description.unit, loaded.conditions()?);
        let space = loaded.space;
        let job = Job { folder, json, params, conditions, unit, space };
        return job.run(&mut loaded.scene, &replay, outputs, stopwatch);
    }

    if arguments.until_contact {
        let document = first_contacts(&mut loaded.scene, &replay, loaded.description.unit)?;
        stopwatch.lap("sweep");
        outputs.stage_json(arguments.json.as_deref(), &document)?;
        return Ok(Finished { outputs, text: document.to_text(), holds: true, stopwatch });
    }

    // Frames depend on the scene, the motion and how bodies follow it.
    let cache = match &arguments.cache {
        Some(path) => FrameCache::open(path, &inputs, &format!("{motion:?}"))?,
        None => FrameCache::None,
    };

    // Walk through all frames, and report them.
    let mut walk = Walk {
        cache,
        files: arguments.vtp.as_deref().map(|path| FrameFiles::new(path, &loaded, &replay)),
        table: arguments.table()?,
        recording: arguments.report.is_some().then(|| record(&loaded.scene)),
        scene: &mut loaded.scene,
        replay: &replay,
        joint,
        outputs: &mut outputs,
        stopwatch: &mut stopwatch,
    };
    let frames = walk.frames()?;
    let recording = walk.finish(arguments.table.as_deref())?;
    let document = MotionDocument {
        unit: loaded.description.unit,
        resting: replay.resting().to_vec(),
        joint_contact: joint,
        frames,
    };

    outputs.stage_json(arguments.json.as_deref(), &document)?;
    if let Some(path) = &arguments.chart {
        let chart = motion_chart(&document).map_err(|error| Failure::new(error.to_string()))?;
        outputs.stage(path, chart)?;
    }
    if let (Some(path), Some(recording)) = (&arguments.report, recording) {
        let model = recording.finish(&loaded.scene, &replay, document.unit);
        let title = format!("Motion of {}", arguments.scene.display());
        let page = motion_page(&title, &document, &model);
        outputs.stage(path, page.map_err(|error| Failure::new(error.to_string()))?)?;
    }
    Ok(Finished { outputs, text: document.to_text(), holds: document.is_clean(), stopwatch })
}

/// Begins to record a motion for a page.
fn record(scene: &Scene) -> Recording {
    let _phase = Phase::start("preparing the scene that turns");
    Recording::new(scene)
}

impl MotionArguments {
    /// Returns all files that are read, but the cache.
    fn inputs(&self, motion: PathBuf, loaded: &LoadedScene) -> Vec<PathBuf> {
        let mut inputs = files_of(&loaded.description);
        inputs.extend([self.scene.clone(), motion]);
        inputs
    }

    fn plan(&self, inputs: Vec<PathBuf>, loaded: &LoadedScene, frames: usize) -> FilePlan {
        let bodies = loaded.scene.bodies();
        let names = bodies.iter().map(|body| body.name());
        FilePlan::reading(inputs)
            .writing(self.json.as_ref())
            .writing_as(OutputFormat::CHART, self.chart.as_ref())
            .writing_as(OutputFormat::TABLE, self.table.as_ref())
            .writing_as(OutputFormat::REPORT, self.report.as_ref())
            .writing_into(self.vtp.as_ref(), frame_files(&loaded.scene, frames), names.clone())
            .writing_into(self.resolve.as_ref(), frame_files(&loaded.scene, frames), names)
    }

    /// Begins the long table, if one is asked for.
    fn table(&self) -> Result<Option<LongTable>, Failure> {
        if self.table.is_none() {
            return Ok(None);
        }
        let subject = self.subject.clone();
        LongTable::new(subject.unwrap_or_else(|| self.scene.display().to_string())).map(Some)
    }
}

/// Walk through the frames of a motion.
struct Walk<'a> {
    cache: FrameCache,
    scene: &'a mut Scene,
    replay: &'a Replay,
    joint: Option<JointContactParams>,
    files: Option<FrameFiles>,
    table: Option<LongTable>,
    recording: Option<Recording>,
    outputs: &'a mut Outputs,
    stopwatch: &'a mut Stopwatch,
}

/// VTP files of all frames, in one folder.
struct FrameFiles {
    path: PathBuf,
    /// Files of joint contact, whose names depend on the results.
    contacts: FileFolder,
    series: Series,
}

impl Walk<'_> {
    /// Checks each frame, and sweeps from each to the next, but for those that the cache has.
    fn frames(&mut self) -> Result<Vec<FrameRecord>, Failure> {
        let phase = Phase::with_steps("replaying", self.replay.frame_count() - 1);
        let (mut frames, mut before) = (Vec::new(), Vec::new());
        for frame in 0..self.replay.frame_count() {
            let found = match self.cache.take(frame, self.scene)? {
                Some(kept) => {
                    self.place(frame)?;
                    kept
                }
                None => self.compute(frame, &before)?,
            };

            let mut record = self.record(frame, &found.reports)?;
            if let Some(step) = &found.step {
                self.add_meetings(frame, step)?;
            }
            record.step = found.step;
            frames.push(record);
            before = found.reports;
            phase.step();
        }
        Ok(frames)
    }

    /// Sweeps to a frame from the one before, whose reports are `before`, and checks it.
    fn compute(&mut self, frame: usize, before: &[PairReport]) -> Result<KeptFrame, Failure> {
        // A sweep starts at the state of the scene, and leaves it there.
        let mut sweep = None;
        if let Some(from) = frame.checked_sub(1) {
            sweep = Some(self.sweep(from)?);
            self.stopwatch.lap("sweep");
        }

        // Near pairs are not reported: their gaps would take most of the time.
        self.place(frame)?;
        let reports = self.scene.check(&CheckParams::new(0.0), Progress::none())?;
        self.stopwatch.lap("check");

        let step = sweep.map(|sweep| StepRecord::new(self.scene, &sweep, before, &reports));
        let found = KeptFrame::new(frame, step, reports);
        self.cache.keep(&found)?;
        Ok(found)
    }

    /// Sweeps from a frame, at which the scene is, to the next.
    fn sweep(&mut self, from: usize) -> Result<SweepReport, SceneError> {
        let ids: Vec<BodyId> = self.scene.ids().collect();
        let (mut paths, mut moves) = (Vec::new(), Vec::new());
        for body in 0..ids.len() {
            paths.push(self.replay.path(body, from));
        }
        for (&body, path) in ids.iter().zip(&paths) {
            moves.push(PathMove { body, path });
        }
        self.scene.sweep_paths(&moves, &ccd::CcdParams::EXACT, Progress::none())
    }

    /// Moves all bodies to a frame.
    ///
    /// All trees follow in every frame, so that a run that goes on has the trees, and to the bit the
    /// results, of one that was not interrupted.
    fn place(&mut self, frame: usize) -> Result<(), SceneError> {
        self.replay.place(self.scene, frame)?;
        self.scene.fit_all()
    }

    /// Records a frame, in which the scene is, and its joint contact where that is asked for.
    fn record(&mut self, frame: usize, reports: &[PairReport]) -> Result<FrameRecord, Failure> {
        let mut record = FrameRecord::new(self.scene, frame, self.replay.time(frame), reports);
        let mut contacts = Vec::new();
        if let Some(params) = &self.joint {
            let pairs = self.scene.close_pairs(params.margin)?;
            contacts = joint_contacts(self.scene, &pairs, params, Progress::none())?;
            record.add_joint_contacts(&contacts, self.scene);
            self.stopwatch.lap("joint contact");
        }

        self.add_pairs(frame, reports)?;
        self.add_joint_contacts(frame, &contacts)?;
        if let Some(recording) = &mut self.recording {
            recording.add(self.replay.time(frame), self.scene, reports);
        }
        if let Some(files) = &mut self.files {
            let time = self.replay.series_time(frame);
            files.stage(frame, time, self.scene, reports, &contacts, self.outputs)?;
            self.stopwatch.lap("write");
        }
        Ok(record)
    }

    /// Adds the pairs of a frame to the table.
    fn add_pairs(&mut self, frame: usize, reports: &[PairReport]) -> Result<(), Failure> {
        let Some(table) = &mut self.table else { return Ok(()) };
        let at = TableFrame { frame, time: self.replay.time(frame) };
        for report in reports {
            table.add_pair(at, &PairRecord::new(report, self.scene))?;
        }
        Ok(())
    }

    /// Adds the joint contacts of a frame to the table.
    fn add_joint_contacts(
        &mut self,
        frame: usize,
        contacts: &[PairContact],
    ) -> Result<(), Failure> {
        let Some(table) = &mut self.table else { return Ok(()) };
        let at = TableFrame { frame, time: self.replay.time(frame) };
        for contact in contacts {
            table.add_pair(at, &PairJointContact::new(contact, self.scene))?;
        }
        Ok(())
    }

    /// Adds the pairs that met on the way to a frame to the table.
    fn add_meetings(&mut self, frame: usize, step: &StepRecord) -> Result<(), Failure> {
        let Some(table) = &mut self.table else { return Ok(()) };
        let at = TableFrame { frame, time: self.replay.time(frame) };
        for meeting in &step.pairs {
            table.add_pair(at, meeting)?;
        }
        Ok(())
    }

    /// Completes the list of files and the table, and returns what was recorded for a page.
    fn finish(self, table: Option<&Path>) -> Result<Option<Recording>, Failure> {
        if let Some(FrameFiles { path, series, .. }) = &self.files {
            self.outputs.stage(&path.join(Series::FILE_NAME), series.to_pvd())?;
        }
        if let (Some(path), Some(rows)) = (table, self.table) {
            self.outputs.stage(path, rows.finish()?)?;
        }
        Ok(self.recording)
    }
}

impl FrameFiles {
    fn new(path: &Path, loaded: &LoadedScene, replay: &Replay) -> Self {
        let planned = frame_files(&loaded.scene, replay.frame_count());
        let contacts = FileFolder::new(path, planned, loaded.space);
        Self { path: path.to_owned(), contacts, series: Series::default() }
    }

    /// Writes the bodies of a frame and their joint contacts.
    fn stage(
        &mut self,
        frame: usize,
        time: f64,
        scene: &Scene,
        reports: &[PairReport],
        contacts: &[PairContact],
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        let mut files = Vec::new();
        for id in scene.ids() {
            let file = frame_file(scene.body(id).name(), frame);
            outputs.stage(
                &self.path.join(&file),
                depth_vtp(id, scene, reports, self.contacts.space()),
            )?;
            files.push(file);
        }
        stage_contact_files(contacts, &format!("_{frame:04}"), scene, &mut self.contacts, outputs)?;
        files.extend(self.contacts.take_completed());

        for (part, file) in files.iter().enumerate() {
            self.series.add(time, part, file);
        }
        Ok(())
    }
}
