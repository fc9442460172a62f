//! Rounds that open the gap between surfaces that do not cross.
//!
//! Each round lists the closest points of all near features, solves for the displacement of least
//! elastic energy that brings them to the gap, and moves as far along it as is certainly free of
//! contact. What did not cross never does.

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::Workspace;
use proximity::{FeaturePoint, NearFeatures};
use scene::{Body, BodyId, PairId};
use surface::progress::{Interrupted, Progress};
use surface::{parallel, triangle};

use crate::damage::rounded_to_single;
use crate::detection::detection_margin;
use crate::elastic::{ElasticProblem, GapRow, Terms};
use crate::held_overlaps::HeldOverlaps;
use crate::near_pairs::detection_cost;
use crate::relaxation::{SOLVED_SHARE, STEP_SWEEPS};
use crate::resolution::{BrokenLimit, GapRound, overlaps_in};
use crate::run::{Run, TOUCHING};
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, ResolveParams, WrittenPrecision};

/// Share of what was missing that is progress where less is left. Near 1, hopeless places take
/// longer; far below, slow ones are given up.
const GAP_PROGRESS: f64 = 0.9;

/// Rounds that open the gap without [progress](GAP_PROGRESS), after which it is given up.
const MAX_STALLED_GAP_ROUNDS: usize = 3;

/// Largest number of sweeps of the elastic solver in a round that opens the gap. Below, gaps need more rounds;
/// above, rounds take longer.
const GAP_SWEEPS: usize = 60;

/// Pair of bodies with its near features.
pub(crate) struct PairFeatures {
    pub(crate) id: PairId,
    pub(crate) features: Vec<NearFeatures>,
}

