//! `check`: overlaps and contacts of a scene at rest.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use clap::Args;
use mesh_io::Space;
use musculo_collide::{CheckParams, PairId, PairReport, Scene};

use super::Finished;
use super::joint_arguments::{JointArgs, joint_contacts};
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments};
use crate::output::{FilePlan, OutputFormat, Outputs};
use crate::phase::Phase;
use crate::report::{
    CheckDocument, ContactField, FileFolder, Gallery, LongTable, OverlapShape, PairContact,
    Pictures, ShownSurfaces, TableFrame, check_page, check_text, stage_contact_files,
    stage_overlap_files,
};
use crate::scene::SceneDescription;
use crate::stopwatch::Stopwatch;
use picture::Image;

/// Find every overlap and contact between bodies, and how deep
///
/// Reads closed or open triangle meshes, lists their defects, and reports for every pair
/// of bodies whether they overlap, how deep, by which volume and over what areas, or else how
/// far apart they are. The depth is that of the deepest point of one surface inside the other
/// body, faces and edges included: its distance from the other surface.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide check femur.ply vastus.ply --rigid femur
  musculo-collide check scene.toml --json contact.json --report contact.html

A scene file:
  unit = \"mm\"             # of all lengths; also um, cm, m, in
  margin = 1.0            # largest distance of a near pair

  [[body]]
  file = \"femur.ply\"      # relative to the folder of the scene file
  name = \"femur\"          # default: the file's name
  kind = \"rigid\"          # or deformable (default, unless it is rigid in its file), or open: a sheet
  follows = \"femur_r\"     # name in the motion; default: the body's name
  # parts = [\"Part1\"]     # of a model of FEBio, Abaqus or Gmsh: those that are this body

  [[ignore]]              # pair that overlaps on purpose
  a = \"femur\"
  b = \"cartilage\"")]
pub(crate) struct CheckArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Largest distance of a near pair, in the scene's unit [default: the scene's, or the mean
    /// edge length]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    margin: Option<f64>,

    /// Width of the certified brackets on depths, in the scene's unit [default: 1 % of the depth,
    /// or a hundred-thousandth of the smaller body where that is more]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    depth_tolerance: Option<f64>,

    #[command(flatten)]
    joint: JointArgs,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Write every number of every pair as a long table (.csv): subject, frame, time, a, b, measure,
    /// value
    #[arg(long, value_name = "FILE.csv")]
    table: Option<PathBuf>,

    /// Subject in the table [default: the first input]
    #[arg(long, value_name = "TEXT", requires = "table")]
    subject: Option<String>,

    /// Write VTP files for ParaView or 3D Slicer: each body with signed gap and depth per vertex;
    /// for each overlap the clipped faces (`a_in_b`, `b_in_a`) with depth per point, and the
    /// crossing curve; for each joint contact the faces (`a_on_b`, `b_on_a`) with gap and pressure
    #[arg(long, value_name = "DIR")]
    vtp: Option<PathBuf>,

    /// Write the report with pictures and tables, as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Write one picture of the contact from three sides
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

pub(super) fn run(arguments: &CheckArguments) -> Result<Finished, Failure> {
    let mut stopwatch = Stopwatch::start();
    let mut description = arguments.scene.describe()?;
    description.set_margin(arguments.margin)?;
    let mut outputs = arguments.plan(&description).open()?;
    let mut loaded = LoadedScene::load(description)?;
    let joint = arguments.joint.params(&mut loaded)?;
    stopwatch.lap("load");

    // Joint contact and the shapes of overlaps cost time: neither is computed unless requested.
    let reports = detect(&mut loaded, arguments.depth_tolerance)?;
    let mut document = loaded.document(&reports)?;
    let mut contacts = Vec::new();
    if let Some(params) = joint {
        let pairs: Vec<PairId> = reports.iter().map(|report| report.pair).collect();
        contacts = Phase::run("measuring joint contact", |progress| {
            joint_contacts(&mut loaded.scene, &pairs, &params, progress)
        })?;
        document.add_joint_contacts(params, &contacts, &loaded.scene);
    }
    let shapes = if arguments.draws_overlaps() {
        overlap_shapes(&mut loaded.scene, &reports)?
    } else {
        Vec::new()
    };
    stopwatch.lap("detect");

    // A failure below leaves no output behind: all are staged, and appear together at the end.
    outputs.stage_json(arguments.json.as_deref(), &document)?;
    if let Some(path) = &arguments.table {
        outputs.stage(path, arguments.long_table(&document)?)?;
    }
    let checked = CheckedScene {
        document: &document,
        scene: &loaded.scene,
        space: loaded.space,
        reports: &reports,
        shapes: &shapes,
        contacts: &contacts,
    };
    if let Some(folder) = &arguments.vtp {
        checked.stage_vtp(folder, &mut outputs)?;
    }
    checked.stage_pictures(arguments, &mut outputs)?;

    let holds = document.overlapping() == 0;
    Ok(Finished { outputs, text: check_text(&document), holds, stopwatch })
}

impl CheckArguments {
    fn plan(&self, description: &SceneDescription) -> FilePlan {
        let names = description.bodies.iter().map(|body| &*body.name);
        let plan = self.scene.plan(description);
        plan.writing(self.json.as_ref())
            .writing_as(OutputFormat::TABLE, self.table.as_ref())
            .writing_as(OutputFormat::REPORT, self.report.as_ref())
            .writing_as(OutputFormat::PICTURE, self.picture.as_ref())
            .writing_into(self.vtp.as_ref(), names.clone().map(body_file), names)
    }

