//! Rounds of one overlap removal, of which the best is kept.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;
use proximity::SurfaceTree;
use response::ParameterError;
use scene::{BodyId, BodyMove, DepthBracket, PairId, PairOverlap, PairReport, Scene};
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use crate::conditions::TieBonds;
use crate::detection::{check, clearance, detection_margin};
use crate::elastic::GapRow;
use crate::exempt::Exempt;
use crate::exit_sides::PairMemory;
use crate::near_pairs::{NearPair, NearPairs};
use crate::obstacle::Obstacle;
use crate::resolution::{BodyChange, Resolution, deepest, max_bracket, overlaps_in};
use crate::round::Round;
use crate::seams::Seams;
use crate::ties::Ties;
use crate::tissue::{Tissue, fitted_tree};
use crate::{Conditions, GapRound, ResolveError, ResolveParams};

/// Width of the brackets on depths that decide \[tolerances\]. Below, near-coincident surfaces
/// take long; above, depths just within the tolerance count as deeper.
pub(crate) const DEPTH_BRACKET: f64 = 0.125;

/// Distance below which two features touch and have no direction of their own \[the gap, or the
/// clearance where overlaps are pushed apart\]. Below, directions are of rounding; above, they are those of faces.
pub(crate) const TOUCHING: f64 = 1e-6;

/// State of one overlap removal.
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a mut Scene,
    pub(crate) params: ResolveParams,
    progress: Progress<'a>,
    /// Tissues of all bodies, in their order.
    pub(crate) tissues: Vec<Tissue>,
    /// Inverse masses of all particles.
    pub(crate) inverse_masses: Vec<f64>,
    pub(crate) before: Vec<PairReport>,
    /// Pairs that overlap at the start, ascending.
    pub(crate) at_first: Vec<PairId>,
    /// Others that share faces there, ascending.
    pub(crate) touching_at_first: Vec<PairId>,
    pub(crate) near: NearPairs,
    /// Pairs that are left as they are.
    pub(crate) exempt_pairs: Vec<PairId>,
    pub(crate) rounds: Vec<Round>,
    /// Number of the best round.
    best: usize,
    /// Rounds since the best one.
    stalled_rounds: u32,
    pub(crate) pair_memories: BTreeMap<PairId, PairMemory>,
    /// Longest way out of a contact in the first round.
    pub(crate) longest_way: f64,
    /// Displacement that is within limits in any case: the smoothing length that was asked for, also where
    /// pushes are longer, or what was carried from the last state, and what is left to do from there.
    pub(crate) allowed_displacement: f64,
    /// True if the rounds begin with carried displacements.
    pub(crate) is_warm: bool,
    /// True if nothing overlaps where bodies are at rest, and no bone was on the way back from carried displacements.
    pub(crate) is_back_at_rest: bool,
    /// True if the last round took apart bodies that cross themselves.
    has_uncrossed: bool,
    /// Rows of edges that crossed in elastic rounds, with the openings that they miss at the start.
    pub(crate) edge_rows: Vec<GapRow>,
    pub(crate) gap_rounds: Vec<GapRound>,
    /// Number of the round that was accepted last.
    accepted: Option<usize>,
    /// Pairs that overlap in the round of least merit, accepted or not.
    unfreed: Vec<PairId>,
    /// States that were accepted last.
    pub(crate) accepted_states: VecDeque<AcceptedState>,
    pub(crate) ties: Ties,
    /// Pairs that cross at their ties in the last measured state, no deeper than they may.
    pub(crate) left_at_ties: Vec<PairId>,
    /// Tied vertices at faces that were turned over in the last state beyond limits.
    pub(crate) strained_ties: Vec<(BodyId, u32)>,
    /// Particles that take steps as one: those of seams, and while the gap is opened the corners of faces that would turn
    /// over.
    pub(crate) joints: Seams,
    /// Faces that the last step would have turned over as it was, by their bodies.
    pub(crate) turning_faces: Vec<(BodyId, u32)>,
}

