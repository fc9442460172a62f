//! `medial`: a muscle as balls, and how near they come to it.

use std::cell::Cell;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use glam::DVec3;
use mesh_io::{PointValues, write_vtp};
use musculo_collide::kdop::Workspace;
use musculo_collide::medial::{
    Generated, MedialError, MedialParams, MedialSurface, PrimitiveTree, Step, Topology, generate,
};
use musculo_collide::surface::TriangleSurface;
use rayon::prelude::*;

use super::{Failure, Outcome, in_threads};
use crate::output::Outputs;
use crate::picture::balls_and_error;
use crate::progress::Progress;
use crate::report::{MedialRecord, medial_table};

/// Make a medial surface of a muscle: balls, and the cones and slabs between them
///
/// A hundred balls say what thousands of faces say. How far balls and surface are
/// from each other is bounded in both directions, and told. The mesh must be one
/// closed surface that does not cross itself.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide medial psoas.ply --out psoas.ma
  musculo-collide medial gluteus.stl --balls 200 --picture gluteus.png
  musculo-collide medial iliacus.ply --tolerance 1.5 --vtp iliacus.vtp

A .ma file is text: a line of counts, then v x y z radius, e and f with the numbers of
two and of three balls, from 0. The picture shows the balls in the surface, and beside
it the surface in the colours of its distance from them; the VTP file has that distance
at each vertex, positive outside of the balls.

Exit status: 0 it worked, 2 bad input or usage.")]
pub(crate) struct MedialArguments {
    /// A mesh: PLY, OBJ, STL or VTP
    #[arg(value_name = "MESH")]
    input: PathBuf,

    /// Make so many balls [default: 100]
    #[arg(long, value_name = "N", conflicts_with = "tolerance")]
    balls: Option<usize>,

    /// Make as few balls as come within this length, in both directions
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Write the medial surface
    #[arg(long, value_name = "FILE.ma")]
    out: Option<PathBuf>,

    /// Draw the balls in the surface, and the error in colour
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,

    /// Write the surface with its distance from the balls
    #[arg(long, value_name = "FILE.vtp")]
    vtp: Option<PathBuf>,

    /// Write everything that is reported as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Threads to use; the answer is the same for any number [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

const DEFAULT_BALLS: usize = 100;

/// A surface where it is.
struct Mesh {
    surface: TriangleSurface,
    positions: Vec<DVec3>,
}

pub(super) fn run(arguments: &MedialArguments) -> Result<Outcome, Failure> {
    in_threads(arguments.threads, || medial(arguments))
}

fn medial(arguments: &MedialArguments) -> Result<Outcome, Failure> {
    let path = &arguments.input;
    let mesh = read_mesh(path)?;
    let start = Instant::now();
    let Generated { medial, deviation } =
        make(&mesh, &params(arguments)).map_err(|error| named(path, error))?;
    let seconds = start.elapsed().as_secs_f64();
    let topologies = topologies(&mesh, &medial).map_err(|error| named(path, error))?;
    let sizes = [mesh.positions.len(), mesh.surface.faces().len()];
    let name = path.display().to_string();
    let record = MedialRecord::new(name, sizes, &medial, deviation, topologies);
    let written = write(arguments, &mesh, &medial, &record)?;

    let mut text = medial_table(&record);
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    text += &format!("{seconds:.2} s\n");
    // Whoever closed standard output has read enough; the exit status tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    Ok(Outcome::Clean)
}

fn params(arguments: &MedialArguments) -> MedialParams {
    match arguments.tolerance {
        Some(tolerance) => MedialParams::tolerance(tolerance),
        None => MedialParams::balls(arguments.balls.unwrap_or(DEFAULT_BALLS)),
    }
}

fn read_mesh(path: &Path) -> Result<Mesh, Failure> {
    let _progress = Progress::start("reading", 1);
    let mesh = mesh_io::read_mesh(path)?;
    let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces);
    Ok(Mesh { surface: surface.map_err(|error| named(path, error))?, positions: mesh.positions })
}

