//! Responses of the runner: what makes of contacts a change of positions, velocities or forces.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3};
use musculo_collide::scene::{StepDetectors, StepError};
use musculo_collide::{
    Friction, Margins, Material, PairContacts, ParticleLoads, Scene, SceneStates, SceneStep,
    SpringDamper, StepLength, StepParams,
};
use response::{
    ContactLaw, ContactRows, NormalForce, ResponseError, Restraint, SoftContacts, SoftLaw,
    SolverMethod, SolverParams,
};
use surface::{Contact, Pose};

use super::Setting;
use super::scenes::World;

/// Distance over which approaches are slowed \[mm\].
const PROXIMITY: f64 = 0.5;

/// Stiffness of a soft contact \[g/s²\]: a particle of 1 g has ω h = 1.2 at 1 ms, where an explicit
/// step holds up to 1.8, and the ball sinks in by 0.1 mm.
const CONTACT_STIFFNESS: f64 = 1.4e6;

/// Damping ratio of a soft contact of 1 g.
const CONTACT_DAMPING: f64 = 0.1;

/// Slip at which explicit friction is full \[mm/s\].
const SLIP: f64 = 1.0;

/// Settings of the solver in all runs.
const SOLVER: SolverParams =
    SolverParams { method: SolverMethod::GaussSeidel, max_iterations: 30, tolerance: 1e-9 };

/// Response to contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Positions after the move, from which velocities follow.
    Positions,
    /// Positions, then velocities, before the move.
    Sequence,
    /// Velocities before the move.
    Velocity,
    /// Accelerations before the move.
    Acceleration,
    /// Penalty forces at the start of the step.
    SoftExplicit,
    /// Springs taken implicitly in the velocities.
    SoftImplicit,
    /// Positions and velocities of contacts that slide and never open.
    Reference,
}

/// Response to the contacts of a scene, with the memory of the last step.
#[derive(Debug)]
pub struct Responder {
    response: Response,
    step: SceneStep,
    material: Material,
    params: StepParams,
    inverse_mass: Vec<f64>,
    /// Velocities before the forces of the step.
    before: Vec<DVec3>,
}

/// Contact without its numbers: its pair of bodies, and the particles that it acts on.
pub type Touch = (u64, Vec<u32>);

/// Account of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepAccount {
    /// Iterations of the solver.
    pub iterations: u32,
    /// Largest depth as first detected.
    pub depth: f64,
    /// Work of the bones \[g mm²/s²\]; `None` where the response does not tell.
    pub work: Option<f64>,
    /// Energy of soft contacts at the start of the step.
    pub contact_energy: f64,
    /// Vertices found inside that were not seen outside.
    pub unknown_sides: usize,
    /// Pairs that were not detected by their method.
    pub fallbacks: usize,
}

impl Response {
    /// All responses.
    pub const ALL: [Self; 7] = [
        Self::Positions,
        Self::Sequence,
        Self::Velocity,
        Self::Acceleration,
        Self::SoftExplicit,
        Self::SoftImplicit,
        Self::Reference,
    ];

    /// Returns the name in tables and pictures.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Positions => "positions",
            Self::Sequence => "sequence",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::SoftExplicit => "soft explicit",
            Self::SoftImplicit => "soft implicit",
            Self::Reference => "reference",
        }
    }

    fn material(self, friction: f64) -> Result<Material, ResponseError> {
        let friction = Friction::coulomb(friction)?;
        let hard = Material { friction, ..Material::hard(Margins::new(0.0, PROXIMITY)?) };
        Ok(match self {
            Self::SoftImplicit => {
                let spring = SpringDamper::new(CONTACT_STIFFNESS, contact_damping())?;
                Material { spring: Some(spring), ..hard }
            }
            Self::Reference => Material { permanent: Some(Restraint::Sliding), ..hard },
            _ => hard,
        })
    }

    fn params(self, h: f64) -> Result<StepParams, ResponseError> {
        let all =
            StepParams { solver: SOLVER, max_rounds: 2, ..StepParams::new(StepLength::new(h)?) };
        Ok(match self {
            Self::Positions => StepParams { approach_tolerance: None, ..all },
            Self::SoftExplicit => {
                StepParams { depth_tolerance: None, approach_tolerance: None, ..all }
            }
            Self::Velocity => StepParams { depth_tolerance: None, ..all },
            Self::Acceleration => StepParams {
                depth_tolerance: None,
                approach_tolerance: None,
                push_tolerance: Some(0.0),
                ..all
            },
            _ => all,
        })
    }
}

