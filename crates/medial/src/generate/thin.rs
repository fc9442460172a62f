//! Taking away the balls that are missed the least, by how far the surface is from
//! what is left.
//!
//! The quadrics of the [collapse](super::collapse) only know the planes that a ball
//! should touch. Once more balls than are wanted have been fitted, the samples of the
//! fit tell more: what becomes of the error where a ball's neighbour takes its place.
//! Balls of which no two are neighbours go at once; then the others are fitted again.

use std::collections::BTreeSet;

use glam::DVec3;

use super::collapse::joints;
use crate::{Ball, FootRule, MedialError, MedialSurface, NearestPrimitive, foot, index};

/// A medial surface, and the samples it was fitted to.
pub(super) struct Thinning<'a> {
    pub(super) medial: &'a MedialSurface,
    pub(super) points: &'a [DVec3],
    /// What each sample's error counts for.
    pub(super) importance: &'a [f64],
    pub(super) feet: &'a [NearestPrimitive],
}

/// A ball, the neighbour that may take its place, and the squares of the errors that
/// this adds.
#[derive(Clone, Copy, Debug)]
struct Removal {
    cost: f64,
    ball: u32,
    into: u32,
}

/// Of so many samples, one is looked at.
const LOOKED_AT: usize = 2;

/// What is where on a medial surface.
struct Places {
    /// Primitives of each ball.
    at_ball: Vec<Vec<u32>>,
    /// Samples whose foot is on each primitive.
    samples: Vec<Vec<u32>>,
}

impl Thinning<'_> {
    /// The medial surface without up to `count` of its balls; `None` if none can go.
    pub(super) fn thinned(&self, count: usize) -> Result<Option<MedialSurface>, MedialError> {
        let places = Places::of(self.medial, self.feet);
        let balls = 0..index(self.medial.balls().len());
        let mut removals: Vec<Removal> =
            balls.clone().filter_map(|ball| self.removal(ball, &places)).collect();
        removals.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.ball.cmp(&b.ball)));
        let mut into: Vec<u32> = balls.collect();
        let mut touched = vec![false; into.len()];
        let mut removed = 0;
        for Removal { ball, into: neighbor, .. } in removals {
            let around = places.around(self.medial, ball);
            if removed < count && around.iter().all(|&b| !touched[b as usize]) {
                around.iter().for_each(|&b| touched[b as usize] = true);
                into[ball as usize] = neighbor;
                removed += 1;
            }
        }
        if removed == 0 { Ok(None) } else { self.merged(&into).map(Some) }
    }

    /// What is left when every ball is replaced by the one that `into` names.
    fn merged(&self, into: &[u32]) -> Result<MedialSurface, MedialError> {
        let mut number = vec![u32::MAX; into.len()];
        let mut balls = Vec::with_capacity(into.len());
        for (ball, &kept) in (0_u32..).zip(into) {
            if ball == kept {
                number[ball as usize] = index(balls.len());
                balls.push(self.medial.balls()[ball as usize]);
            }
        }
        let final_ball: Vec<u32> = into.iter().map(|&kept| number[kept as usize]).collect();
        let (cones, slabs) = joints(self.medial.primitives(), &final_ball);
        MedialSurface::new(balls, cones, slabs)
    }

    /// The neighbour that is missed the least in the place of a ball, if one can be
    /// there.
    fn removal(&self, ball: u32, places: &Places) -> Option<Removal> {
        let around = places.around(self.medial, ball);
        let at_ball = &places.at_ball[ball as usize];
        let seen = self.seen_from(at_ball, &around, places);
        let mut least: Option<Removal> = None;
        for &into in around.iter().filter(|&&other| other != ball) {
            if !places.closes(self.medial, [ball, into]) {
                continue;
            }
            let limit = least.map_or(f64::INFINITY, |least| least.cost);
            let cost = self.cost(&self.replaced(at_ball, ball, into), &seen, limit);
            if cost < limit {
                least = Some(Removal { cost, ball, into });
            }
        }
        least
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
        let distance = |sample: u32| {
            let p = self.points[sample as usize];
            let feet = staying.iter().map(|&q| self.medial.foot(p, q, FootRule::Exact).distance);
            feet.fold(f64::INFINITY, f64::min)
        };
        let samples = at_ball.iter().flat_map(|&primitive| &places.samples[primitive as usize]);
        samples.step_by(LOOKED_AT).map(|&sample| (sample, distance(sample))).collect()
    }

    /// The primitives at a ball with a neighbour in its place; those that had both
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
            let p = self.points[sample as usize];
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

    /// Whether two neighbours may merge without a change of the sheet's topology:
    /// every ball beside both is on a slab with both.
    fn closes(&self, medial: &MedialSurface, [a, b]: [u32; 2]) -> bool {
        let at_a = self.at_ball[a as usize].iter().map(|&p| medial.primitives()[p as usize]);
        let with_both: BTreeSet<u32> = at_a.filter(|balls| balls.contains(&b)).flatten().collect();
        let (of_a, of_b) = (self.around(medial, a), self.around(medial, b));
        of_a.intersection(&of_b).all(|ball| with_both.contains(ball))
    }
}

#[cfg(test)]
mod tests {
    use kdop::Workspace;

    use super::*;
    use crate::PrimitiveTree;

    /// What is left of `medial` without one ball, if samples `above` its balls are what
    /// is to be kept.
    fn thinned(medial: &MedialSurface, above: &[DVec3]) -> Option<MedialSurface> {
        let tree = PrimitiveTree::new(medial).unwrap();
        let workspace = &mut Workspace::default();
        let feet: Vec<_> = above.iter().map(|&p| tree.nearest(medial, p, workspace)).collect();
        let importance = vec![1.0; above.len()];
        Thinning { medial, points: above, importance: &importance, feet: &feet }.thinned(1).unwrap()
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
        let left = thinned(&medial, &twice).unwrap();
        let kept: Vec<DVec3> = left.balls().iter().map(|ball| ball.center).collect();
        assert!(kept == [&centers[..1], &centers[2..]].concat(), "{kept:?}");
        assert_eq!(left.cones().len(), 4);
    }

    #[test]
    fn a_hole_is_not_closed() {
        let corners = [DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0, DVec3::new(9.0, 9.0, 0.0)];
        let balls = corners.map(|center| Ball::new(center, 1.0)).to_vec();
        let ring = vec![[0, 1], [1, 2], [0, 2]];
        let hollow = MedialSurface::new(balls[..3].to_vec(), ring, vec![]).unwrap();
        let above = corners.map(|center| center + DVec3::Z);
        assert_eq!(thinned(&hollow, &above), None);
        let filled = MedialSurface::new(balls, vec![], vec![[0, 1, 2], [1, 2, 3]]).unwrap();
        assert_eq!(thinned(&filled, &above).unwrap().slabs().len(), 1);
    }
}
