//! Swept detection over a whole scene: first contacts between two successive states.

use ccd::{CcdParams, MovingPoints};
use glam::DVec3;
use kdop::Workspace;
use proximity::{SweptContact, SweptContacts, SweptError, SweptQuery, SweptSide};
use surface::progress::Progress;
use surface::{Aabb, Positions, parallel};

use crate::{BodyId, BodyMove, PairId, Scene, SceneError};

/// Distances of particles from their straight lines.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearLines {
    /// Maximum distance of each particle; empty for none.
    pub(crate) deviations: Vec<f64>,
    /// Maximum over the particles of each body, by its number; empty for none.
    pub(crate) max_of_bodies: Vec<f64>,
}

impl NearLines {
    /// Returns the distance within which the chords of two bodies come where the bodies meet.
    fn of_pair(&self, pair: PairId) -> f64 {
        let of_body = |id: BodyId| self.max_of_bodies.get(id.index()).copied().unwrap_or(0.0);
        (of_body(pair.a) + of_body(pair.b)) * (1.0 + 4.0 * f64::EPSILON)
    }

    /// Returns the largest distance of any two bodies.
    fn max_of_pairs(&self) -> f64 {
        let mut largest = 0.0_f64;
        for &of_body in &self.max_of_bodies {
            largest = largest.max(of_body);
        }
        2.0 * largest * (1.0 + 4.0 * f64::EPSILON)
    }
}

/// First contacts of a step.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SweepReport {
    /// Pairs that met, in the order of the bodies.
    pub pairs: Vec<PairSweep>,
    /// Share of the step, in `0.0..=1.0`, before which no contact begins: 1
    /// where nothing meets. Never after the first contact.
    pub largest_free_step: f64,
    /// Pairs of primitives that were queried, over all pairs of bodies.
    pub candidates: usize,
}

/// First contacts of two bodies during a step.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PairSweep {
    /// The two bodies.
    pub pair: PairId,
    /// First contacts of their vertices, edges and faces, by time, with particles
    /// numbered by [`Body::particles`](crate::Body::particles); never empty.
    pub contacts: Vec<SweptContact>,
}

