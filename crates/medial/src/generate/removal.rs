//! Greedy ball removal, ordered by the increase in fitting error.
//!
//! The quadrics of the [collapse](super::collapse) only hold the planes that a ball should touch.
//! Once more balls than requested have been fitted, the samples of the fit give the error itself:
//! its increase where a neighbor takes the place of a ball. With care, that neighbor is moved to
//! [its best place](super::replacement), for the balls with the smallest increase if it stays where
//! it is. Balls of which no two are neighbors are removed at once; then the others are fitted again.

use std::collections::BTreeSet;

use surface::TotalF64;
use surface::progress::Progress;

use super::connectivity::merged;
use super::replacement::Replacement;
use super::sample_map::FittedSurface;
use crate::batches::map_in_batches;
use crate::distance::PreparedSlab;
use crate::{Ball, MedialError, MedialSurface, index};

/// Number of candidates per removal for which the best place of a neighbor is computed.
///
/// Fewer lose better ones; more take longer.
const CANDIDATES_PER_REMOVAL: usize = 5;

/// Interval of the samples by which removals are compared.
const SAMPLE_INTERVAL: usize = 2;

/// Number of balls per batch: some milliseconds.
const BALLS_PER_BATCH: usize = 2;

/// Removals of balls from a fitted medial surface.
pub(super) struct Removals<'a> {
    pub(super) fitted: &'a FittedSurface<'a>,
    /// True if neighbors are moved to their best places; otherwise they stay where they are.
    pub(super) is_careful: bool,
}

/// Removal of a ball, whose neighbor takes its place.
#[derive(Clone, Copy, Debug)]
struct Removal {
    /// Increase of the squares of the errors.
    cost: f64,
    ball: u32,
    /// The neighbor.
    into: u32,
    /// New place of the neighbor.
    place: Ball,
}

/// Sample whose foot is at a ball.
struct AffectedSample {
    sample: u32,
    /// Its distance from the primitives around the ball that stay; infinite without one.
    staying: f64,
}

