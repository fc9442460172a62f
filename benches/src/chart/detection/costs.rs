//! How long each kind of a plan's work takes: frames of several plans are timed, and the times of
//! single pieces of work are those that explain them best.
//!
//! Each plan is timed twice: where bodies touch, and far apart, where nothing is left but to follow
//! them.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use distance_field::Pose;
use glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, Detection, DetectionMethod, OperationCounts, Plan, PlanParams, Scene, machine_factor,
};

use super::question::{Pairs, Question};
use super::scene::{FRAMES, Moving};
use crate::chart::curves::machine;
use crate::chart::sheet::{Cell, Sheet};

/// Names of the kinds of work, in the order of [`OperationCounts::to_array`].
const KINDS: [&str; 5] = [
    "face refitted",
    "face compared with another body's",
    "vertex over a field",
    "vertex followed by balls",
    "vertex among balls",
];

/// Tolerances of the plans \[mm\].
const TOLERANCES: [f64; 5] = [2.0, 1.0, 0.5, 0.2, 0.1];

/// How many of these fields are asked for, which take memory, and balls, which take long to build.
const WITH_FIELDS: usize = 3;
const WITH_BALLS: usize = 2;

/// The frame in which muscles are pressed on the bone most, how often it is timed, and how far apart
/// muscles are put to be out of each other's reach.
const PRESSED: usize = FRAMES as usize / 2;
const ROUNDS: u32 = 25;
const AWAY: DVec3 = DVec3::new(1e4, 0.0, 0.0);

/// What a plan had to do in a frame, and how long that took on the reference machine.
struct Timed {
    plan: String,
    work: [f64; 5],
    seconds: f64,
}

/// Writes what each kind of work takes, and how well that explains the plans.
///
/// # Errors
///
/// When a file cannot be written, or a plan cannot be made.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let timed = pool.install(|| measure().map_err(|error| error.to_string()))?;
    let seconds = explain(&timed);
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (kind, (found, used)) in
        KINDS.iter().zip(seconds.iter().zip(OperationCounts::SECONDS.to_array()))
    {
        rows.push(vec![Cell::text(kind), Cell::Number(1e9 * found), Cell::Number(1e9 * used)]);
    }
    for Timed { plan, work, seconds } in &timed {
        let used = product(work, &OperationCounts::SECONDS.to_array());
        rows.push(vec![Cell::text(plan), Cell::Number(1e9 * seconds), Cell::Number(1e9 * used)]);
    }
    let settings = vec![("time", TIME.to_owned()), ("machine", machine())];
    let columns = vec!["work", "measured [ns]", "predicted [ns]"];
    Ok(Sheet { name: "costs", svg: None, settings, columns, rows }.write(folder)?)
}

const TIME: &str = "least of several frames, over the machine factor of the same moment; of the kinds of work, what explains the frames of all plans best";

fn measure() -> Result<Vec<Timed>, Box<dyn Error>> {
    let moving = Moving::fixture();
    let mut timed = Vec::new();
    for (of, method, count) in [
        (Pairs::Bone, DetectionMethod::Field, WITH_FIELDS),
        (Pairs::Bone, DetectionMethod::Surfaces, TOLERANCES.len()),
        (Pairs::Muscles, DetectionMethod::Surfaces, TOLERANCES.len()),
        (Pairs::Muscles, DetectionMethod::Medial, WITH_BALLS),
    ] {
        let question = Question::new(&moving, of)?;
        for tolerance in &TOLERANCES[..count] {
            timed.extend(frames(&question, method, *tolerance)?);
        }
    }
    Ok(timed)
}

/// Times of a plan's frames, near and away.
fn frames(
    question: &Question<'_>,
    method: DetectionMethod,
    tolerance: f64,
) -> Result<[Timed; 2], Box<dyn Error>> {
    let (mut scene, ids) = question.scene()?;
    for muscle in question.muscles() {
        scene.move_body(ids[muscle], &question.moving.frames[PRESSED][muscle])?;
    }
    let forced: Vec<(BodyId, BodyId, DetectionMethod)> =
        question.pairs.iter().map(|&[a, b]| (ids[a], ids[b], method)).collect();
    let mut plan = Plan::with_forced(&mut scene, &PlanParams::with_tolerance(tolerance), &forced)?;
    let title = |place: &str| format!("plan {method} within {tolerance} mm, {place}");
    let of_pairs =
        plan.pairs().iter().fold(OperationCounts::default(), |sum, pair| sum + pair.work);
    let all = plan.work().to_array();
    let follow = std::array::from_fn(|kind| all[kind] - of_pairs.to_array()[kind]);
    let mut of = |shift| least(&mut plan, &mut scene, question, &ids, shift);
    Ok([
        Timed { plan: title("in contact"), work: all, seconds: of(DVec3::ZERO)? },
        Timed { plan: title("apart"), work: follow, seconds: of(AWAY)? },
    ])
}

