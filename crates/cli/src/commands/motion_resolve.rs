//! `motion --resolve`: removal of overlaps in every frame of a motion.

use std::path::Path;

use musculo_collide::{Progress, Resolution, ResolveParams, Resolver, Scene};

use super::{Outcome, print, write_all};
use crate::failure::Failure;
use crate::motion::Replay;
use crate::output::Outputs;
use crate::phase::Phase;
use crate::report::{FrameInfo, ResolvedDocument, ResolvedFrame, displacement_vtp};
use crate::scene::Unit;
use crate::stopwatch::Stopwatch;

/// Places of the outputs, and parameters.
pub(super) struct Job<'a> {
    pub(super) folder: &'a Path,
    pub(super) json: Option<&'a Path>,
    pub(super) params: ResolveParams,
    pub(super) unit: Unit,
}

impl Job<'_> {
    /// Resolves all frames, and writes every body of each as VTP.
    pub(super) fn run(
        &self,
        scene: &mut Scene,
        replay: &Replay,
        mut stopwatch: Stopwatch,
    ) -> Result<Outcome, Failure> {
        let mut resolver = Resolver::new(self.params)?;
        let mut outputs = Outputs::default();
        outputs.folder(self.folder)?;
        let phase = Phase::with_steps("pushing apart, frame by frame", replay.frame_count());
        let mut frames = Vec::new();
        for frame in 0..replay.frame_count() {
            replay.place(scene, frame)?;
            let resolution = resolver.resolve(scene, Progress::none())?;
            let seconds = stopwatch.lap("resolve").as_secs_f64();
            self.stage(frame, scene, &resolution, &mut outputs)?;
            stopwatch.lap("write");
            let info = FrameInfo { frame, time: replay.time(frame), seconds };
            frames.push(ResolvedFrame::new(info, scene, self.unit, &resolution));
            phase.step();
        }
        drop(phase);

        let document = ResolvedDocument { unit: self.unit, frames };
        outputs.stage_json(self.json, &document)?;
        let written = write_all(outputs)?;
        stopwatch.lap("write");
        print(&(document.to_text() + &written + &stopwatch.line()));
        Ok(Outcome::of_overlaps(!document.is_resolved()))
    }

    /// Writes one file per body, in a series that `ParaView` opens as one.
    fn stage(
        &self,
        frame: usize,
        scene: &Scene,
        resolution: &Resolution,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        for (body, change) in scene.bodies().iter().zip(&resolution.bodies) {
            let (x, faces) = (body.positions(), body.surface().faces());
            let path = self.folder.join(format!("{}_{frame:04}.vtp", body.name()));
            outputs.stage(&path, displacement_vtp(x, faces, &change.displacements))?;
        }
        Ok(())
    }
}