impl Scene {
    /// Finds the first contacts while each body named in `moves` goes to its new positions, every
    /// vertex on a straight line; other bodies rest.
    ///
    /// The bodies are not moved: [`move_body`](Self::move_body) does that. No contact is missed,
    /// and no time is after the true one.
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] and [`SceneError::Surface`] for moves that do not fit their
    ///   bodies.
    /// - [`SceneError::Ccd`] for parameters out of range.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn sweep(
        &mut self,
        moves: &[BodyMove<'_>],
        params: &CcdParams,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        self.sweep_among(moves, params, |_| true, progress)
    }

    /// As [`Self::sweep`], for the pairs that are wanted.
    ///
    /// # Errors
    ///
    /// As [`Self::sweep`].
    pub fn sweep_among(
        &mut self,
        moves: &[BodyMove<'_>],
        params: &CcdParams,
        is_wanted: impl Fn(PairId) -> bool,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        self.sweep_near_lines(moves, params, &NearLines::default(), is_wanted, progress)
    }

    /// As [`Self::sweep_among`], with particles that may be off their straight lines.
    pub(crate) fn sweep_near_lines(
        &mut self,
        moves: &[BodyMove<'_>],
        params: &CcdParams,
        near: &NearLines,
        is_wanted: impl Fn(PairId) -> bool,
        progress: Progress<'_>,
    ) -> Result<SweepReport, SceneError> {
        params.validate()?;
        let ends = self.check_moves(moves)?;
        let margin = params.min_separation + near.max_of_pairs();
        let mut pairs = self.candidates_of_step(&ends, margin);
        pairs.retain(|&pair| is_wanted(pair));
        self.fit_step(&pairs, &ends, progress)?;
        let sides = self.sides_of_step(&pairs, &ends);

        // All particles at both ends of the step.
        let at_rest = vec![None; ends.len()];
        let x = parallel::map(2, |end| self.particles_at([&at_rest, &ends][end]));
        let mut motion = MovingPoints::new(&x[0], &x[1])?;
        if !near.deviations.is_empty() {
            motion = motion.with_deviations(&near.deviations)?;
        }

        // Pairs in any thread; reports in the order of the pairs.
        let steps = progress.steps(pairs.len());
        let cost = |pair: &PairId| self.faces_in_common_box(*pair);
        let swept =
            parallel::map_costly_first(&pairs, cost, Workspace::default, |workspace, &pair| {
                let [Some(a), Some(b)] = pair.bodies().map(|id| sides[id.index()]) else {
                    return Ok(SweptContacts::default());
                };
                let margin = params.min_separation + near.of_pair(pair);
                let query = SweptQuery::new(&motion, params).with_margin(margin);
                let found = query.run(&a, &b, workspace, progress)?;
                steps.advance(1)?;
                Ok::<_, SweptError>(found)
            });

        // The earliest contact of any pair ends the free share of the step.
        let mut report = SweepReport { pairs: Vec::new(), largest_free_step: 1.0, candidates: 0 };
        for (&pair, found) in pairs.iter().zip(swept) {
            let SweptContacts { contacts, candidates } = found?;
            report.add(PairSweep { pair, contacts }, candidates);
        }
        Ok(report)
    }

    /// Returns the end positions of each body, by its number; `None` where it rests.
    fn check_moves<'a>(
        &self,
        moves: &[BodyMove<'a>],
    ) -> Result<Vec<Option<Positions<'a>>>, SceneError> {
        let checked = parallel::map(moves.len(), |number| {
            let BodyMove { body, positions } = moves[number];
            self.get(body)?.check_positions(positions)
        });
        let mut ends = vec![None; self.bodies.len()];
        for (BodyMove { body, .. }, checked) in moves.iter().zip(checked) {
            ends[body.index()] = Some(checked?);
        }
        Ok(ends)
    }

    /// Returns the positions of all particles at an end of a step, by those of the bodies that move.
    fn particles_at(&self, end: &[Option<Positions<'_>>]) -> Vec<DVec3> {
        let mut positions = Vec::with_capacity(self.particle_count());
        for (body, x) in self.bodies.iter().zip(end) {
            positions.extend_from_slice(x.map_or(body.positions(), Positions::as_slice));
        }
        positions
    }

    /// Finds the pairs of bodies whose boxes over the step come within `margin` of each other.
    fn candidates_of_step(&mut self, ends: &[Option<Positions<'_>>], margin: f64) -> Vec<PairId> {
        let at_start = self.boxes();
        let boxes = parallel::map(ends.len(), |number| {
            let at_end = ends[number].map_or(&[][..], Positions::as_slice);
            at_start[number].union(Aabb::of_points(at_end.iter().copied()))
        });
        self.candidate_pairs(&boxes, margin)
    }

    /// Brings the bounds over the step of bodies that are in one of the pairs up to date. For
    /// those at rest, these are the bounds of their state.
    fn fit_step(
        &mut self,
        pairs: &[PairId],
        ends: &[Option<Positions<'_>>],
        progress: Progress<'_>,
    ) -> Result<(), SceneError> {
        let (is_member, progress) = (self.members(pairs), progress.part(0.0, 0.0));
        parallel::try_for_each_mut(&mut self.bodies, |number, body| match ends[number] {
            _ if !is_member[number] => Ok(()),
            Some(end) => body.fit_step(end, progress),
            None => body.fit_with(progress),
        })
    }

    /// Returns the bodies in one of the pairs with their bounds over the step, by number.
    fn sides_of_step(
        &self,
        pairs: &[PairId],
        ends: &[Option<Positions<'_>>],
    ) -> Vec<Option<SweptSide<'_>>> {
        let is_member = self.members(pairs);
        let mut sides = Vec::with_capacity(self.bodies.len());
        for ((body, end), is_member) in self.bodies.iter().zip(ends).zip(is_member) {
            let side = if is_member { body.swept_side(end.is_some()) } else { None };
            sides.push(side);
        }
        sides
    }
}

impl SweepReport {
    pub(crate) fn add(&mut self, pair: PairSweep, candidates: usize) {
        self.candidates += candidates;
        if let Some(time) = pair.first_time() {
            self.largest_free_step = self.largest_free_step.min(time);
        }
        if !pair.contacts.is_empty() {
            self.pairs.push(pair);
        }
    }
}

impl PairSweep {
    /// Returns the earliest time of a contact.
    #[must_use]
    pub fn first_time(&self) -> Option<f64> {
        self.contacts.first().and_then(|first| first.contact.time)
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;

    use super::*;
    use crate::BodyKind;

    #[test]
    fn bodies_that_meet_off_their_lines_are_found() {
        let mut scene = Scene::new();
        let mut ends = Vec::new();
        for (name, x) in [("a", 0.0), ("b", 2.0)] {
            let cube = shapes::cube(1.0).translated(DVec3::X * x);
            let surface = cube.surface();
            let body = scene.add(name, BodyKind::Deformable, surface, cube.positions.clone());
            let positions: Vec<DVec3> =
                cube.positions.iter().map(|x| *x + 0.1 * DVec3::Y).collect();
            ends.push((body.expect("a cube"), positions));
        }
        let moves: Vec<_> =
            ends.iter().map(|(body, positions)| BodyMove { body: *body, positions }).collect();
        for (deviation, meets) in [(0.4, false), (0.6, true)] {
            let near =
                NearLines { deviations: vec![deviation; 16], max_of_bodies: vec![deviation; 2] };
            let params = CcdParams::DEFAULT;
            let report = scene.sweep_near_lines(&moves, &params, &near, |_| true, Progress::none());
            assert_eq!(report.expect("a sweep").largest_free_step < 1.0, meets, "{deviation}");
        }
    }
}
