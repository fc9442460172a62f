//! Maps of a fitted medial surface: the primitives of each ball, the samples of each primitive.

use std::collections::BTreeSet;

use super::tracking::Tracking;
use crate::{ExactFeet, MedialSurface, NearestPrimitive, PreparedSlabs};

/// Medial surface with the samples that it was fitted to.
pub(super) struct FittedSurface<'a> {
    pub(super) medial: &'a MedialSurface,
    slabs: PreparedSlabs,
    pub(super) tracking: &'a Tracking,
    /// Importance of the error of each sample.
    pub(super) importance: &'a [f64],
    pub(super) feet: &'a [NearestPrimitive],
    /// Primitives of each ball.
    pub(super) at_ball: Vec<Vec<u32>>,
    /// Samples whose foot is on each primitive.
    pub(super) samples: Vec<Vec<u32>>,
}

impl<'a> FittedSurface<'a> {
    pub(super) fn new(
        medial: &'a MedialSurface,
        tracking: &'a Tracking,
        importance: &'a [f64],
        feet: &'a [NearestPrimitive],
    ) -> Self {
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
        let slabs = PreparedSlabs::new(medial);
        Self { medial, slabs, tracking, importance, feet, at_ball, samples }
    }

    /// Returns a ball and those that share a primitive with it.
    pub(super) fn balls_around(&self, ball: u32) -> BTreeSet<u32> {
        let primitives = self.at_ball[ball as usize].iter();
        primitives.flat_map(|&primitive| self.medial.primitives()[primitive as usize]).collect()
    }

    /// Returns the neighbors that can take the place of a ball.
    pub(super) fn mergeable_neighbors(&self, ball: u32) -> impl Iterator<Item = u32> {
        let around = self.balls_around(ball).into_iter();
        around.filter(move |&other| other != ball && self.keeps_topology(ball, other))
    }

    /// Returns true if two neighbors may merge without a change of the sheet's topology: every ball
    /// beside both is on a slab with both (the link condition).
    fn keeps_topology(&self, a: u32, b: u32) -> bool {
        // Balls of the slabs with both, and of the cone between them.
        let mut with_both = BTreeSet::new();
        for &primitive in &self.at_ball[a as usize] {
            let balls = self.medial.primitives()[primitive as usize];
            if balls.contains(&b) {
                with_both.extend(balls);
            }
        }
        let (of_a, of_b) = (self.balls_around(a), self.balls_around(b));
        of_a.intersection(&of_b).all(|ball| with_both.contains(ball))
    }

    /// Computes the distance of a sample from some of the primitives; infinite, if from none.
    pub(super) fn distance<'p>(
        &self,
        sample: u32,
        primitives: impl IntoIterator<Item = &'p u32>,
    ) -> f64 {
        let p = self.tracking.points()[sample as usize];
        let mut distance = f64::INFINITY;
        for &primitive in primitives {
            distance = distance.min(self.slabs.exact_foot(p, primitive).distance);
        }
        distance
    }
}
