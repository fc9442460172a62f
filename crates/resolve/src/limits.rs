//! Limits on the change of bodies: the last state within them is kept.

use glam::DVec3;

use crate::resolution::BrokenLimit;
use crate::run::Run;
use crate::tissue::Tissue;
use crate::{ResolveError, ResolveParams, tuning};

impl Run<'_> {
    /// Keeps the positions of all bodies, to return to if later ones break a limit.
    pub(crate) fn keep_good_state(&mut self) {
        if self.good_states.len() == tuning::MAX_GOOD_STATES {
            self.good_states.pop_front();
        }
        let mut state = Vec::new();
        for body in self.scene.bodies() {
            let soft = if body.is_rigid() { Vec::new() } else { body.positions().to_vec() };
            state.push(soft);
        }
        self.good_states.push_back(state);
    }

    /// Goes back to the last good state within limits, unless the present one is or is to be
    /// kept; lists what the present one breaks.
    pub(crate) fn return_to_limits(&mut self) -> Result<Vec<BrokenLimit>, ResolveError> {
        let broken = self.broken_limits()?;
        let mut is_within = broken.is_empty() || self.params.keep_going;
        while !is_within {
            // Bodies at the start are within their limits.
            let state = self.good_states.pop_back();
            self.place_all(state.as_deref())?;
            self.round_positions()?;
            is_within = state.is_none() || self.broken_limits()?.is_empty();
        }
        Ok(broken)
    }

    /// Lists the bodies that are beyond their limits.
    fn broken_limits(&mut self) -> Result<Vec<BrokenLimit>, ResolveError> {
        self.scene.fit_all()?;
        self.for_each_soft(|tissue, tree, _| {
            tissue.assess(tree, true);
            Ok(())
        })?;
        let mut broken = Vec::new();
        let farthest = self.farthest_displacement();
        for Tissue { id, damage, rest, .. } in &self.tissues {
            let spoilt = damage.flipped_faces + damage.self_crossings > 0;
            let x = self.scene.body(*id).positions();
            let max_displacement =
                rest.iter().zip(x).map(|(x, y)| x.distance(*y)).fold(0.0, f64::max);
            if spoilt
                || damage.volume_change > self.params.max_volume_change
                || max_displacement > farthest
            {
                broken.push(BrokenLimit {
                    body: *id,
                    volume_change: damage.volume_change,
                    max_displacement,
                    flipped_faces: damage.flipped_faces,
                    self_crossings: damage.self_crossings,
                });
            }
        }
        Ok(broken)
    }

    /// Returns the distance beyond which a vertex is displaced rather than freed.
    fn farthest_displacement(&self) -> f64 {
        let depth = self.rounds.first().map_or(0.0, |start| start.max_depth);
        let ResolveParams { gap, smoothing, .. } = self.params;
        gap + (tuning::MAX_DISPLACEMENT * depth).max(smoothing)
    }

    /// Moves soft bodies to a state, or to where they were at the start, and detects contacts.
    fn place_all(&mut self, state: Option<&[Vec<DVec3>]>) -> Result<(), ResolveError> {
        self.move_soft(|tissue, _| {
            let x = state.map_or(&tissue.rest, |state| &state[tissue.id.index()]);
            Some(x.clone())
        })
    }
}
