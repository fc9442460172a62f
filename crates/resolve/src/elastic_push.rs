//! First rounds of overlap removal: displacements of least elastic energy that take vertices out.
//!
//! Each round minimizes the energy of the *whole* displacement since the start under one row per
//! contact of a vertex or a crossing edge, and under the volumes of all bodies. Tissue that an
//! earlier round pushed too far comes back, and no displacement is longer than its rows ask.
//! Contacts of edges are found where edges cross: their rows are kept, or edges would come apart in
//! one round and cross again in the next.

use std::collections::BTreeMap;

use glam::DVec3;
use proximity::FeaturePoint;
use scene::BodyId;
use surface::progress::Interrupted;
use surface::{Contact, parallel};

use crate::ResolveError;
use crate::detection::clearance;
use crate::elastic::{ElasticProblem, GapRow, Terms};
use crate::gap_rounds::PairFeatures;
use crate::relaxation::{SOLVED_SHARE, STEP_SWEEPS};
use crate::run::Run;
use crate::spread::NEGLIGIBLE_SHARE;
use crate::tissue::{Tissue, fitted_tree};

impl Run<'_> {
    /// Returns the number of elastic rounds: one for each step that the deepest vertex is inside,
    /// and one in which tissue settles; after carried displacements, which are near their end, two.
    pub(crate) fn elastic_rounds(&self) -> usize {
        if self.is_warm {
            // Carrying them counts as one.
            return 3;
        }
        let max_step = self.params.max_step();
        let depth = self.rounds.first().map_or(0.0, |start| start.max_depth);
        let depth = depth.max(self.longest_way);
        let mut steps = 0;
        while steps < self.params.max_rounds && f64::from(steps) * max_step < depth {
            steps += 1;
        }
        steps as usize + 1
    }

    /// Computes the displacements of one elastic round.
    pub(crate) fn push_elastically(&mut self) -> Result<(), ResolveError> {
        self.start_round();
        let contacts = self.contacts()?;
        if self.rounds.len() == 1 {
            let ways = contacts.iter().flatten().map(|contact| -contact.gap);
            self.longest_way = ways.fold(0.0, f64::max);
        }
        let displacements = self.displacements();
        let mut problem = ElasticProblem::default();
        self.hold_edges(&displacements, &mut problem)?;
        let seeds = self.add_contacts(&contacts, &mut problem);
        self.add_displaced_bodies(seeds, &displacements, &mut problem)?;
        self.add_tie_bonds(&mut problem);

        let tolerance = SOLVED_SHARE * clearance(&self.params);
        let steps = self.minimize(problem, &displacements, STEP_SWEEPS, tolerance);
        self.take_elastic_steps(&steps, &displacements);
        self.clamp();
        Ok(())
    }

    /// Returns the displacements of all particles since the start.
    pub(crate) fn displacements(&self) -> Vec<DVec3> {
        let mut displacements = vec![DVec3::ZERO; self.inverse_masses.len()];
        let mut others = &mut displacements[..];
        let mut parts = Vec::with_capacity(self.tissues.len());
        for tissue in &self.tissues {
            let (own, rest) = others.split_at_mut(tissue.rest.len());
            others = rest;
            parts.push(own);
        }
        parallel::for_each(parts, |number, own| {
            let x = self.scene.bodies()[number].positions();
            for (u, (x, rest)) in own.iter_mut().zip(x.iter().zip(&self.tissues[number].rest)) {
                *u = *x - *rest;
            }
        });
        displacements
    }

    /// Adds the rows of edges that crossed in earlier rounds, and keeps those of edges that cross now.
    /// After a warm start, edges that are near are held as well.
    fn hold_edges(
        &mut self,
        displacements: &[DVec3],
        problem: &mut ElasticProblem,
    ) -> Result<(), ResolveError> {
        if self.is_warm {
            let mut rows = self.rows_of_near_edges()?;
            add_openings(&mut rows, displacements);
            self.edge_rows.extend(rows);
        }

        // What the rows miss by now.
        let max_step = self.params.max_step();
        for row in &self.edge_rows {
            let missing = row.missing - row.opening_by(displacements);
            problem.rows.push(GapRow { missing: missing.min(max_step), ..row.clone() });
        }

        let mut rows = Vec::new();
        for pair in self.near.iter() {
            if self.uses_edges(&pair.report) {
                let is_tied = self.is_tied(pair.report.pair);
                let edges = pair.edges.iter();
                let edges = edges.filter(|contact| !(is_tied && self.is_of_tie(contact)));
                rows.extend(edges.filter_map(|contact| self.row(contact)));
            }
        }
        add_openings(&mut rows, displacements);
        self.edge_rows.extend(rows);
        Ok(())
    }

    /// Makes the rows of edges that are near edges of another body, of pairs that do not cross.
    fn rows_of_near_edges(&mut self) -> Result<Vec<GapRow>, ResolveError> {
        // All pairs, since none are known before.
        let clearance = clearance(&self.params);
        let max_distance = 2.0 * clearance;
        let (mut near, all) = (Vec::new(), vec![true; self.tissues.len()]);
        self.update_features(&mut near, &self.overlapping_pairs(), max_distance, &all)?;

        // Points of an edge have two corners with a weight.
        let mut rows = Vec::new();
        near.retain(|pair| !self.is_tied(pair.id));
        for PairFeatures { id, features } in near {
            for feature in &features {
                let is_on_edge = |point: &FeaturePoint| {
                    point.weights.iter().filter(|weight| **weight > 0.0).count() == 2
                };
                if feature.points.iter().all(is_on_edge) {
                    rows.extend(self.gap_row(id, feature, clearance - feature.distance));
                }
            }
        }
        Ok(rows)
    }

    /// Makes the row of a contact; `None` where neither side can move.
    pub(crate) fn row(&self, contact: &Contact) -> Option<GapRow> {
        let mut terms = Terms::new();
        for term in contact.stencil.terms() {
            if self.inverse_masses[term.particle as usize] != 0.0 {
                terms.push((term.particle, -term.weight));
            }
        }
        let missing = clearance(&self.params) - contact.gap;
        (!terms.is_empty()).then(|| GapRow::new(terms, contact.normal, missing))
    }

    /// Adds the row of each contact of all lists; returns the vertices of each body that rows are to move.
    pub(crate) fn add_contacts(
        &self,
        contacts: &[Vec<Contact>],
        problem: &mut ElasticProblem,
    ) -> BTreeMap<BodyId, Vec<u32>> {
        let max_step = self.params.max_step();
        let mut seeds: BTreeMap<BodyId, Vec<u32>> = BTreeMap::new();
        let bodies = self.scene.bodies();
        problem.rows.reserve(contacts.iter().map(Vec::len).sum());
        for mut row in contacts.iter().flatten().filter_map(|contact| self.row(contact)) {
            // Deeper overlaps than a step are left to later rounds.
            row.missing = row.missing.min(max_step);
            if row.missing > 0.0 {
                for &(particle, _) in &row.terms {
                    let number = bodies.partition_point(|body| body.particles().end <= particle);
                    let first = bodies[number].particles().start;
                    seeds.entry(self.tissues[number].id).or_default().push(particle - first);
                }
            }
            problem.rows.push(row);
        }
        seeds
    }

    /// Adds the tissue around contacts, and all that was displaced before.
    pub(crate) fn add_displaced_bodies(
        &mut self,
        mut seeds: BTreeMap<BodyId, Vec<u32>>,
        displacements: &[DVec3],
        problem: &mut ElasticProblem,
    ) -> Result<(), Interrupted> {
        self.add_tie_seeds(&mut seeds);
        let (progress, length) = (self.round_progress(), self.params.smoothing);
        let (scene, seeds) = (&*self.scene, &seeds);
        let parts = parallel::map_mut_costly_first(&mut self.tissues, Tissue::cost, |tissue| {
            progress.report(0.0)?;
            let body = scene.body(tissue.id);
            let own = body.particles().start as usize..body.particles().end as usize;
            let seeds = seeds.get(&tissue.id).cloned().unwrap_or_default();
            let (own, tree) = (&displacements[own], fitted_tree(body));
            let mut active = Vec::new();
            if !tissue.is_rigid {
                active = tissue.active_vertices(seeds, own, tree, length, progress)?;
            }
            Ok(tissue.elastic_part(body, &active, length))
        });
        problem.extend(parts.into_iter().collect::<Result<Vec<_>, _>>()?);
        Ok(())
    }

    /// Takes the steps of all particles as displacements of this round. Vertices that would end up
    /// next to rest go back there.
    fn take_elastic_steps(&mut self, steps: &[DVec3], displacements: &[DVec3]) {
        let mut longest: f64 = 0.0;
        for (step, displacement) in steps.iter().zip(displacements) {
            longest = longest.max((*displacement + *step).length());
        }
        let ignored = NEGLIGIBLE_SHARE * longest;

        // After carried displacements all tissue moves: no farther than others are known of.
        let mut max_step = self.params.max_step();
        if self.is_warm {
            max_step *= self.params.tuning.detection_margin;
        }
        let bodies = self.scene.bodies();
        parallel::map_mut(&mut self.tissues, |tissue| {
            let first = bodies[tissue.id.index()].particles().start as usize;
            for (v, u) in tissue.u.iter_mut().enumerate() {
                let (step, displacement) = (steps[first + v], displacements[first + v]);
                let is_ignored = (displacement + step).length() < ignored;
                let step = if is_ignored { -displacement } else { step };
                *u = step.clamp_length_max(max_step);
            }
        });
    }
}

