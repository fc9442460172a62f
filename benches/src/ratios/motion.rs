//! Contact in motion: planted screws, the cost of arcs beside straight steps, a map of a hip's range
//! of motion, and a walk.

use std::error::Error;
use std::time::Duration;

use ::ccd::{CcdParams, PathBounds, Primitives, first_contact_on_paths};
use glam::{DQuat, DVec3};
use musculo_collide::surface::parallel;
use musculo_collide::{
    BodyId, BodyMove, CheckParams, JointScene, PathMove, Progress, RigidBodyPath, RigidPath, Scene,
    SceneError, StraightPath, TurnEnd,
};

use super::deep_starts;
use super::motion_scenes::{HIP, Walk, bones, hip_turns, search};
use crate::measure::{Pace, Report, as_f64, nanoseconds, wall_time};

/// Planted screws.
const SCREWS: u32 = 100_000;

/// Times at which the distance of a rod is sampled.
const SAMPLES: u32 = 100;

/// Steps of a bone in degrees.
const STEPS: [f64; 5] = [5.0, 10.0, 20.0, 40.0, 60.0];

/// States of two bones that are compared with the sweep, over all steps.
const STATES: u32 = 10_000;

/// Cells along a side of the map.
const CELLS: u32 = 31;

/// Distance between the cells that are compared with bisection.
const CELL_STRIDE: usize = 37;

/// Frames between those of the walk that are timed.
const FRAME_STRIDE: usize = 12;

type Outcome = Result<(), Box<dyn Error>>;

/// Reports what contact in motion is promised to keep.
pub(super) fn run(report: &mut Report) -> Outcome {
    screws(report)?;
    deep_starts::run(report)?;
    let Some(bones) = bones()? else { return Ok(()) };
    straight(report, bones.clone())?;
    steps(report, &bones)?;
    hip_map(report, bones)?;
    walk(report)
}

/// Pseudorandom numbers, in `0.0..1.0`.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap_or(0)) / f64::from(u32::MAX)
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }
}

/// Rod on an arm that turns and shifts along its axis, and a ball that it meets at a time in closed form.
struct Screw {
    arm: f64,
    step: f64,
    /// Height over the ball at the start, and its change.
    height: [f64; 2],
    /// Distance of the ball from the axis, and angle between it and the rod at the start.
    ball: f64,
    angle: f64,
    /// Time of contact.
    time: f64,
    center: DVec3,
    frame: DQuat,
}

impl Screw {
    /// Draws a screw; arms are 1 to 1000 and steps 0.1 to 90 degrees.
    fn draw(numbers: &mut Numbers) -> Self {
        let arm = 10.0_f64.powf(numbers.between(0.0, 3.0));
        let step = 0.1_f64.to_radians() * 900.0_f64.powf(numbers.next());

        // The rod comes nearer all the time: the angle falls, and so does the height.
        let (time, left) = (numbers.between(0.01, 0.99), numbers.between(1e-4, 0.5));
        let angle = (left + time * step).min(1.5);
        let fall = arm * numbers.between(0.0, 0.5) * step;
        let height = numbers.between(0.0, 0.05) * arm + fall * time;
        Self {
            arm,
            step,
            height: [height, -fall],
            ball: arm * numbers.between(0.3, 0.9),
            angle,
            time,
            center: numbers.vector(1000.0),
            frame: DQuat::from_axis_angle(
                numbers.vector(1.0).normalize_or(DVec3::X),
                numbers.between(0.0, 3.0),
            ),
        }
    }

    /// Returns the distance of the ball's center from the rod at a time, in closed form.
    fn distance(&self, time: f64) -> f64 {
        let beside = self.ball * (self.angle - time * self.step).sin();
        beside.hypot(self.height[0] + time * self.height[1])
    }