impl Run<'_> {
    /// Opens the gap of all pairs that do not cross, as far as it goes, from the state of a round, and
    /// rounds positions. Ends in the best state within limits, and returns what the last state breaks
    /// if it is better; ends in the last state where none is.
    pub(crate) fn open_gaps(
        &mut self,
        from_round: usize,
    ) -> Result<Vec<BrokenLimit>, ResolveError> {
        if self.params.gap <= 0.0 {
            return Ok(Vec::new());
        }
        if self.near.overlapping().next().is_some() {
            // Bodies that were uncrossed or rounded since are elsewhere.
            self.detect_moved(&vec![true; self.tissues.len()])?;
        }
        let crossing = self.overlapping_pairs();
        let slack = self.gap_slack();
        let target = self.params.gap + slack;
        let mut search = GapSearch::new(from_round);
        let (mut near, mut moved) = (Vec::new(), vec![true; self.tissues.len()]);

        let broken = loop {
            self.round_progress().report(0.0)?;
            self.update_features(&mut near, &crossing, target + self.params.gap, &moved)?;
            let (problem, round) = self.gap_problem(&near, target, 0.5 * slack)?;
            let broken = self.judge_gap_round(round, &mut search)?;
            if search.is_over(&round, &self.params)
                || search.rounds > self.params.max_rounds as usize
            {
                break broken;
            }
            if search.stalled > 0 {
                self.join_turning_faces();
            }
            let at_rest = vec![DVec3::ZERO; self.inverse_masses.len()];
            let displacements = self.minimize(problem, &at_rest, GAP_SWEEPS, SOLVED_SHARE * slack);
            moved = self.move_freely(&displacements, &crossing)?;
            if !crossing.is_empty() {
                self.detect_moved(&moved)?;
            }
        };
        self.joints = self.ties.seams.clone();
        let is_accepted = search.least_accepted < f64::INFINITY;
        if is_accepted {
            self.return_to_accepted()?;
        }
        self.round_positions()?;
        Ok(if is_accepted { broken } else { Vec::new() })
    }

    /// Accepts the present state where less is left than in all accepted before, what overlaps is no deeper
    /// than in the first of them, and no body is beyond its limits; returns what a better one breaks.
    fn judge_gap_round(
        &mut self,
        mut round: GapRound,
        search: &mut GapSearch,
    ) -> Result<Vec<BrokenLimit>, ResolveError> {
        round.merit = round.left(&self.params);
        let mut broken = Vec::new();
        self.leave_at_ties()?;
        let is_no_deeper = search.held.as_ref().is_none_or(|held| held.are_no_deeper(self));
        if round.merit < search.least_accepted && is_no_deeper {
            // Steps let no body cross itself anew: counted once.
            broken = self.broken_limits(search.rounds == 0)?;
            round.is_accepted = broken.is_empty() || self.params.keep_going;
        }
        if round.is_accepted {
            search.least_accepted = round.merit;
            self.accept_state(search.from_round);
            search.held.get_or_insert_with(|| HeldOverlaps::of(self));
        }
        search.add(&round);
        self.gap_rounds.push(round);
        Ok(broken)
    }

    /// Returns the addition to the gap that covers what solving and rounding leave.
    pub(crate) fn gap_slack(&self) -> f64 {
        let mut rounding = 0.0;
        if self.params.precision == WrittenPrecision::Single {
            // Half a unit in the last place of each coordinate of both points.
            let largest = self.scene.largest_coordinate();
            rounding = 2.0 * f64::sqrt(3.0) * largest * 0.5 * f64::from(f32::EPSILON);
        }
        self.params.tuning.slack * self.params.gap + rounding
    }

    /// Returns the distance to which a tied pair is opened: none where it did not overlap, and what rounding
    /// may take where it has come apart.
    fn tied_target(&self, pair: PairId) -> f64 {
        if overlaps_in(&self.before, pair) { self.gap_slack() } else { 0.0 }
    }

    /// Returns the pairs whose surfaces cross or contain each other.
    pub(crate) fn overlapping_pairs(&self) -> Vec<PairId> {
        self.near.overlapping().map(|near| near.report.pair).collect()
    }

    /// Lists the near features of all pairs that can be moved apart, in the order of the bodies, without those
    /// that are exempt or cross. Pairs of which neither body has moved keep theirs.
    pub(crate) fn update_features(
        &mut self,
        near: &mut Vec<PairFeatures>,
        crossing: &[PairId],
        max_distance: f64,
        moved: &[bool],
    ) -> Result<(), ResolveError> {
        let has_moved = |pair: PairId| moved[pair.a.index()] || moved[pair.b.index()];
        near.retain(|pair| !has_moved(pair.id));
        let mut pairs = self.scene.close_pairs(max_distance)?;
        self.scene.fit_all()?;
        let is_left = |pair| crossing.contains(&pair) || self.exempt_pairs.contains(&pair);
        pairs.retain(|&pair| has_moved(pair) && self.can_open(pair) && !is_left(pair));

        let scene = &*self.scene;
        let find = |workspace: &mut Workspace, &id: &PairId| {
            let [a, b] = id.bodies().map(|body| fitted_tree(scene.body(body)));
            let mut features = Vec::new();
            NearFeatures::find(a, b, max_distance, workspace, &mut features);
            PairFeatures { id, features }
        };
        let cost = |pair: &PairId| detection_cost(scene, *pair);
        near.extend(parallel::map_costly_first(&pairs, cost, Workspace::default, find));
        near.sort_unstable_by_key(|pair| pair.id);
        Ok(())
    }

    /// Makes the rows that hold a body `target` apart from all that is near, pairs in `crossing` left out.
    pub(crate) fn holding_rows(
        &mut self,
        number: usize,
        crossing: &[PairId],
        target: f64,
    ) -> Result<Vec<GapRow>, ResolveError> {
        let (mut near, mut moves) = (Vec::new(), vec![false; self.tissues.len()]);
        moves[number] = true;
        self.update_features(&mut near, crossing, detection_margin(&self.params), &moves)?;
        let mut rows = Vec::new();
        for PairFeatures { id, features } in near {
            rows.reserve(features.len());
            for feature in &features {
                rows.extend(self.gap_row(id, feature, target - feature.distance));
            }
        }
        Ok(rows)
    }

    /// Takes the step from the displacements `u` to those of least elastic energy, as far as nothing meets; returns
    /// which bodies moved.
    pub(crate) fn step_freely(
        &mut self,
        problem: ElasticProblem,
        u: &[DVec3],
        crossing: &[PairId],
    ) -> Result<Vec<bool>, ResolveError> {
        let tolerance = SOLVED_SHARE * self.gap_slack();
        let steps = self.minimize(problem, u, STEP_SWEEPS, tolerance);
        self.move_freely(&steps, crossing)
    }

    /// Returns true if one body of a pair is soft.
    pub(crate) fn can_open(&self, pair: PairId) -> bool {
        pair.bodies().iter().any(|body| !self.tissues[body.index()].is_rigid)
    }

    /// Sets up the problem of a round. Features are short where more than `tolerance` is missing.
    fn gap_problem(
        &mut self,
        near: &[PairFeatures],
        target: f64,
        tolerance: f64,
    ) -> Result<(ElasticProblem, GapRound), ResolveError> {
        let mut round = GapRound { min_distance: f64::INFINITY, ..GapRound::default() };
        let mut problem = ElasticProblem::default();
        let mut seeds = self.add_contacts(&[self.corner_contacts()], &mut problem);
        for PairFeatures { id, features } in near {
            let target = if self.is_tied(*id) { self.tied_target(*id) } else { target };
            let mut is_short_pair = false;
            for feature in features {
                let missing = target - feature.distance;
                round.min_distance = round.min_distance.min(feature.distance);
                if missing > tolerance {
                    is_short_pair = true;
                    round.short_features += 1;
                    round.missing += missing;
                }
                problem.rows.extend(self.gap_row(*id, feature, missing));

                // What is short is what moves; other rows only hold.
                if missing > tolerance {
                    for (body, point) in id.bodies().into_iter().zip(&feature.points) {
                        let used = point.weights.map(|weight| weight > 0.0);
                        let corners = point.vertices.into_iter().zip(used);
                        let seeds = seeds.entry(body).or_default();
                        seeds.extend(corners.filter(|(_, used)| *used).map(|(v, _)| v));
                    }
                }
            }
            round.short_pairs += usize::from(is_short_pair);
        }

        self.hold_overlaps(&mut problem);
        self.add_bodies(seeds, &mut problem, &mut round)?;
        self.add_tie_bonds(&mut problem);
        Ok((problem, round))
    }

    /// Adds the bodies that move: around their short features, and where a volume is to be given
    /// back.
    fn add_bodies(
        &mut self,
        mut seeds: BTreeMap<BodyId, Vec<u32>>,
        problem: &mut ElasticProblem,
        round: &mut GapRound,
    ) -> Result<(), ResolveError> {
        // What holds each body that moves.
        self.add_tie_seeds(&mut seeds);
        let (progress, gap) = (self.round_progress(), self.params.gap);
        let (scene, seeds) = (&*self.scene, &seeds);
        let parts = parallel::map_mut_costly_first(&mut self.tissues, Tissue::cost, |tissue| {
            progress.report(0.0)?;
            let seeds = seeds.get(&tissue.id).cloned().unwrap_or_default();
            tissue.part_of_gap(scene.body(tissue.id), seeds, gap, progress)
        });
        let mut bodies = Vec::with_capacity(parts.len());
        for part in parts {
            let (part, volume_change) = part?;
            round.volume_change = round.volume_change.max(volume_change);
            bodies.push(part);
        }
        problem.extend(bodies);
        Ok(())
    }

    /// Makes the row of two near features; `None` where neither can move.
    pub(crate) fn gap_row(
        &self,
        pair: PairId,
        feature: &NearFeatures,
        missing: f64,
    ) -> Option<GapRow> {
        let mut terms = Terms::new();
        for ((id, point), sign) in pair.bodies().into_iter().zip(&feature.points).zip([-1.0, 1.0]) {
            let tissue = &self.tissues[id.index()];
            let first = self.scene.body(id).particles().start;
            for (vertex, weight) in point.vertices.into_iter().zip(point.weights) {
                if weight > 0.0 && tissue.is_free(vertex) {
                    terms.push((first + vertex, sign * weight));
                }
            }
        }
        let normal = self.opening_direction(pair, feature);
        let opens = !terms.is_empty() && normal != DVec3::ZERO;
        opens.then(|| GapRow::new(terms, normal, missing))
    }

    /// Returns the unit direction from the first point to the second; where they coincide, that
    /// in which the faces look away from each other.
    fn opening_direction(&self, pair: PairId, feature: &NearFeatures) -> DVec3 {
        let [p, q] = &feature.points;
        let apart = q.point - p.point;
        let is_far = feature.distance > TOUCHING * self.params.gap;
        if let Some(direction) = apart.try_normalize().filter(|_| is_far) {
            return direction;
        }
        let outward = |id: BodyId, point: &FeaturePoint| {
            let tissue = &self.tissues[id.index()];
            tissue.orientation() * triangle::unit_normal(self.scene.body(id).corners(point.face))
        };
        (outward(pair.a, p) - outward(pair.b, q)).normalize_or_zero()
    }

    /// Rounds the positions of soft bodies to the written precision, if a gap is to hold in it. Other bodies follow at
    /// seams.
    pub(crate) fn round_positions(&mut self) -> Result<(), ResolveError> {
        for number in 0..self.tissues.len() {
            let tissue = &self.tissues[number];
            if tissue.is_written_single && !tissue.is_rigid {
                // Self-crossings are counted where they are written: a count of moved tissue stays.
                let x = self.scene.bodies()[number].positions();
                let counted = self.tissues[number].counted_crossings;
                let counted = counted.filter(|_| x != self.tissues[number].rest);
                self.move_tissue(number, &rounded_to_single(x))?;
                self.tissues[number].counted_crossings = counted;
            }
        }

        for (number, x) in self.ties.seams.rounded(self.scene, &self.tissues) {
            self.move_tissue(number, &x)?;
        }
        Ok(())
    }
}

