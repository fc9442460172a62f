//! Numbers of bodies, and pairs of them.

/// Number of a body in its scene, in the order they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId(pub(crate) u32);

/// Pair of bodies, the one of the lower number first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairId {
    /// The body of the lower number.
    pub a: BodyId,
    /// The body of the higher number.
    pub b: BodyId,
}

impl BodyId {
    /// Returns the number itself, from 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl PairId {
    /// Returns the pair of two bodies, named in whichever order.
    #[must_use]
    pub fn new(a: BodyId, b: BodyId) -> Self {
        Self { a: a.min(b), b: a.max(b) }
    }

    /// Returns both bodies, the one of the lower number first.
    #[must_use]
    pub fn bodies(self) -> [BodyId; 2] {
        [self.a, self.b]
    }

    /// Returns true if the body is one of the pair.
    #[must_use]
    pub fn contains(self, id: BodyId) -> bool {
        self.a == id || self.b == id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_holds_its_two_bodies_alone() {
        for (a, b) in [(1, 3), (3, 1)] {
            let pair = PairId::new(BodyId(a), BodyId(b));
            assert_eq!(pair.bodies(), [BodyId(1), BodyId(3)]);
            let held: Vec<u32> = (0..5).filter(|&id| pair.contains(BodyId(id))).collect();
            assert_eq!(held, [1, 3]);
        }
    }
}
