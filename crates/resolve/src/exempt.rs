//! Bodies that stay where they are, pairs that are left as they are, and tied vertices that are let go, so that all others
//! come free.

use std::collections::BTreeSet;

use scene::{BodyId, PairId, PairReport};

/// Bodies and pairs that a start does not take apart, and vertices that it does not hold.
#[derive(Clone, Debug, Default)]
pub(crate) struct Exempt {
    /// Bodies that stay where they are.
    pub(crate) bodies: Vec<BodyId>,
    /// Pairs that are neither pushed apart nor kept from each other. At the end they are detected as all others.
    pub(crate) pairs: Vec<PairId>,
    /// Vertices of bodies that no tie holds.
    pub(crate) loose: BTreeSet<(BodyId, u32)>,
}

impl Exempt {
    /// Nothing.
    pub(crate) const NONE: Self =
        Self { bodies: Vec::new(), pairs: Vec::new(), loose: BTreeSet::new() };

    /// Adds the pairs of which a surface with holes surrounds the other body at the start. Nothing shows that it is a solid
    /// and no sheet around the body: a limb's skin that is open at its ends would be emptied.
    pub(crate) fn with_surrounded(&self, before: &[PairReport]) -> Self {
        let surrounded = before.iter().filter(|report| is_surrounded(report));
        let pairs = self.pairs.iter().copied().chain(surrounded.map(|report| report.pair));
        Self { pairs: pairs.collect(), ..self.clone() }
    }

    /// Returns true if a body of a pair, or the pair, is exempt.
    pub(crate) fn concerns(&self, pair: PairId) -> bool {
        self.pairs.contains(&pair) || pair.bodies().iter().any(|body| self.bodies.contains(body))
    }
}

/// Returns true if a surface without an inside surrounds the other body: vertices are inside of it all the same.
pub(crate) fn is_surrounded(report: &PairReport) -> bool {
    [&report.a_against_b, &report.b_against_a]
        .iter()
        .any(|side| side.inside_count.is_err() && side.near.iter().any(|near| near.gap < 0.0))
}