/// Progress of the rounds that open the gap.
struct GapSearch {
    /// Round of whose state they begin.
    from_round: usize,
    /// Overlaps of the first accepted state.
    held: Option<HeldOverlaps>,
    /// Rounds so far, and the last ones of them without progress.
    rounds: usize,
    stalled: usize,
    /// Least merit of all states, and of accepted ones.
    least: f64,
    least_accepted: f64,
}

impl GapSearch {
    fn new(from_round: usize) -> Self {
        let least = f64::INFINITY;
        Self { from_round, held: None, rounds: 0, stalled: 0, least, least_accepted: least }
    }

    fn add(&mut self, round: &GapRound) {
        let gains = round.merit < GAP_PROGRESS * self.least;
        self.stalled = if gains { 0 } else { self.stalled + 1 };
        self.least = self.least.min(round.merit);
        self.rounds += 1;
    }

    /// Returns true if nothing is left, or if rounds gain nothing: there is no room, or too far to go.
    fn is_over(&self, round: &GapRound, params: &ResolveParams) -> bool {
        let is_open = round.short_features == 0;
        (is_open && round.volume_change <= params.volume_tolerance())
            || self.stalled > MAX_STALLED_GAP_ROUNDS
    }
}

impl Tissue {
    /// Makes the part of the body in a round that opens the gap around `seeds`, and computes by how much
    /// its volume has changed.
    fn part_of_gap(
        &mut self,
        body: &Body,
        mut seeds: Vec<u32>,
        gap: f64,
        progress: Progress<'_>,
    ) -> Result<(ElasticProblem, f64), Interrupted> {
        let mut length = self.mean_edge.max(self.params.tuning.spread_radius * gap);
        let change = if self.is_rigid { 0.0 } else { self.volume_change(body.positions()) };
        if change > self.params.volume_tolerance() {
            // Given back where the body was pushed.
            let x = body.positions();
            length = length.max(self.params.tuning.spread_radius * self.max_displacement(x));
            for (vertex, (x, rest)) in (0..).zip(x.iter().zip(&self.rest)) {
                if x != rest {
                    seeds.push(vertex);
                }
            }
        }

        seeds.sort_unstable();
        seeds.dedup();
        let mut active = Vec::new();
        if !self.is_rigid && !seeds.is_empty() {
            active = self.vertices_around(&seeds, fitted_tree(body), length, progress)?;
            active.extend(&seeds);
            active.sort_unstable();
        }
        Ok((self.elastic_part(body, &active, length), change))
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, Scene};

