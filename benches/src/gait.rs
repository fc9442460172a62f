//! Gait of a real thigh: bones in motion, muscles on springs to their skinned places, contacts
//! corrected in each step.
//!
//! A muscle is skinned by a blend of the bones' motions along its height, which lets it overlap
//! the bones by a centimeter. Springs pull it there, and contacts keep it out.

use std::error::Error;
use std::path::Path;

use fixtures::data;
use glam::{DMat3, DQuat, DVec3};
use musculo_collide::scene::{DetectorParams, StepDetectors, StepError};
use musculo_collide::{
    BodyId, BodyKind, CheckParams, Margins, Material, PairContacts, ParticleLoads, Progress,
    ResolveParams, RigidMotion, Scene, SceneStates, SceneStep, StepLength, StepParams,
};
use response::SolverParams;
use serde_json::Value;
use surface::{Pose, mean_edge};

use crate::measure::{Report, nanoseconds};

/// Steps per frame, and frames per second.
const STEPS: u32 = 4;
const RATE: f64 = 60.0;

/// Frames in which muscles find their place.
const SETTLING: usize = 10;

/// Stiffness over mass of springs to the skinned place \[1/s²\].
const STIFFNESS: f64 = 1e4;

/// Gap up to which contacts are detected, and over which approaches are slowed \[mm\].
const MARGIN: f64 = 2.0;
const PROXIMITY: f64 = 0.5;

/// Bones with their maps from rest; the pelvis stays.
pub(crate) const BONES: [(&str, Option<usize>); 4] = [
    ("bone_pelvis", None),
    ("bone_femur", Some(0)),
    ("bone_tibia", Some(1)),
    ("bone_patella", Some(2)),
];
const MAPS: [&str; 3] = ["femur", "tibia", "patella"];

/// Motion of the bones, and heights at which skinning blends.
pub(crate) struct Motion {
    /// Maps from rest of femur, tibia and patella.
    pub(crate) frames: Vec<[(DQuat, DVec3); 3]>,
    hip: f64,
    knee: f64,
}

/// The thigh with its state.
struct Thigh {
    scene: Scene,
    bones: Vec<(BodyId, Option<usize>)>,
    rest: Vec<DVec3>,
    inverse_mass: Vec<f64>,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    motion: Motion,
}

/// Reports overlaps, lost sides and time; skips without data.
///
/// # Errors
///
/// When data cannot be read, or a step fails.
pub fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let Some(folder) = data::anatomy("gait of the thigh") else { return Ok(()) };
    let mut thigh = Thigh::read(&folder)?;
    let (mut overlaps, mut unknown, mut failed) = (Vec::new(), 0, None);
    let time = nanoseconds(|| {
        let walked = thigh.walk(|overlap, lost| {
            overlaps.push(overlap);
            // Sides may be unknown while muscles find their place.
            if overlaps.len() > SETTLING {
                unknown = unknown.max(lost);
            }
        });
        failed = walked.err();
        overlaps.len()
    });
    if let Some(error) = failed {
        return Err(error.into());
    }

    // The frames of settling do not count for the overlap either.
    let late = overlaps.get(SETTLING..).unwrap_or_default();
    let worst = late.iter().copied().fold(0.0, f64::max);
    let lost = f64::from(u32::try_from(unknown)?);
    report.cost("gait: exact overlap after ten frames", worst, "mm", 0.1);
    report.cost("gait: vertices of unknown side", lost, "vertices", 0.0);
    let taken = f64::from(u32::try_from(overlaps.len())?) / RATE;
    report.ratio("gait: time / motion", [time * 1e-9, taken], "s", f64::INFINITY);
    Ok(())
}

impl Motion {
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let value: Value = serde_json::from_slice(&std::fs::read(path)?)?;
        let mut frames = Vec::new();
        for frame in value["frames"].as_array().ok_or("no frames")? {
            let mut maps = [(DQuat::IDENTITY, DVec3::ZERO); 3];
            for (map, name) in maps.iter_mut().zip(MAPS) {
                *map = rigid(&frame[name]).ok_or("a map of 16 numbers")?;
            }
            frames.push(maps);
        }

