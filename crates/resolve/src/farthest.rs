//! Round that left the least, whether it was accepted or not.

use scene::PairId;

use crate::Round;
use crate::near_pairs::NearPairs;

/// Round of least merit, and the pairs that overlap in it: those that hold up all others where it is not
/// accepted.
#[derive(Debug)]
pub(crate) struct Farthest {
    merit: f64,
    pairs: Vec<PairId>,
}

impl Default for Farthest {
    fn default() -> Self {
        Self { merit: f64::INFINITY, pairs: Vec::new() }
    }
}

impl Farthest {
    /// Takes note of the overlaps of a round, if they are less.
    pub(crate) fn compare(&mut self, round: &Round, near: &NearPairs) {
        if round.merit < self.merit {
            self.merit = round.merit;
            self.pairs = near.overlapping().map(|near| near.report.pair).collect();
        }
    }

    /// Returns the pairs that overlap, and leaves none.
    pub(crate) fn take_unfreed(&mut self) -> Vec<PairId> {
        std::mem::take(&mut self.pairs)
    }
}