fn contact_damping() -> f64 {
    2.0 * CONTACT_DAMPING * CONTACT_STIFFNESS.sqrt()
}

impl Responder {
    /// Prepares a response for a scene.
    ///
    /// # Errors
    ///
    /// As [`StepDetectors::followers`], and for a step out of range.
    pub fn new(
        response: Response,
        world: &World,
        detectors: &StepDetectors,
        setting: Setting,
    ) -> Result<Self, StepError> {
        let material = response.material(world.friction)?;
        let mut step = SceneStep::new(material);
        step.set_followers(detectors.followers(&world.scene)?);

        // Bones keep an inverse mass of 0, so that contacts do not move them.
        let mut inverse_mass = vec![0.0; world.start.len()];
        for tissue in &world.tissues {
            inverse_mass[tissue.particles.clone()].fill(tissue.mass.recip());
        }

        let params = response.params(setting.step)?;
        Ok(Self { response, step, material, params, inverse_mass, before: Vec::new() })
    }

    /// Moves the bones to a time, with the velocities of the step that follows.
    ///
    /// # Errors
    ///
    /// As [`SceneStep::move_bone`].
    pub fn move_bones(&mut self, world: &mut World, time: f64) -> Result<(), StepError> {
        let h = self.params.h.get();
        for bone in &world.bones {
            let pose = Pose::new(DQuat::IDENTITY, bone.drive.way(time));
            let motion = bone.drive.motion(time, h);
            self.step.move_bone(&mut world.scene, bone.id, &pose, motion)?;
        }
        Ok(())
    }

    /// Keeps the velocities before forces, which a response to accelerations needs.
    pub fn begin(&mut self, v: &[DVec3]) {
        self.before.clear();
        self.before.extend_from_slice(v);
    }

    /// Moves particles by a step in which contacts are answered.
    ///
    /// # Errors
    ///
    /// Those of detection and response.
    pub fn advance(
        &mut self,
        world: &mut World,
        detectors: &mut StepDetectors,
        x: &mut [DVec3],
        v: &mut [DVec3],
    ) -> Result<StepAccount, StepError> {
        let h = self.params.h.get();
        let account = match self.response {
            Response::Positions => {
                return self.advance_positions(world, detectors, x, v);
            }
            Response::SoftExplicit => self.push(world, detectors, x, v)?,
            Response::Acceleration => {
                // The forces of the step as accelerations, which contacts may then take away.
                let change = v.iter().zip(&self.before).map(|(v, before)| (*v - *before) / h);
                let mut a: Vec<DVec3> = change.collect();
                v.copy_from_slice(&self.before);
                let loads = ParticleLoads::Accelerations(&mut a);
                let account = self.correct(world, detectors, [&mut *x, &mut *v], loads)?;
                for (v, a) in v.iter_mut().zip(&a) {
                    *v += h * *a;
                }
                StepAccount { work: None, ..account }
            }
            Response::Sequence
            | Response::Velocity
            | Response::SoftImplicit
            | Response::Reference => {
                self.correct(world, detectors, [&mut *x, &mut *v], ParticleLoads::None)?
            }
        };

        // The move itself, by the velocities after the response.
        for (x, v) in x.iter_mut().zip(v) {
            *x += h * *v;
        }
        Ok(account)
    }

