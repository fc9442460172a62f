//! Planted scenes: bones, soft bodies, their motion, and what has to come of it. Millimeters,
//! grams, seconds.

use fixtures::Mesh;
use fixtures::shapes::{capsule, ellipsoid, icosphere, plate};
use glam::{DQuat, DVec3};
use musculo_collide::{BodyId, BodyKind, Scene, SceneError};
use surface::Pose;

use super::Setting;
use super::drive::{Drive, smooth};
use super::tissue::{Hold, Tissue};

/// Gravity \[mm/s²\].
pub const GRAVITY: f64 = 9810.0;

/// Coefficients of friction of the slab that sticks, and of that which slides.
const STICKING_FRICTION: f64 = 0.5;
const SLIDING_FRICTION: f64 = 0.2;

/// Angle of the slope \[turns\]: 20°.
const SLOPE: f64 = 20.0 / 360.0;
const SLOPE_TANGENT: f64 = 0.364;

/// Stiffness over mass of soft bodies \[1/s²\]: a ball 20 mm thick flattens by 1.4 mm under its
/// weight.
const STIFFNESS: f64 = 2e5;

/// Thickness of the thin plate, and the approach to it per step \[mm\].
const THIN: f64 = 1.0;
const THIN_APPROACH: f64 = 0.8;

/// Planted scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planted {
    /// A soft ball is let down on a bone.
    Rest,
    /// A slab on a slope, with friction that holds it.
    SlopeHeld,
    /// The same with less friction, on a bone of two faces: it slides.
    SlopeSliding,
    /// The same on a bone with vertices under way, which may catch it.
    SlopeCatching,
    /// A soft ball between two bones, one of which comes nearer.
    Squeeze,
    /// A soft ball thrown at a bone of 1 mm, of which it crosses 0.8 mm per step.
    ThinPlate,
    /// A muscle that shortens, thickens and bends round a bone.
    Shortening,
    /// Three slabs on each other and on a bone.
    Stack,
    /// A bone is driven into a muscle, and out again.
    DrivenIn,
    /// The edge of a soft wedge is pressed across the edge of a bone.
    EdgeOnEdge,
}

/// Outcome that a scene must have, beside what has to hold in all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// All come to rest.
    Rest,
    /// The body sticks where it lies.
    Stick,
    /// The body slides down with an acceleration \[mm/s²\].
    Slide {
        /// Direction.
        down: DVec3,
        /// Acceleration.
        acceleration: f64,
    },
    /// The body moves away again.
    Rebound,
    /// All come to rest where they were at first.
    Return,
}

/// Bone of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Bone {
    /// Body of the scene.
    pub id: BodyId,
    /// Its motion.
    pub drive: Drive,
}

/// Half-space that no soft vertex may be in.
#[derive(Clone, Copy, Debug)]
pub struct FarSide {
    /// Point of its border: inside a bone.
    pub point: DVec3,
    /// Direction out of it.
    pub normal: DVec3,
    /// Largest distance from the point along x that counts.
    pub half_width: f64,
    /// Bone that it moves with.
    pub bone: usize,
}

/// Bodies of a scene with their motion.
#[derive(Debug)]
pub struct World {
    /// The bodies.
    pub scene: Scene,
    /// Rigid bodies.
    pub bones: Vec<Bone>,
    /// Soft bodies.
    pub tissues: Vec<Tissue>,
    /// Gravity.
    pub gravity: DVec3,
    /// Coefficient of friction.
    pub friction: f64,
    /// Gap up to which contacts are detected.
    pub margin: f64,
    /// Spacing of distance fields.
    pub field_spacing: f64,
    /// Simulated time.
    pub duration: f64,
    /// Fall before the first contact.
    pub drop: f64,
    /// Way per step at the start.
    pub approach: DVec3,
    /// Half-spaces that no vertex may be in.
    pub far_sides: Vec<FarSide>,
    /// Outcome that it must have.
    pub expected: Expected,
    /// Positions at the start.
    pub start: Vec<DVec3>,
    /// Present time.
    pub time: f64,
}

