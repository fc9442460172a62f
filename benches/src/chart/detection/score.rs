//! Errors of answers beside the exact ones.

use std::collections::{BTreeMap, BTreeSet};

use super::task::{Direction, FrameTruth, TRUTH_MARGIN};
use crate::measure::as_f64;

/// Answer of a method in one frame.
#[derive(Clone, Debug)]
pub(super) enum Answer {
    /// Vertices inside with their depths \[mm\], per direction that the method detects.
    Vertices(Vec<(Direction, Vec<(u32, f64)>)>),
    /// Faces that cross, per pair.
    Crossings(Vec<([usize; 2], Vec<[u32; 2]>)>),
    /// Pairs that overlap.
    Overlaps(BTreeSet<[usize; 2]>),
}

/// Errors over some frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Score {
    /// Maximum error of a depth \[mm\].
    max: f64,
    squares: f64,
    depths: usize,
    expected: usize,
    found: usize,
    invented: usize,
}

impl Score {
    /// Adds the answer in a frame.
    pub(super) fn add(&mut self, truth: &FrameTruth, answer: &Answer) {
        match answer {
            Answer::Vertices(directions) => {
                for (direction, depths) in directions {
                    let gaps = truth.gaps.get(direction).cloned().unwrap_or_default();
                    self.add_depths(&gaps, &depths.iter().copied().collect());
                }
            }
            Answer::Crossings(pairs) => {
                for (pair, crossings) in pairs {
                    let expected = truth.crossings.get(pair).cloned().unwrap_or_default();
                    self.count(&expected, &crossings.iter().copied().collect());
                }
            }
            Answer::Overlaps(pairs) => self.count(&truth.overlaps, pairs),
        }
    }

    /// Returns the maximum error of a depth \[mm\]; `None` without depths.
    #[must_use]
    pub(super) fn max(&self) -> Option<f64> {
        (self.depths > 0).then_some(self.max)
    }

    /// Returns the root of the mean squared error of depths \[mm\]; `None` without depths.
    #[must_use]
    pub(super) fn rms(&self) -> Option<f64> {
        (self.depths > 0).then(|| (self.squares / as_f64(self.depths)).sqrt())
    }

    /// Returns the share of the true vertices, crossings or overlaps that was not found.
    #[must_use]
    pub(super) fn missed(&self) -> f64 {
        as_f64(self.expected - self.found) / as_f64(self.expected.max(1))
    }

    /// Returns the number of false vertices, crossings or overlaps over that of true ones.
    #[must_use]
    pub(super) fn invented(&self) -> f64 {
        as_f64(self.invented) / as_f64(self.expected.max(1))
    }

    /// Adds every vertex that is inside or reported to be.
    fn add_depths(&mut self, gaps: &BTreeMap<u32, f64>, reported: &BTreeMap<u32, f64>) {
        let inside: BTreeSet<u32> =
            gaps.iter().filter(|(_, gap)| **gap < 0.0).map(|(vertex, _)| *vertex).collect();
        let reported_inside: BTreeSet<u32> = reported.keys().copied().collect();

        // A vertex that is not reported has depth 0, and one far outside the gap of the margin.
        for vertex in inside.union(&reported_inside) {
            let depth = reported.get(vertex).copied().unwrap_or(0.0);
            let exact = -gaps.get(vertex).copied().unwrap_or(TRUTH_MARGIN);
            let error = (depth - exact).abs();
            self.max = self.max.max(error);
            self.squares += error * error;
            self.depths += 1;
        }
        self.count(&inside, &reported_inside);
    }

    fn count<T: Ord>(&mut self, expected: &BTreeSet<T>, reported: &BTreeSet<T>) {
        let found = expected.intersection(reported).count();
        self.expected += expected.len();
        self.found += found;
        self.invented += reported.len() - found;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three vertices inside, one is reported 0.3 too deep and one not at all; one that is 0.2
    /// outside is reported 0.1 deep.
    #[test]
    fn errors_misses_and_inventions_are_counted() {
        let mut truth = FrameTruth::default();
        let gaps = [(1, -1.0), (2, -0.5), (3, -2.0), (4, 0.2)];
        let direction = Direction { vertices: 0, against: 1 };
        truth.gaps.insert(direction, gaps.into_iter().collect());
        let mut score = Score::default();
        let depths = vec![(1, 1.3), (3, 2.0), (4, 0.1)];
        score.add(&truth, &Answer::Vertices(vec![(direction, depths)]));

        assert!((score.max().unwrap() - 0.5).abs() < 1e-12);
        let squares: f64 = 0.3 * 0.3 + 0.5 * 0.5 + 0.3 * 0.3;
        assert!((score.rms().unwrap() - (squares / 4.0).sqrt()).abs() < 1e-12);
        assert!((score.missed() - 1.0 / 3.0).abs() < 1e-12);
        assert!((score.invented() - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn answers_without_depth_are_only_counted() {
        let overlaps = [[0, 1], [0, 2]].into_iter().collect();
        let truth = FrameTruth { overlaps, ..FrameTruth::default() };
        let mut score = Score::default();
        score.add(&truth, &Answer::Overlaps([[0, 1], [0, 3]].into_iter().collect()));
        assert_eq!((score.max(), score.rms()), (None, None));
        assert_eq!((score.missed(), score.invented()), (0.5, 0.5));
    }
}