/// Adds to what rows miss the openings by displacements, without which they would miss that too.
fn add_openings(rows: &mut [GapRow], displacements: &[DVec3]) {
    for row in rows {
        row.missing += row.opening_by(displacements);
    }
}

#[cfg(test)]
mod tests {
    use fixtures::Mesh;
    use scene::{BodyKind, Scene};

    use super::*;

    use crate::tissue::Tissue;
    use crate::{Conditions, ResolveParams, Tie};

    /// Builds two soft wedges whose ridges cross at right angles, no vertex inside.
    fn crossed_ridges() -> Scene {
        let positions = [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, -3.0, -3.0], [0.0, 3.0, -3.0]];
        let positions = positions.map(DVec3::from).to_vec();
        let lower = Mesh { positions, faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] };
        let upper = lower.clone().mapped(|p| DVec3::new(p.y, p.x, -p.z - 0.25));
        let mut scene = Scene::new();
        for (name, mesh) in [("lower", lower), ("upper", upper)] {
            let mesh = if mesh.volume() > 0.0 { mesh } else { mesh.flipped() };
            let surface = mesh.surface();
            scene.add(name, BodyKind::Deformable, surface, mesh.positions).expect("a wedge");
        }
        scene
    }

    #[test]
    fn edges_that_came_apart_do_not_cross_again() {
        let (mut scene, conditions) = (crossed_ridges(), Conditions::default());
        let params = ResolveParams::with_smoothing(6.0);
        let mut run = Run::start(&mut scene, params, &conditions).expect("a run");
        assert!(run.rounds[0].crossing_faces > 0 && run.rounds[0].max_depth > 0.1);
        for round in 1..6 {
            run.push_elastically().expect("displacements");
            run.move_soft(Tissue::pushed).expect("positions");
            run.record().expect("a round");
            assert_eq!(run.rounds[round].crossing_faces, 0, "round {round}");
        }
    }

    /// The upper ridge ends in a vertex that is tied to a body above it.
    #[test]
    fn edges_that_cross_a_bone_at_a_tie_have_rows() {
        let mut scene = crossed_ridges();
        let upper = scene.find("upper").expect("a body");
        let [a, b, c, d] = [0, 1, 2, 3].map(|vertex: usize| scene.body(upper).positions()[vertex]);
        let far = c.midpoint(d) + 3.0 * (a - b);
        let cap = Mesh {
            positions: vec![a, c, d, far],
            faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        };
        let cap = if cap.volume() > 0.0 { cap } else { cap.flipped() };
        let surface = cap.surface();
        let cap = scene.add("cap", BodyKind::Deformable, surface, cap.positions).expect("a body");
        let ties = vec![Tie { bodies: [upper, cap], distance: f64::MIN_POSITIVE }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let params = ResolveParams::with_smoothing(600.0);
        let mut run = Run::start(&mut scene, params, &conditions).expect("a run");
        assert_eq!(run.ties.seams.points().len(), 3);
        let (displacements, mut problem) = (run.displacements(), ElasticProblem::default());
        run.hold_edges(&displacements, &mut problem).expect("rows");
        assert!(!run.edge_rows.is_empty(), "of the edges that cross");
    }

    #[test]
    fn carried_tissue_moves_no_farther_than_contacts_are_known() {
        let (mut scene, conditions) = (crossed_ridges(), Conditions::default());
        let params = ResolveParams::with_smoothing(6.0);
        let mut run = Run::start(&mut scene, params, &conditions).expect("a run");
        let at_rest = run.displacements();
        let steps = vec![DVec3::new(2.0, 1.0, 2.0); at_rest.len()];
        for (is_warm, longest) in [(false, 1.5), (true, 0.9)] {
            run.is_warm = is_warm;
            run.take_elastic_steps(&steps, &at_rest);
            for u in run.tissues.iter().flat_map(|tissue| &tissue.u) {
                assert!((u.length() - longest).abs() < 1e-12, "{u}");
            }
        }
        assert!(0.9 < crate::detection::detection_margin(&params));
    }
}
