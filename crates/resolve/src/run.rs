//! Rounds of one overlap removal, of which the best is kept.

use std::collections::BTreeMap;

use glam::DVec3;
use scene::{CheckParams, PairId, PairReport, Scene};
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use crate::exit_sides::ExitMemory;
use crate::near_pairs::NearPairs;
use crate::resolution::{BodyChange, Remaining, Resolution, Round};
use crate::tissue::{self, Tissue, fitted_tree};
use crate::warm_start::{LocalDisplacements, local_displacements};
use crate::{ResolveError, ResolveParams, strain, tuning, volume};

/// State of one overlap removal.
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a mut Scene,
    pub(crate) params: ResolveParams,
    progress: Progress<'a>,
    pub(crate) tissues: Vec<Tissue>,
    /// Inverse masses of all particles.
    pub(crate) inverse_masses: Vec<f64>,
    before: Vec<PairReport>,
    pub(crate) near: NearPairs,
    pub(crate) rounds: Vec<Round>,
    /// Number of the best round, and the positions of all particles after it.
    best: usize,
    best_positions: Vec<DVec3>,
    /// Rounds since the best one.
    stalled_rounds: u32,
    pub(crate) exit_memories: BTreeMap<PairId, [ExitMemory; 2]>,
    /// Damage to each body.
    pub(crate) damage: Vec<Damage>,
}

/// Damage that pushes did to the shape of a body.
#[derive(Clone, Copy, Default)]
pub(crate) struct Damage {
    flipped_faces: usize,
    /// Relative change of the volume.
    volume_change: f64,
    /// Pairs of the body's own faces that cross and did not at the start.
    pub(crate) self_crossings: usize,
}

impl Damage {
    /// Returns true if the body's shape has to be restored.
    pub(crate) fn is_spoilt(&self) -> bool {
        self.flipped_faces + self.self_crossings > 0
            || self.volume_change > tuning::MAX_VOLUME_CHANGE
    }
}

impl<'a> Run<'a> {
    /// Detects all overlaps at the start.
    pub(crate) fn new(
        scene: &'a mut Scene,
        params: ResolveParams,
        progress: Progress<'a>,
    ) -> Result<Self, ResolveError> {
        let margin = detection_margin(&params);
        let start = progress.part(0.0, 0.0);
        let before = scene.check(&CheckParams { margin }, start)?;
        let mut near = NearPairs::default();
        let all = vec![true; scene.bodies().len()];
        near.update(scene, margin, &all, start)?;
        let tissues = tissue::tissues(scene);

        let mut run = Self {
            inverse_masses: tissue::inverse_masses(scene, &tissues, params.smoothing),
            damage: vec![Damage::default(); tissues.len()],
            scene,
            params,
            progress,
            tissues,
            before,
            near,
            rounds: Vec::new(),
            best: 0,
            best_positions: Vec::new(),
            stalled_rounds: 0,
            exit_memories: BTreeMap::new(),
        };
        run.record()?;
        Ok(run)
    }

    /// Displaces tissue by `carried`, if there is any and that is better than the state as it
    /// stands.
    pub(crate) fn warm_start(
        &mut self,
        carried: &[Option<LocalDisplacements>],
    ) -> Result<(), ResolveError> {
        if carried.is_empty() || !self.continues() {
            return Ok(());
        }
        for (id, carried) in self.scene.ids().zip(carried) {
            if let Some(carried) = carried {
                let x = carried.displace(&self.tissues[id.index()]);
                self.scene.move_body(id, &x)?;
            }
        }
        self.detect(&self.soft())?;
        self.record()?;
        if self.stalled_rounds > 0 { self.revert_to_best() } else { Ok(()) }
    }

    /// Pushes bodies apart round by round, and takes the best round.
    pub(crate) fn complete(&mut self) -> Result<Resolution, ResolveError> {
        while self.continues() {
            let u = self.push()?;
            let moved = self.move_by(&u)?;
            self.detect(&moved)?;
            self.record()?;
        }
        if self.rounds.last() != self.rounds.get(self.best) {
            self.revert_to_best()?;
        }

        let margin = detection_margin(&self.params);
        let after = self.scene.check(&CheckParams { margin }, self.round_progress())?;
        let stuck = self.is_stuck();
        let remaining = Remaining::list(self.scene, &self.near, &self.before, stuck);
        Ok(Resolution {
            resolved: remaining.iter().all(|pair| pair.is_within(self.params.tolerance)),
            remaining,
            bodies: BodyChange::list(self.scene, &self.tissues),
            before: std::mem::take(&mut self.before),
            after,
            rounds: std::mem::take(&mut self.rounds),
        })
    }

