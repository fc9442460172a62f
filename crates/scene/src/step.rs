//! Contact step over a scene: materials by pair, bones in motion, and all soft bodies in the
//! caller's slices.

use std::collections::BTreeMap;

use ccd::CcdParams;
use glam::DVec3;
use proximity::ProximityError;
use response::{
    Combinations, ContactStep, Followers, Material, ParticleLoads, ParticleStates, ResponseError,
    RigidMotion, StepParams, StepReport, SweptReport,
};
use surface::Pose;

use crate::pair_contacts::{Bones, Materials, PairContacts};
use crate::step_sides::SideMemory;
use crate::step_sweep::MoveEnds;
use crate::{BodyId, PairId, Scene, SceneError};

/// States of all particles of a scene, body after body
/// ([`Body::particles`](crate::Body::particles)). Entries of rigid bodies are not changed.
#[derive(Debug)]
pub struct SceneStates<'a> {
    /// Positions.
    pub x: &'a mut [DVec3],
    /// Velocities.
    pub v: &'a mut [DVec3],
    /// Accelerations or forces of the next move, where the caller's integrator takes these.
    pub loads: ParticleLoads<'a>,
    /// Inverse masses, 0 where fixed.
    pub inverse_mass: &'a [f64],
}

/// Contact step over a scene: a [`ContactStep`] with a [`Material`] per pair and a
/// [`RigidMotion`] per bone.
///
/// It stands *before* the move, as [`ContactStep`] explains: forces, velocities, this step,
/// positions. Contacts may come from any detector. A vertex inside a thin body leaves by the
/// side that it came in by, if it approached by at most the thickness in a step, whichever
/// side the detector finds nearer.
///
/// ```
/// use scene::glam::{DQuat, DVec3};
/// use scene::response::{
///     Margins, Material, ParticleLoads, RigidMotion, StepLength, StepParams,
/// };
/// use scene::{BodyKind, PairId, Scene, SceneError, SceneStates, SceneStep, StepError};
/// use surface::{Contact, ContactSide, Pose, Term, TriangleSurface};
///
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let surface = TriangleSurface::new(4, faces)?;
/// let mut scene = Scene::new();
/// let bone = scene.add("bone", BodyKind::Rigid, surface.clone(), corners.to_vec())?;
/// let tissue = scene.add("tissue", BodyKind::Deformable, surface, corners.to_vec())?;
/// let first = scene.body(tissue).particles().start;
///
/// // The bone moves up at 3, under the first vertex of the tissue.
/// let mut step = SceneStep::new(Material::hard(Margins::new(0.0, 0.1)?));
/// let motion = RigidMotion { velocity: DVec3::Z * 3.0, ..RigidMotion::default() };
/// step.move_bone(&mut scene, bone, &Pose::IDENTITY, motion)?;
/// let mut x = scene.particle_positions();
/// let mut v = vec![DVec3::ZERO; x.len()];
/// let (loads, inverse_mass) = (ParticleLoads::None, vec![1.0; x.len()]);
/// let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
/// let params = StepParams::new(StepLength::new(0.01)?);
/// step.correct(&mut scene, states, &params, |scene, contacts| {
///     let vertex = [Term { particle: first, weight: 1.0 }];
///     let bone_side = ContactSide::at_rest(scene.body(tissue).positions()[0]);
///     let found = Contact::between(ContactSide::Particles(&vertex), bone_side, DVec3::Z, 0.0);
///     contacts.add(PairId::new(bone, tissue), &[found]);
///     Ok::<(), StepError>(())
/// })?;
/// assert_eq!(v[first as usize], DVec3::Z * 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneStep {
    materials: Materials,
    bones: Bones,
    sides: SideMemory,
    step: ContactStep,
    ends: MoveEnds,
    /// Number of bodies whose centers are combined.
    bodies_with_centers: usize,
    /// Number of steps before this one.
    number: u64,
}

/// Failure of a contact step over a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// A contact, a particle or a parameter.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// A body of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A coarse surface that does not follow its body.
    #[error("coarse surface of {name:?}: {source}")]
    Coarse {
        /// The body's name.
        name: String,
        /// The underlying error.
        source: ProximityError,
    },
    /// A pair with a permanent material, which pulls, whose contacts are not kept.
    #[error(
        "the material of {a:?} and {b:?} is permanent: choose the contacts that it pulls on by \
         StepDetectors::set_permanent"
    )]
    NotKept {
        /// The name of the first body.
        a: String,
        /// The name of the second.
        b: String,
    },
}

impl SceneStep {
    /// Returns a step in which all pairs have the same material, and all bones rest.
    #[must_use]
    pub fn new(default: Material) -> Self {
        let materials = Materials { default, by_pair: BTreeMap::new() };
        let (bones, sides) = (Bones::default(), SideMemory::default());
        let (step, ends) = (ContactStep::default(), MoveEnds::default());
        Self { materials, bones, sides, step, ends, bodies_with_centers: 0, number: 0 }
    }

    /// Sets the material of one pair.
    pub fn set_material(&mut self, pair: PairId, material: Material) {
        self.materials.by_pair.insert(pair, material);
    }

    /// Sets the particles that follow others, where the detector compares reduced surfaces.
    pub fn set_followers(&mut self, followers: Followers) {
        self.step.set_followers(followers);
    }

