//! Swept detection between two rigid bodies, in the frame of the second one.
//!
//! The second body rests there, and the first one moves on the composed motion of both
//! ([`RelativePath`]). Both trees are those of the bodies at rest: none is built or refit on the way.
//!
//! The step is halved until faces that may meet stay near the chords of their ways. Faces far from
//! the other body need not, so that a bone is divided by what its joint moves, and not by what its
//! far end does.

use ccd::{CcdParams, MovingPoints, chord_deviation};
use glam::DVec3;
use kdop::{RigidSweep, Workspace};
use proximity::{SweptContact, SweptContacts, SweptQuery, SweptSide};
use surface::progress::Progress;
use surface::{RelativePath, Stencil, Term};

use crate::{Body, SceneError};

/// Maximum number of pieces. A step that would need more is still detected completely, with more
/// candidates.
pub(crate) const MAX_PIECES: u32 = 1024;

/// Deviation of faces that may meet from their chords, relative to the sum of the edges of both bodies.
///
/// Smaller takes more parts of the step, each with a traversal; larger finds more contacts on chords
/// that are none.
const DEVIATION: f64 = 0.04;

/// Maximum number of edges that are measured for a typical one.
const MEASURED_EDGES: usize = 512;

/// Two rigid bodies on their paths.
pub(crate) struct RigidPair<'a> {
    pub(crate) bodies: [&'a Body; 2],
    pub(crate) relative: RelativePath,
    /// Bound of the distance of both bodies from their rigid motions, with rounding.
    pub(crate) rounding: f64,
}

/// First contacts on chords of a part of the step.
pub(crate) struct PieceContacts {
    /// Start and end of the part.
    pub(crate) interval: [f64; 2],
    /// Contacts, with the particles of the scene.
    pub(crate) contacts: Vec<SweptContact>,
    /// Pairs of primitives that were queried.
    pub(crate) candidates: usize,
}

impl RigidPair<'_> {
    /// Calls `visit` with the contacts of one part of the step after the other, until it returns
    /// false.
    pub(crate) fn for_each_piece(
        &self,
        params: &CcdParams,
        workspace: &mut Workspace,
        progress: Progress<'_>,
        mut visit: impl FnMut(PieceContacts) -> Result<bool, SceneError>,
    ) -> Result<(), SceneError> {
        let [Some(a), Some(b)] = self.bodies.map(|body| body.swept_side(false)) else {
            return Ok(());
        };
        let sides = [SweptSide { first_particle: 0, ..a }, self.after_first(b)];
        let allowed = DEVIATION * self.bodies.iter().map(|body| typical_edge(body)).sum::<f64>();
        let radius = self.radius();

        // The particles of both bodies, in the frame of the second one, at both ends of a part.
        let x = [self.bodies[0].positions(), self.bodies[1].positions()].concat();
        let mut ends = [x.clone(), x];

        // Parts of the step that are left, the earliest last.
        let mut left = vec![[0.0, 1.0]];
        while let Some(interval) = left.pop() {
            let [from, to] = interval;
            if from > params.t_max {
                break;
            }
            let sweep = self.sweep(interval, params);
            let largest = sweep.deviation + sweep.deviation_per_length * radius;
            let is_last = (to - from) * f64::from(MAX_PIECES) <= 1.0;
            let deviation = if is_last { largest } else { largest.min(allowed) };
            let max_deviation = if deviation < largest { deviation } else { f64::INFINITY };

            // Where faces that may meet leave their chords, two halves are to follow.
            let near =
                a.tree.start().moving_pairs(&sweep, b.tree.start(), max_deviation, workspace);
            let Some(near) = near else {
                let middle = f64::midpoint(from, to);
                left.extend([[middle, to], [from, middle]]);
                continue;
            };
            progress.report(to)?;
            if near.is_empty() {
                continue;
            }

            let of_piece =
                CcdParams { min_separation: sweep.margin + deviation, t_max: 1.0, ..*params };
            self.place(&sweep, &mut ends);
            let motion = MovingPoints::new(&ends[0], &ends[1])?;
            let query = SweptQuery::new(&motion, &of_piece);
            let SweptContacts { mut contacts, candidates } =
                query.run_rigid(&sides[0], &sides[1], near, progress)?;
            for contact in &mut contacts {
                self.renumber(contact);
            }
            if !visit(PieceContacts { interval, contacts, candidates })? {
                break;
            }
        }
        Ok(())
    }

    /// Places the particles of the first body at both ends of a part of the step.
    fn place(&self, sweep: &RigidSweep, ends: &mut [Vec<DVec3>; 2]) {
        for (map, end) in sweep.ends.iter().zip(ends) {
            for (to, &x) in end.iter_mut().zip(self.bodies[0].positions()) {
                *to = map.transform_point3(x);
            }
        }
    }

    /// Returns the largest distance of the first body from the center of the motion.
    fn radius(&self) -> f64 {
        let center = self.relative.center();
        let mut squared = 0.0_f64;
        for x in self.bodies[0].positions() {
            squared = squared.max(x.distance_squared(center));
        }
        squared.sqrt() * (1.0 + 8.0 * f64::EPSILON)
    }

    /// Bounds the motion during a part of the step.
    fn sweep(&self, interval: [f64; 2], params: &CcdParams) -> RigidSweep {
        let piece = interval[1] - interval[0];
        RigidSweep {
            ends: interval.map(|time| self.relative.map(time)),
            center: self.relative.center(),
            deviation: chord_deviation(self.relative.bend_at_center(), piece),
            deviation_per_length: chord_deviation(self.relative.bend_per_length(), piece),
            margin: params.min_separation + self.rounding,
        }
    }

    /// Numbers the particles of a contact as the scene does.
    fn renumber(&self, contact: &mut SweptContact) {
        let [a, b] = self.bodies.map(|body| body.particles().start);
        let first_of_b = self.count_of_first();
        let terms = contact.contact.stencil.terms();
        let numbered: [Term; 4] = std::array::from_fn(|k| {
            let Term { particle, weight } = terms[k];
            let is_first = particle < first_of_b;
            let particle = if is_first { a + particle } else { b + (particle - first_of_b) };
            Term { particle, weight }
        });
        contact.contact.stencil = Stencil::from_terms(numbered);
    }

    /// Numbers the particles of the second body after those of the first.
    fn after_first<'b>(&self, side: SweptSide<'b>) -> SweptSide<'b> {
        SweptSide { first_particle: self.count_of_first(), ..side }
    }

    fn count_of_first(&self) -> u32 {
        let particles = self.bodies[0].particles();
        particles.end - particles.start
    }
}

/// Returns the mean length of some edges of a body.
fn typical_edge(body: &Body) -> f64 {
    let (edges, x) = (body.surface().edges(), body.positions());
    let stride = edges.len().div_ceil(MEASURED_EDGES).max(1);
    let (mut sum, mut count) = (0.0, 0.0);
    for [from, to] in edges.iter().step_by(stride) {
        sum += x[*from as usize].distance(x[*to as usize]);
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}
