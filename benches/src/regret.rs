//! Regret of plans: time of construction and of all frames by the chosen plan, over that of forced
//! plans, as measured.
//!
//! Times are those of one thread on its processor, so that other load on the machine adds little.
//! Each plan is built and its frames are detected in turns with the others, as often as the clock's
//! steps need; numbers of frames are sums of both times. Plans that are alike have the same time.

use std::error::Error;
use std::time::Instant;

use fixtures::{Mesh, data, shapes, thigh};
use glam::{DQuat, DVec3};
use musculo_collide::{
    BodyKind, Detection, DetectionMethod, ForcedMethod, Plan, PlanError, PlanParams, Progress,
    Scene, SceneError, machine_factor,
};
use surface::Pose;

use crate::measure::thread_time;

/// Numbers of frames that plans are made for.
const FRAMES: [u32; 3] = [1, 100, 10_000];

const TOLERANCES: [f64; 3] = [2.0, 0.5, 0.1];

/// Rounds of a frame at least, and the time that they take at least \[s\], in which the clock makes
/// many steps. The same holds for what is built.
const MIN_ROUNDS: u32 = 3;
const MIN_SECONDS: f64 = 0.25;
const MAX_ROUNDS: u32 = 100_000;

/// Frames below which plans count no work.
const MIN_COUNTED_FRAMES: u32 = 10;

/// Times of a plan \[s\].
#[derive(Clone, Copy, Debug)]
struct PlanTimes {
    build: f64,
    frame: f64,
    /// Predicted time of a frame before the first one; 0 where no work was counted.
    predicted: f64,
}

impl PlanTimes {
    fn over(self, frames: u32) -> f64 {
        self.build + f64::from(frames) * self.frame
    }
}

/// Plan with its times, as they are measured.
struct Candidate {
    plan: Plan,
    times: PlanTimes,
    frames: MeanTime,
}

/// Mean of several times.
#[derive(Clone, Copy, Debug, Default)]
struct MeanTime {
    seconds: f64,
    count: u32,
}

impl MeanTime {
    fn add(&mut self, seconds: f64) {
        self.seconds += seconds;
        self.count += 1;
    }

    fn mean(self) -> f64 {
        self.seconds / f64::from(self.count)
    }
}

/// Scene of the table.
pub(crate) struct NamedScene {
    pub(crate) name: String,
    pub(crate) scene: Scene,
}

/// Returns the table, and the rank correlation of predicted and measured times of frames.
///
/// # Errors
///
/// When a plan cannot be made, or fails in a frame.
pub fn table(only: &[String]) -> Result<String, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    Ok(pool.install(|| rows(only).map_err(|error| error.to_string()))?)
}

fn rows(only: &[String]) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "| scene | tolerance | frames | chosen [s] | over best | over exact | predicted over measured |\n|---|---|---|---|---|---|---|\n",
    );
    let mut pairs = Vec::new();
    let (mut worst_best, mut worst_exact): (f64, f64) = (0.0, 0.0);
    for mut named in scenes()? {
        if !only.is_empty() && !only.iter().any(|part| named.name.contains(part)) {
            continue;
        }
        for tolerance in TOLERANCES {
            let rows = measure(&mut named.scene, tolerance)?;
            let [exact, coarse, field] = rows.forced.each_ref().map(Option::as_ref);
            for (frames, chosen) in FRAMES.into_iter().zip(&rows.chosen) {
                let all = [exact, coarse, field].into_iter().flatten();
                let best = all.map(|times| times.over(frames)).fold(f64::INFINITY, f64::min);
                let chosen_seconds = chosen.over(frames);

                // The best is no worse than the choice itself, so that the ratio is at least 1.
                let of_best = chosen_seconds / best.min(chosen_seconds);
                let of_exact = exact.map_or(1.0, |exact| chosen_seconds / exact.over(frames));
                worst_best = worst_best.max(of_best);
                worst_exact = worst_exact.max(of_exact);

                let ratio = chosen.predicted / chosen.frame;
                let ratio = if ratio > 0.0 { format!("{ratio:.2}") } else { "-".to_owned() };
                text += &format!(
                    "| {} | {tolerance} | {frames} | {chosen_seconds:.4} | {of_best:.2} | {of_exact:.2} | {ratio} |\n",
                    named.name,
                );
            }

            // Chosen and forced plans count alike for the correlation, where work was counted.
            for times in rows.chosen.iter().chain(rows.forced.iter().flatten()) {
                if times.predicted > 0.0 {
                    pairs.push([times.predicted, times.frame]);
                }
            }
        }
    }
    text += &format!(
        "\nat most {worst_best:.2} of the best and {worst_exact:.2} of exact detection; rank correlation of predicted and measured frames {:.3} over {} plans\n",
        rank_correlation(&pairs),
        pairs.len(),
    );
    Ok(text)
}