/// Returns the shortest time of a frame, over the machine factor.
fn least(
    plan: &mut Plan,
    scene: &mut Scene,
    question: &Question<'_>,
    ids: &[BodyId],
    shift: DVec3,
) -> Result<f64, Box<dyn Error>> {
    let mut detection = Detection::default();
    let (mut least, mut factor) = (f64::INFINITY, f64::INFINITY);
    for round in 0..ROUNDS {
        // Back and forth by next to nothing, so that all has to follow.
        let next = f64::from(1 + round % 2) * 1e-6;
        scene.pose_body(ids[0], &Pose::new(DQuat::IDENTITY, DVec3::splat(next)))?;
        for muscle in question.muscles() {
            let by = crate::ratio::amount(muscle) * shift + next;
            let pressed = question.moving.frames[PRESSED][muscle].iter();
            let x: Vec<DVec3> = pressed.map(|p| *p + by).collect();
            scene.move_body(ids[muscle], &x)?;
        }
        let start = Instant::now();
        plan.detect(scene, &mut detection)?;
        least = least.min(start.elapsed().as_secs_f64());
        factor = factor.min(machine_factor(|| start.elapsed()));
    }
    Ok(least / factor)
}

/// The times of single pieces of work, none negative, whose sums are nearest to what was measured,
/// in the ratio of both.
fn explain(timed: &[Timed]) -> [f64; 5] {
    const SWEEPS: u32 = 100_000;
    let rows: Vec<[f64; 5]> =
        timed.iter().map(|timed| timed.work.map(|count| count / timed.seconds)).collect();
    let mut seconds = [0.0; 5];
    for _ in 0..SWEEPS {
        for kind in 0..5 {
            let rest = |row: &[f64; 5]| 1.0 - product(row, &seconds) + row[kind] * seconds[kind];
            let along: f64 = rows.iter().map(|row| row[kind] * rest(row)).sum();
            let square: f64 = rows.iter().map(|row| row[kind] * row[kind]).sum();
            seconds[kind] = if square > 0.0 { (along / square).max(0.0) } else { 0.0 };
        }
    }
    seconds
}

fn product(a: &[f64; 5], b: &[f64; 5]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where this fails after the numbers were measured anew, [`OperationCounts::SECONDS`] is to follow them.
    /// They vary by a fifth from one run to the next.
    #[test]
    fn plans_predict_by_the_numbers_that_were_measured() {
        let numbers = include_str!("../../../../docs/chart/costs.csv");
        for (kind, used) in KINDS.iter().zip(OperationCounts::SECONDS.to_array()) {
            let row = numbers.lines().find(|line| line.trim_matches('"').starts_with(kind));
            let mut values = row.expect("a row a kind").rsplit(',').map(str::parse);
            let [_, measured]: [f64; 2] =
                std::array::from_fn(|_| values.next().expect("a value").expect("a number"));
            let ratio = 1e9 * used / measured;
            assert!((0.8..1.25).contains(&ratio), "{kind}: {measured} ns, {used} s in use");
        }
    }

    #[test]
    fn times_that_explain_all_frames_are_found() {
        let planted = [12e-9, 0.0, 150e-9, 90e-9, 400e-9];
        let timed: Vec<Timed> = (0..12_u32)
            .map(|row| {
                let count = |kind: u32| f64::from((7 * row + 11 * kind * kind + 3) % 13) * 1e3;
                let work = [0, 1, 2, 3, 4].map(count);
                Timed { plan: String::new(), work, seconds: product(&work, &planted) }
            })
            .collect();
        for (found, planted) in explain(&timed).iter().zip(planted) {
            assert!((found - planted).abs() < 1e-12, "{found} for {planted}");
        }
    }
}
