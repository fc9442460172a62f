//! The largest value of a function, by branch and bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use surface::DirectedHausdorff;

use crate::MedialSurface;

/// Excess of a bound over what was seen at which splitting ends, relative to
/// the latter.
const SLACK: f64 = 0.05;

/// The same relative to the size of the medial surface, for deviations that
/// are hardly there: a micrometre on a muscle.
const MIN_SLACK: f64 = 1e-5;

/// Pieces looked at before splitting ends anyway: seconds of work.
const MAX_PIECES: usize = 400_000;

/// Something with a bound, the largest first.
struct Piece<T> {
    bound: f64,
    /// Breaks ties, so that the order is fixed.
    number: usize,
    content: T,
}

impl<T> Ord for Piece<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then_with(|| other.number.cmp(&self.number))
    }
}

impl<T> PartialOrd for Piece<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Piece<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T> Eq for Piece<T> {}

/// A search for the largest value over pieces that can be bounded and split.
pub(super) struct Largest<T> {
    pieces: BinaryHeap<Piece<T>>,
    number: usize,
    seen: f64,
    least_slack: f64,
}

impl<T> Largest<T> {
    pub(super) fn new(least_slack: f64) -> Self {
        Self { pieces: BinaryHeap::new(), number: 0, seen: 0.0, least_slack }
    }

    /// What is larger than this is of interest.
    pub(super) fn enough(&self) -> f64 {
        self.seen + self.least_slack.max(SLACK * self.seen)
    }

    /// Adds a piece on which `seen` occurs and nothing above `bound`; its content
    /// is made where that matters.
    pub(super) fn add(&mut self, seen: f64, bound: f64, content: impl FnOnce() -> T) {
        self.seen = self.seen.max(seen);
        if bound > self.enough() {
            self.pieces.push(Piece { bound, number: self.number, content: content() });
            self.number += 1;
        }
    }

    /// Splits what may be largest until the rest hardly matters.
    pub(super) fn run(mut self, mut split: impl FnMut(&mut Self, T)) -> DirectedHausdorff {
        // What `add` leaves out is bounded by what was enough then, which only grows.
        while self.number < MAX_PIECES {
            let Some(top) = self.pieces.pop() else { break };
            if top.bound <= self.enough() {
                break;
            }
            split(&mut self, top.content);
        }
        let rest = self.pieces.peek().map_or(0.0, |piece| piece.bound);
        DirectedHausdorff { lower: self.seen, upper: rest.max(self.enough()) }
    }
}

/// What is as good as no deviation on a medial surface of this size.
pub(super) fn least_slack(medial: &MedialSurface) -> f64 {
    let [low, high] = medial.bounds();
    MIN_SLACK * low.distance(high)
}
