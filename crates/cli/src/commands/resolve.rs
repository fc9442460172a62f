//! `resolve`: removal of overlaps.

use std::cell::OnceCell;
use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use mesh_io::Precision;
use musculo_collide::{BodyKind, Conditions, ResolveParams, Resolver, WrittenPrecision};

use super::Finished;
use super::body_file::BodyFile;
use super::check::{CheckedScene, detect, overlap_shapes};
use super::resolve_arguments::ResolveArgs;
use super::resolve_files::{
    FileRounding, check_elements, check_shared_parts, complete_files, file_roundings, suffix,
};
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::output::{FilePlan, Outputs};
use crate::phase::Phase;
use crate::report::{
    ResolutionDocument, ShownSurfaces, displacement_vtp, displacement_vtu, pushed_out,
    resolution_text,
};
use crate::scene::{BodyDescription, SceneDescription};
use crate::stopwatch::Stopwatch;
use crate::terminal;

/// Push overlapping bodies apart, to a gap, and write their new meshes
///
/// Rigid bodies stay, soft ones yield and share their overlaps by mass. Every mesh is written into a
/// copy of its file in which only positions change: format, encoding, number type, order and
/// attributes stay. The nodes inside volume meshes follow, and no element is inverted. The
/// displacements of soft bodies are written as VTP or VTU, and reports of the states before and
/// after. With --gap, the distance of all surfaces is proved at the positions in the files. Where it
/// does not hold, or an overlap remains, each pair is named with the reason, and no mesh is written.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide resolve scene.toml --out apart
  musculo-collide resolve femur.ply vastus.ply --fixed femur --out apart
  musculo-collide resolve scene.toml --gap 0.05 --out apart --json gap.json

In the scene file, a body with stiffness = 2 yields half as much as others (from 1e-9 to 1e9), and one with uncross = true has its own parts taken out of each other;
[[tie]] attaches two bodies where they are near each other, and needs no gap there;
[[fixed]] keeps vertices where they are:
  [[tie]]
  a = \"femur\"
  b = \"cartilage\"
  within = 0.2            # largest distance of attached vertices

  [[fixed]]
  body = \"tendon\"
  within = 1.0            # all vertices within this distance
  of = \"femur\"          # of that body; or
  # vertices = \"ids.txt\" # the numbers in this file, or
  # box = [[0, 0, 0], [10, 10, 5]]
Numbers are those of the nodes in INP, FEB and MSH files. In PLY, OFF, OBJ, VTP, VTU and VTK files they count from 0, also in OBJ, whose own count
from 1: its first vertex is 0. Vertices of STL files have none.")]
pub(crate) struct ResolveArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Folder for the meshes
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    #[command(flatten)]
    params: ResolveArgs,

    /// Write the meshes even where the gap does not hold, an overlap remains or a limit is broken, with
    /// `_unproved` in their names
    #[arg(long)]
    keep_going: bool,

    /// Write the result as JSON: each pair with its distance, whether the gap is proved, and why not
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Write no reports with pictures of the states before and after
    #[arg(long)]
    no_report: bool,
}

pub(super) fn run(arguments: &ResolveArguments) -> Result<Finished, Failure> {
    let mut stopwatch = Stopwatch::start();
    let description = arguments.scene.describe()?;
    let mut outputs = arguments.plan(&description).open()?;
    let mut loaded = LoadedScene::load(description)?;

    // Lengths, conditions and elements are checked before any work.
    let keep_going = arguments.keep_going;
    let asked = ResolveParams { keep_going, ..arguments.params.params(&mut loaded)? };
    asked.validate()?;
    let mut conditions = loaded.conditions()?;
    check_elements(&loaded)?;
    check_shared_parts(&loaded)?;
    let params = for_files(asked, &mut conditions, &loaded)?;
    stopwatch.lap("load");

    let [before, after] = STATES;
    let surfaces = OnceCell::new();
    arguments.stage_report(before, "", &mut loaded, &surfaces, &mut outputs)?;
    stopwatch.lap("report");
    let start: Vec<Vec<DVec3>> =
        loaded.scene.bodies().iter().map(|body| body.positions().to_vec()).collect();
    let mut resolver = Resolver::new(params)?.with_conditions(conditions.clone());
    let mut resolution =
        Phase::run("pushing apart", |progress| resolver.resolve(&mut loaded.scene, progress))?;
    stopwatch.lap("resolve");

    // The files hold rounded positions, of which all that follows is said.
    let bodies = &mut resolution.bodies;
    let files =
        Phase::run("following", |progress| complete_files(&mut loaded, &start, bodies, progress))?;
    let elements: Vec<_> = files.iter().map(|file| file.elements.clone()).collect();
    let unit = loaded.description.unit;
    let mut document = ResolutionDocument::new(
        unit,
        &asked,
        &resolution,
        &conditions,
        &mut loaded.scene,
        &elements,
    )?;
    stopwatch.lap("prove");
    let mark = if document.resolved { "" } else { UNPROVED };
    arguments.stage_report(after, mark, &mut loaded, &surfaces, &mut outputs)?;
    stopwatch.lap("report");

    document.written = document.resolved || keep_going;
    if document.written {
        arguments.stage_files(&document, &loaded, &files, &mut outputs)?;
    }
    outputs.stage_json(arguments.json.as_deref(), &document)?;
    let pushed_out = pushed_out(&resolution, &loaded.scene);
    for warning in document.tie_warnings().chain(pushed_out) {
        terminal::print_line("warning", &warning);
    }
    let overlaps = document.overlaps_in_files();
    let text = resolution_text(&resolution, &loaded.scene, unit, keep_going, overlaps)
        + &document.to_text();
    Ok(Finished { outputs, text, holds: document.resolved, stopwatch })
}