/// Times of all plans of a scene within one tolerance.
struct Measured {
    /// By exact surfaces, coarse surfaces and fields; `None` where the method serves no pair.
    forced: [Option<PlanTimes>; 3],
    /// One per number of frames.
    chosen: Vec<PlanTimes>,
}

fn measure(scene: &mut Scene, tolerance: f64) -> Result<Measured, Box<dyn Error>> {
    let methods = [DetectionMethod::Exact, DetectionMethod::Coarse, DetectionMethod::Field];

    // Forced plans first, in the order of the methods, then one per number of frames.
    let mut candidates = Vec::new();
    for method in methods {
        candidates.push(forced(scene, method, tolerance)?);
    }
    for frames in FRAMES {
        candidates.push(Some(build(scene, tolerance, frames, &[])?));
    }

    // In turns, so that what else the machine does hits all alike.
    for round in 0..MAX_ROUNDS {
        let mut is_done = true;
        for candidate in candidates.iter_mut().flatten() {
            if round > MIN_ROUNDS && candidate.frames.seconds > MIN_SECONDS {
                continue;
            }
            is_done = false;
            let seconds = time_frame(scene, &mut candidate.plan, round)?;
            // The first round warms the caches.
            if round > 0 {
                candidate.frames.add(seconds);
                candidate.times.frame = candidate.frames.mean();
            }
        }
        if is_done {
            break;
        }
    }

    // Times come in the order of the candidates.
    let mut times = candidates.iter().map(|candidate| candidate.as_ref().map(|c| c.times));
    let mut forced = [None; 3];
    for slot in &mut forced {
        *slot = times.next().flatten();
    }
    let mut chosen: Vec<PlanTimes> = times.flatten().collect();

    // Plans of the same methods differ in noise alone.
    share_times(&candidates, &mut forced, &mut chosen);
    Ok(Measured { forced, chosen })
}

/// Gives plans with the same methods for all pairs the smallest time of a frame of any of them.
fn share_times(
    candidates: &[Option<Candidate>],
    forced: &mut [Option<PlanTimes>; 3],
    chosen: &mut [PlanTimes],
) {
    let methods = |candidate: &Candidate| {
        let pairs = candidate.plan.pairs().iter();
        pairs.map(|pair| (pair.method, pair.is_coarse)).collect::<Vec<_>>()
    };
    let keys: Vec<_> = candidates.iter().map(|candidate| candidate.as_ref().map(methods)).collect();

    // Forced plans before chosen ones, as in the list of candidates.
    let mut all: Vec<Option<&mut PlanTimes>> = Vec::new();
    all.extend(forced.iter_mut().map(Option::as_mut));
    all.extend(chosen.iter_mut().map(Some));
    for place in 0..all.len() {
        let mut least = f64::INFINITY;
        for other in 0..all.len() {
            if keys[other].is_some() && keys[other] == keys[place] {
                least = least.min(all[other].as_ref().map_or(f64::INFINITY, |times| times.frame));
            }
        }
        if let Some(times) = &mut all[place] {
            times.frame = least.min(times.frame);
        }
    }
}