impl Removals<'_> {
    /// Returns the medial surface without up to `count` of its balls; `None` if none can be removed.
    pub(super) fn apply(
        &self,
        count: usize,
        progress: Progress<'_>,
    ) -> Result<Option<MedialSurface>, MedialError> {
        let medial = self.fitted.medial;
        let mut balls = medial.balls().to_vec();
        let mut into: Vec<u32> = (0..index(balls.len())).collect();
        let mut is_touched = vec![false; balls.len()];
        let mut removed = 0;
        for removal in self.find(count, progress)? {
            let around = self.fitted.balls_around(removal.ball);
            if removed == count || around.iter().any(|&ball| is_touched[ball as usize]) {
                continue;
            }

            // The neighbor takes its place; no ball around is removed in this round.
            for ball in around {
                is_touched[ball as usize] = true;
            }
            into[removal.ball as usize] = removal.into;
            balls[removal.into as usize] = removal.place;
            removed += 1;
        }
        if removed == 0 { Ok(None) } else { merged(&balls, medial.primitives(), &into).map(Some) }
    }

    /// Finds removals, those with the smallest increase of the error first.
    fn find(&self, count: usize, progress: Progress<'_>) -> Result<Vec<Removal>, MedialError> {
        // By neighbors that stay where they are.
        let balls = self.fitted.medial.balls().len();
        let assess = |(): &mut (), ball: usize| self.assess(index(ball));
        let found = map_in_batches(balls, BALLS_PER_BATCH, progress, <()>::default, assess)?;
        let mut removals: Vec<Removal> = found.into_iter().flatten().collect();
        sort_by_cost(&mut removals);

        // The best of these by neighbors that move.
        if self.is_careful {
            removals.truncate(CANDIDATES_PER_REMOVAL * count);
            let assess = |(): &mut (), k: usize| self.assess_carefully(removals[k].ball);
            let found =
                map_in_batches(removals.len(), BALLS_PER_BATCH, progress, <()>::default, assess)?;
            removals = found.into_iter().flatten().collect();
            sort_by_cost(&mut removals);
        }
        Ok(removals)
    }

    /// Finds the neighbor that increases the error least in the place of a ball, where it stays.
    fn assess(&self, ball: u32) -> Option<Removal> {
        let samples = self.affected_samples(ball);
        let mut best: Option<Removal> = None;
        for into in self.fitted.mergeable_neighbors(ball) {
            let limit = best.map_or(f64::INFINITY, |best| best.cost);
            let cost = self.cost(&self.replaced(ball, into), &samples, limit);
            if cost < limit {
                let place = self.fitted.medial.balls()[into as usize];
                best = Some(Removal { cost, ball, into, place });
            }
        }
        best
    }

    /// Finds the neighbor that increases the error least in the place of a ball, at its best place.
    fn assess_carefully(&self, ball: u32) -> Option<Removal> {
        let removals = self.fitted.mergeable_neighbors(ball).map(|into| {
            let placed = Replacement::new(self.fitted, ball, into).fit();
            Removal { cost: placed.cost, ball, into, place: placed.ball }
        });
        removals.min_by_key(|removal| TotalF64(removal.cost))
    }

    /// Returns the samples whose foot is at a ball.
    fn affected_samples(&self, ball: u32) -> Vec<AffectedSample> {
        let FittedSurface { at_ball, samples, .. } = self.fitted;
        let of_ball = &at_ball[ball as usize];
        let mut staying = BTreeSet::new();
        for other in self.fitted.balls_around(ball) {
            staying.extend(&at_ball[other as usize]);
        }
        staying.retain(|primitive| !of_ball.contains(primitive));

        // A part of the samples is sufficient to compare removals.
        let all = of_ball.iter().flat_map(|&primitive| &samples[primitive as usize]);
        let affected = |&sample: &u32| AffectedSample {
            sample,
            staying: self.fitted.distance(sample, &staying),
        };
        all.step_by(SAMPLE_INTERVAL).map(affected).collect()
    }

    /// Returns the primitives at a ball with a neighbor in its place; those of both vanish.
    fn replaced(&self, ball: u32, into: u32) -> Vec<PreparedSlab> {
        let medial = self.fitted.medial;
        let mut replaced = Vec::new();
        for &primitive in &self.fitted.at_ball[ball as usize] {
            let balls = medial.primitives()[primitive as usize];
            if !balls.contains(&into) {
                let at = |b: u32| medial.balls()[if b == ball { into } else { b } as usize];
                replaced.push(PreparedSlab::new(balls.map(at)));
            }
        }
        replaced
    }

    /// Computes the increase of the samples' squares with `replaced` primitives beside those that
    /// stay; some value of at least `limit` where it reaches that.
    fn cost(&self, replaced: &[PreparedSlab], samples: &[AffectedSample], limit: f64) -> f64 {
        let FittedSurface { tracking, importance, feet, .. } = self.fitted;
        let before = |&AffectedSample { sample, .. }: &AffectedSample| {
            importance[sample as usize] * feet[sample as usize].foot.distance.powi(2)
        };

        // The sum rises from here, and is complete where it stays below the limit.
        let mut cost = -samples.iter().map(before).sum::<f64>();
        for &AffectedSample { sample, staying } in samples {
            let p = tracking.points()[sample as usize];
            let mut distance = staying;
            for slab in replaced {
                distance = distance.min(slab.foot(p).distance);
            }
            cost += importance[sample as usize] * distance.powi(2);
            if cost >= limit {
                break;
            }
        }
        cost
    }
}