/// Returns parameters by which the gap holds in the files: positions in single precision are rounded
/// before distances are proved, all others keep their digits, and decimal ones and those of placed instances need a
/// hair more.
fn for_files(
    asked: ResolveParams,
    conditions: &mut Conditions,
    loaded: &LoadedScene,
) -> Result<ResolveParams, Failure> {
    let roundings = file_roundings(loaded)?;
    let mut precision = asked.precision;
    let is_single = |rounding: &FileRounding| rounding.precision == Precision::Single;
    if roundings.iter().any(is_single) {
        precision = WrittenPrecision::Single;
        let others = loaded.scene.ids().zip(&roundings).filter(|(_, own)| !is_single(own));
        conditions.unrounded.extend(others.map(|(id, _)| id));
    }

    let mut max_rounding: f64 = 0.0;
    for (rounding, body) in roundings.iter().zip(loaded.scene.bodies()) {
        let mut of_body = rounding.of_placement;
        if precision != WrittenPrecision::Single {
            of_body += rounding.precision.max_rounding(body.largest_coordinate());
        }
        max_rounding = max_rounding.max(of_body);
    }
    let slack = if asked.gap > 0.0 { 2.0 * max_rounding } else { 0.0 };
    Ok(ResolveParams { gap: asked.gap + slack, precision, ..asked })
}

/// Mark in the names of files that hold no proved state.
pub(super) const UNPROVED: &str = "_unproved";

/// Returns the name of the file of a body: parts of one file stay in one, which has its name.
fn mesh_file(body: &BodyDescription, mark: &str) -> String {
    let stem = body.path.file_stem().unwrap_or_default().to_string_lossy();
    let name = if body.parts.is_empty() { &body.name } else { &*stem };
    format!("{name}{mark}{}", suffix(body))
}

fn displacement_file(body: &BodyDescription, mark: &str, has_volume: bool) -> String {
    let extension = if has_volume { "vtu" } else { "vtp" };
    format!("{}{mark}_displacement.{extension}", body.name)
}

/// States of which there are reports.
const STATES: [&str; 2] = ["before", "after"];

fn report_file(state: &str, mark: &str) -> String {
    format!("{state}{mark}.html")
}

impl ResolveArguments {
    fn plan(&self, description: &SceneDescription) -> FilePlan {
        let mut files = Vec::new();

        for bodies in description.bodies_by_file() {
            files.push(mesh_file(&description.bodies[bodies[0]], ""));
        }
        if !self.no_report {
            files.extend(STATES.map(|state| report_file(state, "")));
        }
        let plan = self.scene.plan(description).writing(self.json.as_ref());
        let bodies = description.bodies.iter().map(|body| &*body.name);
        plan.writing_into(Some(&self.out), files, bodies)
    }

    /// Writes all meshes, and the displacements of soft bodies beside them.
    fn stage_files(
        &self,
        document: &ResolutionDocument,
        loaded: &LoadedScene,
        files: &[BodyFile],
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        let mark = if document.resolved { "" } else { UNPROVED };
        for (number, (description, file)) in loaded.description.bodies.iter().zip(files).enumerate()
        {
            let mesh = self.out.join(mesh_file(description, mark));
            match &file.content {
                Some(content) if document.resolved => outputs.stage(&mesh, content)?,
                Some(content) => outputs.stage_found(&mesh, content)?,
                // In the file of a body before.
                None => {}
            }

            // Bones do not move, and have no displacements.
            let body = &loaded.scene.bodies()[number];
            if body.kind() == BodyKind::Rigid {
                continue;
            }
            let volume = loaded.volumes[number].as_ref().zip(file.nodes.as_ref());
            let name = displacement_file(description, mark, volume.is_some());
            let content = match volume {
                Some((volume, [nodes, u])) => {
                    displacement_vtu(nodes, &volume.mesh, u, loaded.space)
                }
                None => {
                    let (x, faces) = (body.positions(), body.surface().faces());
                    displacement_vtp(x, faces, &file.displacements, loaded.space)
                }
            };
            outputs.stage_found(&self.out.join(name), content)?;
        }
        Ok(())
    }

    /// Writes a report of the present state, unless reports are off. A mark is of a state that is no
    /// result.
    fn stage_report(
        &self,
        state: &str,
        mark: &str,
        loaded: &mut LoadedScene,
        surfaces: &OnceCell<ShownSurfaces>,
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
            space: loaded.space,
            reports: &reports,
            shapes: &shapes,
            contacts: &[],
        };
        let page = self.out.join(report_file(state, mark));
        if mark.is_empty() {
            let title = format!("Contact {state} overlap removal");
            outputs.stage(&page, checked.page(&title, surfaces)?)
        } else {
            let title = format!("Contact {state} overlap removal, which is not complete");
            outputs.stage_found(&page, checked.page(&title, surfaces)?)
        }
    }
}