        let height = |name: &str| value["ambient_skin"][name].as_f64().ok_or("a height");
        Ok(Self { frames, hip: height("hip_z")?, knee: height("knee_z")? })
    }

    /// Returns the maps at a step: between frames, rotations on the shortest way.
    fn at(&self, step: u32) -> [(DQuat, DVec3); 3] {
        let (frame, share) = (step / STEPS, f64::from(step % STEPS) / f64::from(STEPS));
        let last = self.frames.len() - 1;
        let [from, to] = [frame as usize, frame as usize + 1].map(|k| self.frames[k.min(last)]);
        std::array::from_fn(|k| (from[k].0.slerp(to[k].0, share), from[k].1.lerp(to[k].1, share)))
    }

    /// Returns the skinned place of a vertex.
    pub(crate) fn skinned(&self, rest: DVec3, maps: &[(DQuat, DVec3); 3]) -> DVec3 {
        let [of_pelvis, of_femur, of_tibia] = self.weights(rest);
        let [femur, tibia, _] = maps.map(|(turn, shift)| turn * rest + shift);
        of_pelvis * rest + of_femur * femur + of_tibia * tibia
    }

    /// Returns the weights of pelvis, femur and tibia at a vertex.
    pub(crate) fn weights(&self, rest: DVec3) -> [f64; 3] {
        // Weights sum to 1, and change over 10 cm at the hip and over 8 cm at the knee.
        let of_pelvis = smooth((rest.z - self.hip + 50.0) / 100.0);
        let of_tibia = 1.0 - smooth((rest.z - self.knee + 40.0) / 80.0);
        [of_pelvis, 1.0 - of_pelvis - of_tibia, of_tibia]
    }
}

impl Thigh {
    fn read(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let motion = Motion::read(&folder.join("motions/gait_walk.json"))?;

        // Bones come first, so that the particles from `first` on are those of muscles.
        let (mut scene, mut bones) = (Scene::new(), Vec::new());
        let folder = folder.join("vhf_left_thigh_lo");
        for (name, map) in BONES {
            let mesh = data::mesh(&folder.join(format!("{name}.ply")));
            bones.push((scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions)?, map));
        }
        let first = scene.particle_positions().len();
        for path in data::bodies(&folder) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if name.starts_with("muscle") {
                let mesh = data::mesh(&path);
                scene.add(&name, BodyKind::Deformable, mesh.surface(), mesh.positions)?;
            }
        }

        // Bones have an inverse mass of 0: only their own motion moves them.
        let rest = scene.particle_positions();
        let mut inverse_mass = vec![1.0; rest.len()];
        inverse_mass[..first].fill(0.0);

        // Muscles begin where the first frame has them.
        let mut x = rest.clone();
        let maps = motion.at(0);
        for x in &mut x[first..] {
            *x = motion.skinned(*x, &maps);
        }
        let v = vec![DVec3::ZERO; x.len()];
        Ok(Self { scene, bones, rest, inverse_mass, x, v, motion })
    }

    /// Walks through all frames; `observe` receives the exact overlap that is left in each, and
    /// the number of vertices whose side is unknown, the largest of its steps.
    fn walk(&mut self, mut observe: impl FnMut(f64, usize)) -> Result<(), StepError> {
        let mut step = SceneStep::new(Material::hard(Margins::new(0.0, PROXIMITY)?));
        let mut detectors = StepDetectors::new(DetectorParams { margin: MARGIN, tolerance: 0.1 })?;
        let solver = SolverParams { max_iterations: 50, tolerance: 1e-4, ..Default::default() };
        let h = (RATE * f64::from(STEPS)).recip();
        let params = StepParams {
            solver,
            max_rounds: 8,
            depth_tolerance: Some(0.02),
            ..StepParams::new(StepLength::new(h)?)
        };

        // In each step, bones and springs come first, then contacts, then the move.
        let mut unknown = 0;
        let count = u32::try_from(self.motion.frames.len()).unwrap_or(0);
        for number in 0..count * STEPS {
            self.place_bones(&mut step, number, h)?;
            self.pull(number + 1, h);
            let Self { scene, x, v, inverse_mass, .. } = self;
            let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass };
            step.correct(scene, states, &params, |scene, contacts: &mut PairContacts<'_>| {
                detectors.detect(scene, contacts)
            })?;

            // Overlaps are measured once per frame, before the move.
            unknown = unknown.max(step.unknown_sides());
            if number % STEPS == 0 {
                observe(self.overlap()?, std::mem::take(&mut unknown));
            }
            for (x, v) in self.x.iter_mut().zip(&self.v) {
                *x += h * *v;
            }
        }
        Ok(())
    }

    /// Places the bones at a step, with the motion to the next.
    fn place_bones(&mut self, step: &mut SceneStep, number: u32, h: f64) -> Result<(), StepError> {
        let (now, next) = (self.motion.at(number), self.motion.at(number + 1));
        for &(bone, map) in &self.bones {
            let (mut pose, mut motion) = (Pose::IDENTITY, RigidMotion::default());
            if let Some(map) = map {
                let ((turn, shift), (next_turn, next_shift)) = (now[map], next[map]);
                pose = Pose::new(turn, shift);
                motion.about = shift;
                motion.velocity = (next_shift - shift) / h;
                motion.spin = (next_turn * turn.inverse()).to_scaled_axis() / h;
            }
            step.move_bone(&mut self.scene, bone, &pose, motion)?;
        }
        Ok(())
    }

    /// Changes velocities by springs to the skinned places at a step, critically damped.
    fn pull(&mut self, number: u32, h: f64) {
        let (maps, last) = (self.motion.at(number), self.motion.at(number - 1));
        let damping = h * 2.0 * STIFFNESS.sqrt();
        for (k, w) in self.inverse_mass.iter().enumerate() {
            if *w > 0.0 {
                // The damper is taken implicitly, and acts against the motion of the goal.
                let goal = self.motion.skinned(self.rest[k], &maps);
                let moves = (goal - self.motion.skinned(self.rest[k], &last)) / h;
                let damped = (self.v[k] + damping * moves) / (1.0 + damping);
                self.v[k] = damped + h * STIFFNESS * (goal - self.x[k]);
            }
        }
    }

    /// Measures the largest depth of a vertex of a pair with a muscle.
    fn overlap(&mut self) -> Result<f64, StepError> {
        let mut depth = 0.0_f64;
        for report in self.scene.check(&CheckParams::without_measures(0.0), Progress::none())? {
            // Pairs of two bones are left out: nothing corrects them.
            if report.pair.bodies().iter().any(|body| !self.scene.body(*body).is_rigid()) {
                depth = depth.max(report.max_vertex_depth);
            }
        }
        Ok(depth)
    }
}

