//! Settling of the most displaced body, once nothing crosses: it slides back toward rest.
//!
//! Rounds that take bodies apart leave tissue farther from its place than it has to be. From there,
//! the displacement of least elastic energy is found under the exact near features, by steps that let
//! nothing cross, while the largest displacement falls.

use surface::progress::Interrupted;

use crate::elastic::ElasticProblem;
use crate::gap_rounds::PairFeatures;
use crate::resolver::soft_positions;
use crate::run::{Run, clearance, detection_margin};
use crate::tissue::fitted_tree;
use crate::{BrokenLimit, ResolveError, tuning};

impl Run<'_> {
    /// Opens the gap from the state of a round in which tissue has settled; from the state as it is
    /// where that leads no farther, where something crosses, and after displacements were carried over.
    pub(crate) fn open_settled_gaps(
        &mut self,
        from_round: usize,
    ) -> Result<Vec<BrokenLimit>, ResolveError> {
        if self.is_warm || self.near.overlapping().next().is_some() {
            return self.open_gaps(from_round);
        }
        let unsettled = soft_positions(self.scene);
        self.settle()?;
        let broken = self.open_gaps(from_round)?;
        let is_open = self.gap_rounds.last().is_none_or(|last| last.short_features == 0);
        if broken.is_empty() && is_open && self.broken_limits(true)?.is_empty() {
            return Ok(broken);
        }
        self.gap_rounds.clear();
        self.move_soft(|tissue, _| Some(unsettled[tissue.id.index()].clone()))?;
        self.open_gaps(from_round)
    }

    /// Moves the most displaced body toward rest as long as the largest displacement falls. Tied ones
    /// stay: back one by one, they would come apart.
    fn settle(&mut self) -> Result<(), ResolveError> {
        let target = clearance(&self.params) + self.gap_slack();
        let (mut number, mut displacement) = self.most_displaced();
        for _ in 0..tuning::MAX_STALLED_ROUNDS {
            let id = self.tissues[number].id;
            if displacement <= self.longest_way || self.tied.iter().any(|pair| pair.contains(id)) {
                break;
            }
            let last = displacement;
            self.settle_body(number, target)?;
            (number, displacement) = self.most_displaced();
            if displacement > (1.0 - tuning::NEGLIGIBLE_SHARE) * last {
                break;
            }
        }
        Ok(())
    }

    /// Takes one step of a body toward rest, in which all others stay.
    fn settle_body(&mut self, number: usize, target: f64) -> Result<(), ResolveError> {
        // Only its own pairs.
        let (mut near, mut moves) = (Vec::new(), vec![false; self.tissues.len()]);
        moves[number] = true;
        self.update_features(&mut near, &[], detection_margin(&self.params), &moves)?;
        let problem = self.settling_problem(number, &near, target)?;

        let tolerance = tuning::SOLVED_SHARE * self.gap_slack();
        let (sweeps, penalty) = (tuning::GAP_SWEEPS, tuning::GAP_PENALTY);
        let steps = problem.minimize(&self.displacements(), sweeps, tolerance, penalty);
        self.move_freely(&steps, &[])?;
        Ok(())
    }

    /// Returns the number of the body with the longest displacement, and its length.
    fn most_displaced(&self) -> (usize, f64) {
        let mut most = (0, 0.0);
        for (number, (tissue, body)) in self.tissues.iter().zip(self.scene.bodies()).enumerate() {
            let displacement = tissue.max_displacement(body.positions());
            if displacement > most.1 {
                most = (number, displacement);
            }
        }
        most
    }

    /// Sets up the problem of one body: all that is displaced, and what is around it.
    fn settling_problem(
        &mut self,
        number: usize,
        near: &[PairFeatures],
        target: f64,
    ) -> Result<ElasticProblem, Interrupted> {
        let mut problem = ElasticProblem::default();
        for PairFeatures { id, features } in near {
            for feature in features {
                self.add_row(*id, feature, target - feature.distance, &mut problem.rows);
            }
        }

        let (progress, length) = (self.round_progress(), self.params.smoothing);
        let tissue = &mut self.tissues[number];
        let body = self.scene.body(tissue.id);
        let mut own = Vec::with_capacity(tissue.rest.len());
        for (x, rest) in body.positions().iter().zip(&tissue.rest) {
            own.push(*x - *rest);
        }
        let active =
            tissue.active_vertices(Vec::new(), &own, fitted_tree(body), length, progress)?;
        problem.append(tissue.elastic_part(body, &active, length));
        Ok(problem)
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use scene::{BodyKind, PairId, Scene};
    use surface::progress::Progress;

    use crate::run::{Run, clearance};
    use crate::{Conditions, ResolveParams};

    /// Settles a muscle one deep in a bone, which was taken three out of it; returns its displacement.
    fn settled(is_tied: bool) -> f64 {
        let bone = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]).translated(DVec3::Z * -4.0);
        let muscle = shapes::ellipsoid(DVec3::new(10.0, 10.0, 6.0), 2).translated(DVec3::Z * 5.0);
        let mut scene = Scene::new();
        for (name, kind, mesh) in
            [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)]
        {
            scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
        }
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::new(&mut scene, params, &conditions, &[], None, Progress::none());
        let mut run = run.expect("a run");
        run.longest_way = 1.0;
        let bodies = [0, 1].map(|number| run.tissues[number].id);
        if is_tied {
            run.tied.push(PairId::new(bodies[0], bodies[1]));
        }
        let out = |x: &DVec3| *x + DVec3::Z * 3.0;
        run.move_soft(|_, from| Some(from.iter().map(out).collect())).expect("positions");
        run.settle().expect("a state");
        let (_, displacement) = run.most_displaced();
        let height = |x: &DVec3| x.z;
        let lowest = scene.body(bodies[1]).positions().iter().map(height).fold(9.0, f64::min);
        assert!(lowest > 0.5 * clearance(&params), "{lowest} above the bone");
        displacement
    }

    #[test]
    fn what_was_taken_out_too_far_comes_back_until_it_is_near() {
        let displacement = settled(false);
        assert!((1.0..1.3).contains(&displacement), "{displacement}");
    }

    #[test]
    fn tied_bodies_stay() {
        assert!((settled(true) - 3.0).abs() < 1e-12);
    }
}
