//! `resolve`: removal of overlaps.

use std::path::PathBuf;

use clap::Args;
use mesh_io::MeshFormat;
use musculo_collide::BodyKind;

use super::Finished;
use super::check::{CheckedScene, detect, overlap_shapes};
use super::resolve_arguments::ResolveArgs;
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::output::{FilePlan, Outputs};
use crate::phase::Phase;
use crate::report::{displacement_vtp, resolution_text};
use crate::scene::{BodyDescription, SceneDescription};
use crate::stopwatch::Stopwatch;

/// Push overlapping bodies apart, and write their new meshes
///
/// Rigid bodies stay, soft ones yield and share their overlaps by mass. Writes every mesh
/// in the format of its file with the same order of vertices, the displacements of the
/// soft ones as VTP, and reports of the states before and after. Lists the overlaps that
/// remain, with the reasons.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide resolve scene.toml --out apart
  musculo-collide resolve femur.ply vastus.ply --fixed femur --out apart")]
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

pub(super) fn run(arguments: &ResolveArguments) -> Result<Finished, Failure> {
    let mut stopwatch = Stopwatch::start();
    let description = arguments.scene.describe()?;
    let mut outputs = arguments.plan(&description).open()?;
    let mut loaded = LoadedScene::load(description)?;

    // Lengths are checked before any work.
    let params = arguments.params.params(&loaded);
    params.validate()?;
    stopwatch.lap("load");

    let [before, after] = STATES;
    arguments.stage_report(before, &mut loaded, &mut outputs)?;
    stopwatch.lap("report");
    let resolution = Phase::run("pushing apart", |progress| {
        musculo_collide::resolve(&mut loaded.scene, &params, progress)
    })?;
    stopwatch.lap("resolve");
    arguments.stage_report(after, &mut loaded, &mut outputs)?;
    stopwatch.lap("report");

    // Meshes in the formats in which they were read, displacements beside them.
    for (description, change) in loaded.description.bodies.iter().zip(&resolution.bodies) {
        let body = loaded.scene.body(change.body);
        let (x, faces) = (body.positions(), body.surface().faces());
        let mesh = arguments.out.join(mesh_file(description));
        outputs.stage(&mesh, format_of(description).encode(x, faces))?;
        if body.kind() != BodyKind::Rigid {
            let displacements = arguments.out.join(displacement_file(description));
            outputs.stage(&displacements, displacement_vtp(x, faces, &change.displacements))?;
        }
    }

    let text = resolution_text(&resolution, &loaded.scene, loaded.description.unit);
    Ok(Finished { outputs, text, holds: resolution.resolved, stopwatch })
}

/// Returns the format of a body's file, PLY where its extension is none of ours.
fn format_of(body: &BodyDescription) -> MeshFormat {
    MeshFormat::of(&body.path).unwrap_or(MeshFormat::Ply)
}

fn mesh_file(body: &BodyDescription) -> String {
    format!("{}.{}", body.name, format_of(body).extension())
}

/// States of which there are reports.
const STATES: [&str; 2] = ["before", "after"];

fn report_file(state: &str) -> String {
    format!("{state}.html")
}

fn displacement_file(body: &BodyDescription) -> String {
    format!("{}_displacement.vtp", body.name)
}

impl ResolveArguments {
    fn plan(&self, description: &SceneDescription) -> FilePlan {
        let mut files = Vec::new();

        // Bones do not move, and have no displacements.
        for body in &description.bodies {
            files.push(mesh_file(body));
            if body.kind != BodyKind::Rigid {
                files.push(displacement_file(body));
            }
        }
        if !self.no_report {
            files.extend(STATES.map(report_file));
        }
        self.scene.plan(description).writing_into(Some(&self.out), files)
    }

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

        let reports = detect(loaded, None)?;
        let document = loaded.document(&reports)?;
        let shapes = overlap_shapes(&mut loaded.scene, &reports)?;
        let checked = CheckedScene {
            document: &document,
            scene: &loaded.scene,
            reports: &reports,
            shapes: &shapes,
            contacts: &[],
        };
        let page = checked.page(&format!("Contact {state} overlap removal"))?;
        outputs.stage(&self.out.join(report_file(state)), page)
    }
}
