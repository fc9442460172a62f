//! Bodies that stay where they are, and pairs that are left as they are, so that all others come free.

use scene::{BodyId, PairId};

/// Bodies and pairs that a start does not take apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exempt {
    /// Bodies that stay where they are.
    pub(crate) bodies: Vec<BodyId>,
    /// Pairs that are neither pushed apart nor kept from each other. At the end they are detected as all others.
    pub(crate) pairs: Vec<PairId>,
}

impl Exempt {
    /// Nothing.
    pub(crate) const NONE: Self = Self { bodies: Vec::new(), pairs: Vec::new() };

    /// Returns true if a body of a pair, or the pair, is exempt.
    pub(crate) fn concerns(&self, pair: PairId) -> bool {
        self.pairs.contains(&pair) || pair.bodies().iter().any(|body| self.bodies.contains(body))
    }
}