impl Planted {
    /// All scenes.
    pub const ALL: [Self; 10] = [
        Self::Rest,
        Self::SlopeHeld,
        Self::SlopeSliding,
        Self::SlopeCatching,
        Self::Squeeze,
        Self::ThinPlate,
        Self::Shortening,
        Self::Stack,
        Self::DrivenIn,
        Self::EdgeOnEdge,
    ];

    /// Returns the name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::SlopeHeld => "slope held",
            Self::SlopeSliding => "slope sliding",
            Self::SlopeCatching => "slope catching",
            Self::Squeeze => "squeeze",
            Self::ThinPlate => "thin plate",
            Self::Shortening => "shortening",
            Self::Stack => "stack",
            Self::DrivenIn => "driven in",
            Self::EdgeOnEdge => "edge on edge",
        }
    }

    /// Returns the title in pictures.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Rest => "rest: a soft ball let down on a bone",
            Self::SlopeHeld => "slope of 20°, µ 0.5: a slab that must stick",
            Self::SlopeSliding => "slope of 20°, µ 0.2: a slab that must slide, on two large faces",
            Self::SlopeCatching => "the same on a bone with vertices every 2 mm under way",
            Self::Squeeze => "squeeze: a soft ball between two bones",
            Self::ThinPlate => "thin plate: 0.8 mm per step at a bone of 1 mm",
            Self::Shortening => "a muscle that shortens round a bone",
            Self::Stack => "stack: three slabs on a bone",
            Self::DrivenIn => "a bone driven into a muscle, and out again",
            Self::EdgeOnEdge => "edge on edge: a soft wedge across a bone's edge",
        }
    }

    /// Builds the scene.
    ///
    /// # Errors
    ///
    /// As [`Scene::add`].
    pub fn build(self) -> Result<World, SceneError> {
        let mut world = World::new();
        match self {
            Self::Rest => world.rest(icosphere(10.0, 2))?,
            Self::SlopeHeld => world.slope(STICKING_FRICTION, [60, 20])?,
            Self::SlopeSliding => world.slope(SLIDING_FRICTION, [1, 1])?,
            Self::SlopeCatching => world.slope(SLIDING_FRICTION, [60, 20])?,
            Self::Squeeze => world.squeeze()?,
            Self::ThinPlate => world.thin_plate()?,
            Self::Shortening => world.shortening()?,
            Self::Stack => world.stack()?,
            Self::DrivenIn => world.driven_in()?,
            Self::EdgeOnEdge => world.edge_on_edge()?,
        }
        world.start = world.scene.particle_positions();
        world.expected = self.expected();
        Ok(world)
    }

    /// Returns what has to come of the scene.
    #[must_use]
    pub fn expected(self) -> Expected {
        match self {
            Self::SlopeSliding | Self::SlopeCatching => {
                let turn = DQuat::from_rotation_y(SLOPE * std::f64::consts::TAU);
                let (down, normal) = (turn * DVec3::X, turn * DVec3::Z);
                let share = down.dot(-DVec3::Z) - SLIDING_FRICTION * normal.z;
                Expected::Slide { down, acceleration: GRAVITY * share }
            }
            Self::SlopeHeld => Expected::Stick,
            Self::ThinPlate => Expected::Rebound,
            Self::DrivenIn => Expected::Return,
            _ => Expected::Rest,
        }
    }
}

impl World {
    fn new() -> Self {
        Self {
            scene: Scene::new(),
            bones: Vec::new(),
            tissues: Vec::new(),
            gravity: DVec3::ZERO,
            friction: 0.5,
            margin: 0.5,
            field_spacing: 0.5,
            duration: 0.22,
            drop: 0.3,
            approach: DVec3::ZERO,
            far_sides: Vec::new(),
            expected: Expected::Rest,
            start: Vec::new(),
            time: 0.0,
        }
    }

