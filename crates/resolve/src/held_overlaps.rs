//! Pairs that still overlap while the gap is opened between all others: they get no deeper.

use scene::PairId;

use crate::elastic::{ElasticProblem, GapRow};
use crate::near_pairs::NearPair;
use crate::run::Run;

/// Pairs that overlap in a state, ascending, with their depths.
pub(crate) struct HeldOverlaps {
    depths: Vec<(PairId, f64)>,
    /// Those that cross at their ties.
    at_ties: Vec<PairId>,
}

impl HeldOverlaps {
    /// Lists the overlaps of the present state.
    pub(crate) fn of(run: &Run<'_>) -> Self {
        let overlapping = run.near.overlapping();
        let depths = overlapping.map(|near| (near.report.pair, near.depth())).collect();
        Self { depths, at_ties: run.left_at_ties.clone() }
    }

    /// Returns true if no pair is deeper by more than the accuracy of the gap, and those that cross at their ties by no more than they
    /// may.
    pub(crate) fn are_no_deeper(&self, run: &Run<'_>) -> bool {
        run.near.overlapping().all(|near| {
            let pair = near.report.pair;
            if self.at_ties.contains(&pair) {
                return run.left_at_ties.contains(&pair);
            }
            let known = self.depths.binary_search_by_key(&pair, |(pair, _)| *pair);
            known.is_ok_and(|index| near.depth() <= self.depths[index].1 + run.gap_slack())
        })
    }
}

impl Run<'_> {
    /// Adds a row for each contact of the pairs that overlap: what is inside stays as it is, or comes out,
    /// and what is near comes no nearer than to touch.
    pub(crate) fn hold_overlaps(&self, problem: &mut ElasticProblem) {
        for NearPair { report, edges } in self.near.overlapping() {
            for contact in report.contacts(self.scene).iter().chain(edges) {
                let missing = -contact.gap.max(0.0);
                problem.rows.extend(self.row(contact).map(|row| GapRow { missing, ..row }));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::{DQuat, DVec3};
    use scene::{BodyKind, Scene};

    use super::*;

    use crate::{Conditions, ResolveParams};

    /// A muscle is .5 deep in a bone, and has another one .02 above it: a gap of 1 finds no room.
    #[test]
    fn what_overlaps_gets_no_deeper_while_the_gap_to_others_is_opened() {
        let plate = || shapes::plate(DVec3::new(24.0, 24.0, 10.0), [6, 6]);
        let depth = 0.5;
        for (gap, opens) in [(0.5, true), (1.0, false)] {
            let muscle = shapes::ellipsoid(DVec3::new(8.0, 8.0, 1.0), 2);
            let mut scene = Scene::new();
            for (name, kind, mesh, z) in [
                ("below", BodyKind::Rigid, plate(), -5.0 + depth),
                ("muscle", BodyKind::Deformable, muscle, 1.0),
                ("above", BodyKind::Rigid, plate(), 7.02),
            ] {
                let mesh = mesh.translated(z * DVec3::Z);
                scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
            }
            let params = ResolveParams { gap, ..ResolveParams::with_smoothing(6.0) };
            let conditions = Conditions::default();
            let run = Run::start(&mut scene, params, &conditions);
            let mut run = run.expect("a run");

            // Turned a little since, as what was uncrossed.
            let turned = |x: &DVec3| DQuat::from_rotation_z(0.01) * *x;
            let x: Vec<DVec3> = run.scene.bodies()[1].positions().iter().map(turned).collect();
            run.move_tissue(1, &x).expect("finite");
            run.open_gaps(0).expect("rounds");
            run.detect_moved(&[false, true, false]).expect("detected");

            let after = run.near.overlapping().map(NearPair::depth).fold(0.0, f64::max);
            assert!(after <= depth + 1.01 * run.gap_slack(), "{depth} {after}");
            let mut accepted = run.gap_rounds.iter().filter(|round| round.is_accepted);
            let short = accepted.next_back().map(|round| round.short_features > 0);
            assert_eq!(short, Some(!opens), "{:?}", run.gap_rounds);
        }
    }
}