    /// Returns the ends of the rod, and the ball twice, at a time.
    fn points(&self, time: f64) -> [DVec3; 4] {
        let (sin, cos) = (time * self.step).sin_cos();
        let height = self.height[0] + time * self.height[1];
        let along = |r: f64| self.center + self.frame * DVec3::new(r * cos, r * sin, height);
        let (sin, cos) = self.angle.sin_cos();
        let ball = self.center + self.frame * DVec3::new(self.ball * cos, self.ball * sin, 0.0);
        [along(0.1 * self.arm), along(self.arm), ball, ball]
    }
}

/// Rods that touch balls at times in closed form.
fn screws(report: &mut Report) -> Outcome {
    let mut numbers = Numbers(1);
    let (mut missed, mut late, mut early) = (0_u32, 0_u32, 0_u32);
    let count = report.rounds(SCREWS);
    for _ in 0..count {
        let screw = Screw::draw(&mut numbers);
        let radius = screw.distance(screw.time);

        // Rounding of positions of a few thousand, and of the turn.
        let rounding = 64.0 * f64::EPSILON * (2000.0 + 4.0 * screw.arm);
        let bend = screw.arm * screw.step * screw.step * (1.0 + 1e-12);
        let bounds = PathBounds { bend, rounding };
        let params = CcdParams { min_separation: radius, ..CcdParams::DEFAULT };
        let at = |time: f64| screw.points(time);
        let found = first_contact_on_paths(Primitives::EdgeEdge, at, bounds, [0.0, 1.0], &params)?;

        // A time is late where a sample before it is within the ball, too.
        let Some(found) = found else {
            missed += 1;
            continue;
        };
        let is_within = |sample| {
            let time = found.lo * f64::from(sample) / f64::from(SAMPLES + 1);
            screw.distance(time) < radius * (1.0 - 1e-12)
        };
        late += u32::from(found.lo > screw.time + 1e-12 || (0..=SAMPLES).any(is_within));
        early += u32::from(found.lo < screw.time - 1e-6);
    }
    report.cost("planted screws: missed", f64::from(missed), "steps", 0.0);
    report.cost("planted screws: late", f64::from(late), "steps", 0.0);
    let share = f64::from(early) / f64::from(count);
    report.cost("planted screws: earlier by 1e-6 of the step", share, "", 0.01);
    Ok(())
}

/// A straight step as paths, beside the straight step.
fn straight(report: &mut Report, scene: Scene) -> Outcome {
    let femur = scene.find("bone_femur").ok_or("a femur")?;
    let from = scene.body(femur).positions().to_vec();
    let to: Vec<DVec3> = from.iter().map(|&x| x + DVec3::new(0.0, 0.0, 6.0)).collect();
    let path = StraightPath { from: &from, to: &to };
    let (mut on_paths, mut at_once) = (scene.clone(), scene);

    // Both count their candidates, which are to be the same.
    let mut sides = [0_usize; 2];
    let mut ours = || {
        let moves = [PathMove { body: femur, path: &path }];
        let swept = on_paths.sweep_paths(&moves, &CcdParams::EXACT, Progress::none());
        sides[0] = swept.map_or(0, |swept| swept.candidates);
        sides[0]
    };
    let mut other = 0;
    let mut theirs = || {
        let moves = [BodyMove { body: femur, positions: &to }];
        let swept = at_once.sweep(&moves, &CcdParams::EXACT, Progress::none());
        other = swept.map_or(0, |swept| swept.candidates);
        other
    };
    report.compare("straight paths / straight step", 3000, 1.02, [&mut ours, &mut theirs]);
    report.cost("straight paths: other candidates", as_f64(sides[0].abs_diff(other)), "", 0.0);
    Ok(())
}