/// State of all bodies after an accepted round.
#[derive(Debug)]
pub(crate) struct AcceptedState {
    /// Number of the round.
    pub(crate) round: usize,
    /// Positions of each body, none of rigid ones.
    pub(crate) positions: Vec<Vec<DVec3>>,
}

/// Properties of a start that are known from others.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    /// Overlaps without any displacement.
    pub(crate) before: Option<&'a [PairReport]>,
    /// Ties of the first state.
    pub(crate) ties: Option<&'a TieBonds>,
}

#[cfg(test)]
impl<'a> Run<'a> {
    /// Begins a run of which nothing is known, and nothing is exempt.
    pub(crate) fn start(
        scene: &'a mut Scene,
        params: ResolveParams,
        conditions: &Conditions,
    ) -> Result<Self, ResolveError> {
        let known = Known { before: None, ties: None };
        Self::new(scene, params, conditions, &Exempt::NONE, known, Progress::none())
    }
}

impl<'a> Run<'a> {
    /// Detects all overlaps at the start, unless they are `known`. Bodies that are `exempt`
    /// stay there, and pairs are left as they are.
    pub(crate) fn new(
        scene: &'a mut Scene,
        params: ResolveParams,
        conditions: &Conditions,
        exempt: &Exempt,
        known: Known<'_>,
        progress: Progress<'a>,
    ) -> Result<Self, ResolveError> {
        // Steps that change no coordinate move nothing.
        if params.smoothing < f64::EPSILON * scene.largest_coordinate() {
            let range = "at least the rounding of the largest coordinate";
            let error = ParameterError { name: "smoothing", value: params.smoothing, range };
            return Err(error.into());
        }

        if let Some(body) = scene.bodies().iter().find(|body| body.has_moving_centers()) {
            return Err(ResolveError::Polygons { name: body.name().to_owned() });
        }
        check_welded(scene)?;

        // Overlaps at the start, by which later rounds are judged.
        let margin = detection_margin(&params);
        let start = progress.part(0.0, 0.0);
        let before = match known.before {
            Some(before) => before.to_vec(),
            None => check(scene, margin, params.tolerance, start)?,
        };
        scene.fit_all()?;
        let exempt = &exempt.with_surrounded(&before);
        let mut near = NearPairs::new(scene, exempt);
        near.adopt(scene, &before, margin, start)?;

        // Tissues at rest, and the masses by which they share overlaps.
        let mut tissues = Tissue::of_bodies(scene, &params, start)?;
        conditions.fix(&mut tissues)?;
        conditions.stiffen(scene, &mut tissues)?;
        conditions.keep_unrounded(scene, &mut tissues)?;
        conditions.hold_corners(scene, &mut tissues)?;
        for tissue in &mut tissues {
            tissue.is_held = exempt.bodies.contains(&tissue.id);
        }
        conditions.uncross(scene, &mut tissues, start)?;
        let ties = Ties::new(conditions, scene, &mut tissues, &near, &exempt.loose, known.ties)?;
        let mut inverse_masses = Vec::new();
        for tissue in &tissues {
            inverse_masses.extend(tissue.inverse_masses());
        }
        ties.seams.add_masses(&mut inverse_masses);
        near.open_seams(scene, ties.seams.faces(scene), margin);

        let mut run = Self {
            scene,
            params,
            progress,
            tissues,
            inverse_masses,
            before,
            at_first: Vec::new(),
            touching_at_first: Vec::new(),
            near,
            exempt_pairs: exempt.pairs.clone(),
            rounds: Vec::new(),
            best: 0,
            stalled_rounds: 0,
            pair_memories: BTreeMap::new(),
            longest_way: 0.0,
            allowed_displacement: params.smoothing,
            is_warm: false,
            is_back_at_rest: false,
            has_uncrossed: false,
            edge_rows: Vec::new(),
            gap_rounds: Vec::new(),
            accepted: None,
            unfreed: Vec::new(),
            accepted_states: VecDeque::new(),
            joints: ties.seams.clone(),
            turning_faces: Vec::new(),
            strained_ties: Vec::new(),
            left_at_ties: Vec::new(),
            ties,
        };
        match run.begin() {
            Ok(()) => Ok(run),
            Err(error) => {
                run.restore()?;
                Err(error)
            }
        }
    }