    /// Stores the displacements of soft bodies in local frames.
    pub(crate) fn local_displacements(&self) -> Vec<Option<LocalDisplacements>> {
        local_displacements(self.scene, &self.tissues)
    }

    /// Puts soft bodies back to where they were at the start.
    pub(crate) fn restore(&mut self) -> Result<(), ResolveError> {
        for (id, tissue) in self.scene.ids().zip(&self.tissues) {
            if !self.scene.body(id).is_rigid() {
                self.scene.move_body(id, &tissue.rest)?;
            }
        }
        Ok(())
    }

    /// Reports the completed share of the rounds, and polls for an interruption.
    pub(crate) fn poll(&self) -> Result<(), Interrupted> {
        self.round_progress().report(0.0)
    }

    fn round_progress(&self) -> Progress<'a> {
        let rounds = u32::try_from(self.rounds.len()).unwrap_or(u32::MAX);
        let fraction = f64::from(rounds) / (f64::from(self.params.max_rounds) + 1.0);
        self.progress.part(fraction, fraction)
    }

    fn continues(&self) -> bool {
        let is_clean = self.rounds.last().is_none_or(Round::is_clean);
        let has_rounds_left = self.rounds.len() <= self.params.max_rounds as usize;
        !is_clean && !self.is_stuck() && has_rounds_left
    }

    /// Returns true if nothing has improved for too many rounds.
    fn is_stuck(&self) -> bool {
        let best = self.rounds.get(self.best);
        let is_settled = best.is_some_and(|best| best.is_within(self.params.tolerance));
        let max_rounds =
            if is_settled { tuning::MAX_SETTLED_ROUNDS } else { tuning::MAX_STALLED_ROUNDS };
        self.stalled_rounds >= max_rounds
    }

    /// Returns for each body whether it is soft.
    fn soft(&self) -> Vec<bool> {
        self.scene.bodies().iter().map(|body| !body.is_rigid()).collect()
    }

    /// Detects the contacts of moved bodies.
    fn detect(&mut self, moved: &[bool]) -> Result<(), ResolveError> {
        let progress = self.round_progress();
        self.near.update(self.scene, detection_margin(&self.params), moved, progress)
    }

    /// Adds the present state to the rounds, and keeps its positions where it is the best.
    fn record(&mut self) -> Result<(), ResolveError> {
        let mut round = Round::of_overlaps(&self.near, &self.before);
        let tolerance = self.params.tolerance;
        let counts_crossings = round.is_within(tolerance) && !self.rounds.is_empty();
        self.assess_damage(counts_crossings)?;
        for damage in &self.damage {
            round.volume_change = round.volume_change.max(damage.volume_change);
            round.flipped_faces += damage.flipped_faces;
            if counts_crossings {
                round.self_crossings += damage.self_crossings;
            }
        }

        let best = self.rounds.get(self.best);
        if best.is_none_or(|best| round.is_better_than(best, tolerance)) {
            self.best = self.rounds.len();
            self.best_positions = self.scene.particle_positions();
            self.stalled_rounds = 0;
        } else {
            self.stalled_rounds += 1;
        }
        self.rounds.push(round);
        Ok(())
    }

    /// Assesses the damage to all bodies. Self-crossings take long, and are counted on demand.
    fn assess_damage(&mut self, counts_crossings: bool) -> Result<(), Interrupted> {
        let progress = self.round_progress();
        let bodies = self.scene.bodies().iter().zip(&self.tissues);
        let mut bodies: Vec<_> = bodies.zip(&mut self.damage).collect();
        parallel::try_for_each_mut(&mut bodies, |_, ((body, tissue), damage)| {
            progress.report(0.0)?;
            let tree = fitted_tree(body);
            damage.flipped_faces = strain::count_flipped(tissue, body.positions());
            if !body.is_rigid() {
                damage.volume_change = volume::relative_change(tissue, body.positions());
            }
            if counts_crossings {
                damage.self_crossings = strain::count_new_self_crossings(tree, tissue);
            }
            Ok(())
        })
    }

    /// Moves soft bodies back to the best round.
    fn revert_to_best(&mut self) -> Result<(), ResolveError> {
        let soft = self.soft();
        for id in self.scene.ids().filter(|id| soft[id.index()]) {
            let particles = self.scene.body(id).particles();
            let x = &self.best_positions[particles.start as usize..particles.end as usize];
            self.scene.move_body(id, x)?;
        }
        self.detect(&soft)
    }
}

/// Returns the margin within which contacts are detected.
fn detection_margin(params: &ResolveParams) -> f64 {
    let step = tuning::MAX_STEP * params.smoothing;
    tuning::CLEARANCE_MARGIN * params.clearance + tuning::DETECTION_MARGIN * step
}
