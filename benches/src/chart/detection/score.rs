//! How far answers are from the truth.

use std::collections::{BTreeMap, BTreeSet};

use super::question::{REACH, Truth, Way};

/// What a method tells of one frame.
#[derive(Clone, Debug)]
pub(super) enum Told {
    /// Vertices inside with their depths \[mm\], for each way that the method looks.
    Vertices(Vec<(Way, Vec<(u32, f64)>)>),
    /// Faces that cross, for each pair.
    Crossings(Vec<([usize; 2], Vec<[u32; 2]>)>),
    /// Pairs that overlap.
    Overlaps(BTreeSet<[usize; 2]>),
}

/// Errors over some frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Score {
    /// Largest error of a depth \[mm\].
    worst: f64,
    squares: f64,
    depths: u32,
    true_ones: u32,
    found: u32,
    invented: u32,
}

impl Score {
    /// Adds what was told of a frame.
    pub(super) fn add(&mut self, truth: &Truth, told: &Told) {
        match told {
            Told::Vertices(ways) => {
                let nothing = BTreeMap::new();
                for (way, depths) in ways {
                    let gaps = truth.gaps.get(way).unwrap_or(&nothing);
                    let depths = depths.iter().copied().collect();
                    self.add_depths(gaps, &depths);
                }
            }
            Told::Crossings(pairs) => {
                let nothing = BTreeSet::new();
                for (pair, crossings) in pairs {
                    let is = truth.crossings.get(pair).unwrap_or(&nothing);
                    self.count(is, &crossings.iter().copied().collect());
                }
            }
            Told::Overlaps(pairs) => self.count(&truth.overlaps, pairs),
        }
    }

    /// Largest error of a depth \[mm\]; `None` where no depth was told.
    #[must_use]
    pub(super) fn worst(&self) -> Option<f64> {
        (self.depths > 0).then_some(self.worst)
    }

    /// Root of the mean squared error of depths \[mm\]; `None` where none was told.
    #[must_use]
    pub(super) fn rms(&self) -> Option<f64> {
        (self.depths > 0).then(|| (self.squares / f64::from(self.depths)).sqrt())
    }

    /// Share of the true vertices, crossings or overlaps that was missed.
    #[must_use]
    pub(super) fn missed(&self) -> f64 {
        f64::from(self.true_ones - self.found) / f64::from(self.true_ones.max(1))
    }

    /// Those that were told and are not, over the number of true ones.
    #[must_use]
    pub(super) fn invented(&self) -> f64 {
        f64::from(self.invented) / f64::from(self.true_ones.max(1))
    }

    /// Every vertex that is inside or was told to be.
    fn add_depths(&mut self, gaps: &BTreeMap<u32, f64>, told: &BTreeMap<u32, f64>) {
        let inside: BTreeSet<u32> =
            gaps.iter().filter(|(_, gap)| **gap < 0.0).map(|(vertex, _)| *vertex).collect();
        let told_inside: BTreeSet<u32> = told.keys().copied().collect();
        for vertex in inside.union(&told_inside) {
            let depth = told.get(vertex).copied().unwrap_or(0.0);
            let is = -gaps.get(vertex).copied().unwrap_or(REACH);
            let error = (depth - is).abs();
            self.worst = self.worst.max(error);
            self.squares += error * error;
            self.depths += 1;
        }
        self.count(&inside, &told_inside);
    }

    fn count<T: Ord>(&mut self, is: &BTreeSet<T>, told: &BTreeSet<T>) {
        let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let found = number(is.intersection(told).count());
        self.true_ones += number(is.len());
        self.found += found;
        self.invented += number(told.len()) - found;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three vertices inside one is told 0.3 too deep and one not at all; one outside by 0.2
    /// is told to be inside by 0.1.
    #[test]
    fn errors_misses_and_inventions_are_counted() {
        let mut truth = Truth::default();
        let gaps = [(1, -1.0), (2, -0.5), (3, -2.0), (4, 0.2)];
        truth.gaps.insert([0, 1], gaps.into_iter().collect());
        let mut score = Score::default();
        score.add(&truth, &Told::Vertices(vec![([0, 1], vec![(1, 1.3), (3, 2.0), (4, 0.1)])]));
        assert!((score.worst().unwrap() - 0.5).abs() < 1e-12);
        let squares: f64 = 0.3 * 0.3 + 0.5 * 0.5 + 0.3 * 0.3;
        assert!((score.rms().unwrap() - (squares / 4.0).sqrt()).abs() < 1e-12);
        assert!((score.missed() - 1.0 / 3.0).abs() < 1e-12);
        assert!((score.invented() - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_tells_no_depth_is_counted_only() {
        let overlaps = [[0, 1], [0, 2]].into_iter().collect();
        let truth = Truth { overlaps, ..Truth::default() };
        let mut score = Score::default();
        score.add(&truth, &Told::Overlaps([[0, 1], [0, 3]].into_iter().collect()));
        assert_eq!((score.worst(), score.rms()), (None, None));
        assert_eq!((score.missed(), score.invented()), (0.5, 0.5));
    }
}