    /// Records the start.
    fn begin(&mut self) -> Result<(), ResolveError> {
        self.move_out_of_level()?;
        for near in self.near.iter() {
            if near.report.overlaps {
                self.at_first.push(near.report.pair);
            } else if self.count_touching_faces(near) > 0 {
                self.touching_at_first.push(near.report.pair);
            }
        }
        self.record()?;
        self.rounds[0].surface_depth = deepest(&self.before);
        Ok(())
    }

    /// Pushes bodies apart round by round, and takes the best round.
    pub(crate) fn complete(&mut self) -> Result<Resolution, ResolveError> {
        while self.continues() {
            self.go_round()?;
            self.record()?;
        }
        let mut final_round = self.best;
        if final_round + 1 != self.rounds.len() {
            self.revert_to_best()?;
        }
        self.uncross_anew()?;

        // From what does not cross, the gap; also from an earlier round, where the best one breaks
        // limits that opening the gap does not restore.
        let mut broken_limits = self.open_settled_gaps(final_round)?;
        let (broken, kept_round) = self.return_to_limits(final_round)?;
        let is_listed = |body| broken_limits.iter().any(|listed| listed.body == body);
        let unlisted: Vec<_> = broken.into_iter().filter(|it| !is_listed(it.body)).collect();
        broken_limits.extend(unlisted);
        if kept_round != final_round {
            final_round = kept_round;
            self.open_gaps(final_round)?;
            (_, final_round) = self.return_to_limits(final_round)?;
        }

        // The final state, detected in full, decides by the depth of surfaces.
        let (after, final_round) = self.detect_end(final_round)?;
        self.rounds[final_round].surface_depth = deepest(&after);
        let overlapping: Vec<PairId> =
            after.iter().filter(|report| report.overlaps).map(|report| report.pair).collect();
        let gap = self.prove_gap(&overlapping)?;
        let standstill = if !broken_limits.is_empty() {
            Obstacle::Limits
        } else if self.is_stuck() {
            Obstacle::Stuck
        } else {
            Obstacle::Rounds
        };
        let self_overlaps = self.self_overlaps()?;
        let mut remaining = self.list_remaining(&after, standstill);
        self.name_standstills(&mut remaining, &after, standstill);
        let (ties, is_torn) = self.measure_ties();
        Ok(Resolution {
            resolved: gap.holds()
                && broken_limits.is_empty()
                && !is_torn
                && self_overlaps.is_empty()
                && remaining.iter().all(|pair| pair.is_within(self.params.tolerance)),
            gap,
            self_overlaps,
            broken_limits,
            ties,
            gap_rounds: std::mem::take(&mut self.gap_rounds),
            remaining,
            bodies: BodyChange::list(self.scene, &self.tissues, self.round_progress())?,
            before: std::mem::take(&mut self.before),
            after,
            rounds: std::mem::take(&mut self.rounds),
            final_round,
            is_continued: self.is_warm && final_round > 0 || self.is_back_at_rest,
            unfreed: std::mem::take(&mut self.unfreed),
        })
    }

    /// Moves bodies by one round. Bodies that only cross themselves are taken apart, by pushes where that led
    /// no farther.
    pub(crate) fn go_round(&mut self) -> Result<(), ResolveError> {
        let crosses_itself = self.rounds.last().is_some_and(Round::only_crosses_itself);
        self.has_uncrossed = crosses_itself && !self.has_uncrossed;
        if self.has_uncrossed {
            return self.uncross_anew();
        } else if self.rounds.len() <= self.elastic_rounds() {
            self.push_elastically()?;
        } else {
            self.push()?;
        }
        self.move_soft(Tissue::pushed)?;
        self.part_at_ties()
    }