    /// Places a rigid body by its pose, and sets its motion there: the motion holds until the
    /// next call.
    ///
    /// # Errors
    ///
    /// As [`Scene::pose_body`].
    pub fn move_bone(
        &mut self,
        scene: &mut Scene,
        bone: BodyId,
        pose: &Pose,
        motion: RigidMotion,
    ) -> Result<(), SceneError> {
        scene.pose_body(bone, pose)?;
        self.bones.fit(scene);
        self.bones.0[bone.index()] = Some(motion);
        Ok(())
    }

    /// Corrects positions, velocities and loads of soft bodies: see [`ContactStep::correct`].
    ///
    /// Soft bodies of the scene are moved to `states.x` before each detection. `detect` adds
    /// the contacts of the scene's present state. Afterwards the scene has the corrected
    /// positions.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] unless there is one entry per particle, and those of
    /// [`ContactStep::correct`], [`Scene::move_body`] and `detect`.
    pub fn correct<E: From<ResponseError> + From<SceneError>>(
        &mut self,
        scene: &mut Scene,
        states: SceneStates<'_>,
        params: &StepParams,
        mut detect: impl FnMut(&mut Scene, &mut PairContacts<'_>) -> Result<(), E>,
    ) -> Result<StepReport, E> {
        let SceneStates { x, v, loads, inverse_mass } = states;
        scene.check_particles(x.len())?;
        self.bones.fit(scene);
        if self.bodies_with_centers != scene.bodies().len() {
            self.bodies_with_centers = scene.bodies().len();
            self.step.set_combinations(scene.centers()?);
        }
        let Self { materials, bones, sides, step, number, .. } = self;
        let step_number = *number;
        *number += 1;
        let particles = ParticleStates { x, v, loads, inverse_mass };
        let report = step.correct(particles, params, |x, set| {
            scene.move_soft_bodies(x)?;
            sides.begin_detection();
            detect(scene, &mut PairContacts { set, materials, bones, sides, x, step_number })?;
            let motion_of = |body: BodyId| bones.0[body.index()].unwrap_or_default();
            sides.correct(scene, set, motion_of).map_err(E::from)
        });
        // A step that fails is taken again: what was known before it stays known.
        if report.is_ok() {
            sides.end_step(scene);
        }
        report
    }

    /// Corrects velocities again, by contacts that are met on the way to x + h v, after
    /// [`Self::correct`] of the same step: see [`ContactStep::correct_swept`]. Bones move by their
    /// motions, all vertices on straight lines.
    ///
    /// What is in contact at the start is left to `correct`. Where contacts are left in the end,
    /// the move may stop at the [share](SweptReport::free_share) of it that is free.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] unless there is one entry per particle, and those of
    /// [`ContactStep::correct_swept`] and [`Scene::sweep`].
    pub fn correct_swept(
        &mut self,
        scene: &mut Scene,
        states: SceneStates<'_>,
        params: &StepParams,
        ccd: &CcdParams,
        report: &mut StepReport,
    ) -> Result<SweptReport, StepError> {
        let SceneStates { x, v, inverse_mass, .. } = states;
        scene.check_particles(x.len())?;
        scene.check_particles(v.len())?;
        self.bones.fit(scene);
        scene.move_soft_bodies(x)?;
        let Self { materials, bones, sides, step, ends, number, .. } = self;
        let (x, step_number) = (&*x, *number);
        step.correct_swept(v, inverse_mass, params, report, |v, set| {
            let mut contacts = PairContacts { set, materials, bones, sides, x, step_number };
            Ok(ends.sweep(scene, v, params.h, ccd, &mut contacts)?)
        })
    }

    /// Returns the number of contacts in the last detection of vertices inside a body that were
    /// neither in contact with it in the step before nor outside: they leave by the nearest side,
    /// which of a thin body may be the far one.
    ///
    /// It stays 0 where bodies start apart, and come nearer in a step by at most the thickness.
    #[must_use]
    pub fn unknown_sides(&self) -> usize {
        self.sides.unknown
    }

    /// Returns the step without the scene.
    #[must_use]
    pub fn contact_step(&self) -> &ContactStep {
        &self.step
    }
}

impl Scene {
    /// Returns the number of vertices of all bodies.
    pub(crate) fn particle_count(&self) -> usize {
        self.bodies.last().map_or(0, |body| body.particles().end as usize)
    }

    /// Checks that there is one state per particle.
    fn check_particles(&self, got: usize) -> Result<(), ResponseError> {
        let (what, expected) = ("particle states", self.particle_count());
        if got == expected { Ok(()) } else { Err(ResponseError::Count { what, expected, got }) }
    }

    /// Returns the centers of polygons of soft bodies.
    fn centers(&self) -> Result<Combinations, ResponseError> {
        let mut centers = Combinations::default();
        for body in self.bodies.iter().filter(|body| !body.is_rigid()) {
            body.add_centers(&mut centers)?;
        }
        Ok(centers)
    }

    /// Moves soft bodies to the positions of all particles.
    fn move_soft_bodies(&mut self, x: &[DVec3]) -> Result<(), SceneError> {
        for body in self.bodies.iter_mut().filter(|body| !body.is_rigid()) {
            let particles = body.particles();
            let x = &x[particles.start as usize..particles.end as usize];
            if x != body.positions() {
                body.set_positions(x)?;
            }
        }
        Ok(())
    }
}
