//! Settling of the most displaced body, once nothing crosses: it slides back toward rest.
//!
//! Rounds that take bodies apart leave tissue farther from its place than it has to be. From there,
//! the displacement of least elastic energy is found under the exact near features, by steps that let
//! nothing cross, while the largest displacement falls. Each step asks for a little less of it: surfaces bend,
//! and what leaves a body where it is deepest has shorter ways beside its own.

use glam::DVec3;
use surface::parallel;
use surface::progress::Interrupted;

use crate::detection::clearance;
use crate::elastic::{ElasticProblem, GapRow, Terms};
use crate::run::Run;
use crate::soft_positions::soft_positions;
use crate::tissue::{Tissue, fitted_tree};
use crate::{BrokenLimit, ResolveError};

/// Steps without gain after which tissue has settled. Below, it stops where surfaces bend; above, it takes longer.
const MAX_STALLED_STEPS: usize = 3;

impl Run<'_> {
    /// Opens the gap from the state of a round in which tissue has settled; from the state as it is
    /// where that leads no farther, where something crosses, and after displacements were carried over.
    pub(crate) fn open_settled_gaps(
        &mut self,
        from_round: usize,
    ) -> Result<Vec<BrokenLimit>, ResolveError> {
        self.part_at_ties()?;
        self.leave_at_ties()?;
        if self.is_warm || self.to_come_apart().next().is_some() {
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
    /// stay: back one by one, they would come apart. Ends after a few steps that gain less than the accuracy of the
    /// gap: one of them may only have turned a corner.
    fn settle(&mut self) -> Result<(), ResolveError> {
        let target = clearance(&self.params) + self.gap_slack();
        let (mut number, mut displacement) = self.most_displaced();
        let mut stalled = 0;
        for _ in 0..self.params.max_rounds {
            let Some(id) = self.tissues.get(number).map(|tissue| tissue.id) else { break };
            if displacement <= self.longest_way
                || self.ties.pairs.iter().any(|pair| pair.contains(id))
            {
                break;
            }
            let (last, body) = (displacement, number);
            let before = self.scene.body(id).positions().to_vec();
            self.settle_body(body, target)?;
            (number, displacement) = self.most_displaced();
            if displacement > last || self.may_cross_when_written(body)? {
                return self.move_tissue(body, &before);
            }
            let gains = displacement < last - self.gap_slack();
            stalled = if gains { 0 } else { stalled + 1 };
            if stalled >= MAX_STALLED_STEPS {
                break;
            }
        }
        Ok(())
    }

    /// Returns true if a body is so near another one that rounding to the written precision may let them cross, and
    /// no gap is opened after.
    fn may_cross_when_written(&mut self, number: usize) -> Result<bool, ResolveError> {
        let rounding = self.gap_slack();
        if self.params.gap > 0.0 || rounding <= 0.0 {
            return Ok(false);
        }
        let (mut near, mut moves) = (Vec::new(), vec![false; self.tissues.len()]);
        moves[number] = true;
        self.update_features(&mut near, &[], rounding, &moves)?;
        Ok(near.iter().any(|pair| !pair.features.is_empty()))
    }

    /// Takes one step of a body toward rest, in which all others stay.
    fn settle_body(&mut self, number: usize, target: f64) -> Result<(), ResolveError> {
        let rows = self.holding_rows(number, &[], target)?;
        let problem = self.settling_problem(number, rows)?;
        self.step_freely(problem, &self.displacements(), &[])?;
        Ok(())
    }

    /// Returns the number of the body with the longest displacement, and its length.
    fn most_displaced(&self) -> (usize, f64) {
        let displacements = parallel::map(self.tissues.len(), |number| {
            self.tissues[number].max_displacement(self.scene.bodies()[number].positions())
        });
        let mut most = (0, 0.0);
        for (number, displacement) in displacements.into_iter().enumerate() {
            if displacement > most.1 {
                most = (number, displacement);
            }
        }
        most
    }

    /// Sets up the problem of one body: all that is displaced, what is around it, and how far it may be
    /// displaced.
    fn settling_problem(
        &mut self,
        number: usize,
        rows: Vec<GapRow>,
    ) -> Result<ElasticProblem, Interrupted> {
        let mut problem = ElasticProblem { rows, ..Default::default() };
        let (progress, length) = (self.round_progress(), self.params.smoothing);
        let tissue = &mut self.tissues[number];
        let body = self.scene.body(tissue.id);
        let (first, mut own) = (body.particles().start, Vec::with_capacity(tissue.rest.len()));
        for (x, rest) in body.positions().iter().zip(&tissue.rest) {
            own.push(*x - *rest);
        }
        let settled = longest(&own);
        let limit = settled - tissue.params.tuning.settled_share * (settled - self.longest_way);
        problem.rows.extend(tissue.displacement_rows(&own, first, self.longest_way, limit));
        let active =
            tissue.active_vertices(Vec::new(), &own, fitted_tree(body), length, progress)?;
        problem.extend(vec![tissue.elastic_part(body, &active, length)]);
        Ok(problem)
    }
}

impl Tissue {
    /// Makes one row for each vertex that is displaced beyond a distance: it is to come back to a little
    /// less than the longest displacement.
    pub(crate) fn displacement_rows(
        &self,
        displacements: &[DVec3],
        first: u32,
        distance: f64,
        limit: f64,
    ) -> Vec<GapRow> {
        let mut rows = Vec::new();
        for (vertex, displacement) in (0..).zip(displacements) {
            let length = displacement.length();
            if length > distance && self.is_free(vertex) {
                let back = -*displacement / length;
                let terms = Terms::from_iter([(first + vertex, 1.0)]);
                rows.push(GapRow::new(terms, back, length - limit));
            }
        }
        rows
    }
}

/// Returns the length of the longest displacement.
fn longest(displacements: &[DVec3]) -> f64 {
    let mut longest: f64 = 0.0;
    for displacement in displacements {
        longest = longest.max(displacement.length());
    }
    longest
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};
    use glam::DVec3;
    use scene::{CheckParams, PairId};
    use surface::progress::Progress;

    use crate::detection::clearance;

    use crate::run::Run;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams, WrittenPrecision};

    /// Settles a muscle that is `longest_way` deep in a bone, which was taken `out` of it upward; returns
    /// its displacement.
    fn settled(bone: Mesh, muscle: Mesh, longest_way: f64, out: f64, is_tied: bool) -> f64 {
        let mut scene = bone_and_muscle(bone, muscle);
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.longest_way = longest_way;
        let bodies = [0, 1].map(|number| run.tissues[number].id);
        if is_tied {
            run.ties.pairs.push(PairId::new(bodies[0], bodies[1]));
        }
        let out = |x: &DVec3| *x + out * DVec3::Z;
        run.move_soft(|_, from| Some(from.iter().map(out).collect())).expect("positions");
        run.settle().expect("a state");
        let (_, displacement) = run.most_displaced();
        let reports = scene.check(&CheckParams::without_measures(5.0), Progress::none());
        let distance = reports.expect("reports")[0].distance.expect("near");
        assert!(distance > 0.5 * clearance(&params), "{distance} apart");
        displacement
    }

    /// Settles a muscle one deep in a plate of bone.
    fn settled_on_plate(is_tied: bool) -> f64 {
        let bone = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]).translated(DVec3::Z * -4.0);
        let muscle = shapes::ellipsoid(DVec3::new(10.0, 10.0, 6.0), 2).translated(DVec3::Z * 5.0);
        settled(bone, muscle, 1.0, 3.0, is_tied)
    }

    #[test]
    fn what_was_taken_out_too_far_comes_back_until_it_is_near() {
        let displacement = settled_on_plate(false);
        assert!((1.0..1.3).contains(&displacement), "{displacement}");
    }

    #[test]
    fn what_least_energy_leaves_too_far_comes_back_along_the_surface() {
        // A tip in a round bone: all else would keep it where energy is least, 1.85 ways out.
        let bone = shapes::ellipsoid(DVec3::new(4.0, 4.8, 4.0), 3);
        let tip = shapes::ellipsoid(DVec3::new(3.0, 3.0, 8.0), 3);
        let tip = tip.translated(DVec3::new(0.4, 0.2, 9.0));
        let displacement = settled(bone, tip, 2.9, 10.0, false);
        assert!(displacement < 1.1 * 2.9, "{displacement}");
    }

    #[test]
    fn nothing_settles_so_near_that_written_positions_cross() {
        // A way that no step goes to its end, so that steps are held back over and over. Far from the origin,
        // where single precision is coarse.
        let far = DVec3::new(7000.0, -6500.0, 9000.0);
        let bone = shapes::ellipsoid(DVec3::new(5.0, 5.0, 5.0), 3).translated(far);
        let tip = shapes::ellipsoid(DVec3::new(3.0, 3.0, 8.0), 3);
        let tip = tip.translated(far + DVec3::new(1.0, 0.5, 9.0));
        let mut scene = bone_and_muscle(bone, tip);
        let params = ResolveParams {
            precision: WrittenPrecision::Single,
            ..ResolveParams::with_smoothing(6.0)
        };
        let conditions = Conditions::default();
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.longest_way = 1.0;
        let out = |x: &DVec3| *x + 10.0 * DVec3::Z;
        run.move_soft(|_, from| Some(from.iter().map(out).collect())).expect("positions");
        run.settle().expect("a state");
        let (number, displacement) = run.most_displaced();
        assert!(displacement < 9.0, "{displacement}");
        assert!(!run.may_cross_when_written(number).expect("features"));
        run.params.precision = WrittenPrecision::Double;
        run.settle().expect("a state");
        run.params.precision = WrittenPrecision::Single;
        assert!(run.may_cross_when_written(number).expect("features"), "settles nearer otherwise");
    }

    #[test]
    fn tied_bodies_stay() {
        assert!((settled_on_plate(true) - 3.0).abs() < 1e-12);
    }
}
