//! `field`: build the signed distance field of a bone, and say how exact it is.

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use mesh_io::FieldFormat;
use musculo_collide::distance_field::{DistanceField, FieldMethod, FieldParams, Storage};
use musculo_collide::surface::{TriangleSurface, progress};

use super::{Failure, Outcome, in_threads};
use crate::output::Outputs;
use crate::picture::slices;
use crate::progress::Progress;
use crate::report::{BuiltRecord, FieldRecord, field_table};

/// Build the signed distance field of a bone, and say how exact it is
///
/// The field is a grid of distances to the surface, negative inside. It is
/// compared with exact distances near the surface before it is written, and
/// what makes it unreliable is told. Open and damaged meshes are taken: inside
/// is where their winding number passes one half.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide field femur.ply --out femur.nrrd
  musculo-collide field pelvis.stl --spacing 0.5 --out pelvis.vti --picture pelvis.png
  musculo-collide field femur.nrrd --out femur.vti
  musculo-collide field femur.ply --step 0.001 --out small.nrrd

NRRD opens in 3D Slicer, VTI in ParaView, in the place of the mesh: both hold 32-bit
floats in the mesh's own frame and unit, or with --step whole steps in 16 bits, beside
which they say how long a step is. They also say whether nodes hold distances or, as by
default, values up to an eighth of a spacing off, between which interpolation is right.
NRRD calls the frame left-posterior-superior, as 3D Slicer does with meshes that name none.

Exit status: 0 it worked, 2 bad input or usage.")]
pub(crate) struct FieldArguments {
    /// A mesh (PLY, OBJ, STL or VTP), or a field to show or convert (NRRD or VTI)
    #[arg(value_name = "MESH | FIELD")]
    input: PathBuf,

    #[command(flatten)]
    build: BuildArguments,

    /// Keep distances as whole steps of this length, in half the room: each is off by
    /// half a step at most
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    step: Option<f64>,

    /// Write the field
    #[arg(long, value_name = "FILE.nrrd | .vti")]
    out: Option<PathBuf>,

    /// Draw three slices through the deepest place: depth in colour, level lines outside
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,

    /// Write everything that is reported as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

/// How a mesh becomes a field; lengths are in its unit.
#[derive(Debug, Args)]
struct BuildArguments {
    /// Distance between nodes [default: 1]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    spacing: Option<f64>,

    /// Room around the mesh [default: 10]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    padding: Option<f64>,

    /// How distances are found [default: band]
    #[arg(long, value_name = "METHOD")]
    method: Option<MethodName>,

    /// Largest distance that is told apart; 0 for no limit [default: 15]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    truncate: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// Exact distances in a band, and beyond it to the nearest band node's face
    Band,
    /// Voxels and a distance transform: half a spacing wrong; closed meshes only
    Voxel,
}

/// Distance between nodes where none is asked for: a bone in millimeters.
const SPACING: f64 = 1.0;

/// Room around a mesh where none is asked for, as much at every spacing.
const PADDING: f64 = 10.0;

/// Largest distance that is kept where none is asked for, as much at every spacing.
const TRUNCATION: f64 = 15.0;

impl BuildArguments {
    fn params(&self) -> FieldParams {
        let method = match self.method {
            Some(MethodName::Voxel) => FieldMethod::VOXEL,
            Some(MethodName::Band) | None => FieldMethod::EXACT_BAND,
        };
        let truncation = self.truncate.unwrap_or(TRUNCATION);
        FieldParams {
            padding: self.padding.unwrap_or(PADDING),
            method,
            truncation: (truncation != 0.0).then_some(truncation),
            ..FieldParams::new(self.spacing.unwrap_or(SPACING))
        }
    }

    fn are_given(&self) -> bool {
        let Self { spacing, padding, method, truncate } = self;
        method.is_some() || [spacing, padding, truncate].iter().any(|length| length.is_some())
    }
}

pub(super) fn run(arguments: &FieldArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || field(arguments))
}

fn field(arguments: &FieldArguments) -> Result<Outcome, Failure> {
    let out = arguments.out.as_deref().map(with_format).transpose()?;
    let start = Instant::now();
    let (field, record) = match FieldFormat::of(&arguments.input) {
        Some(_) => read_field(arguments)?,
        None => build_field(arguments)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    let written = write(arguments, out, &field, &record)?;

    let mut text = field_table(&record);
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    if record.built.is_some() {
        text += &format!("{seconds:.2} s to build\n");
    }
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(Outcome::Clean)
}

fn with_format(path: &Path) -> Result<(&Path, FieldFormat), Failure> {
    let problem = "is of no format that a field is written in: expected .nrrd or .vti";
    let format = FieldFormat::of(path).ok_or_else(|| named(path, problem))?;
    Ok((path, format))
}

fn read_field(arguments: &FieldArguments) -> Result<(DistanceField, FieldRecord), Failure> {
    let path = &arguments.input;
    if arguments.build.are_given() {
        let problem = "is a field already: --spacing, --padding, --method and --truncate build one";
        return Err(named(path, problem));
    }
    let _progress = Progress::start("reading", 1);
    let mut field = mesh_io::read_field(path)?;
    if let Some(step) = arguments.step {
        let (storage, nodes) = (Storage::Quantized { step }, field.node_values());
        field = DistanceField::from_values(*field.grid(), field.values(), storage)
            .map_err(|error| named(path, error))?
            .with_node_values(nodes);
    }
    let record = FieldRecord::new(path.display().to_string(), &field, None);
    Ok((field, record))
}

fn build_field(arguments: &FieldArguments) -> Result<(DistanceField, FieldRecord), Failure> {
    let path = &arguments.input;
    let mesh = {
        let _progress = Progress::start("reading", 1);
        mesh_io::read_mesh(path)?
    };
    let _progress = Progress::start("building the field", 1);
    let sizes = [mesh.positions.len(), mesh.faces.len()];
    let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces);
    let surface = surface.map_err(|error| named(path, error))?;
    let x = surface.positions(&mesh.positions).map_err(|error| named(path, error))?;
    let mut params = arguments.build.params();
    if let Some(step) = arguments.step {
        params.storage = Storage::Quantized { step };
    }
    let field = DistanceField::build(&surface, x, &params, progress::Progress::none());
    let field = field.map_err(|error| named(path, error))?;
    let built = BuiltRecord::new(sizes, params, field.report());
    let record = FieldRecord::new(path.display().to_string(), &field, Some(built));
    Ok((field, record))
}

fn named(path: &Path, problem: impl std::fmt::Display) -> Failure {
    Failure::new(vec![format!("{}: {problem}", path.display())])
}

fn write(
    arguments: &FieldArguments,
    out: Option<(&Path, FieldFormat)>,
    field: &DistanceField,
    record: &FieldRecord,
) -> Result<Vec<PathBuf>, Failure> {
    let _progress = Progress::start("writing", 1);
    let mut outputs = Outputs::default();
    if let Some((path, format)) = out {
        outputs.stage(path, &format.encode(field))?;
    }
    if let Some(path) = &arguments.picture {
        outputs.stage(path, &slices(field).to_png()?)?;
    }
    if let Some(path) = &arguments.json {
        let mut json = serde_json::to_string_pretty(record)?;
        json.push('\n');
        outputs.stage(path, json.as_bytes())?;
    }
    Ok(outputs.commit()?)
}