    /// Moves soft bodies back to where they were at the start.
    pub(crate) fn restore(&mut self) -> Result<(), ResolveError> {
        for tissue in &self.tissues {
            if !tissue.is_rigid {
                self.scene.move_body(tissue.id, &tissue.rest)?;
            }
        }
        Ok(())
    }

    pub(crate) fn continues(&self) -> bool {
        let is_clean = self.rounds.last().is_none_or(|last| last.is_clean(&self.params));
        let has_rounds_left = self.rounds.len() <= self.params.max_rounds as usize;
        !is_clean && !self.is_stuck() && has_rounds_left
    }

    /// Returns true if nothing has improved for more than a third of the rounds that there may be.
    fn is_stuck(&self) -> bool {
        3 * self.stalled_rounds > self.params.max_rounds
    }

    /// Returns the progress of the present round, which only polls for an interruption.
    pub(crate) fn round_progress(&self) -> Progress<'a> {
        let rounds = u32::try_from(self.rounds.len()).unwrap_or(u32::MAX);
        let fraction = f64::from(rounds) / (f64::from(self.params.max_rounds) + 1.0);
        self.progress.part(fraction, fraction)
    }

    /// Adds the present state to the rounds, and keeps its positions where it is the best.
    pub(crate) fn record(&mut self) -> Result<(), ResolveError> {
        let mut round = self.measure_round()?;

        // The best round so far is kept, to be returned to in the end.
        if self.rounds.iter().all(|other| round.merit < other.merit) {
            self.unfreed = self.to_come_apart().map(|near| near.report.pair).collect();
        }
        let best = self.rounds.get(self.best);
        if best.is_none_or(|best| round.is_better_than(best)) {
            self.keep_as_best(self.rounds.len());
        } else if self.rounds.len() <= self.elastic_rounds() {
            // Elastic rounds pass through states that are no better.
            self.stalled_rounds = 1;
        } else {
            self.stalled_rounds += 1;
        }

        // So is the best one in which no pair overlaps anew and no body is beyond its limits.
        let is_better = self.accepted.is_none_or(|last| round.is_better_than(&self.rounds[last]));
        round.is_accepted = is_better && round.new_pairs == 0 && self.holds_limits()?;
        if round.is_accepted {
            self.accepted = Some(self.rounds.len());
            self.accept_state(self.rounds.len());
        }
        self.rounds.push(round);
        Ok(())
    }

    /// Measures the overlaps, the damage and the merit of the present state.
    fn measure_round(&mut self) -> Result<Round, ResolveError> {
        let tolerance = self.params.tolerance;
        self.leave_at_ties()?;
        let mut round = self.overlaps_of_round();
        for near in self.near.iter() {
            round.touching_faces += self.count_touching_faces(near);
        }
        for contact in self.self_contacts()? {
            round.max_depth = round.max_depth.max(-contact.gap);
        }

        // Vertices and edges miss what is deepest in the middle of a face: where they are within
        // the tolerance, the surfaces decide.
        if round.is_within(tolerance) && round.overlapping_pairs > 0 {
            round.surface_depth = self.surface_depth()?;
        }

        // Self-crossings take long to find, and are taken apart once the overlaps are gone.
        let is_wanted = |tissue: &Tissue| tissue.crossings_to_resolve.is_some();
        let counts_crossings = round.overlapping_pairs == 0 || self.tissues.iter().any(is_wanted);
        self.for_each_soft(|tissue, tree, progress| {
            tissue.assess(tree, counts_crossings, progress)
        })?;
        for tissue in &self.tissues {
            round.add_damage(&tissue.damage, counts_crossings);
        }
        round.merit = round.weigh(&self.params);
        Ok(round)
    }

    /// Keeps the present state as the best one, after a round of a number.
    pub(crate) fn keep_as_best(&mut self, number: usize) {
        self.best = number;
        self.stalled_rounds = 0;
        let x = |id: BodyId| self.scene.body(id).positions();
        parallel::map_mut(&mut self.tissues, |tissue| tissue.best.copy_from_slice(x(tissue.id)));
    }

    /// Counts the faces that a pair shares, where it is to come apart: for a gap, or since surfaces of
    /// common corners overlap between these.
    fn count_touching_faces(&self, near: &NearPair) -> usize {
        let pair = near.report.pair;
        if self.is_tied(pair) || (self.params.gap <= 0.0 && !overlaps_in(&self.before, pair)) {
            return 0;
        }
        near.count_touching_faces(self.scene, TOUCHING * clearance(&self.params))
    }

    /// Brackets the depth of the deepest overlap at present.
    fn surface_depth(&mut self) -> Result<Option<DepthBracket>, ResolveError> {
        let pairs = self.overlapping_pairs();
        let width = DEPTH_BRACKET * self.params.tolerance;
        let overlaps = self.scene.pair_overlaps(&pairs, Some(width), self.round_progress())?;
        Ok(max_bracket(overlaps.iter().flatten().filter_map(PairOverlap::max_depth)))
    }

    /// Calls `f` on every soft tissue with its tree and the progress to poll, and polls between
    /// them.
    pub(crate) fn for_each_soft(
        &mut self,
        f: impl Fn(&mut Tissue, &SurfaceTree, Progress<'_>) -> Result<(), Interrupted> + Sync + Send,
    ) -> Result<(), Interrupted> {
        let (progress, bodies) = (self.round_progress(), self.scene.bodies());
        let cost = |_: usize, tissue: &Tissue| tissue.cost();
        parallel::try_for_each_costly_first(&mut self.tissues, cost, |number, tissue| {
            progress.report(0.0)?;
            if tissue.is_rigid { Ok(()) } else { f(tissue, fitted_tree(&bodies[number]), progress) }
        })
    }

    /// Moves soft bodies back to the best round.
    pub(crate) fn revert_to_best(&mut self) -> Result<(), ResolveError> {
        self.move_soft(|tissue, _| Some(tissue.best.clone()))
    }

    /// Moves one body, whose self-crossings are to be counted again.
    pub(crate) fn move_tissue(&mut self, number: usize, x: &[DVec3]) -> Result<(), ResolveError> {
        let tissue = &mut self.tissues[number];
        tissue.counted_crossings = None;
        Ok(self.scene.move_body(tissue.id, x)?)
    }

    /// Moves soft bodies from their positions to others, where `to` computes some, and detects
    /// their contacts.
    pub(crate) fn move_soft(
        &mut self,
        to: impl Fn(&Tissue, &[DVec3]) -> Option<Vec<DVec3>> + Sync + Send,
    ) -> Result<(), ResolveError> {
        let scene = &*self.scene;
        let mut ends = parallel::map_slice_with(
            &self.tissues,
            || (),
            |(), tissue| {
                let from = scene.body(tissue.id).positions();
                let x = if tissue.is_rigid { None } else { to(tissue, from) };
                x.filter(|x| x != from)
            },
        );
        self.ties.seams.join_ends(scene, &mut ends);
        let mut moves = Vec::new();
        for (tissue, end) in self.tissues.iter_mut().zip(&ends) {
            if let Some(positions) = end {
                tissue.counted_crossings = None;
                moves.push(BodyMove { body: tissue.id, positions });
            }
        }
        self.scene.move_bodies(&moves)?;
        let moved: Vec<bool> = ends.iter().map(Option::is_some).collect();
        self.detect_moved(&moved)
    }

    /// Detects the contacts of bodies that have moved. Pairs of bodies that stayed keep their reports.
    pub(crate) fn detect_moved(&mut self, moved: &[bool]) -> Result<(), ResolveError> {
        let progress = self.round_progress();
        self.near.update(self.scene, detection_margin(&self.params), moved, progress)
    }
}

/// Checks that no soft body would tear along edges whose vertices are not welded.
fn check_welded(scene: &Scene) -> Result<(), ResolveError> {
    for body in scene.bodies().iter().filter(|body| !body.is_rigid()) {
        let is_welded = body.surface().require_welded(body.checked_positions());
        is_welded
            .map_err(|source| ResolveError::Unwelded { name: body.name().to_owned(), source })?;
    }
    Ok(())
}