fn sort_by_cost(removals: &mut [Removal]) {
    removals.sort_by_key(|removal| (TotalF64(removal.cost), removal.ball));
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::tracking::Tracking;
    use super::*;

    /// Returns `medial` without one ball, fitted to samples `above` its balls.
    fn thinned(medial: &MedialSurface, above: &[DVec3], is_careful: bool) -> Option<MedialSurface> {
        let mut tracking = Tracking::new(medial, above.to_vec(), Progress::none()).unwrap();
        let step = vec![0.0; medial.balls().len()];
        let feet = tracking.feet(medial, &step, Progress::none()).unwrap();
        let importance = vec![1.0; above.len()];
        let fitted = FittedSurface::new(medial, &tracking, &importance, &feet);
        Removals { fitted: &fitted, is_careful }.apply(1, Progress::none()).unwrap()
    }

    #[test]
    fn a_ball_between_others_on_a_line_is_removed() {
        // On a line, all but the fourth; the ends are needed.
        let heights = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        let at = |(x, z): (f64, f64)| DVec3::new(4.0 * x, 0.0, z);
        let centers: Vec<DVec3> = (0..6_u32).map(f64::from).zip(heights).map(at).collect();
        let balls = centers.iter().map(|&center| Ball::new(center, 1.0)).collect();
        let cones = (0..5).map(|k| [k, k + 1]).collect();
        let medial = MedialSurface::new(balls, cones, vec![]).unwrap();
        let mut above: Vec<DVec3> = centers.iter().map(|center| center + DVec3::Z).collect();
        above.extend(centers.windows(2).map(|pair| pair[0].midpoint(pair[1]) + DVec3::Z));
        above.extend([centers[0] - DVec3::X, centers[5] + DVec3::X]);

        // Each sample twice, so that every second one is all of them.
        let twice: Vec<DVec3> = above.iter().flat_map(|&p| [p, p]).collect();
        let left = thinned(&medial, &twice, false).unwrap();
        let kept: Vec<DVec3> = left.balls().iter().map(|ball| ball.center).collect();
        assert!(kept == [&centers[..1], &centers[2..]].concat(), "{kept:?}");
        assert_eq!(left.cones().len(), 4);
    }

    /// Two cones that are thick where they meet, given as three: of the two balls beside the thickest
    /// place, either is removed, and the other moves to it.
    #[test]
    fn a_neighbor_moves_to_its_best_place() {
        let on_axis = |x: f64| Ball::new(DVec3::X * x, 2.0 - (x - 12.0).abs() / 12.0);
        let balls = [0.0, 10.0, 14.0, 24.0].map(on_axis).to_vec();
        let medial = MedialSurface::new(balls, vec![[0, 1], [1, 2], [2, 3]], vec![]).unwrap();
        let slope = 1.0 / 12.0_f64;
        let on_cone = |x: f64, angle: f64| {
            let outward = (1.0 - slope * slope).sqrt() * DVec3::new(0.0, angle.cos(), angle.sin());
            let back = -slope * (12.0 - x).signum() * DVec3::X;
            on_axis(x).center + on_axis(x).radius * (back + outward)
        };
        let around = |x| (0..6_u32).map(move |k| on_cone(x, f64::from(k)));
        let above: Vec<DVec3> =
            (0..48_u32).flat_map(|k| around(f64::from(k) / 2.0 + 0.25)).collect();
        let left = thinned(&medial, &above, true).unwrap();
        let [.., middle, _] = left.balls() else { panic!("three balls") };
        assert_eq!(left.balls().len(), 3);
        assert!(middle.center.distance(12.0 * DVec3::X) < 0.1, "{middle:?}");
        assert!((middle.radius - 2.0).abs() < 0.05, "{middle:?}");
    }

    #[test]
    fn a_hole_is_not_closed() {
        let corners = [DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0, DVec3::new(9.0, 9.0, 0.0)];
        let balls = corners.map(|center| Ball::new(center, 1.0)).to_vec();
        let ring = vec![[0, 1], [1, 2], [0, 2]];
        let hollow = MedialSurface::new(balls[..3].to_vec(), ring, vec![]).unwrap();
        let above = corners.map(|center| center + DVec3::Z);
        assert_eq!(thinned(&hollow, &above, false), None);
        let filled = MedialSurface::new(balls, vec![], vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        assert_eq!(thinned(&filled, &above, false).unwrap().slabs().len(), 1);
    }
}