    /// Writes the long table.
    fn long_table(&self, document: &CheckDocument) -> Result<Vec<u8>, Failure> {
        let subject = self.subject.clone();
        let first = || self.scene.inputs[0].display().to_string();
        let mut table = LongTable::new(subject.unwrap_or_else(first))?;
        for pair in &document.pairs {
            table.add_pair(TableFrame { frame: 0, time: None }, pair)?;
        }
        table.finish()
    }

    /// Returns true if an output shows the shape of overlaps.
    fn draws_overlaps(&self) -> bool {
        self.vtp.is_some() || self.report.is_some() || self.picture.is_some()
    }
}

/// Returns the name of a body's VTP file.
fn body_file(name: &str) -> String {
    format!("{name}.vtp")
}

/// Checks a scene with its margin.
pub(super) fn detect(
    loaded: &mut LoadedScene,
    depth_tolerance: Option<f64>,
) -> Result<Vec<PairReport>, Failure> {
    let params = CheckParams { depth_tolerance, ..CheckParams::new(loaded.margin()) };
    Ok(Phase::run("detecting contact", |progress| loaded.scene.check(&params, progress))?)
}

/// Computes the shape of every overlap.
pub(super) fn overlap_shapes<'r>(
    scene: &mut Scene,
    reports: &'r [PairReport],
) -> Result<Vec<OverlapShape<'r>>, Failure> {
    let (mut overlapping, mut pairs) = (Vec::new(), Vec::new());
    for report in reports {
        if report.overlaps {
            overlapping.push(report);
            pairs.push(report.pair);
        }
    }

    let geometries = Phase::run("clipping", |progress| scene.overlap_geometries(&pairs, progress))?;
    let mut shapes = Vec::with_capacity(pairs.len());
    for (report, geometry) in overlapping.into_iter().zip(geometries) {
        shapes.push(OverlapShape { report, geometry });
    }
    Ok(shapes)
}

/// Scene with the results of its check.
pub(super) struct CheckedScene<'a> {
    pub(super) document: &'a CheckDocument,
    pub(super) scene: &'a Scene,
    /// Space that the files of the scene state.
    pub(super) space: Option<Space>,
    pub(super) reports: &'a [PairReport],
    /// Shapes of the overlaps.
    pub(super) shapes: &'a [OverlapShape<'a>],
    /// Joint contacts, where they are measured.
    pub(super) contacts: &'a [PairContact],
}

impl CheckedScene<'_> {
    fn stage_vtp(&self, folder: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
        let bodies = self.scene.bodies().iter();
        let mut files =
            FileFolder::new(folder, bodies.map(|body| body_file(body.name())), self.space);
        for (id, body) in self.scene.ids().zip(self.scene.bodies()) {
            let field = ContactField::new(id, self.scene, self.reports, self.document.margin);
            let vtp = field.to_vtp(body.positions(), body.surface().faces(), self.space);
            outputs.stage(&folder.join(body_file(body.name())), vtp)?;
        }
        stage_overlap_files(self.shapes, self.scene, &mut files, outputs)?;
        stage_contact_files(self.contacts, "", self.scene, &mut files, outputs)
    }

    fn stage_pictures(
        &self,
        arguments: &CheckArguments,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        if let Some(path) = &arguments.picture {
            let gallery = self.gallery();
            let phase = Phase::with_steps("drawing", gallery.len());
            let views = gallery.overview(|| phase.step());
            let images: Vec<Image> = views.into_iter().map(|view| view.image).collect();
            outputs.stage(path, Image::beside(&images).to_png()?)?;
        }
        if let Some(path) = &arguments.report {
            let title = match &arguments.scene.inputs[..] {
                [input] => format!("Contact in {}", input.display()),
                inputs => format!("Contact of {} bodies", inputs.len()),
            };
            outputs.stage(path, self.page(&title, &OnceCell::new())?)?;
        }
        Ok(())
    }

    /// Writes a report with pictures of the scene and of each overlap. Its surfaces are those of an
    /// earlier state, if there are any.
    pub(super) fn page(
        &self,
        title: &str,
        surfaces: &OnceCell<ShownSurfaces>,
    ) -> Result<String, Failure> {
        let gallery = self.gallery();
        let phase = Phase::with_steps("drawing", gallery.len() + self.contacts.len());
        let mut pictures = Pictures {
            overview: gallery.overview(|| phase.step()),
            close_ups: gallery.close_ups(|| phase.step()),
            joints: Vec::new(),
        };
        if let Some(params) = &self.document.joint_contact {
            pictures.joints = gallery.joint_views(self.contacts, params, || phase.step());
        }
        drop(phase);
        let _phase = Phase::start("preparing the scene that turns");
        let surfaces = surfaces.get_or_init(|| ShownSurfaces::new(self.scene));
        let model = gallery.model(surfaces, self.document.unit);
        Ok(check_page(title, self.document, &pictures, &model)?)
    }

    fn gallery(&self) -> Gallery<'_> {
        Gallery::new(self.scene, self.shapes)
    }
}
