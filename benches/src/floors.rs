//! Times per unit of work beside the time that its memory alone takes, and what two threads gain.
//!
//! The memory of a piece of work is what it reads and writes at least, each byte once per pass. Its
//! time is that of a sweep over as many bytes, in turns with the work: in the same caches, on the
//! same machine and under the same load.

use std::error::Error;
use std::fmt::Write;

use ::ccd::{CcdParams, MovingPoints};
use distance_field::{DistanceField, FieldParams};
use fixtures::femur::femur;
use fixtures::muscle::{Muscle, Placement, scene};
use kdop::{Leaves, Tree, Workspace};
use musculo_collide::{Detection, Plan, PlanParams, Progress};
use rayon::ThreadPool;

use crate::ccd::queries::{QueryKind, random};
use crate::chart::size::operations::{Operation, Spheres};
use crate::measure::{Pace, Report, Side, as_f64, busiest_times, interleave, pool};

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 700;

/// Rounds of what takes long.
const ROUNDS: u32 = 7;

/// Bytes per node of a field that its passes read and write: two lists set to zero (8), the band (8),
/// the faces that rows, columns and planes carry (3 × 10), distances measured (12), signs (9) and
/// the prefilter (8).
const FIELD_BYTES: f64 = 75.0;

/// Bytes per candidate of a swept query: four points at two ends, and their numbers.
const CANDIDATE_BYTES: f64 = 4.0 * 2.0 * 24.0 + 16.0;

/// Splits of the spheres that threads share, and of smaller ones that are pushed apart beside them.
const LEVEL: u32 = 5;
const SMALL_LEVEL: u32 = 3;

/// Bytes of the sweep that two threads share: far more than caches hold.
const SWEPT_BYTES: usize = 1 << 28;

/// Returns the tables, in Markdown.
///
/// # Errors
///
/// When no thread can be started, or a scene cannot be set up.
pub fn tables() -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "| work, one thread | units | bytes per unit | ns per unit | of memory [ns] | times memory |\n|---|---|---|---|---|---|\n",
    );
    pool(1)?.install(|| {
        for (faces, size) in [(6500, "6.5k faces"), (80_000, "80k faces")] {
            trees(&mut text, size, &scene(faces, Placement::Oblique).a);
        }
        fields(&mut text);
        queries(&mut text);
    });

    text += "\n| work of two threads | one thread [ms] | busier of two [ms] | gain |\n|---|---|---|---|\n";
    gains(&mut text, [pool(1)?, pool(2)?])?;
    Ok(text)
}

/// Work on a number of units, and the bytes that each needs.
struct Work<'a> {
    name: String,
    units: usize,
    bytes_per_unit: f64,
    run: &'a mut dyn FnMut() -> usize,
}

/// Adds a row: the work in turns with a sweep over its bytes.
fn row(text: &mut String, pace: Option<Pace>, work: Work<'_>) {
    let Work { name, units, bytes_per_unit, run } = work;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a size in memory")]
    let memory = vec![1_u64; (bytes_per_unit * as_f64(units) / 8.0) as usize];
    let (mut ours, mut floor) = (|| run(), || sweep(&memory));
    let sides: [Side<'_>; 2] = [("work", &mut ours), ("memory", &mut floor)];
    let times = match pace {
        None => interleave(BUDGET, sides),
        Some(pace) => Report::new(1.0).measure("", pace, sides),
    };
    let [time, floor] = times.map(|time| time / as_f64(units));
    let _ = writeln!(
        text,
        "| {name} | {units} | {bytes_per_unit:.0} | {time:.2} | {floor:.2} | {:.1} |",
        time / floor
    );
}

/// Sums numbers, eight at a time.
fn sweep(memory: &[u64]) -> usize {
    let mut sums = [0_u64; 8];
    for eight in memory.chunks_exact(8) {
        for (sum, value) in sums.iter_mut().zip(eight) {
            *sum = sum.wrapping_add(*value);
        }
    }
    usize::try_from(sums.into_iter().fold(0, u64::wrapping_add)).unwrap_or(usize::MAX)
}

/// Refits of a tree, and its pairs with itself.
fn trees(text: &mut String, size: &str, muscle: &Muscle) {
    let built = Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]);
    let mut tree = built.expect("a valid mesh");
    let (units, points) = (tree.leaf_count(), as_f64(size_of_val(&*muscle.states[0])));
    let of_tree = as_f64(tree.bytes()) / as_f64(units);

    // Between two states, in turns.
    let mut turn = 0;
    let mut refit = || {
        turn = 1 - turn;
        tree.refit(&muscle.states[turn]).map_or(0, |()| 1)
    };
    let bytes_per_unit = of_tree + points / as_f64(units);
    let name = format!("refit of a tree, {size}");
    row(text, None, Work { name, units, bytes_per_unit, run: &mut refit });

    let mut workspace = Workspace::new();
    let mut pairs = || {
        let mut count = 0;
        tree.self_pairs(0.0, &mut workspace, |_, _| count += 1);
        count
    };
    let name = format!("pairs of a tree with itself, {size}");
    row(text, None, Work { name, units, bytes_per_unit: of_tree, run: &mut pairs });
}