/// Reads a row-major map of 4 × 4 numbers.
fn rigid(value: &Value) -> Option<(DQuat, DVec3)> {
    let numbers: Vec<f64> = value.as_array()?.iter().filter_map(Value::as_f64).collect();
    let [a, b, c, x, d, e, f, y, g, h, i, z, ..] = numbers[..] else { return None };
    let rows = DMat3::from_cols(DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, i));
    Some((DQuat::from_mat3(&rows.transpose()), DVec3::new(x, y, z)))
}

/// Rises from 0 at 0 to 1 at 1.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Reads a thigh. Bones have names that begin with `bone`.
pub(crate) fn thigh(folder: &Path) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    for path in data::bodies(folder) {
        let mesh = data::mesh(&path);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let is_bone = name.starts_with("bone");
        let kind = if is_bone { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(name, kind, mesh.surface(), mesh.positions)?;
    }
    Ok(scene)
}

/// Returns the parameters that the program takes by default.
pub(crate) fn resolve_params(scene: &mut Scene) -> Result<ResolveParams, Box<dyn Error>> {
    let mut deepest = 0.0_f64;
    for pair in scene.check(&CheckParams::without_measures(0.0), Progress::none())? {
        deepest = deepest.max(pair.max_vertex_depth);
    }
    let (mut length, mut count) = (0.0, 0.0);
    for body in scene.bodies().iter().filter(|body| !body.is_rigid()) {
        let edges = f64::from(u32::try_from(body.surface().edges().len())?);
        length += edges * mean_edge(body.surface(), body.surface().positions(body.positions())?);
        count += edges;
    }
    Ok(ResolveParams::for_overlaps(deepest, length / count))
}
