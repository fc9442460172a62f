//! Steps that are certainly free of contact.
//!
//! Continuous detection finds the first contacts on the way. Particles that meet are held back to
//! before their contact, by themselves: all others go on. Since that changes the way of their
//! neighbors, the step is swept again until nothing meets.

use ccd::CcdParams;
use glam::DVec3;
use scene::{BodyMove, PairId};

use crate::run::Run;
use crate::{ResolveError, tuning};

impl Run<'_> {
    /// Moves soft bodies by the displacements of all particles, as far as nothing meets and no
    /// body leaves its limits. Pairs that cross already are not regarded.
    pub(crate) fn move_freely(
        &mut self,
        displacements: &[DVec3],
        crossing: &[PairId],
    ) -> Result<(), ResolveError> {
        let mut shares = vec![1.0; displacements.len()];
        self.limit_shape(displacements, &mut shares);

        let mut changed = vec![true; self.tissues.len()];
        for pass in 0.. {
            // Only pairs of which a way has changed may meet anew.
            let ends = self.ends_of_step(displacements, &shares);
            let mut moves = Vec::new();
            for (tissue, end) in self.tissues.iter().zip(&ends) {
                if let Some(positions) = end {
                    moves.push(BodyMove { body: tissue.id, positions });
                }
            }
            let is_wanted = |pair: PairId| {
                let has_changed = changed[pair.a.index()] || changed[pair.b.index()];
                has_changed && !crossing.contains(&pair)
            };
            let progress = self.round_progress();
            let params = CcdParams::DEFAULT;
            let report = self.scene.sweep_among(&moves, &params, is_wanted, progress)?;
            if report.pairs.is_empty() {
                return self.take_step(&ends);
            }

            // What meets is held back; whole bodies, where that does not end.
            changed.fill(false);
            for found in &report.pairs {
                for id in found.pair.bodies() {
                    changed[id.index()] = true;
                }
                if pass >= tuning::MAX_HOLD_PASSES {
                    for id in found.pair.bodies() {
                        let range = self.scene.body(id).particles();
                        shares[range.start as usize..range.end as usize].fill(0.0);
                    }
                    continue;
                }
                for contact in &found.contacts {
                    let time = contact.contact.time.unwrap_or(0.0);
                    for term in contact.contact.stencil.terms() {
                        let share = &mut shares[term.particle as usize];
                        *share = share.min(tuning::FREE_SHARE * time * *share);
                    }
                }
            }
        }
        Ok(())
    }

    /// Shortens the steps of bodies until each is within its limits.
    fn limit_shape(&mut self, displacements: &[DVec3], shares: &mut [f64]) {
        for number in 0..self.tissues.len() {
            let tissue = &self.tissues[number];
            if tissue.is_rigid {
                continue;
            }
            let body = self.scene.body(tissue.id);
            let range = body.particles().start as usize..body.particles().end as usize;
            let flipped = tissue.count_flipped(body.positions());
            for _ in 0..tuning::MAX_HOLD_PASSES {
                let mut x = body.positions().to_vec();
                for ((x, d), share) in
                    x.iter_mut().zip(&displacements[range.clone()]).zip(&shares[range.clone()])
                {
                    *x += *share * *d;
                }
                if tissue.count_flipped(&x) <= flipped {
                    break;
                }
                for share in &mut shares[range.clone()] {
                    *share *= 0.5;
                }
            }
        }
    }

    /// Returns the end positions of each body; `None` where it rests.
    fn ends_of_step(&self, displacements: &[DVec3], shares: &[f64]) -> Vec<Option<Vec<DVec3>>> {
        let mut ends = Vec::new();
        for body in self.scene.bodies() {
            let range = body.particles().start as usize..body.particles().end as usize;
            let (d, shares) = (&displacements[range.clone()], &shares[range]);
            let mut x = body.positions().to_vec();
            let mut moves = false;
            for ((x, d), share) in x.iter_mut().zip(d).zip(shares) {
                let step = *share * *d;
                if step != DVec3::ZERO {
                    *x += step;
                    moves = true;
                }
            }
            ends.push(moves.then_some(x));
        }
        ends
    }

    fn take_step(&mut self, ends: &[Option<Vec<DVec3>>]) -> Result<(), ResolveError> {
        for (tissue, end) in self.tissues.iter().zip(ends) {
            if let Some(x) = end {
                self.scene.move_body(tissue.id, x)?;
            }
        }
        Ok(())
    }
}
