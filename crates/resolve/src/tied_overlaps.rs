//! Overlaps of tied bodies by what their meshes differ in: where two tied surfaces bend, corners of one come to be a little
//! below faces of the other.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use scene::{BodyId, PairId, PairOverlap, PairReport, Scene};

use crate::ResolveError;
use crate::detection::clearance;
use crate::near_pairs::NearPair;
use crate::obstacle::Obstacle;
use crate::resolution::{Remaining, overlaps_in};
use crate::round::Round;
use crate::run::{DEPTH_BRACKET, Run};
use crate::seams::place;
use crate::soft_positions::soft_positions;
use crate::ties::Ties;

/// Depth up to which rounds leave what crosses at a tie \[tolerances\]. Near 1, the gap that is opened next takes it beyond the
/// tolerance; far below, rounds bend tissue to no end.
const LEFT_AT_TIES: f64 = 0.5;

/// Steps by which tied vertices leave the faces of their leaders. Below, what is left at a tie is not swept while the gap is opened;
/// above, what does not end takes longer.
const MAX_PARTING_STEPS: usize = 8;

impl Ties {
    /// Returns true if two bodies cross beside tied vertices only: all faces that cross, and those around what is inside, have
    /// a tied corner.
    pub(crate) fn are_around_overlap(&self, scene: &Scene, report: &PairReport) -> bool {
        let PairReport { pair, crossing_faces, a_against_b, b_against_a, .. } = report;
        let Some(tied) = self.particles.get(pair) else { return false };
        let is_at_tie = |id: usize, face: u32| {
            let body = scene.body(pair.bodies()[id]);
            let corners = body.surface().faces()[face as usize];
            corners.iter().any(|corner| tied.contains(&(body.particles().start + corner)))
        };
        let is_vertex_at_tie = |id: usize, vertex: u32| {
            let faces = scene.body(pair.bodies()[id]).surface().vertex_faces(vertex);
            faces.iter().any(|face| is_at_tie(id, *face))
        };

        let is_crossing_at_tie = |[a, b]: &[u32; 2]| is_at_tie(0, *a) || is_at_tie(1, *b);
        let mut is_around = crossing_faces.iter().all(is_crossing_at_tie);
        for (id, side) in [a_against_b, b_against_a].into_iter().enumerate() {
            for near in side.near.iter().filter(|near| near.gap < 0.0) {
                is_around &= is_vertex_at_tie(id, near.vertex) || is_at_tie(1 - id, near.face);
            }
        }
        is_around
    }
}

