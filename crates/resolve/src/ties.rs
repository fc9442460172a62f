//! Motion of tied vertices with their leaders.

use std::collections::BTreeMap;

use glam::DVec3;
use scene::{BodyId, PairId};
use surface::{Contact, Term};

use crate::elastic::{Bond, ElasticProblem};
use crate::run::Run;

impl Run<'_> {
    /// Returns true if two bodies are tied to each other.
    pub(crate) fn is_tied(&self, pair: PairId) -> bool {
        self.tied.binary_search(&pair).is_ok()
    }

    /// Returns true if a vertex of a contact is tied.
    pub(crate) fn is_of_tie(&self, contact: &Contact) -> bool {
        let is_tied = |term: &Term| self.is_follower[term.particle as usize];
        !self.tie_bonds.is_empty() && contact.stencil.terms().iter().any(is_tied)
    }

    /// Moves tied vertices with their leaders in this round.
    pub(crate) fn follow_ties(&mut self) {
        for bond in &self.tie_bonds {
            let leader = &self.tissues[bond.leader.index()];
            let mut u = DVec3::ZERO;
            for (corner, weight) in bond.corners.into_iter().zip(bond.weights) {
                u += weight * leader.u[corner as usize];
            }
            self.tissues[bond.follower.index()].u[bond.vertex as usize] = u;
        }
    }

    /// Adds the particles of ties to those that move, where one of their bodies does.
    pub(crate) fn add_tie_seeds(&self, seeds: &mut BTreeMap<BodyId, Vec<u32>>) {
        for tie in &self.tie_bonds {
            if seeds.contains_key(&tie.follower) || seeds.contains_key(&tie.leader) {
                seeds.entry(tie.follower).or_default().push(tie.vertex);
                seeds.entry(tie.leader).or_default().extend(tie.corners);
            }
        }
    }

    /// Adds ties as bonds where their vertices take part.
    pub(crate) fn add_tie_bonds(&self, problem: &mut ElasticProblem) {
        for tie in &self.tie_bonds {
            let first = |id: BodyId| self.scene.body(id).particles().start;
            let corners = tie.corners.into_iter().zip(tie.weights);
            let corners = corners.map(|(corner, weight)| (first(tie.leader) + corner, -weight));
            let follower = (first(tie.follower) + tie.vertex, 1.0);
            let terms = std::iter::once(follower).chain(corners).collect();
            let tissue = &self.tissues[tie.follower.index()];
            let mass = tissue.area(tie.vertex) * tissue.mass_per_area();
            let stiffness = mass / (self.params.tuning.slack * tissue.mean_edge * tissue.mean_edge);
            problem.bonds.push(Bond { terms, stiffness });
        }
    }
}