/// Builds a plan in which a method is forced on all pairs that it suits; `None` without any.
fn forced(
    scene: &mut Scene,
    method: DetectionMethod,
    tolerance: f64,
) -> Result<Option<Candidate>, Box<dyn Error>> {
    let forced = forced_pairs(scene, method, tolerance)?;
    if forced.is_empty() {
        return Ok(None);
    }
    Ok(Some(build(scene, tolerance, FRAMES[2], &forced)?))
}

/// Forces a method on all pairs of a plan that it suits.
pub(crate) fn forced_pairs(
    scene: &mut Scene,
    method: DetectionMethod,
    tolerance: f64,
) -> Result<Vec<ForcedMethod>, PlanError> {
    let free = Plan::new(scene, &PlanParams::with_tolerance(tolerance), Progress::none())?;

    // Fields need a bone; the other methods suit all pairs.
    let mut forced = Vec::new();
    for planned in free.pairs() {
        let has_bone = planned.pair.bodies().iter().any(|&id| scene.body(id).is_rigid());
        if method != DetectionMethod::Field || has_bone {
            forced.push(ForcedMethod { pair: planned.pair, method });
        }
    }
    Ok(forced)
}

/// Builds a plan of trees that are built anew.
fn build(
    scene: &mut Scene,
    tolerance: f64,
    frames: u32,
    forced: &[ForcedMethod],
) -> Result<Candidate, Box<dyn Error>> {
    let start = Instant::now();
    let machine_factor = machine_factor(|| start.elapsed());
    let params = PlanParams { frames, machine_factor, ..PlanParams::with_tolerance(tolerance) };
    let (mut builds, mut built) = (MeanTime::default(), None);
    while builds.count < MAX_ROUNDS && builds.seconds < MIN_SECONDS {
        let start = thread_time();
        built = Some(Plan::with_forced(scene, &params, forced, Progress::none())?);
        builds.add((thread_time() - start).as_secs_f64());
    }
    let (plan, build) = (built.ok_or("no plan was built")?, builds.mean());

    // For a few frames no work is counted, so that none is predicted.
    let is_counted = frames >= MIN_COUNTED_FRAMES;
    let predicted = if is_counted { plan.predicted_time().as_secs_f64() } else { 0.0 };
    let times = PlanTimes { build, frame: f64::INFINITY, predicted };
    Ok(Candidate { plan, times, frames: MeanTime::default() })
}

/// Returns the time of a frame after tiny moves, which everything has to follow \[s\].
pub(crate) fn time_frame(
    scene: &mut Scene,
    plan: &mut Plan,
    round: u32,
) -> Result<f64, Box<dyn Error>> {
    let offset = DVec3::splat(1e-6 * (f64::from(round % 2) - 0.5));
    let ids: Vec<_> = scene.ids().collect();
    for id in ids {
        if scene.body(id).is_rigid() {
            scene.pose_body(id, &Pose::new(DQuat::IDENTITY, offset))?;
        } else {
            let x: Vec<DVec3> = scene.body(id).positions().iter().map(|p| *p + offset).collect();
            scene.move_body(id, &x)?;
        }
    }

    // Detection alone is timed, without the moves.
    let mut detection = Detection::default();
    let start = thread_time();
    plan.detect(scene, &mut detection)?;
    Ok((thread_time() - start).as_secs_f64())
}

/// Computes Spearman's rank correlation of pairs of values.
fn rank_correlation(pairs: &[[f64; 2]]) -> f64 {
    let ranks = [0, 1].map(|column| {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|&p, &q| pairs[p][column].total_cmp(&pairs[q][column]));
        let mut ranks = vec![0.0; pairs.len()];
        for (rank, place) in order.into_iter().enumerate() {
            ranks[place] = crate::measure::as_f64(rank);
        }
        ranks
    });

    // The short form of Spearman's coefficient holds without ties.
    let count = crate::measure::as_f64(pairs.len());
    let squares: f64 = ranks[0].iter().zip(&ranks[1]).map(|(p, q)| (p - q) * (p - q)).sum();
    1.0 - 6.0 * squares / (count * (count * count - 1.0))
}