/// Turns of a femur in its socket: time beside the straight step, and states before the first
/// contact that overlap.
fn steps(report: &mut Report, bones: &Scene) -> Outcome {
    let femur = bones.find("bone_femur").ok_or("a femur")?;
    let from = bones.body(femur).positions().to_vec();
    let mut missed = 0;
    for step in STEPS {
        let path = RigidPath::turn(HIP, DVec3::new(1.0, 0.2, -0.3), step.to_radians());
        let arc = RigidBodyPath { from: &from, path };
        let to: Vec<DVec3> = from.iter().map(|&x| path.transform_point(x, 1.0)).collect();

        // The same turn on its arc, and on the chords of all vertices.
        let (mut scene, mut straight) = (bones.clone(), bones.clone());
        let mut on_arc = || {
            let moves = [PathMove { body: femur, path: &arc }];
            let swept = scene.sweep_paths(&moves, &CcdParams::EXACT, Progress::none());
            swept.map_or(0, |swept| swept.candidates)
        };
        let mut on_chord = || {
            let moves = [BodyMove { body: femur, positions: &to }];
            let swept = straight.sweep(&moves, &CcdParams::EXACT, Progress::none());
            swept.map_or(0, |swept| swept.candidates)
        };
        let name = format!("two bones, {step}° / straight step");
        let pace = Pace { min_turns: 3, calls: 1, budget: Duration::ZERO, clock: wall_time };
        let sides =
            [("ours", &mut on_arc as &mut dyn FnMut() -> usize), ("straight", &mut on_chord)];
        let times = report.measure(&name, pace, sides);
        report.times(name, times, 3.0);
        missed += missed_states(report, bones.clone(), femur, path)?;
    }
    report.cost("two bones: states missed", as_f64(missed), "states", 0.0);
    Ok(())
}

/// Counts the states of a turn that overlap before its first contact.
fn missed_states(
    report: &Report,
    mut scene: Scene,
    femur: BodyId,
    path: RigidPath,
) -> Result<usize, Box<dyn Error>> {
    let from = scene.body(femur).positions().to_vec();
    let arc = RigidBodyPath { from: &from, path };
    let moves = [PathMove { body: femur, path: &arc }];
    let swept = scene.first_contacts(&moves, &CcdParams::EXACT, Progress::none())?;
    let free = swept.largest_free_step;

    // States until shortly after the contact, of which none before it may overlap.
    let count = report.rounds(STATES / 5);
    let end = (1.05 * free).min(1.0);
    let mut missed = 0;
    for state in 0..=count {
        let time = end * f64::from(state) / f64::from(count);
        let x: Vec<DVec3> = from.iter().map(|&x| path.transform_point(x, time)).collect();
        scene.move_body(femur, &x)?;
        let reports = scene.check(&CheckParams::without_measures(0.0), Progress::none())?;
        let overlaps = reports.iter().any(|report| report.overlaps);
        missed += usize::from(overlaps && time < free);
    }
    Ok(missed)
}

/// A map of the range of motion of a hip: its time, and its cells beside bisection.
fn hip_map(report: &mut Report, bones: Scene) -> Outcome {
    let femur = bones.find("bone_femur").ok_or("a femur")?;
    let turns = hip_turns();
    let joint = JointScene::new(bones, &[femur], turns)?;

    // Rows in parallel, each with trees of its own.
    let mut cells = Vec::new();
    let time = nanoseconds(|| {
        let rows = parallel::map(CELLS as usize, |row| {
            let mut joint = joint.clone();
            let cell = |column: u32| joint.turn(angles(row, column));
            (0..CELLS).map(cell).collect::<Result<Vec<_>, _>>()
        });
        cells = rows;
        cells.len()
    });
    report.cost("hip map of 31 × 31: time", time * 1e-9, "s", 60.0);

    let (mut worst, mut compared, mut contacts, mut off) = (0.0_f64, 0_usize, 0_usize, 0_usize);
    let mut joint = joint;
    for (row, cells) in cells.into_iter().enumerate() {
        for (column, end) in (0..).zip(cells?) {
            let TurnEnd::Contact(contact) = end else { continue };
            contacts += 1;
            off += usize::from(is_off(&mut joint, angles(row, column), contact.angle)?);
            if contacts % CELL_STRIDE == 0 {
                let exact = bisected(&mut joint, angles(row, column), contact.angle)?;
                worst = worst.max((exact - contact.angle).abs().to_degrees());
                compared += 1;
            }
        }
    }
    report.cost("hip map: cells with a contact", as_f64(contacts), "", f64::INFINITY);
    report.cost("hip map: cells 0.001° or more off", as_f64(off), "", 0.0);
    report.cost(format!("hip map: {compared} cells beside bisection"), worst, "°", 1e-3);
    Ok(())
}

