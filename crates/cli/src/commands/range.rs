//! `range`: how far a joint turns before bodies meet.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use musculo_collide::surface::MAX_COORDINATE;
use musculo_collide::{BodyId, PairId, PathMove, RigidBodyPath, RigidPath, Scene, ccd};

use super::Finished;
use super::motion_until::{names, overlapping_pairs};
use super::range_map::{LastTurn, MapArguments};
use super::vector::Vector;
use crate::failure::Failure;
use crate::load::{LoadedScene, SceneArguments, files_of};
use crate::output::OutputFormat;
use crate::phase::Phase;
use crate::report::{FirstContactRecord, RangeDocument};
use crate::stopwatch::Stopwatch;

/// Turn bodies about an axis, and find the angle at which each pair first meets
///
/// The bodies turn rigidly about an axis through a center, the others rest. The angle of a first
/// contact is certified from below: before it, the surfaces do not meet. Pairs that overlap from the
/// start are named, and have no angle.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  musculo-collide range scene.toml --turn femur --axis 1,0,0 --center 0,12,850 --to 120
  musculo-collide range pelvis.ply femur.ply --turn femur --axis 0,0,-1 --center 90,-70,0 --to 45 --json rom.json
  musculo-collide range pelvis.ply femur.ply --turn femur --center 441,459,883 \\
    --over 1,0,0:0:120:31 --over 0,0,1:-30:30:31 --axis 0,-1,0 --to 60 --map hip.svg --cache hip.cells

With --over twice, each cell of a map has the angle at which bodies that turn first meet bodies that
rest, after two turns before. A cell that overlaps before the last turn has none.")]
pub(crate) struct RangeArguments {
    #[command(flatten)]
    scene: SceneArguments,

    /// Body that turns; may be given several times
    #[arg(long, required = true, value_name = "NAME")]
    turn: Vec<String>,

    /// Direction of the axis: the turn is right-handed about it
    #[arg(long, required = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis: Vector,

    /// Point on the axis, in the scene's unit
    #[arg(long, required = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    center: Vector,

    /// Largest angle, in degrees
    #[arg(long, required = true, value_name = "DEGREES", allow_negative_numbers = true)]
    to: f64,

    /// Write the report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    #[command(flatten)]
    map: MapArguments,
}

pub(super) fn run(arguments: &RangeArguments) -> Result<Finished, Failure> {
    let mut stopwatch = Stopwatch::start();
    let axis = arguments.check()?;
    arguments.map.check()?;
    let description = arguments.scene.describe()?;

    // Names are checked and outputs opened before meshes are read: mistakes are reported at once.
    let mut turning = Vec::new();
    for name in &arguments.turn {
        turning.push(description.index_of(name)?);
    }
    if (0..description.bodies.len()).all(|body| turning.contains(&body)) {
        return Err(Failure::new("--turn leaves no body at rest that another one could meet"));
    }
    let mut inputs = files_of(&description);
    inputs.extend(arguments.scene.inputs.iter().cloned());
    let plan = arguments.scene.plan(&description).writing(arguments.json.as_ref());
    let plan = plan.writing_as(OutputFormat::CHART, arguments.map.map.as_ref());
    let plan = plan.writing_as(OutputFormat::TABLE, arguments.map.table.as_ref());
    let mut outputs = plan.reading_too(arguments.map.cache.clone()).open()?;
    let mut loaded = LoadedScene::load(description)?;
    let ids: Vec<BodyId> = loaded.scene.ids().collect();
    let turning: Vec<BodyId> = turning.into_iter().map(|body| ids[body]).collect();
    stopwatch.lap("load");

    // A map is a result of its own: the last turn up to contact, over two turns before it.
    if arguments.map.is_map() {
        let (center, to) = (arguments.center, arguments.to);
        let last = LastTurn { turning: &turning, axis: Vector(axis), center, to };
        let map = arguments.map.compute(&loaded.scene, &last, &inputs)?;
        stopwatch.lap("map");
        if let Some(path) = &arguments.map.table {
            outputs.stage(path, map.to_csv()?)?;
        }
        if let Some(path) = &arguments.map.map {
            let picture = map.to_svg().map_err(|error| Failure::new(error.to_string()))?;
            outputs.stage(path, picture)?;
        }
        return Ok(Finished { outputs, text: map.to_text(), holds: true, stopwatch });
    }

    // What overlaps at the start has no first contact.
    let overlapping = overlapping_pairs(&mut loaded.scene)?;
    stopwatch.lap("check");

    // All bodies that turn share one path, and so keep their places relative to each other.
    let path = RigidPath::turn(arguments.center.0, axis, arguments.to.to_radians());
    let mut starts = Vec::new();
    for &body in &turning {
        starts.push(loaded.scene.body(body).positions().to_vec());
    }
    let mut turns = Vec::new();
    for from in &starts {
        turns.push(RigidBodyPath { from, path });
    }
    let mut moves = Vec::new();
    for (&body, path) in turning.iter().zip(&turns) {
        moves.push(PathMove { body, path });
    }
    let swept = Phase::run("turning", |progress| {
        loaded.scene.first_contacts(&moves, &ccd::CcdParams::EXACT, progress)
    })?;
    stopwatch.lap("sweep");

    let document = RangeDocument {
        unit: loaded.description.unit,
        to: arguments.to,
        overlapping: names(&loaded.scene, &overlapping),
        contacts: contacts(&loaded.scene, &swept, &overlapping, &moves, arguments.to),
    };
    outputs.stage_json(arguments.json.as_deref(), &document)?;
    Ok(Finished { outputs, text: document.to_text(), holds: true, stopwatch })
}

impl RangeArguments {
    /// Checks the axis, the center and the angle, and returns the direction of the axis.
    fn check(&self) -> Result<DVec3, Failure> {
        if !self.to.is_finite() || self.to.abs() > 360.0 {
            let problem =
                format!("--to is {}, but must be within a full turn, 360 degrees", self.to);
            return Err(Failure::new(problem));
        }
        let of_center = self.center.0.to_array();
        if let Some(far) = of_center.into_iter().find(|x| x.abs() > MAX_COORDINATE) {
            let problem = format!(
                "--center has the coordinate {far:e}, but magnitudes end at {MAX_COORDINATE:e}"
            );
            return Err(Failure::new(problem));
        }
        let axis = self.axis.0.try_normalize();
        axis.ok_or_else(|| {
            Failure::new(format!("--axis is {}, which has no direction", self.axis.0))
        })
    }
}

/// Returns the first contacts of pairs that do not overlap at the start, by angle.
fn contacts(
    scene: &Scene,
    swept: &musculo_collide::SweepReport,
    overlapping: &BTreeSet<PairId>,
    moves: &[PathMove<'_>],
    to: f64,
) -> Vec<FirstContactRecord> {
    let mut records = Vec::new();
    for pair in &swept.pairs {
        let Some(first) = pair.contacts.first() else { continue };
        if overlapping.contains(&pair.pair) {
            continue;
        }

        let at = scene.contact_place(pair.pair, first, moves);
        let [a, b] = scene.names(pair.pair).map(str::to_owned);
        let angle = first.contact.time.unwrap_or(1.0) * to;
        records.push(FirstContactRecord { a, b, angle, certain: first.certain, at: at.to_array() });
    }
    records.sort_by(|p, q| p.angle.abs().total_cmp(&q.angle.abs()));
    records
}