    /// Builds the scene of a ball let down on a bone, with a ball of one's own.
    ///
    /// # Errors
    ///
    /// As [`Scene::add`].
    pub fn at_rest(ball: Mesh) -> Result<Self, SceneError> {
        let mut world = Self::new();
        world.rest(ball)?;
        world.start = world.scene.particle_positions();
        Ok(world)
    }

    fn add_bone(&mut self, name: &str, mesh: Mesh, drive: Drive) -> Result<usize, SceneError> {
        let id = self.scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions)?;
        self.bones.push(Bone { id, drive });
        Ok(self.bones.len() - 1)
    }

    fn add_tissue(&mut self, name: &str, mesh: Mesh, hold: Hold) -> Result<(), SceneError> {
        let (kind, surface) = (BodyKind::Deformable, mesh.surface());
        let id = self.scene.add(name, kind, surface, mesh.positions.clone())?;
        let particles = self.scene.body(id).particles();
        let particles = particles.start as usize..particles.end as usize;
        self.tissues.push(Tissue::new(particles, mesh.positions, hold));
        Ok(())
    }

    /// Forbids the half-space below a point of a bone, against a direction.
    fn forbid_below(&mut self, bone: usize, point: DVec3, normal: DVec3) {
        self.far_sides.push(FarSide { point, normal, half_width: f64::INFINITY, bone });
    }

    fn rest(&mut self, ball: Mesh) -> Result<(), SceneError> {
        let floor = self.add_bone("bone", floor(4.0), Drive::Still)?;
        let lowest = ball.bounds().min.z;
        self.add_tissue("ball", ball.translated(DVec3::Z * (0.3 - lowest)), Hold::Shape)?;
        self.duration = 0.4;
        self.gravity = DVec3::Z * -GRAVITY;
        self.forbid_below(floor, DVec3::Z * -2.0, DVec3::Z);
        Ok(())
    }

    fn slope(&mut self, friction: f64, squares: [u32; 2]) -> Result<(), SceneError> {
        // All turned about y, so that x leads down.
        let turned = |mesh: Mesh| mesh.rotated(DVec3::Y, SLOPE);
        let mesh = plate(DVec3::new(120.0, 40.0, 4.0), squares).translated(DVec3::Z * -2.0);
        let bone = self.add_bone("bone", turned(mesh), Drive::Still)?;
        let slides = friction < SLOPE_TANGENT;
        let at = if slides { -40.0 } else { 0.0 };
        let slab = plate(DVec3::new(20.0, 16.0, 6.0), [10, 8]);
        let slab = slab.translated(DVec3::new(at, 0.0, 3.1));
        self.add_tissue("slab", turned(slab), Hold::Shape)?;

        let normal = DQuat::from_rotation_y(SLOPE * std::f64::consts::TAU) * DVec3::Z;
        self.gravity = DVec3::Z * -GRAVITY;
        (self.friction, self.drop) = (friction, 0.1);
        self.field_spacing = 1.0;
        self.duration = if slides { 0.16 } else { 0.5 };
        self.far_sides.push(FarSide { point: normal * -2.0, normal, half_width: 50.0, bone });
        Ok(())
    }

    fn squeeze(&mut self) -> Result<(), SceneError> {
        let lower = self.add_bone("lower bone", floor(4.0), Drive::Still)?;
        let above = floor(4.0).translated(DVec3::Z * 24.4);
        let upper = self.add_bone("upper bone", above, Drive::To(DVec3::Z * -3.0, 0.12))?;
        let ball = icosphere(10.0, 2).translated(DVec3::Z * 10.2);
        self.add_tissue("ball", ball, Hold::Shape)?;
        self.friction = 0.3;
        self.forbid_below(lower, DVec3::Z * -2.0, DVec3::Z);
        self.forbid_below(upper, DVec3::Z * 22.4, -DVec3::Z);
        Ok(())
    }

    fn thin_plate(&mut self) -> Result<(), SceneError> {
        let bone = self.add_bone("bone", floor(THIN), Drive::Still)?;
        let ball = icosphere(10.0, 2).translated(DVec3::Z * 12.0);
        self.add_tissue("ball", ball, Hold::Shape)?;
        self.approach = DVec3::Z * -THIN_APPROACH;
        self.margin = 2.5;
        self.duration = 0.06;
        self.forbid_below(bone, DVec3::Z * (-0.5 * THIN), DVec3::Z);
        Ok(())
    }

    fn shortening(&mut self) -> Result<(), SceneError> {
        let shaft = capsule(6.0, 30.0, 16).rotated(DVec3::X, 0.25);
        let bone = self.add_bone("bone", shaft.translated(DVec3::Z * -6.0), Drive::Still)?;
        let muscle = ellipsoid(DVec3::new(24.0, 9.0, 5.0), 2).translated(DVec3::Z * 5.3);
        self.add_tissue("muscle", muscle, Hold::Place(shortened))?;
        self.far_sides.push(FarSide {
            point: DVec3::Z * -6.0,
            normal: DVec3::Z,
            half_width: 6.0,
            bone,
        });
        Ok(())
    }

    fn stack(&mut self) -> Result<(), SceneError> {
        let bone = self.add_bone("bone", floor(4.0), Drive::Still)?;
        for (number, name) in (0..).zip(["lowest", "middle", "highest"]) {
            // Each is turned against the one below, so that vertices do not meet vertices.
            let slab = plate(DVec3::new(16.0, 16.0, 6.0), [6, 6]);
            let slab = slab.rotated(DVec3::Z, 0.03 * f64::from(number));
            let height = 3.1 + 6.1 * f64::from(number);
            self.add_tissue(name, slab.translated(DVec3::Z * height), Hold::Shape)?;
        }
        self.duration = 0.4;
        self.gravity = DVec3::Z * -GRAVITY;
        self.forbid_below(bone, DVec3::Z * -2.0, DVec3::Z);
        Ok(())
    }

    fn driven_in(&mut self) -> Result<(), SceneError> {
        let finger = capsule(4.0, 20.0, 12).translated(DVec3::new(0.4, 0.3, 23.0));
        self.add_bone("bone", finger, Drive::ToAndBack(DVec3::Z * -5.0, 0.14))?;
        let muscle = ellipsoid(DVec3::new(16.0, 11.0, 8.0), 2);
        self.add_tissue("muscle", muscle, Hold::Place(|rest, _| rest))?;
        self.friction = 0.2;
        Ok(())
    }

    fn edge_on_edge(&mut self) -> Result<(), SceneError> {
        // Upside down, and turned so that its edge crosses that of the bone.
        let turned = |mesh: Mesh| mesh.rotated(DVec3::X, 0.5).rotated(DVec3::Z, 0.21);
        self.add_bone("bone", wedge(), Drive::Still)?;
        let soft = turned(wedge()).translated(DVec3::Z * 0.3);
        self.add_tissue("wedge", soft, Hold::Place(pressed_down))?;
        self.friction = 0.2;
        Ok(())
    }

    /// Puts all bodies back to the start, for a setting; returns the velocities there.
    ///
    /// # Errors
    ///
    /// As [`Scene::move_body`].
    pub fn reset(&mut self, setting: Setting) -> Result<Vec<DVec3>, SceneError> {
        for bone in &self.bones {
            self.scene.pose_body(bone.id, &Pose::IDENTITY)?;
        }
        self.time = 0.0;
        let (start, mut v) = (self.start.clone(), vec![DVec3::ZERO; self.start.len()]);
        self.move_tissues(&start)?;
        for tissue in &mut self.tissues {
            v[tissue.particles.clone()].fill(self.approach / setting.step);
            tissue.stiffness = STIFFNESS * setting.stiffness;
            tissue.mass = 1.0;
            tissue.reset();
        }
        if let Some(last) = self.tissues.last_mut() {
            last.mass = setting.mass_ratio;
        }
        Ok(v)
    }

    /// Returns the soft bodies: all after the bones.
    #[must_use]
    pub fn soft_bodies(&self) -> Vec<BodyId> {
        self.scene.ids().skip(self.bones.len()).collect()
    }

    /// Moves the soft bodies of the scene to the positions of all particles.
    ///
    /// # Errors
    ///
    /// As [`Scene::move_body`].
    pub fn move_tissues(&mut self, x: &[DVec3]) -> Result<(), SceneError> {
        for (tissue, id) in self.tissues.iter().zip(self.soft_bodies()) {
            self.scene.move_body(id, &x[tissue.particles.clone()])?;
        }
        Ok(())
    }

    /// Returns the number of soft vertices that left by a far side.
    #[must_use]
    pub fn far_count(&self, x: &[DVec3]) -> usize {
        let mut count = 0;
        for far in &self.far_sides {
            let point = far.point + self.bones[far.bone].drive.way(self.time);
            for tissue in &self.tissues {
                for x in &x[tissue.particles.clone()] {
                    let is_beside = (x.x - point.x).abs() > far.half_width;
                    count += usize::from(!is_beside && (*x - point).dot(far.normal) < 0.0);
                }
            }
        }
        count
    }
}

