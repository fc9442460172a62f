//! Scenes of real bones and muscles in motion.

use std::error::Error;

use fixtures::data;
use glam::{DAffine3, DQuat, DVec3};
use musculo_collide::kdop::Workspace;
use musculo_collide::proximity::LazySurfaceTree;
use musculo_collide::surface::parallel;
use musculo_collide::{
    BodyId, BodyKind, BodyMove, JointTurns, NearRigidPath, Path, PathMove, Progress, RigidPath,
    Scene, SceneError, ccd,
};
use surface::Pose;

use crate::gait::{BONES, Motion};

/// Center of the hip of the data \[mm\].
pub(super) const HIP: DVec3 = DVec3::new(441.2558, 459.0173, 883.3095);

/// Returns femur and pelvis; `None` without data.
pub(super) fn bones() -> Result<Option<Scene>, Box<dyn Error>> {
    let Some(folder) = data::anatomy("contact of bones in motion") else { return Ok(None) };
    let mut scene = Scene::new();
    for name in ["bone_femur", "bone_pelvis"] {
        let mesh = data::mesh(&folder.join(format!("vhf_left_thigh/{name}.ply")));
        scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions)?;
    }
    scene.fit_all()?;
    Ok(Some(scene))
}

/// Returns flexion, rotation and then adduction of the left hip.
pub(super) fn hip_turns() -> JointTurns {
    let axes = [DVec3::X, DVec3::Z, DVec3::NEG_Y];
    JointTurns { center: HIP, axes, to: 60.0_f64.to_radians() }
}

/// Walk of a thigh of 25 bodies.
pub(super) struct Walk {
    scene: Scene,
    /// Bodies with their positions at rest and the map that they follow.
    bodies: Vec<(BodyId, Vec<DVec3>, Follows)>,
    motion: Motion,
}

#[derive(Clone, Copy)]
enum Follows {
    Nothing,
    Bone(usize),
    Blend,
}

/// State of a body in a frame.
pub(super) enum BodyState {
    Pose(BodyId, Pose),
    Positions(BodyId, Vec<DVec3>),
}

impl Walk {
    /// Reads the walk; `None` without data, which `who` says it needs.
    pub(super) fn read(who: &str) -> Result<Option<Self>, Box<dyn Error>> {
        let Some(folder) = data::anatomy(who) else { return Ok(None) };
        let motion = Motion::read(&folder.join("motions/gait_walk.json"))?;
        let (mut scene, mut bodies) = (Scene::new(), Vec::new());
        for path in data::bodies(&folder.join("vhf_left_thigh")) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let bone = BONES.iter().find(|(bone, _)| *bone == name);
            let (kind, follows) = match bone {
                Some((_, Some(map))) => (BodyKind::Rigid, Follows::Bone(*map)),
                Some((_, None)) => (BodyKind::Rigid, Follows::Nothing),
                None => (BodyKind::Deformable, Follows::Blend),
            };
            let mesh = data::mesh(&path);
            let rest = mesh.positions.clone();
            bodies.push((scene.add(name, kind, mesh.surface(), mesh.positions)?, rest, follows));
        }
        Ok(Some(Self { scene, bodies, motion }))
    }

    pub(super) fn frame_count(&self) -> usize {
        self.motion.frames.len()
    }

    pub(super) fn into_scene(self) -> Scene {
        self.scene
    }

    /// Returns the states of all bodies in a frame: poses of rigid ones.
    pub(super) fn states(&self, frame: usize) -> Vec<BodyState> {
        let mut states = Vec::new();
        for (body, rest, follows) in &self.bodies {
            states.push(match follows {
                Follows::Nothing => BodyState::Pose(*body, Pose::IDENTITY),
                Follows::Bone(map) => {
                    let (turn, shift) = self.motion.frames[frame][*map];
                    BodyState::Pose(*body, Pose::new(turn, shift))
                }
                Follows::Blend => {
                    let path = WalkPath::new(&self.motion, rest, *follows, frame);
                    let vertices = (0_u32..).take(rest.len());
                    let x = vertices.map(|vertex| path.position(vertex, 0.0)).collect();
                    BodyState::Positions(*body, x)
                }
            });
        }
        states
    }

    /// Moves all bodies to a frame.
    pub(super) fn place(&mut self, frame: usize) -> Result<(), SceneError> {
        for (body, rest, follows) in &self.bodies {
            let path = WalkPath::new(&self.motion, rest, *follows, frame);
            self.scene.move_body(*body, &path.all_positions(0.0))?;
        }
        Ok(())
    }

    /// Sweeps from a frame to the next on straight ways; returns the number of contacts.
    pub(super) fn sweep_straight(&mut self, frame: usize) -> Result<usize, SceneError> {
        let mut ends = Vec::new();
        for (body, rest, follows) in &self.bodies {
            let path = WalkPath::new(&self.motion, rest, *follows, frame);
            ends.push((*body, path.all_positions(1.0)));
        }
        let mut moves = Vec::new();
        for (body, positions) in &ends {
            moves.push(BodyMove { body: *body, positions });
        }
        let swept = self.scene.sweep(&moves, &ccd::CcdParams::EXACT, Progress::none())?;
        Ok(swept.pairs.iter().map(|pair| pair.contacts.len()).sum())
    }

    /// Returns the trees of all bodies over the step from a frame to the next.
    pub(super) fn step_trees(&self, frame: usize) -> Result<Vec<LazySurfaceTree>, Box<dyn Error>> {
        let mut trees = Vec::new();
        for (body, rest, follows) in &self.bodies {
            let path = WalkPath::new(&self.motion, rest, *follows, frame);
            let (start, end) = (path.all_positions(0.0), path.all_positions(1.0));
            let surface = self.scene.body(*body).surface().clone();
            let mut tree = LazySurfaceTree::new(surface.clone(), start)?;
            tree.fit_step(surface.positions(&end)?)?;
            trees.push(tree);
        }
        Ok(trees)
    }

    /// Sweeps from a frame to the next; returns the number of contacts.
    pub(super) fn sweep(&mut self, frame: usize) -> Result<usize, SceneError> {
        let mut paths = Vec::new();
        for (body, rest, follows) in &self.bodies {
            paths.push((*body, WalkPath::new(&self.motion, rest, *follows, frame)));
        }
        let mut moves = Vec::new();
        for (body, path) in &paths {
            moves.push(PathMove { body: *body, path });
        }
        let swept = self.scene.sweep_paths(&moves, &ccd::CcdParams::EXACT, Progress::none())?;
        Ok(swept.pairs.iter().map(|pair| pair.contacts.len()).sum())
    }
}

