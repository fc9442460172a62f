//! `field`: signed distance field of a bone, with its accuracy.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use mesh_io::{FieldFormat, Space};
use musculo_collide::Progress;
use musculo_collide::distance_field::{DistanceField, FieldMethod, FieldParams, Storage};
use musculo_collide::kdop::Workspace;
use musculo_collide::proximity::SurfaceTree;
use musculo_collide::surface::mean_edge;

use super::Finished;
use crate::failure::Failure;
use crate::load::LoadedSurface;
use crate::output::{FilePlan, OutputFormat};
use crate::phase::Phase;
use crate::report::{BuiltRecord, FieldRecord};
use crate::stopwatch::Stopwatch;
use picture::draw_slices;

/// Build the signed distance field of a bone, and measure its accuracy
///
/// The field is a grid of distances to the surface, negative inside. It is compared with
/// exact distances near the surface; the report has the error and warnings of unreliable
/// parts. Open and damaged meshes are valid: their inside is where the winding number
/// exceeds one half.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide field femur.ply --out femur.nrrd
  musculo-collide field pelvis.stl --spacing 0.5 --out pelvis.vti --picture pelvis.png
  musculo-collide field femur.nrrd --out femur.vti
  musculo-collide field femur.ply --step 0.001 --out small.nrrd

NRRD opens in 3D Slicer, VTI in ParaView, in the place of the mesh. Both have 32-bit floats
in the mesh's frame and unit, or with --step multiples of the step in 16 bits, with the
step's length beside them. They also have the kind of node values: distances or, by default,
values up to an eighth of a spacing off, between which interpolation is accurate. NRRD names
the frame left-posterior-superior, which is 3D Slicer's for meshes that name none.")]
pub(crate) struct FieldArguments {
    /// Mesh (PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP or FEB), or field to show or convert (NRRD or VTI)
    #[arg(value_name = "MESH | FIELD")]
    input: PathBuf,

    #[command(flatten)]
    build: BuildArguments,

    /// Store distances as multiples of this length, in half the space: each is rounded by at
    /// most half a step
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    step: Option<f64>,

    /// Write the field
    #[arg(long, value_name = "FILE.nrrd | .vti")]
    out: Option<PathBuf>,

    /// Compress the field by gzip, as 3D Slicer does by default; for NRRD
    #[arg(long, requires = "out")]
    gzip: bool,

    /// Draw three slices through the deepest place: depth in color, level lines outside
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Parameters of a field, with lengths in the unit of the mesh.
#[derive(Debug, Args)]
struct BuildArguments {
    /// Part of a model of FEBio, Abaqus or Gmsh that is the body, by its name; may be given several times
    #[arg(long, value_name = "NAME")]
    part: Vec<String>,

    /// Distance between nodes [default: half the mean edge]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    spacing: Option<f64>,

    /// Distance from the mesh to the border of the grid [default: 10 spacings]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    padding: Option<f64>,

    /// Algorithm that computes the distances [default: band]
    #[arg(long, value_name = "METHOD")]
    method: Option<MethodName>,

    /// Largest distance that is stored; 0 for no limit [default: 15 spacings]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    truncate: Option<f64>,
}

/// Algorithm that computes the distances of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// Exact distances in a band; beyond it to the face closest to the nearest band node
    Band,
    /// Voxels and a distance transform: errors of half a spacing; closed meshes only
    Voxel,
}

/// Spacing in mean edges of the mesh: its details are about as large as its edges.
const SPACING_IN_EDGES: f64 = 0.5;

pub(super) fn run(arguments: &FieldArguments) -> Result<Finished, Failure> {
    // Read the field, or build that of a mesh.
    let mut stopwatch = Stopwatch::start();
    let out = arguments.out.as_deref();
    let out_format = out.map(|path| arguments.format_of(path)).transpose()?;
    let plan = FilePlan::reading([arguments.input.clone()]).writing(arguments.out.as_ref());
    let plan = plan.writing_as(OutputFormat::PICTURE, arguments.picture.as_ref());
    let plan = plan.writing(arguments.json.as_ref());
    let mut outputs = plan.open()?;

    let is_field = FieldFormat::of(&arguments.input).is_some();
    let (field, built) = if is_field {
        (arguments.read()?, None)
    } else {
        let (field, built) = arguments.build(out_format)?;
        (field, Some(built))
    };
    let record = FieldRecord::new(arguments.input.display().to_string(), &field, built);
    stopwatch.lap(if is_field { "read" } else { "build" });

    if let (Some(path), Some(format)) = (out, out_format) {
        outputs.stage(path, format.encode(&field))?;
    }
    if let Some(path) = &arguments.picture {
        outputs.stage(path, draw_slices(&field).to_png()?)?;
    }
    outputs.stage_json(arguments.json.as_deref(), &record)?;
    Ok(Finished { outputs, text: record.to_text(), holds: true, stopwatch })
}