    /// Corrects a state by the contact step.
    fn correct(
        &mut self,
        world: &mut World,
        detectors: &mut StepDetectors,
        [x, v]: [&mut [DVec3]; 2],
        loads: ParticleLoads<'_>,
    ) -> Result<StepAccount, StepError> {
        let states = SceneStates { x, v, loads, inverse_mass: &self.inverse_mass };
        let detect =
            |scene: &mut Scene, contacts: &mut PairContacts<'_>| detectors.detect(scene, contacts);
        let report = self.step.correct(&mut world.scene, states, &self.params, detect)?;

        let mut iterations = 0;
        for solved in [report.positions, report.velocities, report.loads] {
            iterations += solved.map_or(0, |solved| solved.iterations);
        }

        // For soft contacts, the depth is that of the contacts themselves.
        let of_soft = || deepest(self.step.contact_step().contacts().contacts());
        Ok(StepAccount {
            iterations,
            depth: if self.material.is_hard() { report.depth_before } else { of_soft() },
            work: Some(report.rigid_work),
            contact_energy: report.contact_energy,
            unknown_sides: self.step.unknown_sides(),
            fallbacks: detectors.fallbacks().len(),
        })
    }

    /// Moves first, then pushes positions apart; velocities follow from both.
    fn advance_positions(
        &mut self,
        world: &mut World,
        detectors: &mut StepDetectors,
        x: &mut [DVec3],
        v: &mut [DVec3],
    ) -> Result<StepAccount, StepError> {
        let h = self.params.h.get();
        let before = x.to_vec();
        for (x, v) in x.iter_mut().zip(&*v) {
            *x += h * *v;
        }

        // Bones move to the end of the step too, so that contacts are those of the moved state.
        self.move_bones(world, world.time + h)?;
        let account = self.correct(world, detectors, [&mut *x, &mut *v], ParticleLoads::None)?;

        // Velocities follow from the positions, corrections included.
        for ((v, x), before) in v.iter_mut().zip(x).zip(before) {
            *v = (*x - before) / h;
        }
        // Its depth is of another state than that at the start of the step.
        Ok(StepAccount { work: None, depth: f64::NAN, ..account })
    }

    /// Adds penalty forces to velocities.
    fn push(
        &mut self,
        world: &mut World,
        detectors: &mut StepDetectors,
        x: &mut [DVec3],
        v: &mut [DVec3],
    ) -> Result<StepAccount, StepError> {
        // The contacts of the present state, with their bones' velocities; nothing is corrected.
        let account = self.correct(world, detectors, [x, &mut *v], ParticleLoads::None)?;
        let contacts = self.step.contact_step().contacts().contacts();
        let law = ContactLaw::new(self.material.margins, 0.0)?;
        let mut rows = ContactRows::new(v.len());
        rows.extend(contacts, law.with_friction(self.material.friction))?;

        // Forces at the velocities before the step.
        let (stiffness, damping) = (CONTACT_STIFFNESS, contact_damping());
        let penalty = SoftLaw::new(NormalForce::Penalty { stiffness, damping }, SLIP)?;
        let soft = SoftContacts::new(&rows, &self.before, penalty)?;
        let mut force = vec![DVec3::ZERO; v.len()];
        soft.add_forces(&mut force)?;
        let h = self.params.h.get();
        for ((v, force), w) in v.iter_mut().zip(&force).zip(&self.inverse_mass) {
            *v += h * *w * *force;
        }

        // Energy of the springs alone, over all contacts that overlap.
        let depths = contacts.iter().map(|contact| contact.gap.min(0.0).powi(2));
        let contact_energy = 0.5 * stiffness * depths.sum::<f64>();
        Ok(StepAccount { work: None, contact_energy, ..account })
    }

    /// Returns the contacts of the last step whose gap is at most `gap`.
    #[must_use]
    pub fn touches(&self, gap: f64) -> BTreeSet<Touch> {
        let (set, mut touches) = (self.step.contact_step().contacts(), BTreeSet::new());
        for group in set.groups() {
            for contact in &set.contacts()[group.contacts.clone()] {
                if contact.gap <= gap {
                    let terms = contact.stencil.terms().iter();
                    touches.insert((group.pair, terms.map(|term| term.particle).collect()));
                }
            }
        }
        touches
    }
}

/// Returns the largest depth of contacts.
fn deepest(contacts: &[Contact]) -> f64 {
    contacts.iter().fold(0.0, |depth, contact| depth.max(-contact.gap))
}
