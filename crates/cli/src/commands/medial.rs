//! `medial`: medial surface of a muscle, with its deviation.

use std::path::{Path, PathBuf};

use clap::Args;
use mesh_io::{PointValues, write_vtp};
use musculo_collide::Progress;
use musculo_collide::kdop::Workspace;
use musculo_collide::medial::{
    Generated, MedialError, MedialParams, MedialSurface, PrimitiveTree, Topology, generate,
};
use rayon::prelude::*;

use super::Finished;
use crate::failure::Failure;
use crate::load::LoadedSurface;
use crate::output::{FilePlan, OutputFormat, Outputs};
use crate::phase::Phase;
use crate::report::MedialRecord;
use crate::stopwatch::Stopwatch;
use picture::draw_balls_and_error;

/// Generate the medial surface of a muscle: balls, with cones and slabs between them
///
/// A hundred balls represent thousands of faces. The deviation between balls and surface
/// is bounded in both directions, and reported. The mesh must be one closed surface
/// without self-crossings, which `check` lists.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide medial psoas.ply --out psoas.ma
  musculo-collide medial gluteus.stl --balls 200 --picture gluteus.png
  musculo-collide medial iliacus.ply --tolerance 1.5 --vtp iliacus.vtp

A .ma file is text: a line of counts, then v x y z radius, e and f with the numbers of two
and of three balls, from 0. The picture shows the balls in the surface, and beside it the
surface in the colors of its distance from them. The VTP file has that distance per vertex,
positive outside of the balls.")]
pub(crate) struct MedialArguments {
    /// Mesh: PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP or FEB
    #[arg(value_name = "MESH")]
    input: PathBuf,

    /// Part of a model of FEBio, Abaqus or Gmsh that is the body, by its name; may be given several times
    #[arg(long, value_name = "NAME")]
    part: Vec<String>,

    /// Number of balls
    #[arg(long, value_name = "N", default_value_t = 100, conflicts_with = "tolerance")]
    balls: usize,

    /// Largest deviation in both directions, with as few balls as it needs
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Write the medial surface
    #[arg(long, value_name = "FILE.ma")]
    out: Option<PathBuf>,

    /// Draw the balls in the surface, and the error in color
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,

    /// Write the surface with its distance from the balls
    #[arg(long, value_name = "FILE.vtp")]
    vtp: Option<PathBuf>,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Medial surface with its report, and the surface that it approximates.
struct MedialResult {
    mesh: LoadedSurface,
    medial: MedialSurface,
    record: MedialRecord,
}

pub(super) fn run(arguments: &MedialArguments) -> Result<Finished, Failure> {
    let mut stopwatch = Stopwatch::start();
    let path = &arguments.input;
    let mut outputs = arguments.plan().open()?;

    // Balls by number or by tolerance.
    let params = match arguments.tolerance {
        Some(tolerance) => MedialParams::tolerance(tolerance),
        None => MedialParams::balls(arguments.balls),
    };
    let mesh = LoadedSurface::read(path, &arguments.part)?;
    let result = MedialResult::compute(path, mesh, &params);
    let result = result.map_err(|error| refusal(path, error))?;
    stopwatch.lap("generate");

    result.stage(arguments, &mut outputs)?;
    Ok(Finished { outputs, text: result.record.to_text(), holds: true, stopwatch })
}

/// Returns the failure to represent a mesh, with the repair of one that crosses itself: balls
/// touch the surface from inside, which such a mesh does not define where it crosses.
fn refusal(path: &Path, error: MedialError) -> Failure {
    let repair = match error {
        MedialError::SelfCrossing { .. } => {
            "; `check` lists them with their places. Remove them and fill the holes (in MeshLab: \
             Select Self Intersecting Faces, Delete Selected Faces, Close Holes), or segment anew"
        }
        _ => "",
    };
    Failure::in_file(path, format!("{error}{repair}"))
}

impl MedialArguments {
    fn plan(&self) -> FilePlan {
        FilePlan::reading([self.input.clone()])
            .writing_as(OutputFormat::BALLS, self.out.as_ref())
            .writing_as(OutputFormat::PICTURE, self.picture.as_ref())
            .writing_as(OutputFormat::VTP, self.vtp.as_ref())
            .writing(self.json.as_ref())
    }
}

impl MedialResult {
    fn compute(
        path: &Path,
        mesh: LoadedSurface,
        params: &MedialParams,
    ) -> Result<Self, MedialError> {
        // The fit takes nearly all of the time, and has a bar of its own.
        let Generated { medial, deviation } = Phase::run("fitting balls", |progress| {
            generate(&mesh.surface, mesh.positions(), params, progress)
        })?;

        let union =
            Phase::run("counting parts and holes", |progress| union_topology(&medial, progress));
        let record = MedialRecord {
            file: path.display().to_string(),
            vertices: mesh.surface.vertex_count(),
            faces: mesh.surface.faces().len(),
            balls: medial.balls().len(),
            slabs: medial.slabs().len(),
            cones: medial.cones().len(),
            isolated_balls: medial.isolated_balls().len(),
            deviation,
            union,
            inside: Topology::of_inside(&mesh.surface, mesh.positions())?,
        };
        Ok(Self { mesh, medial, record })
    }

    /// Writes the files that the arguments name.
    fn stage(&self, arguments: &MedialArguments, outputs: &mut Outputs) -> Result<(), Failure> {
        let _phase = Phase::start("writing");
        if let Some(path) = &arguments.out {
            outputs.stage(path, self.medial.to_ma())?;
        }
        if arguments.picture.is_some() || arguments.vtp.is_some() {
            let distances = self.distances();
            let distances = distances.map_err(|error| Failure::in_file(&arguments.input, error))?;
            let (x, faces) = (self.mesh.positions().as_slice(), self.mesh.surface.faces());
            if let Some(path) = &arguments.picture {
                let picture = draw_balls_and_error(x, faces, self.medial.balls(), &distances);
                outputs.stage(path, picture.to_png()?)?;
            }
            if let Some(path) = &arguments.vtp {
                let values = [PointValues::Scalars("medial_distance", &distances)];
                outputs.stage(path, write_vtp(x, faces, &values, self.mesh.space))?;
            }
        }
        outputs.stage_json(arguments.json.as_deref(), &self.record)
    }

    /// Computes the signed distance of each vertex from the union of balls.
    fn distances(&self) -> Result<Vec<f64>, MedialError> {
        // Vertices are independent, and each finds its nearest primitive in a tree.
        let tree = PrimitiveTree::new(&self.medial)?;
        let distance = |workspace: &mut Workspace, p: &_| {
            tree.nearest(&self.medial, *p, workspace).foot.distance
        };
        Ok(self
            .mesh
            .positions()
            .as_slice()
            .par_iter()
            .map_init(Workspace::default, distance)
            .collect())
    }
}

/// Cells per radius of the grid on which parts and holes are counted: half as many lose
/// necks of an eighth of the thickness, twice as many take eight times as long.
const CELLS_PER_RADIUS: f64 = 8.0;

/// Counts parts and holes of the union of balls, unless the balls are too small for their
/// number of cells.
fn union_topology(medial: &MedialSurface, progress: Progress<'_>) -> Option<Topology> {
    // The median is not moved by the few smallest balls at the ends of a muscle.
    let mut radii: Vec<f64> = medial.balls().iter().map(|ball| ball.radius).collect();
    radii.sort_by(f64::total_cmp);
    let median = radii[radii.len() / 2];
    Topology::of_union(medial, median / CELLS_PER_RADIUS, progress).ok()
}
