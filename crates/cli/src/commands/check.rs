//! `check`: find every overlap and contact of a scene at rest.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use musculo_collide::{CheckParams, PairReport, SceneError};

use super::{Failure, Outcome, in_threads};
use crate::load::{build_scene, read_meshes};
use crate::output::Outputs;
use crate::picture::Image;
use crate::progress::Progress;
use crate::report::{
    BodyRecord, ContactField, Document, Gallery, PairRecord, divisions, html, table,
};
use crate::scene::{Bounds, Scene, unit_warnings};

/// Find every overlap and contact between bodies, and say how deep
///
/// Reads closed or open triangle meshes, lists their defects, and reports for
/// every pair of bodies whether they overlap, how deep, over what area, and how
/// far apart they are otherwise. Depth is that of the deepest vertex inside the
/// other body.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide check femur.ply vastus.ply --rigid femur
  musculo-collide check scene.toml --json contact.json --report contact.html

A scene file:
  unit = \"mm\"             # of all lengths; also um, cm, m, in
  reach = 1.0             # how far apart still counts as near

  [[body]]
  file = \"femur.ply\"      # from the folder of the scene file
  name = \"femur\"          # the file's name, if left out
  kind = \"rigid\"          # or deformable (if left out), or open: a sheet

  [[ignore]]              # a pair that is meant to overlap
  a = \"femur\"
  b = \"cartilage\"

Exit status: 0 nothing overlaps, 1 something overlaps, 2 bad input or usage.")]
pub(crate) struct CheckArguments {
    /// A scene file (.toml), or mesh files: PLY, OBJ, STL or VTP
    #[arg(required = true, value_name = "SCENE.toml | MESH")]
    inputs: Vec<PathBuf>,

    /// Treat this body as rigid (a bone); may be given more than once
    #[arg(long, value_name = "NAME")]
    rigid: Vec<String>,

    /// How far apart surfaces still count as near, in the scene's unit [default: the scene's, or 1 mm]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    reach: Option<f64>,

    /// Write everything that is reported as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Write each body as VTP, with signed gap and depth at its vertices, for ParaView or 3D Slicer
    #[arg(long, value_name = "DIR")]
    vtp: Option<PathBuf>,

    /// Write a report with pictures and tables, one file for any browser
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Write one picture of the contact from three sides
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
}

pub(super) fn run(arguments: &CheckArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || check(arguments))
}

fn check(arguments: &CheckArguments) -> Result<Outcome, Failure> {
    let mut times = Times::start();
    let mut description = Scene::from_inputs(&arguments.inputs)?;
    description.set_rigid(&arguments.rigid)?;
    if let Some(reach) = arguments.reach {
        description.set_reach(reach)?;
    }
    let meshes = read_meshes(&description)?;
    times.end_of("read");

    let (mut scene, bodies) = build_scene(&description, meshes)?;
    times.end_of("inspect");

    let params = CheckParams { margin: description.reach };
    let reports = {
        let _progress = Progress::start("looking for contact", 1);
        scene.check(&params, musculo_collide::Progress::none())?
    };
    times.end_of("detect");

    let checked = Checked {
        document: document(&description, bodies, &mut scene, &reports)?,
        scene: &scene,
        reports: &reports,
    };
    let written = checked.write(arguments)?;
    times.end_of("write");

    let mut text = table(&checked.document);
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    text += &times.line();
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    let overlaps = checked.document.overlapping() > 0;
    Ok(if overlaps { Outcome::Overlaps } else { Outcome::Clean })
}

pub(super) fn document(
    description: &Scene,
    bodies: Vec<BodyRecord>,
    scene: &mut musculo_collide::Scene,
    reports: &[PairReport],
) -> Result<Document, SceneError> {
    let sizes: Vec<(&str, Bounds)> =
        bodies.iter().map(|body| (body.name.as_str(), body.bounds)).collect();
    Ok(Document {
        unit: description.unit,
        reach: description.reach,
        warnings: unit_warnings(&sizes),
        pairs: reports.iter().map(|report| PairRecord::new(report, scene)).collect(),
        divisions: divisions(scene, reports)?,
        bodies,
    })
}