impl Run<'_> {
    /// Finds the pairs that may be left as they are: those that cross beside their tied vertices, no deeper by their surfaces than
    /// meshes differ, and did not at the start.
    pub(crate) fn leave_at_ties(&mut self) -> Result<(), ResolveError> {
        let pairs = self.crossing_at_ties();
        self.left_at_ties.clear();
        if pairs.is_empty() {
            return Ok(());
        }
        let limit = LEFT_AT_TIES * self.params.tolerance;
        let width = DEPTH_BRACKET * self.params.tolerance;
        let overlaps = self.scene.pair_overlaps(&pairs, Some(width), self.round_progress())?;
        for (pair, overlap) in pairs.into_iter().zip(overlaps) {
            let depth = overlap.as_ref().and_then(PairOverlap::max_depth);
            if depth.is_none_or(|depth| depth.upper <= limit) {
                self.left_at_ties.push(pair);
            }
        }
        Ok(())
    }

    /// Lists the pairs that cross beside their tied vertices and did not at the start, with vertices and edges no deeper than
    /// meshes differ.
    fn crossing_at_ties(&self) -> Vec<PairId> {
        let mut pairs = Vec::new();
        for near in self.near.overlapping() {
            if self.ties.are_around_overlap(self.scene, &near.report)
                && near.depth() <= LEFT_AT_TIES * self.params.tolerance
                && !overlaps_in(&self.before, near.report.pair)
            {
                pairs.push(near.report.pair);
            }
        }
        pairs
    }

    /// Moves tied vertices off the faces of their leaders that they cross, if no other pair overlaps. From where that does not
    /// end, bodies stay where they are.
    pub(crate) fn part_at_ties(&mut self) -> Result<(), ResolveError> {
        let crossing = self.crossing_at_ties();
        if crossing.is_empty() || self.near.overlapping().count() > crossing.len() {
            return Ok(());
        }
        let before = soft_positions(self.scene);
        for _ in 0..MAX_PARTING_STEPS {
            let steps = self.steps_off_leaders();
            self.move_soft(|tissue, x| {
                let own = steps.get(&tissue.id)?;
                let mut x = x.to_vec();
                for (vertex, step) in own {
                    x[*vertex as usize] += *step;
                }
                Some(x)
            })?;
            if self.near.overlapping().next().is_none() {
                return Ok(());
            }
        }
        self.move_soft(|tissue, _| Some(before[tissue.id.index()].clone()))
    }

    /// Computes the steps of tied bodies' vertices off what they cross: at each vertex, that of its deepest contact.
    fn steps_off_leaders(&self) -> BTreeMap<BodyId, BTreeMap<u32, DVec3>> {
        let beyond = (self.params.tuning.slack * clearance(&self.params)).max(self.gap_slack());
        let mut steps: BTreeMap<BodyId, BTreeMap<u32, DVec3>> = BTreeMap::new();
        for NearPair { report, edges } in self.near.overlapping() {
            let tied = self.ties.particles.get(&report.pair);
            let Some(&tied) = tied.and_then(BTreeSet::first) else { continue };
            let (follower, _) = place(self.scene, tied);
            let tissue = &self.tissues[follower];
            for contact in report.contacts(self.scene).iter().chain(edges) {
                for term in contact.stencil.terms() {
                    let (body, vertex) = place(self.scene, term.particle);
                    if contact.gap >= 0.0 || body != follower || !tissue.is_free(vertex) {
                        continue;
                    }
                    let step = -term.weight.signum() * (beyond - contact.gap) * contact.normal;
                    let own = steps.entry(tissue.id).or_default().entry(vertex).or_default();
                    if step.length() > own.length() {
                        *own = step;
                    }
                }
            }
        }
        steps
    }

    /// Lists the pairs that still overlap, which ended for the reason of `standstill`.
    pub(crate) fn list_remaining(
        &self,
        after: &[PairReport],
        standstill: Obstacle,
    ) -> Vec<Remaining> {
        let Self { near, exempt_pairs, before, ties, .. } = self;
        Remaining::list(self.scene, after, near, exempt_pairs, before, ties, standstill)
    }

    /// Returns the pairs that overlap and are to come apart.
    pub(crate) fn to_come_apart(&self) -> impl Iterator<Item = &NearPair> {
        self.near.overlapping().filter(|near| !self.left_at_ties.contains(&near.report.pair))
    }

    /// Summarizes the overlaps of the present state.
    pub(crate) fn overlaps_of_round(&self) -> Round {
        Round::of_overlaps(self.to_come_apart(), |pair, depth| self.overlaps_anew(pair, depth))
    }

    /// Returns true if a pair of a depth did not overlap at the start. Those that shared faces then do where they are deeper than
    /// the tolerance.
    fn overlaps_anew(&self, pair: PairId, depth: f64) -> bool {
        let is_in = |pairs: &[PairId]| pairs.binary_search(&pair).is_ok();
        let is_touching = depth <= self.params.tolerance && is_in(&self.touching_at_first);
        !(is_touching || is_in(&self.at_first))
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, CheckParams};

    use super::*;
    use crate::{Conditions, ResolveParams, Tie};

    const LIMIT: f64 = LEFT_AT_TIES * ResolveParams::with_smoothing(6.0).tolerance;

    /// A soft plate that is tied to another one on its left half, where they touch; on the right it is .2 above it.
    fn plates() -> (Scene, Conditions) {
        let mut scene = Scene::new();
        for (name, z, cells) in [("upper", 1.0, 14), ("lower", -1.0, 20)] {
            let plate = shapes::plate(DVec3::new(20.0, 20.0, 2.0), [cells, cells]);
            let lift = |x: DVec3| if z > 0.0 && x.x > 0.1 { 0.2 * DVec3::Z } else { DVec3::ZERO };
            let plate = plate.translated(z * DVec3::Z).mapped(|x| x + lift(x));
            let added = scene.add(name, BodyKind::Deformable, plate.surface(), plate.positions);
            added.expect("a plate");
        }
        let bodies = ["upper", "lower"].map(|name| scene.find(name).expect("a plate"));
        let ties = vec![Tie { bodies, distance: 0.1 }];
        (scene, Conditions { ties, ..Conditions::default() })
    }

    /// Moves the one corner of the lower plate's upper side at a place up, and measures the state.
    fn lift(run: &mut Run<'_>, [x, y]: [f64; 2], height: f64) {
        let place = DVec3::new(x, y, 0.0);
        let is_there = |x: &DVec3| x.distance(place) < 1e-9;
        assert_eq!(run.scene.bodies()[1].positions().iter().filter(|x| is_there(x)).count(), 1);
        let lifted = |x: &DVec3| if is_there(x) { *x + height * DVec3::Z } else { *x };
        run.move_soft(|_, x| Some(x.iter().map(lifted).collect())).expect("positions");
        run.record().expect("a round");
    }

    #[test]
    fn a_corner_below_a_tied_face_is_no_new_overlap_up_to_a_depth() {
        // Beside the tie, beyond it, and deeper.
        for (place, height, new_pairs) in [
            ([-5.0, 1.0], 0.5 * LIMIT, 0),
            ([5.0, 1.0], 0.2 + 0.5 * LIMIT, 1),
            ([-5.0, 1.0], 2.5 * LIMIT, 1),
        ] {
            let (mut scene, conditions) = plates();
            let params = ResolveParams::with_smoothing(6.0);
            let mut run = Run::start(&mut scene, params, &conditions).expect("a run");
            assert_eq!(run.near.overlapping().count(), 0);
            lift(&mut run, place, height);
            assert_eq!(run.near.overlapping().count(), 1, "{place:?} {height}");
            let round = run.rounds.last().expect("a round");
            assert_eq!(round.new_pairs, new_pairs, "{place:?} {height}");
            assert_eq!(run.left_at_ties.len(), 1 - new_pairs);

            // What is left in the end is named by its tie, and may be no deeper than the tolerance.
            let after = run.scene.check(&CheckParams::without_measures(0.1), run.round_progress());
            let left = run.list_remaining(&after.expect("reports"), Obstacle::Stuck);
            let is_tied = left[0].obstacle == Obstacle::Tied;
            assert_eq!(is_tied, place[0] < 0.0, "{left:?}");
            assert_eq!(left[0].is_within(2.0 * LIMIT), new_pairs == 0, "{left:?}");
        }
    }

    #[test]
    fn tied_vertices_leave_what_crosses_them() {
        for (place, height, parts) in [([-5.0, 1.0], 0.5 * LIMIT, true), ([5.0, 1.0], 0.21, false)]
        {
            let (mut scene, conditions) = plates();
            let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(6.0) };
            let mut run = Run::start(&mut scene, params, &conditions).expect("a run");
            lift(&mut run, place, height);
            let before = run.scene.bodies().iter().map(|body| body.positions().to_vec());
            let before: Vec<Vec<DVec3>> = before.collect();
            run.part_at_ties().expect("positions");
            assert_eq!(run.near.overlapping().next().is_none(), parts);
            let moves = |body: usize| {
                let x = run.scene.bodies()[body].positions().iter().zip(&before[body]);
                x.map(|(x, before)| x.distance(*before)).fold(0.0, f64::max)
            };
            let most = if parts { height + 3.0 * run.gap_slack() } else { 0.0 };
            assert!(moves(0) <= most && (moves(0) > 0.0) == parts, "{}", moves(0));
            assert!(moves(1) <= 0.0, "the leader stays");
        }
    }
}
