//! Errors of answers beside the exact ones.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::task::{Direction, FrameTruth, TRUTH_MARGIN};
use crate::measure::as_f64;

/// Answer of a method in one frame.
#[derive(Clone, Debug)]
pub(super) enum Answer {
    /// Vertices inside with their depths \[mm\], per direction that the method detects.
    Vertices(Vec<(Direction, Vec<(u32, f64)>)>),
    /// Depths of the surfaces of pairs that overlap \[mm\].
    Depths(BTreeMap<[usize; 2], f64>),
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

/// Errors of a method, columns of its table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Errors {
    /// Maximum error of a depth; `None` without depths.
    #[serde(rename = "max error [mm]")]
    pub(super) max: Option<f64>,
    /// Root of the mean squared error of depths; `None` without depths.
    #[serde(rename = "rms error [mm]")]
    pub(super) rms: Option<f64>,
    /// Share of the true vertices, crossings or overlaps that was not found.
    #[serde(rename = "missed [share]")]
    pub(super) missed: f64,
    /// Number of false vertices, crossings or overlaps over that of true ones.
    #[serde(rename = "invented [share]")]
    pub(super) invented: f64,
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
            Answer::Depths(depths) => self.add_pair_depths(truth, depths),
            Answer::Crossings(pairs) => {
                for (pair, crossings) in pairs {
                    let expected = truth.crossings.get(pair).cloned().unwrap_or_default();
                    self.count(&expected, &crossings.iter().copied().collect());
                }
            }
            Answer::Overlaps(pairs) => self.count(&truth.overlaps, pairs),
        }
    }

    /// Returns the errors over all answers.
    #[must_use]
    pub(super) fn errors(&self) -> Errors {
        let has_depths = self.depths > 0;
        let expected = as_f64(self.expected.max(1));
        Errors {
            max: has_depths.then_some(self.max),
            rms: has_depths.then(|| (self.squares / as_f64(self.depths)).sqrt()),
            missed: as_f64(self.expected - self.found) / expected,
            invented: as_f64(self.invented) / expected,
        }
    }

    /// Adds every vertex that is inside or reported to be.
    fn add_depths(&mut self, gaps: &BTreeMap<u32, f64>, reported: &BTreeMap<u32, f64>) {
        let mut inside = BTreeSet::new();
        for (vertex, gap) in gaps {
            if *gap < 0.0 {
                inside.insert(*vertex);
            }
        }
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

    /// Adds every pair that overlaps or is reported to; one that is not has depth 0.
    fn add_pair_depths(&mut self, truth: &FrameTruth, reported: &BTreeMap<[usize; 2], f64>) {
        let pairs: BTreeSet<[usize; 2]> = reported.keys().copied().collect();
        for pair in truth.overlaps.union(&pairs) {
            let [depth, exact] =
                [reported, &truth.depths].map(|depths| depths.get(pair).copied().unwrap_or(0.0));
            let error = (depth - exact).abs();
            self.max = self.max.max(error);
            self.squares += error * error;
            self.depths += 1;
        }
        self.count(&truth.overlaps, &pairs);
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

        let errors = score.errors();
        assert!((errors.max.unwrap() - 0.5).abs() < 1e-12);
        let squares: f64 = 0.3 * 0.3 + 0.5 * 0.5 + 0.3 * 0.3;
        assert!((errors.rms.unwrap() - (squares / 4.0).sqrt()).abs() < 1e-12);
        assert!((errors.missed - 1.0 / 3.0).abs() < 1e-12);
        assert!((errors.invented - 1.0 / 3.0).abs() < 1e-12);
    }

    /// Of two pairs that overlap, one is reported 0.1 too deep and one not at all.
    #[test]
    fn depths_of_pairs_are_compared() {
        let truth = FrameTruth {
            overlaps: [[0, 1], [0, 2]].into_iter().collect(),
            depths: [([0, 1], 1.0), ([0, 2], 0.3)].into_iter().collect(),
            ..FrameTruth::default()
        };
        let mut score = Score::default();
        score.add(&truth, &Answer::Depths([([0, 1], 1.1)].into_iter().collect()));
        let errors = score.errors();
        assert!((errors.max.unwrap() - 0.3).abs() < 1e-12);
        assert!((errors.missed - 0.5).abs() < 1e-12 && errors.invented == 0.0);
    }

    #[test]
    fn answers_without_depth_are_only_counted() {
        let overlaps = [[0, 1], [0, 2]].into_iter().collect();
        let truth = FrameTruth { overlaps, ..FrameTruth::default() };
        let mut score = Score::default();
        score.add(&truth, &Answer::Overlaps([[0, 1], [0, 3]].into_iter().collect()));
        let errors = Errors { max: None, rms: None, missed: 0.5, invented: 0.5 };
        assert_eq!(score.errors(), errors);
    }
}
