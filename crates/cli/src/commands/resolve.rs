//! `resolve`: removal of overlaps.

use std::path::PathBuf;

use clap::Args;
use mesh_io::write_ply;
use musculo_collide::BodyKind;

use super::check::{CheckedScene, detect};
use super::resolve_arguments::ResolveArgs;
use super::{Outcome, print, write_all};
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::output::Outputs;
use crate::phase::Phase;
use crate::report::{displacement_vtp, resolution_text};
use crate::stopwatch::Stopwatch;

/// Push overlapping bodies apart, and write their new meshes
///
/// Rigid bodies stay, soft ones yield and share their overlaps by mass. Writes every mesh
/// as PLY, the displacements of the soft ones as VTP, and reports of the states before
/// and after. Lists the overlaps that remain, with the reasons.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide resolve scene.toml --out apart
  musculo-collide resolve femur.ply vastus.ply --fixed femur --out apart

Exit status: 0 no overlap exceeds the tolerance, 1 some overlap does, 2 bad input or usage.")]
pub(crate) struct ResolveArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Folder for the meshes
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    #[command(flatten)]
    params: ResolveArgs,

    /// Write no reports with pictures of the states before and after
    #[arg(long)]
    no_report: bool,
}

pub(super) fn run(arguments: &ResolveArguments) -> Result<Outcome, Failure> {
    let mut stopwatch = Stopwatch::start();
    let mut loaded = LoadedScene::load(arguments.scene.describe()?)?;
    let params = arguments.params.params(&loaded);
    params.validate()?;
    stopwatch.lap("load");

    let mut outputs = Outputs::default();
    outputs.folder(&arguments.out)?;
    arguments.stage_report("before", &mut loaded, &mut outputs)?;
    stopwatch.lap("report");
    let resolution = Phase::run("pushing apart", |progress| {
        musculo_collide::resolve(&mut loaded.scene, &params, progress)
    })?;
    stopwatch.lap("resolve");
    arguments.stage_report("after", &mut loaded, &mut outputs)?;
    stopwatch.lap("report");

    for (body, change) in loaded.scene.bodies().iter().zip(&resolution.bodies) {
        let (x, faces) = (body.positions(), body.surface().faces());
        let path = |extension: &str| arguments.out.join(format!("{}.{extension}", body.name()));
        outputs.stage(&path("ply"), write_ply(x, faces))?;
        if body.kind() != BodyKind::Rigid {
            outputs.stage(&path("vtp"), displacement_vtp(x, faces, &change.displacements))?;
        }
    }
    let written = write_all(outputs)?;
    stopwatch.lap("write");

    let text = resolution_text(&resolution, &loaded.scene, loaded.description.unit);
    print(&(text + &written + &stopwatch.line()));
    Ok(Outcome::of_overlaps(!resolution.resolved))
}

impl ResolveArguments {
    /// Writes a report of the present state, unless reports are off.
    fn stage_report(
        &self,
        state: &str,
        loaded: &mut LoadedScene,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        if self.no_report {
            return Ok(());
        }
        let reports = detect(loaded)?;
        let document = loaded.document(&reports)?;
        let checked = CheckedScene { document: &document, scene: &loaded.scene, reports: &reports };
        let page = checked.page(&format!("Contact {state} overlap removal"))?;
        outputs.stage(&self.out.join(format!("{state}.html")), page)
    }
}
