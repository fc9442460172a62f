//! Taking away the balls that are missed the least, by how far the surface is from
//! what is left.
//!
//! The quadrics of the [collapse](super::collapse) only know the planes that a ball
//! should touch. Once more balls than are wanted have been fitted, the samples of the
//! fit tell more: what becomes of the error where a ball's neighbor takes its place.
//! With care, it is sought [where that neighbor should go](super::replacement), for the
//! balls that are missed the least if it stays where it is. Balls of which no two are
//! neighbors go at once; then the others are fitted again.

use std::collections::BTreeSet;

use super::collapse::joints;
use super::replacement::Replacement;
use super::tracking::Tracking;
use crate::{Ball, FootRule, MedialError, MedialSurface, NearestPrimitive, foot, index, parallel};

/// A medial surface, and the samples it was fitted to.
pub(super) struct Thinning<'a> {
    pub(super) medial: &'a MedialSurface,
    pub(super) tracking: &'a Tracking,
    /// What each sample's error counts for.
    pub(super) importance: &'a [f64],
    pub(super) feet: &'a [NearestPrimitive],
    /// Whether it is sought where neighbors should go, or they stay where they are.
    pub(super) careful: bool,
}

/// A ball, the neighbor that may take its place, where that one goes, and the squares
/// of the errors that this adds.
#[derive(Clone, Copy, Debug)]
struct Removal {
    cost: f64,
    ball: u32,
    into: u32,
    place: Ball,
}

/// Balls for each that is to go, for which the best place of a neighbor is sought.
const SHORTLIST: usize = 5;

/// Of so many samples, one is looked at.
const LOOKED_AT: usize = 2;

/// What is where on a medial surface.
pub(super) struct Places {
    /// Primitives of each ball.
    pub(super) at_ball: Vec<Vec<u32>>,
    /// Samples whose foot is on each primitive.
    pub(super) samples: Vec<Vec<u32>>,
}

