//! Ties of a scene: vertices that follow another body, and seams.

use std::collections::{BTreeMap, BTreeSet};

use scene::{BodyId, PairId, Scene};

use crate::conditions::{TieBond, TieBonds};
use crate::near_pairs::NearPairs;
use crate::seams::Seams;
use crate::tissue::Tissue;
use crate::{Conditions, ResolveError};

/// Ties of a scene.
pub(crate) struct Ties {
    /// Pairs that are tied, ascending.
    pub(crate) pairs: Vec<PairId>,
    /// All bonds, those of loose vertices and seams among them.
    pub(crate) all: TieBonds,
    /// Bonds that hold, those of seams among them.
    pub(crate) held: TieBonds,
    /// Vertices that follow a point of another body from a distance, or of a rigid one.
    pub(crate) bonds: Vec<TieBond>,
    /// Vertices of soft bodies that are tied at one place.
    pub(crate) seams: Seams,
    /// True for particles that follow another body; empty where none does.
    pub(crate) is_follower: Vec<bool>,
    /// Particles of each pair that follow its other body.
    pub(crate) particles: BTreeMap<PairId, BTreeSet<u32>>,
}

impl Ties {
    /// Finds the vertices that follow another body but for loose ones, unless they are `known` from an earlier state, and
    /// fixes those at one place with fixed ones.
    pub(crate) fn new(
        conditions: &Conditions,
        scene: &Scene,
        tissues: &mut [Tissue],
        near: &NearPairs,
        loose: &BTreeSet<(BodyId, u32)>,
        known: Option<&TieBonds>,
    ) -> Result<Self, ResolveError> {
        let all = match known {
            Some(known) => known.without_crossing(scene, near),
            None => conditions.tie_bonds(scene, tissues, near)?,
        };
        let held = all.without_loose(loose);
        let mut bonds = held.bonds.clone();
        let count = scene.bodies().last().map_or(0, |body| body.particles().end);
        let follower = |bond: &TieBond| scene.body(bond.follower).particles().start + bond.vertex;
        let (mut is_follower, mut particles) = (Vec::new(), BTreeMap::<_, BTreeSet<u32>>::new());
        for bond in &bonds {
            is_follower.resize(count as usize, false);
            is_follower[follower(bond) as usize] = true;
            let pair = PairId::new(bond.follower, bond.leader);
            particles.entry(pair).or_default().insert(follower(bond));
        }

        let seams = Seams::new(scene, &bonds);
        bonds.retain(|bond| bond.corner_at_follower(scene).is_none());
        seams.fix(scene, tissues);
        Ok(Self { pairs: conditions.tied_pairs(), all, held, bonds, seams, is_follower, particles })
    }
}