/// Returns the angles of the first two turns of a cell.
fn angles(row: usize, column: u32) -> [f64; 2] {
    let share = |k: u32| f64::from(k) / f64::from(CELLS - 1);
    let row = u32::try_from(row).unwrap_or(0);
    [120.0 * share(row), 60.0 * share(column) - 30.0].map(f64::to_radians)
}

/// Returns true if exact detection finds an overlap at the angle of a contact, or none 0.001° beyond.
fn is_off(joint: &mut JointScene, angles: [f64; 2], contact: f64) -> Result<bool, Box<dyn Error>> {
    let beyond = contact + 0.001_f64.to_radians().copysign(contact);
    Ok(joint.overlaps(angles, contact)? || !joint.overlaps(angles, beyond)?)
}

/// Finds the angle at which bodies begin to overlap by bisection, between the start and half a degree
/// beyond a contact; infinite where they do not overlap there.
fn bisected(joint: &mut JointScene, angles: [f64; 2], contact: f64) -> Result<f64, Box<dyn Error>> {
    let mut free = 0.0;
    let mut overlapping = contact + 0.5_f64.to_radians().copysign(contact);
    if !joint.overlaps(angles, overlapping)? {
        return Ok(f64::INFINITY);
    }
    for _ in 0..40 {
        let middle = f64::midpoint(free, overlapping);
        if joint.overlaps(angles, middle)? {
            overlapping = middle;
        } else {
            free = middle;
        }
    }
    Ok(overlapping)
}

/// Steps of a walk of a whole thigh on arcs.
fn walk(report: &mut Report) -> Outcome {
    let Some(mut walk) = Walk::read("walk on arcs")? else { return Ok(()) };
    let (mut times, mut frames) = ([0.0; 3], 0.0);
    for frame in (1..walk.frame_count()).step_by(FRAME_STRIDE) {
        walk.place(frame - 1)?;
        walk.sweep(frame - 1)?;

        // The second sweep of a frame finds structures that are built once.
        let mut failed = None;
        times[0] += nanoseconds(|| kept(walk.sweep(frame - 1), &mut failed));
        times[1] += nanoseconds(|| kept(walk.sweep_straight(frame - 1), &mut failed));
        if let Some(error) = failed {
            return Err(error.into());
        }

        // All that contacts of the last frame could save: the search of faces that may meet.
        let trees = walk.step_trees(frame - 1)?;
        times[2] += nanoseconds(|| search(&trees));
        frames += 1.0;
    }
    let [on_arcs, straight, search] = times.map(|time| time * 1e-9 / frames);
    report.cost("walk, straight: time per frame", straight, "s", 0.12);
    report.ratio("walk: search of candidates / straight", [search, straight], "s", f64::INFINITY);
    report.cost("walk on arcs: time per frame", on_arcs, "s", 0.25);
    report.ratio("walk on arcs / straight", [on_arcs, straight], "s", f64::INFINITY);
    Ok(())
}

/// Returns the count of a timed call; keeps its error aside, which cannot leave the call.
fn kept(counted: Result<usize, SceneError>, failed: &mut Option<SceneError>) -> usize {
    match counted {
        Ok(count) => count,
        Err(error) => {
            *failed = Some(error);
            0
        }
    }
}
