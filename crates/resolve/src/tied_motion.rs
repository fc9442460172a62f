//! Motion of tied vertices with their leaders, and of the particles at each point of a seam as one.

use std::collections::BTreeMap;

use glam::DVec3;
use scene::{BodyId, PairId};
use surface::{Contact, Term};

use crate::TiedVertices;
use crate::elastic::{Bond, ElasticProblem};
use crate::run::Run;
use crate::seams::place;

impl Run<'_> {
    /// Returns true if two bodies are tied to each other.
    pub(crate) fn is_tied(&self, pair: PairId) -> bool {
        self.ties.pairs.binary_search(&pair).is_ok()
    }

    /// Returns the vertices of each tie with their distances from their places, and whether one is torn.
    pub(crate) fn measure_ties(&self) -> (Vec<TiedVertices>, bool) {
        let ties = self.ties.held.clone().measured(self.scene);
        let allowance = self.params.gap + self.params.tolerance;
        let is_torn = ties.iter().any(|tie| tie.is_torn(allowance));
        (ties, is_torn)
    }

    /// Returns true if a vertex of a contact is tied.
    pub(crate) fn is_of_tie(&self, contact: &Contact) -> bool {
        let is_tied = |term: &Term| self.ties.is_follower[term.particle as usize];
        !self.ties.is_follower.is_empty() && contact.stencil.terms().iter().any(is_tied)
    }

    /// Moves tied vertices with their leaders in this round, each with all that are at its place.
    pub(crate) fn follow_ties(&mut self) {
        for bond in &self.ties.bonds {
            let leader = &self.tissues[bond.leader.index()];
            let mut u = DVec3::ZERO;
            for (corner, weight) in bond.corners.into_iter().zip(bond.weights) {
                u += weight * leader.u[corner as usize];
            }
            let follower = self.scene.body(bond.follower).particles().start + bond.vertex;
            for particle in self.ties.seams.together_with(follower) {
                let (body, vertex) = place(self.scene, particle);
                self.tissues[body].u[vertex as usize] = u;
            }
        }
    }

    /// Adds the particles of ties to those that move, where one of their bodies does.
    pub(crate) fn add_tie_seeds(&self, seeds: &mut BTreeMap<BodyId, Vec<u32>>) {
        for tie in &self.ties.bonds {
            if seeds.contains_key(&tie.follower) || seeds.contains_key(&tie.leader) {
                seeds.entry(tie.follower).or_default().push(tie.vertex);
                seeds.entry(tie.leader).or_default().extend(tie.corners);
            }
        }
        self.add_seam_seeds(seeds);
    }

    /// Adds the particles of seams to those that move, where a body of theirs does, and so on along bodies.
    fn add_seam_seeds(&self, seeds: &mut BTreeMap<BodyId, Vec<u32>>) {
        let mut is_added = vec![false; self.ties.seams.points().len()];
        let mut count = usize::MAX;
        while count != seeds.len() {
            count = seeds.len();
            for (point, is_added) in self.ties.seams.points().iter().zip(&mut is_added) {
                let places = || point.iter().map(|particle| place(self.scene, *particle));
                let moves = |(body, _): (usize, u32)| seeds.contains_key(&self.tissues[body].id);
                if !*is_added && places().any(moves) {
                    *is_added = true;
                    for (body, vertex) in places() {
                        seeds.entry(self.tissues[body].id).or_default().push(vertex);
                    }
                }
            }
        }
    }

    /// Computes the steps of all particles from their displacements `u` to those of least elastic energy; particles
    /// that are joined take one.
    pub(crate) fn minimize(
        &self,
        mut problem: ElasticProblem,
        u: &[DVec3],
        max_sweeps: usize,
        tolerance: f64,
    ) -> Vec<DVec3> {
        problem.join_seams(&self.joints);
        let mut steps = problem.minimize(u, max_sweeps, tolerance, self.params.tuning.penalty);
        self.joints.follow(&mut steps);
        steps
    }

    /// Adds ties as bonds where their vertices take part.
    pub(crate) fn add_tie_bonds(&self, problem: &mut ElasticProblem) {
        for tie in &self.ties.bonds {
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
