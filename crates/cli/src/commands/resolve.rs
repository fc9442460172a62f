//! `resolve`: push apart what overlaps.

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use mesh_io::write_ply;
use musculo_collide::{BodyKind, CheckParams, Resolution};

use super::check::{document, page};
use super::resolve_lengths::ResolveLengths;
use super::{Failure, Outcome, in_threads};
use crate::load::{build_scene, read_meshes};
use crate::output::Outputs;
use crate::progress::Progress;
use crate::report::{BodyRecord, displacement_vtp, resolution_table};
use crate::scene::Scene;

/// Push bodies apart that overlap, and write where they then are
///
/// Rigid bodies stay, soft ones yield, and share by mass what they overlap with
/// each other. Writes every mesh as PLY, the displacements of the soft ones as
/// VTP, and reports from before and after. Tells what still overlaps at the end, and why.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide resolve scene.toml --out apart
  musculo-collide resolve femur.ply vastus.ply --fixed femur --out apart

Exit status: 0 nothing overlaps by more than the tolerance, 1 something does, 2 bad input or usage.")]
pub(crate) struct ResolveArguments {
    /// A scene file (.toml), or mesh files: PLY, OBJ, STL or VTP
    #[arg(required = true, value_name = "SCENE.toml | MESH")]
    inputs: Vec<PathBuf>,

    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Keep this body where it is, as rigid ones are; may be given more than once
    #[arg(long, visible_alias = "rigid", value_name = "NAME")]
    fixed: Vec<String>,

    #[command(flatten)]
    lengths: ResolveLengths,

    /// Write no reports with pictures from before and after
    #[arg(long)]
    no_report: bool,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

pub(super) fn run(arguments: &ResolveArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || resolve(arguments))
}

fn resolve(arguments: &ResolveArguments) -> Result<Outcome, Failure> {
    let mut description = Scene::from_inputs(&arguments.inputs)?;
    description.set_rigid(&arguments.fixed)?;
    let (mut scene, bodies) = build_scene(&description, read_meshes(&description)?)?;
    let before = arguments.page("before", &description, bodies.clone(), &mut scene)?;
    let start = Instant::now();
    let resolution = {
        let _progress = Progress::start("pushing apart", 1);
        let params = arguments.lengths.params(description.unit);
        musculo_collide::resolve(&mut scene, &params, musculo_collide::Progress::none())?
    };
    let seconds = start.elapsed().as_secs_f64();
    let after = arguments.page("after", &description, bodies, &mut scene)?;
    let pages = [before, after].into_iter().flatten().collect();
    let written = write(&arguments.out, &scene, &resolution, pages)?;

    let mut text = resolution_table(&resolution, &scene, description.unit);
    text += &format!("wrote {} files to {}\n", written.len(), arguments.out.display());
    text += &format!("{seconds:.2} s: {} rounds\n", resolution.rounds.len() - 1);
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(if resolution.resolved { Outcome::Clean } else { Outcome::Overlaps })
}

/// The name of a file and what is to stand in it.
type Page = (&'static str, String);

impl ResolveArguments {
    /// A report of the scene as it stands, unless there are to be none.
    fn page(
        &self,
        when: &'static str,
        description: &Scene,
        bodies: Vec<BodyRecord>,
        scene: &mut musculo_collide::Scene,
    ) -> Result<Option<Page>, Failure> {
        if self.no_report {
            return Ok(None);
        }
        let reports = scene
            .check(&CheckParams { margin: description.reach }, musculo_collide::Progress::none())?;
        let document = document(description, bodies, scene, &reports)?;
        let title = format!("Contact {when} bodies were pushed apart");
        Ok(Some((when, page(&title, &document, scene, &reports)?)))
    }
}

/// Writes all meshes, displacements and reports, or nothing; returns the paths.
fn write(
    folder: &Path,
    scene: &musculo_collide::Scene,
    resolution: &Resolution,
    pages: Vec<Page>,
) -> Result<Vec<PathBuf>, Failure> {
    let mut outputs = Outputs::default();
    outputs.folder(folder)?;
    for (when, page) in pages {
        outputs.stage(&folder.join(format!("{when}.html")), page.as_bytes())?;
    }
    for (body, change) in scene.bodies().iter().zip(&resolution.bodies) {
        let (x, faces) = (body.positions(), body.surface().faces());
        let path = |extension: &str| folder.join(format!("{}.{extension}", body.name()));
        outputs.stage(&path("ply"), &write_ply(x, faces))?;
        if body.kind() != BodyKind::Rigid {
            let map = displacement_vtp(x, faces, &change.displacements);
            outputs.stage(&path("vtp"), map.as_bytes())?;
        }
    }
    Ok(outputs.commit()?)
}