/// A field of a bone of 80,000 vertices.
fn fields(text: &mut String) {
    let bone = femur(2.0);
    let surface = bone.surface();
    let x = surface.positions(&bone.positions).expect("a generated bone is finite");
    let params = FieldParams { samples: 0, ..FieldParams::new(1.0) };
    let build =
        || DistanceField::build(&surface, x, &params, Progress::none()).expect("a bone fits");
    let units = build().grid().node_count();
    let name = "field at 1 mm, per node".to_owned();
    let pace = Pace::long_calls(ROUNDS);
    let run = &mut || build().bytes();
    row(text, Some(pace), Work { name, units, bytes_per_unit: FIELD_BYTES, run });
}

/// Random swept queries of vertices and faces: all, and their filter.
fn queries(text: &mut String) {
    let set = random(QueryKind::VertexFace, 20_000);
    let ([x0, x1], candidates) = set.as_motion();
    let Ok(points) = MovingPoints::new(&x0, &x1) else { return };
    let units = candidates.len();
    let params = CcdParams::DEFAULT;
    let mut filter =
        || points.filter_vertex_faces(&candidates, &params).map_or(0, |left| left.len());
    let mut all =
        || points.vertex_face_contacts(&candidates, &params).map_or(0, |found| found.len());
    for (name, run) in [
        ("swept queries, filter", &mut filter as &mut dyn FnMut() -> usize),
        ("swept queries, all", &mut all),
    ] {
        let work = Work { name: name.to_owned(), units, bytes_per_unit: CANDIDATE_BYTES, run };
        row(text, None, work);
    }
}

/// Compares the processor time of the busier of two threads with that of one, for each operation and
/// for a sweep over memory.
fn gains(text: &mut String, pools: [ThreadPool; 2]) -> Result<(), Box<dyn Error>> {
    let memory = vec![1_u64; SWEPT_BYTES / 8];
    let parts: Vec<&[u64]> = memory.chunks(1 << 14).collect();
    gain(text, "sweep over memory", &pools, || {
        surface::parallel::map(parts.len(), |part| sweep(parts[part])).into_iter().sum()
    });
    for operation in [Operation::Check, Operation::Sweep, Operation::Field, Operation::Resolve] {
        let mut spheres = Spheres::with_muscles(LEVEL)?;
        gain(text, operation.name(), &pools, || operation.run(&mut spheres).unwrap_or(0));
    }
    let mut spheres = Spheres::with_muscles(SMALL_LEVEL)?;
    let name = format!("resolve, {} faces", spheres.faces());
    gain(text, &name, &pools, || Operation::Resolve.run(&mut spheres).unwrap_or(0));

    let mut spheres = Spheres::with_muscles(LEVEL)?;
    let params = PlanParams::with_tolerance(0.5);
    let mut plan = Plan::new(spheres.scene(), &params, Progress::none())?;
    let mut detection = Detection::default();
    gain(text, "plan, one frame", &pools, || {
        let moved = spheres.move_to_rest().is_ok();
        usize::from(moved && plan.detect(spheres.scene(), &mut detection).is_ok())
    });
    Ok(())
}

/// Adds a row: the time of one thread, and that of the busier of two.
fn gain(text: &mut String, name: &str, pools: &[ThreadPool; 2], run: impl FnMut() -> usize + Send) {
    let [one, two] = busiest_times(ROUNDS, pools, run);
    let _ = writeln!(text, "| {name} | {one:.1} | {two:.1} | {:.2} |", one / two);
}
