//! First rounds of overlap removal: displacements of least elastic energy that take vertices out.
//!
//! Each round minimizes the energy of the *whole* displacement since the start under one row per
//! contact of a vertex or a crossing edge, and under the volumes of all bodies. Tissue that an
//! earlier round pushed too far comes back, and no displacement is longer than its rows ask.
//! Edges that come to cross between their vertices are left to the rounds after these.

use std::collections::BTreeMap;

use glam::DVec3;
use scene::BodyId;
use surface::Contact;
use surface::progress::Interrupted;

use crate::elastic::{ElasticProblem, GapRow, VolumeRow};
use crate::run::{Run, clearance};
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, tuning};

impl Run<'_> {
    /// Returns the number of elastic rounds: one for each step that the deepest vertex is inside,
    /// and those in which tissue settles.
    pub(crate) fn elastic_rounds(&self) -> usize {
        let max_step = tuning::MAX_STEP * self.params.smoothing;
        let depth = self.rounds.first().map_or(0.0, |start| start.max_depth);
        let depth = depth.max(self.longest_way);
        let mut steps = 0;
        while steps < self.params.max_rounds && f64::from(steps) * max_step < depth {
            steps += 1;
        }
        steps as usize + tuning::SETTLING_ROUNDS
    }

    /// Computes the displacements of one elastic round.
    pub(crate) fn push_elastically(&mut self) -> Result<(), ResolveError> {
        self.start_round();
        let contacts = self.contacts()?;
        if self.rounds.len() == 1 {
            let ways = contacts.iter().map(|contact| -contact.gap);
            self.longest_way = ways.fold(0.0, f64::max);
        }
        let displacements = self.displacements();
        let mut problem = ElasticProblem::default();
        let seeds = self.add_contacts(&contacts, &mut problem);
        self.add_displaced_bodies(seeds, &displacements, &mut problem)?;
        self.add_tie_bonds(&mut problem);

        let tolerance = tuning::SOLVED_SHARE * clearance(&self.params);
        let steps =
            problem.minimize(&displacements, tuning::PUSH_SWEEPS, tolerance, tuning::PUSH_PENALTY);
        self.take_elastic_steps(&steps, &displacements);
        self.clamp();
        Ok(())
    }

    /// Returns the displacements of all particles since the start.
    fn displacements(&self) -> Vec<DVec3> {
        let mut displacements = Vec::with_capacity(self.inverse_masses.len());
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            for (x, rest) in body.positions().iter().zip(&tissue.rest) {
                displacements.push(*x - *rest);
            }
        }
        displacements
    }

    /// Adds the row of each contact; returns the vertices of each body that rows are to move.
    fn add_contacts(
        &self,
        contacts: &[Contact],
        problem: &mut ElasticProblem,
    ) -> BTreeMap<BodyId, Vec<u32>> {
        let max_step = tuning::MAX_STEP * self.params.smoothing;
        let clearance = clearance(&self.params);
        let mut seeds: BTreeMap<BodyId, Vec<u32>> = BTreeMap::new();
        let bodies = self.scene.bodies();
        for contact in contacts {
            // Deeper overlaps than a step are left to later rounds.
            let missing = (clearance - contact.gap).min(max_step);
            let mut terms = Vec::with_capacity(6);
            for term in contact.stencil.terms() {
                if self.inverse_masses[term.particle as usize] == 0.0 {
                    continue;
                }
                terms.push((term.particle, -term.weight));
                if missing > 0.0 {
                    let number =
                        bodies.partition_point(|body| body.particles().end <= term.particle);
                    let first = bodies[number].particles().start;
                    let seeds = seeds.entry(self.tissues[number].id).or_default();
                    seeds.push(term.particle - first);
                }
            }
            if !terms.is_empty() {
                problem.rows.push(GapRow::new(terms, contact.normal, missing));
            }
        }
        seeds
    }

    /// Adds the tissue around contacts, and all that was displaced before.
    fn add_displaced_bodies(
        &mut self,
        mut seeds: BTreeMap<BodyId, Vec<u32>>,
        displacements: &[DVec3],
        problem: &mut ElasticProblem,
    ) -> Result<(), Interrupted> {
        self.add_tie_seeds(&mut seeds);
        let (progress, length) = (self.round_progress(), self.params.smoothing);
        for number in 0..self.tissues.len() {
            problem.volumes.push(VolumeRow::default());
            let tissue = &mut self.tissues[number];
            if tissue.is_rigid {
                continue;
            }
            let body = self.scene.body(tissue.id);
            let first = body.particles().start;
            let own = &displacements[first as usize..body.particles().end as usize];
            let seeds = seeds.remove(&tissue.id).unwrap_or_default();
            let active = tissue.active_vertices(seeds, own, fitted_tree(body), length, progress)?;
            if !active.is_empty() {
                tissue.add_active(fitted_tree(body), &active, first, number, length, problem);
            }
        }
        Ok(())
    }

    /// Takes the steps of all particles as displacements of this round. Vertices that would end up
    /// next to rest go back there.
    fn take_elastic_steps(&mut self, steps: &[DVec3], displacements: &[DVec3]) {
        let mut longest: f64 = 0.0;
        for (step, displacement) in steps.iter().zip(displacements) {
            longest = longest.max((*displacement + *step).length());
        }
        let ignored = tuning::MIN_SPREAD * longest;
        for (tissue, body) in self.tissues.iter_mut().zip(self.scene.bodies()) {
            let first = body.particles().start as usize;
            for (v, u) in tissue.u.iter_mut().enumerate() {
                let (step, displacement) = (steps[first + v], displacements[first + v]);
                let is_ignored = (displacement + step).length() < ignored;
                *u = if is_ignored { -displacement } else { step };
            }
        }
        self.clamp();
    }
}

impl Tissue {
    /// Finds the vertices around `seeds` and all that are displaced, ascending.
    fn active_vertices(
        &mut self,
        mut seeds: Vec<u32>,
        displacements: &[DVec3],
        tree: &proximity::SurfaceTree,
        length: f64,
        progress: surface::progress::Progress<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        seeds.sort_unstable();
        seeds.dedup();
        let mut active = self.vertices_around(&seeds, tree, length, progress)?;
        active.extend(seeds);
        for (vertex, displacement) in (0..).zip(displacements) {
            if *displacement != DVec3::ZERO {
                active.push(vertex);
            }
        }
        active.sort_unstable();
        active.dedup();
        Ok(active)
    }
}