/// A plate whose top is at height 0.
fn floor(thickness: f64) -> Mesh {
    plate(DVec3::new(70.0, 60.0, thickness), [35, 30]).translated(DVec3::Z * (-0.5 * thickness))
}

/// A prism along x whose upper edge is at height 0.
fn wedge() -> Mesh {
    let mut positions = Vec::new();
    for x in [-12.0, 12.0] {
        positions.extend([DVec3::new(x, -8.0, -10.0), DVec3::new(x, 8.0, -10.0), DVec3::X * x]);
    }
    let faces = vec![
        [0, 2, 1],
        [3, 4, 5],
        [0, 1, 4],
        [0, 4, 3],
        [1, 2, 5],
        [1, 5, 4],
        [2, 0, 3],
        [2, 3, 5],
    ];
    Mesh { positions, faces }
}

/// A muscle that shortens by a quarter, keeps its volume, and bends down by 4 mm at the ends.
fn shortened(rest: DVec3, time: f64) -> DVec3 {
    let shorter = 1.0 - 0.25 * smooth(time / 0.12);
    let wider = shorter.sqrt().recip();
    let x = rest.x * shorter;
    let height = 5.3 + (rest.z - 5.3) * wider;
    let bent = smooth(time / 0.12) * (1.0 + x * x / 120.0);
    DVec3::new(x, rest.y * wider, height - bent)
}

/// Down by 1.5 mm.
fn pressed_down(rest: DVec3, time: f64) -> DVec3 {
    rest - DVec3::Z * 1.5 * smooth(time / 0.12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_bodies_are_closed_and_apart_at_the_start() {
        for planted in Planted::ALL {
            let mut world = planted.build().unwrap();
            for body in world.scene.bodies() {
                assert!(body.has_inside().is_ok(), "{planted:?}: {}", body.name());
                let volume: f64 = (0..)
                    .zip(body.surface().faces())
                    .map(|(face, _)| {
                        let [a, b, c] = body.corners(face);
                        a.dot(b.cross(c))
                    })
                    .sum();
                assert!(volume > 0.0, "{planted:?}: {} is inside out", body.name());
            }
            let params = musculo_collide::CheckParams::without_measures(0.0);
            let found = world.scene.check(&params, musculo_collide::Progress::none()).unwrap();
            assert!(found.iter().all(|pair| !pair.overlaps), "{planted:?}");
            assert_eq!(world.far_count(&world.start), 0, "{planted:?}");
        }
    }
}