impl Thinning<'_> {
    /// The medial surface without up to `count` of its balls; `None` if none can go.
    pub(super) fn thinned(&self, count: usize) -> Result<Option<MedialSurface>, MedialError> {
        let places = Places::of(self.medial, self.feet);
        let mut left = self.medial.clone();
        let mut into: Vec<u32> = (0..index(left.balls().len())).collect();
        let mut touched = vec![false; into.len()];
        let mut removed = 0;
        for Removal { ball, into: neighbor, place, .. } in self.removals(count, &places) {
            let around = places.around(self.medial, ball);
            if removed < count && around.iter().all(|&b| !touched[b as usize]) {
                around.iter().for_each(|&b| touched[b as usize] = true);
                into[ball as usize] = neighbor;
                left.balls_mut()[neighbor as usize] = place;
                removed += 1;
            }
        }
        if removed == 0 { Ok(None) } else { merged(&left, &into).map(Some) }
    }

    /// Balls that can go, those that are missed the least first.
    fn removals(&self, count: usize, places: &Places) -> Vec<Removal> {
        let balls = 0..index(self.medial.balls().len());
        let mut removals: Vec<Removal> =
            balls.filter_map(|ball| self.removal(ball, places)).collect();
        sort(&mut removals);
        if self.careful {
            removals.truncate(SHORTLIST * count);
            let careful = |(): &mut (), k: usize| self.careful_removal(removals[k].ball, places);
            let found = parallel::map(removals.len(), || (), careful);
            removals = found.into_iter().flatten().collect();
            sort(&mut removals);
        }
        removals
    }

    /// The neighbor that is missed the least in the place of a ball, if one can be
    /// there.
    fn removal(&self, ball: u32, places: &Places) -> Option<Removal> {
        let at_ball = &places.at_ball[ball as usize];
        let seen = self.seen_from(at_ball, &places.around(self.medial, ball), places);
        let mut least: Option<Removal> = None;
        for into in places.replacing(self.medial, ball) {
            let limit = least.map_or(f64::INFINITY, |least| least.cost);
            let cost = self.cost(&self.replaced(at_ball, ball, into), &seen, limit);
            if cost < limit {
                let place = self.medial.balls()[into as usize];
                least = Some(Removal { cost, ball, into, place });
            }
        }
        least
    }

    /// The same, of neighbors that go to where they are missed the least.
    fn careful_removal(&self, ball: u32, places: &Places) -> Option<Removal> {
        let removals = places.replacing(self.medial, ball).map(|into| {
            let placed = Replacement::new(self, places, [ball, into]).fitted();
            Removal { cost: placed.cost, ball, into, place: placed.ball }
        });
        removals.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The samples whose foot is at a ball, with their distance from what is around
    /// it and stays.
    fn seen_from(
        &self,
        at_ball: &[u32],
        around: &BTreeSet<u32>,
        places: &Places,
    ) -> Vec<(u32, f64)> {
        let beside = around.iter().flat_map(|&other| &places.at_ball[other as usize]);
        let staying: BTreeSet<u32> = beside.copied().filter(|p| !at_ball.contains(p)).collect();
        let samples = at_ball.iter().flat_map(|&primitive| &places.samples[primitive as usize]);
        samples.step_by(LOOKED_AT).map(|&s| (s, self.distance(s, &staying))).collect()
    }

    /// The distance of a sample from some of the primitives; infinite, if from none.
    pub(super) fn distance<'p>(
        &self,
        sample: u32,
        primitives: impl IntoIterator<Item = &'p u32>,
    ) -> f64 {
        let p = self.tracking.points()[sample as usize];
        let feet = primitives.into_iter().map(|&q| self.medial.foot(p, q, FootRule::Exact));
        feet.map(|foot| foot.distance).fold(f64::INFINITY, f64::min)
    }

    /// The primitives at a ball with a neighbor in its place; those that had both
    /// are gone.
    fn replaced(&self, at_ball: &[u32], ball: u32, into: u32) -> Vec<[Ball; 3]> {
        let primitives = at_ball.iter().map(|&p| self.medial.primitives()[p as usize]);
        let left = primitives.filter(|balls| !balls.contains(&into));
        let replaced = |b: u32| self.medial.balls()[if b == ball { into } else { b } as usize];
        left.map(|balls| balls.map(replaced)).collect()
    }

    /// What samples' squares gain from `replaced` primitives beside those that stay;
    /// not less than `limit`, where it stops.
    fn cost(&self, replaced: &[[Ball; 3]], seen: &[(u32, f64)], limit: f64) -> f64 {
        let before = |&(sample, _): &(u32, f64)| {
            let sample = sample as usize;
            self.importance[sample] * self.feet[sample].foot.distance.powi(2)
        };
        let mut cost = -seen.iter().map(before).sum::<f64>();
        for &(sample, staying) in seen {
            let p = self.tracking.points()[sample as usize];
            let feet = replaced.iter().map(|balls| foot(p, balls, FootRule::Exact).distance);
            cost += self.importance[sample as usize] * feet.fold(staying, f64::min).powi(2);
            if cost >= limit {
                break;
            }
        }
        cost
    }
}

impl Places {
    fn of(medial: &MedialSurface, feet: &[NearestPrimitive]) -> Self {
        let mut at_ball = vec![Vec::new(); medial.balls().len()];
        for (primitive, balls) in (0_u32..).zip(medial.primitives()) {
            for ball in BTreeSet::from(*balls) {
                at_ball[ball as usize].push(primitive);
            }
        }
        let mut samples = vec![Vec::new(); medial.primitives().len()];
        for (sample, foot) in (0_u32..).zip(feet) {
            samples[foot.primitive as usize].push(sample);
        }
        Self { at_ball, samples }
    }

    /// A ball and those that share a primitive with it.
    fn around(&self, medial: &MedialSurface, ball: u32) -> BTreeSet<u32> {
        let at_ball = self.at_ball[ball as usize].iter();
        at_ball.flat_map(|&primitive| medial.primitives()[primitive as usize]).collect()
    }

