//! `motion --resolve`: push apart what overlaps in every frame of a motion.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use musculo_collide::{BodyId, Resolution, Resolver};

use super::{Failure, Outcome};
use crate::motion::Replay;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::report::{ResolvedDocument, ResolvedFrame, displacement_vtp, resolved_table};
use crate::scene::Unit;

/// Where a motion is written that has been resolved, and how.
pub(super) struct Job<'a> {
    pub(super) folder: &'a Path,
    pub(super) json: Option<&'a Path>,
    pub(super) params: musculo_collide::ResolveParams,
    pub(super) unit: Unit,
    /// Seconds of each frame, where the motion tells them.
    pub(super) times: &'a [Option<f64>],
}

/// Resolves all frames, and writes every body of each as VTP.
pub(super) fn run(
    job: &Job<'_>,
    scene: &mut musculo_collide::Scene,
    replay: &Replay<'_>,
) -> Result<Outcome, Failure> {
    let mut resolver = Resolver::new(job.params)?;
    let mut outputs = Outputs::default();
    outputs.folder(job.folder)?;
    let progress = Progress::start("pushing apart, frame by frame", job.times.len());
    let mut frames = Vec::new();
    let mut seconds = Vec::new();
    for (frame, &time) in job.times.iter().enumerate() {
        place(scene, &replay.positions(frame))?;
        let start = Instant::now();
        let resolution = resolver.resolve(scene, musculo_collide::Progress::none())?;
        seconds.push(start.elapsed().as_secs_f64());
        stage(job.folder, frame, scene, &resolution, &mut outputs)?;
        frames.push(ResolvedFrame::new((frame, time), scene, &resolution));
        progress.step();
    }
    drop(progress);
    let document = ResolvedDocument { unit: job.unit, frames };
    if let Some(path) = job.json {
        let mut json = serde_json::to_string_pretty(&document)?;
        json.push('\n');
        outputs.stage(path, json.as_bytes())?;
    }
    let written = outputs.commit()?;

    let mut text = resolved_table(&document, &seconds);
    text += &format!("wrote {} files, most to {}\n", written.len(), job.folder.display());
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(if document.is_resolved() { Outcome::Clean } else { Outcome::Overlaps })
}

fn place(
    scene: &mut musculo_collide::Scene,
    positions: &[Vec<glam::DVec3>],
) -> Result<(), Failure> {
    let ids: Vec<BodyId> = scene.ids().collect();
    for (id, x) in ids.into_iter().zip(positions) {
        scene.move_body(id, x)?;
    }
    Ok(())
}

/// One file a body and frame, in series that `ParaView` opens as one.
fn stage(
    folder: &Path,
    frame: usize,
    scene: &musculo_collide::Scene,
    resolution: &Resolution,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    for (body, change) in scene.bodies().iter().zip(&resolution.bodies) {
        let map = displacement_vtp(body.positions(), body.surface().faces(), &change.displacements);
        outputs.stage(&file(folder, body.name(), frame), map.as_bytes())?;
    }
    Ok(())
}

fn file(folder: &Path, body: &str, frame: usize) -> PathBuf {
    folder.join(format!("{body}_{frame:04}.vtp"))
}