    use super::*;

    use crate::{Conditions, ResolveParams, Tie};

    /// Rounding to single precision would let what came out of a tied body cross it again.
    #[test]
    fn what_came_out_of_a_tied_body_is_kept_beyond_rounding() {
        for (height, overlaps) in [(18.0, true), (20.2, false)] {
            let mut scene = Scene::new();
            let mut ids = Vec::new();
            for (name, z) in [("bone", 0.0), ("cartilage", height)] {
                let ball = shapes::icosphere(10.0, 2).translated(DVec3::new(700.0, -650.0, z));
                let kind = if z > 0.0 { BodyKind::Deformable } else { BodyKind::Rigid };
                ids.push(scene.add(name, kind, ball.surface(), ball.positions).expect("a ball"));
            }
            let pair = PairId::new(ids[0], ids[1]);
            let ties = vec![Tie { bodies: [ids[0], ids[1]], distance: 1.0 }];
            let conditions = Conditions { ties, ..Conditions::default() };
            let params = ResolveParams {
                gap: 0.05,
                precision: WrittenPrecision::Single,
                ..ResolveParams::with_smoothing(6.0)
            };
            let run = Run::start(&mut scene, params, &conditions);
            let target = run.expect("a run").tied_target(pair);
            assert_eq!(target > 700.0 * f64::from(f32::EPSILON), overlaps, "{target}");
        }
    }
}
