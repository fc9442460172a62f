//! Attempts at one state of a scene, of which the best one is kept.

use glam::DVec3;
use scene::{BodyId, PairReport, Scene};
use surface::progress::Progress;

use crate::conditions::TieBonds;
use crate::exempt::Exempt;
use crate::local_displacements::LocalDisplacements;
use crate::run::{Known, Run};
use crate::soft_positions::{move_soft_bodies, soft_positions};
use crate::{Conditions, Obstacle, Resolution, ResolveError, ResolveParams};

/// Factor on the smoothing length of a start after one that was the same but for it. Near 1, both lead
/// to the same end; above, more tissue moves than was asked for.
const LONGER: f64 = 1.5;

/// Length of pushes up to which a further start has shorter ones \[deepest overlaps\]. Above, those are long, too.
const FAR: f64 = 3.0;

/// Largest number of starts after the first one. Below, deep tissue with short pushes is not freed; above, what has no
/// way out is refused later.
const MAX_FURTHER_STARTS: usize = 6;

/// Beginning of attempts: what is wished for, and what an earlier state left.
#[derive(Clone, Copy)]
pub(crate) struct Start<'a> {
    pub(crate) params: ResolveParams,
    pub(crate) conditions: &'a Conditions,
    /// Ties of an earlier state, which are found in this one where there is none.
    pub(crate) ties: Option<&'a TieBonds>,
    /// Displacements of an earlier state; empty where there is none.
    pub(crate) carried: &'a [LocalDisplacements],
}

/// Attempts at one state of a scene.
pub(crate) struct Attempts<'a> {
    pub(crate) start: Start<'a>,
    pub(crate) scene: &'a mut Scene,
    progress: Progress<'a>,
    /// Positions of soft bodies without any push.
    rest: Vec<Vec<DVec3>>,
    /// Ties of the first state.
    pub(crate) ties: TieBonds,
    /// Best end so far, in which the scene is between attempts.
    pub(crate) end: Resolution,
    /// Displacements of the best end.
    pub(crate) displacements: Vec<LocalDisplacements>,
    /// Exemptions of the best end, which further attempts have, too.
    pub(crate) exempt: Exempt,
    /// Tied vertices at faces that the last attempt would have turned over.
    pub(crate) strained_ties: Vec<(BodyId, u32)>,
}

impl<'a> Attempts<'a> {
    /// Removes overlaps a first time, with displacements of an earlier state where there are any.
    pub(crate) fn begin(
        start: Start<'a>,
        scene: &'a mut Scene,
        progress: Progress<'a>,
    ) -> Result<Self, ResolveError> {
        let rest = soft_positions(scene);
        let known = Known { before: None, ties: start.ties };
        let mut run =
            Run::new(scene, start.params, start.conditions, &Exempt::NONE, known, progress)?;
        let ties = start.ties.map_or_else(|| run.ties.all.clone(), TieBonds::clone);
        let end = run.remove_overlaps(start.carried)?;
        let displacements = run.local_displacements();
        let strained_ties = std::mem::take(&mut run.strained_ties);
        let exempt = Exempt::NONE;
        Ok(Self { start, scene, progress, rest, ties, end, displacements, exempt, strained_ties })
    }

    /// Removes overlaps once more, from the state by itself. Keeps the end if it is better than the best one so far;
    /// else returns it, and takes the scene back to that one.
    pub(crate) fn try_again(
        &mut self,
        params: ResolveParams,
        exempt: &Exempt,
    ) -> Result<Option<Resolution>, ResolveError> {
        let best = soft_positions(self.scene);
        move_soft_bodies(self.scene, &self.rest)?;
        let Start { params: asked, conditions, .. } = self.start;
        let before = (params == asked).then_some(&self.end.before[..]);
        let known = Known { before, ties: Some(&self.ties) };
        let mut run = Run::new(self.scene, params, conditions, exempt, known, self.progress)?;
        run.allowed_displacement = asked.smoothing;
        let mut next = run.remove_overlaps(&[])?;
        self.strained_ties = std::mem::take(&mut run.strained_ties);
        if next.may_be_better() && next.left() >= self.end.left() {
            move_soft_bodies(self.scene, &best)?;
            return Ok(Some(next));
        }

        self.displacements = run.local_displacements();
        next.name_exempt(exempt, &self.end);
        let last = std::mem::replace(&mut self.end, next);
        if !self.end.resolved && !exempt.bodies.is_empty() {
            self.end.list_before(last.broken_limits);
        }
        Ok(None)
    }

    /// Removes overlaps with longer pushes, and then shorter ones, as long as an end may be better. Longer ones may also
    /// take apart what has no side to be pushed to, where nothing else is left.
    pub(crate) fn push_otherwise(&mut self) -> Result<(), ResolveError> {
        if !self.end.may_be_better() {
            return Ok(());
        }
        let is_left = self.end.is_left_without(&self.exempt);
        let exempt = if is_left { self.exempt.clone() } else { Exempt::NONE };
        for params in self.other_pushes() {
            let worse = self.try_again(params, &exempt)?;
            if !worse.as_ref().unwrap_or(&self.end).may_be_better() {
                break;
            }
        }
        Ok(())
    }

    /// Returns the parameters of further starts, each with longer pushes, until these are far longer than the deepest
    /// vertex is deep, and then one with shorter pushes, where these are no shorter than that. Displacements of the last
    /// state may lead where no way goes on, and so may short pushes: after a first start without any, pushes begin a little longer; after others no shorter than the deepest vertex is
    /// deep, since those that an earlier state was given for turn faces over.
    fn other_pushes(&self) -> Vec<ResolveParams> {
        // The depth of what another body encloses is not how far it is to come.
        let is_enclosed = |report: &PairReport| {
            let mut remaining = self.end.remaining.iter();
            remaining.any(|left| left.pair == report.pair && left.obstacle == Obstacle::Enclosed)
        };
        let mut depth: f64 = 0.0;
        for report in self.end.before.iter().filter(|report| !is_enclosed(report)) {
            depth = depth.max(report.max_vertex_depth);
        }

        let Start { params, carried, .. } = self.start;
        let asked = params.smoothing;
        let first = if carried.is_empty() { LONGER * asked } else { asked.max(depth) };
        let next = |length: &f64| (*length <= LONGER * depth).then_some(LONGER * length);
        let longer = std::iter::successors(Some(first), next).take(MAX_FURTHER_STARTS);
        let may_be_shorter = asked <= FAR * depth && asked >= LONGER * depth;
        let shorter = may_be_shorter.then_some(asked / LONGER);
        longer.chain(shorter).map(|smoothing| ResolveParams { smoothing, ..params }).collect()
    }
}

impl Resolution {
    /// Returns true if something is left that another start might change: more than what is between rigid
    /// bodies.
    pub(crate) fn may_be_better(&self) -> bool {
        let is_broken = !self.broken_limits.is_empty() || !self.self_overlaps.is_empty();
        !self.resolved && (is_broken || self.is_left_without(&Exempt::NONE))
    }
}