/// Sets up the scenes: generated ones, and real anatomy where it is available.
pub(crate) fn scenes() -> Result<Vec<NamedScene>, Box<dyn Error>> {
    let muscle = shapes::ellipsoid(DVec3::new(20.0, 20.0, 40.0), 4);
    let spike = shapes::ellipsoid(DVec3::new(15.0, 1.0, 1.0), 2).translated(DVec3::X * 29.0);
    let plate = shapes::plate(DVec3::new(60.0, 60.0, 40.0), [1, 1]).translated(DVec3::Z * -20.0);
    let rod = shapes::capsule(2.0, 30.0, 16).translated(DVec3::new(12.0, 3.0, 8.0));
    let two = |a: Mesh, b: Mesh| vec![("bone a".to_owned(), a), ("b".to_owned(), b)];
    let mut scenes = vec![
        named("three balls, 1,280 faces", three_balls(3))?,
        named("three balls, 20,480 faces", three_balls(5))?,
        named("spike in an ellipsoid", two(spike, muscle))?,
        named("rod in a box", two(rod, plate))?,
    ];

    // Of the generated thigh, the femur alone is a bone.
    let mut bodies = Vec::new();
    for body in thigh::thigh().bodies {
        let kind = if body.name == "femur" { "bone " } else { "" };
        bodies.push((format!("{kind}{}", body.name), body.mesh.clone()));
    }
    scenes.push(named("generated thigh", bodies)?);

    // Real anatomy: all bodies of a folder, or those of some names.
    let Some(folder) = data::anatomy("regret of plans of real anatomy") else { return Ok(scenes) };
    for (name, set, members) in [
        ("thigh, simplified", "vhf_left_thigh_lo", &[][..]),
        ("thigh, full", "vhf_left_thigh", &[][..]),
        ("joints", "vhf_left_joints", &[][..]),
        ("femur, vastus intermedius", "vhf_left_thigh", &["femur", "vastus_intermedius"][..]),
        ("both vasti", "vhf_left_thigh", &["vastus_intermedius", "vastus_lateralis"][..]),
        ("pelvis, iliacus, simplified", "vhf_left_thigh_lo", &["pelvis", "iliacus"][..]),
        ("gluteus medius, minimus", "vhf_left_thigh", &["gluteus_medius", "gluteus_minimus"][..]),
    ] {
        let mut bodies = Vec::new();
        for path in data::bodies(&folder.join(set)) {
            let body = path.file_stem().ok_or("a file has no name")?.to_string_lossy().into_owned();
            if members.is_empty() || members.iter().any(|member| body.ends_with(member)) {
                bodies.push((body, data::mesh(&path)));
            }
        }
        scenes.push(named(name, bodies)?);
    }
    Ok(scenes)
}

/// Returns a bone and two soft balls in a row, which overlap by 2 and 3.
pub(crate) fn three_balls(halvings: u32) -> Vec<(String, Mesh)> {
    let mut balls = Vec::new();
    for (name, x) in [("bone", 0.0), ("first", 58.0), ("second", 115.0)] {
        balls.push((name.to_owned(), shapes::icosphere(30.0, halvings).translated(DVec3::X * x)));
    }
    balls
}

/// Sets up a scene; bodies whose names begin with "bone" are rigid.
pub(crate) fn named(name: &str, bodies: Vec<(String, Mesh)>) -> Result<NamedScene, SceneError> {
    let mut scene = Scene::new();
    for (name, mesh) in bodies {
        let is_bone = name.starts_with("bone");
        let kind = if is_bone { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(name, kind, mesh.surface(), mesh.positions)?;
    }
    // Trees are there before the first plan, so that none pays for them alone.
    scene.fit_all()?;
    Ok(NamedScene { name: name.to_owned(), scene })
}