    /// The neighbors of a ball that can take its place.
    fn replacing(&self, medial: &MedialSurface, ball: u32) -> impl Iterator<Item = u32> {
        let around = self.around(medial, ball).into_iter();
        around.filter(move |&other| other != ball && self.closes(medial, [ball, other]))
    }

    /// Whether two neighbors may merge without a change of the sheet's topology:
    /// every ball beside both is on a slab with both.
    fn closes(&self, medial: &MedialSurface, [a, b]: [u32; 2]) -> bool {
        let at_a = self.at_ball[a as usize].iter().map(|&p| medial.primitives()[p as usize]);
        let with_both: BTreeSet<u32> = at_a.filter(|balls| balls.contains(&b)).flatten().collect();
        let (of_a, of_b) = (self.around(medial, a), self.around(medial, b));
        of_a.intersection(&of_b).all(|ball| with_both.contains(ball))
    }
}

/// Those that are missed the least first.
fn sort(removals: &mut [Removal]) {
    removals.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.ball.cmp(&b.ball)));
}

/// What is left when every ball is replaced by the one that `into` names.
fn merged(medial: &MedialSurface, into: &[u32]) -> Result<MedialSurface, MedialError> {
    let mut number = vec![u32::MAX; into.len()];
    let mut balls = Vec::with_capacity(into.len());
    for (ball, &kept) in (0_u32..).zip(into) {
        if ball == kept {
            number[ball as usize] = index(balls.len());
            balls.push(medial.balls()[ball as usize]);
        }
    }
    let final_ball: Vec<u32> = into.iter().map(|&kept| number[kept as usize]).collect();
    let (cones, slabs) = joints(medial.primitives(), &final_ball);
    MedialSurface::new(balls, cones, slabs)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// What is left of `medial` without one ball, if samples `above` its balls are what
    /// is to be kept.
    fn thinned(medial: &MedialSurface, above: &[DVec3], careful: bool) -> Option<MedialSurface> {
        let mut tracking = Tracking::new(medial, above.to_vec()).unwrap();
        let feet = tracking.feet(medial, &vec![0.0; medial.balls().len()]).unwrap();
        let importance = vec![1.0; above.len()];
        let thinning =
            Thinning { medial, tracking: &tracking, importance: &importance, feet: &feet, careful };
        thinning.thinned(1).unwrap()
    }

    #[test]
    fn the_ball_that_nothing_misses_goes() {
        // On a line, all but the fourth; the ends are missed when they go.
        let heights = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        let at = |(x, z): (f64, f64)| DVec3::new(4.0 * x, 0.0, z);
        let centers: Vec<DVec3> = (0..6_u32).map(f64::from).zip(heights).map(at).collect();
        let balls = centers.iter().map(|&center| Ball::new(center, 1.0)).collect();
        let cones = (0..5).map(|k| [k, k + 1]).collect();
        let medial = MedialSurface::new(balls, cones, vec![]).unwrap();
        let mut above: Vec<DVec3> = centers.iter().map(|center| center + DVec3::Z).collect();
        above.extend(centers.windows(2).map(|pair| pair[0].midpoint(pair[1]) + DVec3::Z));
        above.extend([centers[0] - DVec3::X, centers[5] + DVec3::X]);
        // All samples are looked at, whichever every second one is.
        let twice: Vec<DVec3> = above.iter().flat_map(|&p| [p, p]).collect();
        let left = thinned(&medial, &twice, false).unwrap();
        let kept: Vec<DVec3> = left.balls().iter().map(|ball| ball.center).collect();
        assert!(kept == [&centers[..1], &centers[2..]].concat(), "{kept:?}");
        assert_eq!(left.cones().len(), 4);
    }

    /// Two cones that are thick where they meet, given as three: of the two balls beside
    /// the thickest one, either goes, and the other moves to it.
    #[test]
    fn a_neighbor_moves_to_where_it_is_missed_the_least() {
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
