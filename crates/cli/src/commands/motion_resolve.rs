//! `motion --resolve`: removal of overlaps in every frame of a motion.

use std::path::Path;

use mesh_io::Space;
use musculo_collide::{Conditions, Progress, Resolution, ResolveParams, Resolver, Scene};

use super::Finished;
use super::resolve::UNPROVED;
use crate::failure::Failure;
use crate::motion::Replay;
use crate::output::Outputs;
use crate::phase::Phase;
use crate::report::{
    FrameInfo, ResolvedDocument, ResolvedFrame, Series, displacement_vtp, rest_text,
};
use crate::scene::Unit;
use crate::stopwatch::Stopwatch;

/// Returns the name of the file of a body in a frame whose state is not proved.
fn unproved_file(body: &str, frame: usize) -> String {
    format!("{body}_{frame:04}{UNPROVED}.vtp")
}

/// Returns the name of the file of a body in a frame.
pub(super) fn frame_file(body: &str, frame: usize) -> String {
    format!("{body}_{frame:04}.vtp")
}

/// Returns the names of the files of all bodies in all frames, and of their list.
pub(super) fn frame_files(scene: &Scene, frames: usize) -> Vec<String> {
    let mut files = vec![Series::FILE_NAME.to_owned()];
    for body in scene.bodies() {
        files.extend((0..frames).map(|frame| frame_file(body.name(), frame)));
    }
    files
}

/// Places of the outputs, and parameters.
pub(super) struct Job<'a> {
    pub(super) folder: &'a Path,
    pub(super) json: Option<&'a Path>,
    pub(super) params: ResolveParams,
    pub(super) conditions: Conditions,
    pub(super) unit: Unit,
    /// Space that the files of the scene state.
    pub(super) space: Option<Space>,
}

impl Job<'_> {
    /// Resolves all frames, and writes every body of each as VTP.
    pub(super) fn run(
        &self,
        scene: &mut Scene,
        replay: &Replay,
        mut outputs: Outputs,
        mut stopwatch: Stopwatch,
    ) -> Result<Finished, Failure> {
        let mut resolver = Resolver::new(self.params)?.with_conditions(self.conditions.clone());
        let phase = Phase::with_steps("pushing apart, frame by frame", replay.frame_count());

        // Tissue keeps its displacements from frame to frame, so that pushes do not jump.
        let mut frames = Vec::new();
        let mut series = Series::default();

        for frame in 0..replay.frame_count() {
            replay.place(scene, frame)?;
            let resolution = resolver.resolve(scene, Progress::none())?;
            let seconds = stopwatch.lap("resolve").as_secs_f64();

            // Written at once: the states of all frames would not fit in memory.
            let files = self.stage(frame, scene, &resolution, &mut outputs)?;
            for (part, file) in files.iter().enumerate() {
                series.add(replay.series_time(frame), part, file);
            }
            stopwatch.lap("write");

            let info = FrameInfo { frame, time: replay.time(frame), seconds };
            let mut frame = ResolvedFrame::new(info, scene, self.unit, &self.params, &resolution);
            frame.follow(frames.last());
            frames.push(frame);
            phase.step();
        }
        drop(phase);
        outputs.stage(&self.folder.join(Series::FILE_NAME), series.to_pvd())?;

        let document =
            ResolvedDocument::new(self.unit, &self.params, scene, &self.conditions, frames);
        outputs.stage_json(self.json, &document)?;
        let text = document.to_text() + &rest_text(replay.resting());
        Ok(Finished { outputs, text, holds: document.resolved, stopwatch })
    }

    /// Writes one file per body, marked where the frame is not resolved, and returns their names.
    fn stage(
        &self,
        frame: usize,
        scene: &Scene,
        resolution: &Resolution,
        outputs: &mut Outputs,
    ) -> Result<Vec<String>, Failure> {
        let mut files = Vec::new();

        // Bones are written too: they move from frame to frame.
        for (body, change) in scene.bodies().iter().zip(&resolution.bodies) {
            let (x, faces) = (body.positions(), body.surface().faces());
            let content = displacement_vtp(x, faces, &change.displacements, self.space);
            let file = if resolution.resolved {
                let file = frame_file(body.name(), frame);
                outputs.stage(&self.folder.join(&file), content)?;
                file
            } else {
                let file = unproved_file(body.name(), frame);
                outputs.stage_found(&self.folder.join(&file), content)?;
                file
            };
            files.push(file);
        }
        Ok(files)
    }
}