/// Searches the pairs of faces of all bodies that may meet over a step, and nothing else; returns
/// their number.
pub(super) fn search(trees: &[LazySurfaceTree]) -> usize {
    let mut pairs = Vec::new();
    for (number, a) in trees.iter().enumerate() {
        for b in &trees[..number] {
            pairs.extend(a.step_tree().zip(b.step_tree()));
        }
    }
    let counts = parallel::map_slice_with(&pairs, Workspace::default, |workspace, (a, b)| {
        let mut count = 0;
        a.pairs(b, 0.0, workspace, |_, _| count += 1);
        count
    });
    counts.into_iter().sum()
}

/// Path of a body from a frame to the next.
struct WalkPath<'a> {
    motion: &'a Motion,
    rest: &'a [DVec3],
    follows: Follows,
    /// Maps of femur, tibia and patella to the frame, and their motions from there.
    maps: [(DAffine3, RigidPath); 3],
}

impl<'a> WalkPath<'a> {
    fn new(motion: &'a Motion, rest: &'a [DVec3], follows: Follows, frame: usize) -> Self {
        let last = motion.frames.len() - 1;
        let [from, to] = [frame, (frame + 1).min(last)].map(|frame| motion.frames[frame]);
        let maps = std::array::from_fn(|k| {
            let ((turn, shift), (next_turn, next_shift)) = (from[k], to[k]);
            let rotation: DQuat = next_turn * turn.inverse();
            let path = RigidPath::new(rotation, next_shift - rotation * shift, turn * HIP + shift);
            (DAffine3::from_rotation_translation(turn, shift), path)
        });
        Self { motion, rest, follows, maps }
    }

    /// Returns the positions of all vertices at a time.
    fn all_positions(&self, time: f64) -> Vec<DVec3> {
        let vertices: Vec<u32> = (0_u32..).take(self.rest.len()).collect();
        let mut x = vec![DVec3::ZERO; vertices.len()];
        self.positions(&vertices, time, &mut x);
        x
    }

    /// Returns a vertex at rest, with the weights of resting bones, femur, tibia and patella.
    fn weights(&self, vertex: u32) -> (DVec3, [f64; 4]) {
        let rest = self.rest[vertex as usize];
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        match self.follows {
            Follows::Nothing => {}
            Follows::Bone(map) => {
                weights = [0.0; 4];
                weights[map + 1] = 1.0;
            }
            Follows::Blend => weights[..3].copy_from_slice(&self.motion.weights(rest)),
        }
        (rest, weights)
    }
}

impl Path for WalkPath<'_> {
    fn position(&self, vertex: u32, time: f64) -> DVec3 {
        let mut x = [DVec3::ZERO];
        self.positions(&[vertex], time, &mut x);
        x[0]
    }

    fn positions(&self, vertices: &[u32], time: f64, out: &mut [DVec3]) {
        let places = self.maps.map(|(map, path)| (map, path.place(time)));
        for (out, &vertex) in out.iter_mut().zip(vertices) {
            let (rest, weights) = self.weights(vertex);
            let mut x = weights[0] * rest;
            for ((map, place), weight) in places.iter().zip(&weights[1..]) {
                if *weight > 0.0 {
                    x += *weight * place.transform_point(map.transform_point3(rest));
                }
            }
            *out = x;
        }
    }

    fn bend(&self, vertex: u32) -> f64 {
        let (rest, weights) = self.weights(vertex);
        let mut bend = 0.0;
        for ((map, path), weight) in self.maps.iter().zip(&weights[1..]) {
            bend += *weight * path.bend(map.transform_point3(rest));
        }
        bend * (1.0 + 8.0 * f64::EPSILON)
    }

    fn rigid(&self) -> Option<NearRigidPath> {
        let path = match self.follows {
            Follows::Nothing => RigidPath::at_rest(DVec3::ZERO),
            Follows::Bone(map) => self.maps[map].1,
            Follows::Blend => return None,
        };
        Some(NearRigidPath { path, deviation: 0.0 })
    }
}
