//! Contacts of a step by pair of bodies, with the material of the pair and the motion of bones.

use std::collections::BTreeMap;

use glam::DVec3;
use response::{ContactSet, Material, RigidMotion};
use surface::Contact;

use crate::step_sides::{KeptSide, SideMemory, key_of};
use crate::{BodyId, PairId, Scene};

/// Materials by pair.
#[derive(Clone, Debug)]
pub(crate) struct Materials {
    pub(crate) default: Material,
    pub(crate) by_pair: BTreeMap<PairId, Material>,
}

/// Motions of rigid bodies, by their numbers; `None` for soft bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bones(pub(crate) Vec<Option<RigidMotion>>);

/// Contacts of a step by pair of bodies, to be filled by a detector.
#[derive(Debug)]
pub struct PairContacts<'a> {
    pub(crate) set: &'a mut ContactSet,
    pub(crate) materials: &'a Materials,
    pub(crate) bones: &'a Bones,
    pub(crate) sides: &'a mut SideMemory,
    /// Positions of all particles.
    pub(crate) x: &'a [DVec3],
    pub(crate) step_number: u64,
}

impl PairContacts<'_> {
    /// Adds the contacts of a pair that were kept, not detected: vertices leave by the sides of
    /// these contacts.
    pub(crate) fn add_kept(&mut self, pair: PairId, contacts: &[Contact], sides: &[KeptSide]) {
        self.sides.keep(pair, sides);
        self.add(pair, contacts);
    }

    /// Replaces contacts of vertices that would leave a body by another side than they came in by.
    pub(crate) fn correct_sides(&mut self, scene: &Scene, pair: PairId, found: &mut [Contact]) {
        let bones = self.bones;
        let motion_of = |body: BodyId| bones.0[body.index()].unwrap_or_default();
        self.sides.correct_pair(scene, pair, found, &motion_of);
    }

    /// Returns the material of a pair.
    #[must_use]
    pub fn material(&self, pair: PairId) -> &Material {
        self.materials.of(pair)
    }

    /// Returns the number of contacts of the present detection so far.
    #[must_use]
    pub fn len(&self) -> usize {
        self.set.contacts().len()
    }

    /// Returns true if the present detection has found no contacts so far.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of the step, from 0. A step may detect several times.
    #[must_use]
    pub fn step_number(&self) -> u64 {
        self.step_number
    }

    /// Adds the contacts of a pair, with its material. Anchors get the velocity and the
    /// acceleration of their bone.
    pub fn add(&mut self, pair: PairId, contacts: &[Contact]) {
        let material = self.materials.of(pair);
        let motion = pair.bodies().iter().find_map(|body| self.bones.0[body.index()]);
        self.set.add(key_of(pair), material, &motion.unwrap_or_default(), contacts);
    }
}

impl Materials {
    pub(crate) fn of(&self, pair: PairId) -> &Material {
        self.by_pair.get(&pair).unwrap_or(&self.default)
    }
}

impl Bones {
    /// Returns the motion of a bone; `None` for a soft body.
    pub(crate) fn motion(&self, id: BodyId) -> Option<RigidMotion> {
        self.0[id.index()]
    }

    /// Adds bodies that are new in the scene, at rest.
    pub(crate) fn fit(&mut self, scene: &Scene) {
        for body in &scene.bodies()[self.0.len().min(scene.bodies().len())..] {
            self.0.push(body.is_rigid().then(RigidMotion::default));
        }
    }
}