/// A report with pictures of everything and of each overlap.
pub(super) fn page(
    title: &str,
    document: &Document,
    scene: &musculo_collide::Scene,
    reports: &[PairReport],
) -> Result<String, Failure> {
    let overlapping = overlapping(reports);
    let gallery = Gallery::new(scene, reports, document.reach);
    let progress = Progress::start("drawing", 3 + overlapping.len());
    let overview = gallery.overview(|| progress.step());
    let close_ups = gallery.close_ups(&overlapping, || progress.step());
    Ok(html(title, document, &overview, &close_ups)?)
}

/// Pairs that overlap, the deepest first.
fn overlapping(reports: &[PairReport]) -> Vec<&PairReport> {
    let mut overlapping: Vec<&PairReport> = reports.iter().filter(|pair| pair.overlaps).collect();
    overlapping.sort_by(|p, q| q.max_depth.total_cmp(&p.max_depth));
    overlapping
}

/// All that outputs are made from.
struct Checked<'a> {
    document: Document,
    scene: &'a musculo_collide::Scene,
    reports: &'a [PairReport],
}

impl Checked<'_> {
    /// Writes what was asked for, all or nothing; returns the paths.
    fn write(&self, arguments: &CheckArguments) -> Result<Vec<PathBuf>, Failure> {
        let mut outputs = Outputs::default();
        if let Some(path) = &arguments.json {
            let mut json = serde_json::to_string_pretty(&self.document)?;
            json.push('\n');
            outputs.stage(path, json.as_bytes())?;
        }
        if let Some(folder) = &arguments.vtp {
            self.stage_vtp(folder, &mut outputs)?;
        }
        self.stage_pictures(arguments, &mut outputs)?;
        Ok(outputs.commit()?)
    }

    fn stage_vtp(&self, folder: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
        outputs.folder(folder)?;
        for (id, body) in self.scene.ids().zip(self.scene.bodies()) {
            let field = ContactField::new(id, self.scene, self.reports, self.document.reach);
            let text = field.to_vtp(body.positions(), body.surface().faces());
            outputs.stage(&folder.join(format!("{}.vtp", body.name())), text.as_bytes())?;
        }
        Ok(())
    }

    fn stage_pictures(
        &self,
        arguments: &CheckArguments,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        if arguments.picture.is_none() && arguments.report.is_none() {
            return Ok(());
        }
        let overlapping = overlapping(self.reports);
        let progress = Progress::start("drawing", 3 + overlapping.len());
        let gallery = Gallery::new(self.scene, self.reports, self.document.reach);
        let overview = gallery.overview(|| progress.step());
        if let Some(path) = &arguments.picture {
            let images: Vec<Image> = overview.iter().map(|sight| sight.image.clone()).collect();
            outputs.stage(path, &Image::beside(&images).to_png()?)?;
        }
        if let Some(path) = &arguments.report {
            let close_ups = gallery.close_ups(&overlapping, || progress.step());
            let page = html(&title(arguments), &self.document, &overview, &close_ups)?;
            outputs.stage(path, page.as_bytes())?;
        }
        Ok(())
    }
}

fn title(arguments: &CheckArguments) -> String {
    match &arguments.inputs[..] {
        [path] => format!("Contact in {}", path.display()),
        paths => format!("Contact of {} bodies", paths.len()),
    }
}

/// How long each phase took.
struct Times {
    start: Instant,
    phases: Vec<(&'static str, Duration)>,
}

impl Times {
    fn start() -> Self {
        Self { start: Instant::now(), phases: Vec::new() }
    }

    fn end_of(&mut self, phase: &'static str) {
        let before: Duration = self.phases.iter().map(|(_, time)| *time).sum();
        self.phases.push((phase, self.start.elapsed().saturating_sub(before)));
    }

    fn line(&self) -> String {
        let phases: Vec<String> = self
            .phases
            .iter()
            .map(|(phase, time)| format!("{phase} {:.2} s", time.as_secs_f64()))
            .collect();
        format!("{:.2} s: {}\n", self.start.elapsed().as_secs_f64(), phases.join(", "))
    }
}