fn make(mesh: &Mesh, params: &MedialParams) -> Result<Generated, MedialError> {
    let x = mesh.surface.positions(&mesh.positions)?;
    let progress = Progress::start("fitting balls", FIT_STEPS);
    let done = Cell::new(0);
    generate(&mesh.surface, x, params, |now| {
        // A search for a tolerance fits several times: the bar begins anew.
        let at = match now.step {
            Step::Inspect | Step::Shrink | Step::Collapse => 0,
            Step::Fit => twentieths(now.share),
            Step::Measure => FIT_STEPS,
        };
        if at < done.get() {
            progress.restart();
            done.set(0);
        }
        for _ in done.replace(at)..at {
            progress.step();
        }
    })
}

/// Steps of the bar.
const FIT_STEPS: usize = 20;

fn twentieths(share: f64) -> usize {
    (1..=20_u8).take_while(|&step| share >= f64::from(step) / 20.0).count()
}

/// That of the union of balls, and that of the inside of the surface.
fn topologies(mesh: &Mesh, medial: &MedialSurface) -> Result<[Option<Topology>; 2], MedialError> {
    let _progress = Progress::start("counting parts and holes", 1);
    let mut radii: Vec<f64> = medial.balls().iter().map(|ball| ball.radius).collect();
    radii.sort_by(f64::total_cmp);
    let spacing = radii[radii.len() / 2] / CELLS_A_RADIUS;
    let x = mesh.surface.positions(&mesh.positions)?;
    let inside = Topology::of_inside(&mesh.surface, x)?;
    // None where the balls are too small for their number of cells.
    Ok([Topology::of_union(medial, spacing).ok(), Some(inside)])
}

/// Cells of the grid on which parts and holes are counted, along a radius: half as
/// many lose necks of an eighth of the thickness, twice as many take eight times as
/// long.
const CELLS_A_RADIUS: f64 = 8.0;

fn write(
    arguments: &MedialArguments,
    mesh: &Mesh,
    medial: &MedialSurface,
    record: &MedialRecord,
) -> Result<Vec<PathBuf>, Failure> {
    let _progress = Progress::start("writing", 1);
    let mut outputs = Outputs::default();
    if let Some(path) = &arguments.out {
        outputs.stage(path, medial.to_ma().as_bytes())?;
    }
    let named = |error| named(&arguments.input, error);
    let distances = match (&arguments.picture, &arguments.vtp) {
        (None, None) => Vec::new(),
        _ => distances(mesh, medial).map_err(named)?,
    };
    let (x, faces) = (&mesh.positions, mesh.surface.faces());
    if let Some(path) = &arguments.picture {
        let balls = medial.balls().iter().map(|ball| (ball.center, ball.radius));
        let picture = balls_and_error(x, faces, &balls.collect::<Vec<_>>(), &distances);
        outputs.stage(path, &picture.to_png()?)?;
    }
    if let Some(path) = &arguments.vtp {
        let values = [PointValues::Scalars("medial_distance", &distances)];
        outputs.stage(path, write_vtp(x, faces, &values).as_bytes())?;
    }
    if let Some(path) = &arguments.json {
        let mut json = serde_json::to_string_pretty(record)?;
        json.push('\n');
        outputs.stage(path, json.as_bytes())?;
    }
    Ok(outputs.commit()?)
}

/// Signed distances of the vertices from the union of balls.
fn distances(mesh: &Mesh, medial: &MedialSurface) -> Result<Vec<f64>, MedialError> {
    let tree = PrimitiveTree::new(medial)?;
    let distance =
        |workspace: &mut Workspace, p: &DVec3| tree.nearest(medial, *p, workspace).foot.distance;
    Ok(mesh.positions.par_iter().map_init(Workspace::default, distance).collect())
}

fn named(path: &Path, problem: impl std::fmt::Display) -> Failure {
    Failure::new(vec![format!("{}: {problem}", path.display())])
}