impl FieldArguments {
    /// Returns the format of the field that is written.
    fn format_of(&self, path: &Path) -> Result<FieldFormat, Failure> {
        let Some(format) = FieldFormat::of(path) else {
            let problem = "unknown format of a field: expected .nrrd or .vti";
            return Err(Failure::in_file(path, problem));
        };
        if !self.gzip {
            return Ok(format);
        }
        match format.compressed() {
            Some(compressed) => Ok(compressed),
            None => Err(Failure::in_file(path, "--gzip needs a field in .nrrd")),
        }
    }

    /// Reads a field, and stores it in steps if there is a length for them.
    fn read(&self) -> Result<DistanceField, Failure> {
        // The grid of a file is as it is.
        let BuildArguments { part, spacing, padding, method, truncate } = &self.build;
        let lengths = [spacing, padding, truncate];
        if !part.is_empty() || method.is_some() || lengths.iter().any(|length| length.is_some()) {
            let problem = "is a field already: --part, --spacing, --padding, --method and --truncate need \
                           a mesh";
            return Err(Failure::in_file(&self.input, problem));
        }

        let _phase = Phase::start("reading");
        let field = mesh_io::read_field(&self.input)?;

        // Steps round the values; the kind of node values is kept.
        let Some(step) = self.step else { return Ok(field) };
        let storage = Storage::Quantized { step };
        let quantized = DistanceField::from_values(*field.grid(), field.values(), storage);
        let quantized = quantized.map_err(|error| Failure::in_file(&self.input, error))?;
        Ok(quantized.with_node_values(field.node_values()))
    }

    fn build(&self, out: Option<FieldFormat>) -> Result<(DistanceField, BuiltRecord), Failure> {
        let mesh = LoadedSurface::read(&self.input, &self.build.part)?;
        let is_nrrd = matches!(out, Some(FieldFormat::Nrrd | FieldFormat::GzipNrrd));
        if is_nrrd && mesh.space == Some(Space::RightAnteriorSuperior) {
            let problem = "a mesh in the space RAS has no field in NRRD, which is written in LPS: save \
                           the mesh in LPS, or write the field as .vti";
            return Err(Failure::in_file(&self.input, problem));
        }
        let (surface, x) = (&mesh.surface, mesh.positions());

        // Details of a mesh are about as large as its edges.
        let params = self.params(SPACING_IN_EDGES * mean_edge(surface, x));
        let field = Phase::run("building the field", |progress| {
            DistanceField::build(surface, x, &params, progress)
        });
        let field = field.map_err(|error| Failure::in_file(&self.input, error))?;
        let refused = |error| Failure::in_file(&self.input, error);

        // Faces within a body are as near as those around it.
        let positions = x.as_slice().to_vec();
        let tree = SurfaceTree::new(surface.clone(), positions).map_err(refused)?;
        let crossings = tree.self_crossings(&mut Workspace::default(), Progress::none());

        let built = BuiltRecord {
            self_crossings: crossings.map_or(0, |crossings| crossings.len()),
            vertices: surface.vertex_count(),
            faces: surface.faces().len(),
            params,
            report: field.report().clone(),
        };
        Ok((field, built))
    }

    fn params(&self, default_spacing: f64) -> FieldParams {
        let BuildArguments { spacing, padding, method, truncate, .. } = self.build;
        let default = FieldParams::new(spacing.unwrap_or(default_spacing));
        FieldParams {
            padding: padding.unwrap_or(default.padding),
            method: match method {
                Some(MethodName::Voxel) => FieldMethod::VOXEL,
                Some(MethodName::Band) | None => FieldMethod::EXACT_BAND,
            },
            truncation: match truncate {
                Some(0.0) => None,
                given => given.or(default.truncation),
            },
            storage: match self.step {
                Some(step) => Storage::Quantized { step },
                None => default.storage,
            },
            ..default
        }
    }
}
