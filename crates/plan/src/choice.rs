//! Choice of the method of each pair: least time of construction and of all frames.
//!
//! Each candidate of a pair needs structures of its bodies, which all pairs of a body share. For a
//! given set of structures every pair takes the cheapest candidate that they allow. The set is
//! found by local search from trees of all bodies, over all sets of one body and of both bodies of
//! a pair, until no change saves time. It is the same in every run.

use scene::{BodyId, PairId};

use crate::{DetectionMethod, OperationCounts, StructureKind};

/// Set of kinds of structures of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StructureSet(u8);

/// One way to detect a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) method: DetectionMethod,
    pub(crate) is_coarse: [bool; 2],
    pub(crate) bone: Option<BodyId>,
    /// Operations per frame.
    pub(crate) operations: OperationCounts,
    /// Time that they take \[s\].
    pub(crate) seconds: f64,
}

/// Candidates of one pair.
#[derive(Clone, Debug)]
pub(crate) struct PairOptions {
    pub(crate) pair: PairId,
    pub(crate) candidates: Vec<Candidate>,
}

/// Costs of the structures of one body; infinite for those that it cannot have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyOptions {
    /// Time of construction and of following the body over all frames \[s\], per kind.
    pub(crate) seconds: [f64; KINDS],
}

/// Options of all pairs and bodies.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    pub(crate) frames: f64,
    pub(crate) bodies: Vec<BodyOptions>,
    pub(crate) pairs: Vec<PairOptions>,
}

/// Chosen candidate per pair, and the structures that these need, per body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub(crate) candidates: Vec<usize>,
    pub(crate) structures: Vec<StructureSet>,
    /// Time of construction and of all frames \[s\].
    pub(crate) seconds: f64,
}

/// Share of the predicted time of whole surfaces, above which these are taken, since predictions are no
/// more exact. Below, gains are missed; above, a plan may take longer than detection without one.
const WORTHWHILE_SHARE: f64 = 0.85;

/// Number of kinds of structures.
pub(crate) const KINDS: usize = 4;

/// Sets of trees, coarse surfaces and fields; medial surfaces are forced.
const FREE_SETS: u8 = 8;

/// Rounds of the search. Two or three are needed; more guard against rounding.
const MAX_ROUNDS: u32 = 16;

impl StructureSet {
    pub(crate) const fn of(kind: StructureKind) -> Self {
        Self(1 << place(kind))
    }

    pub(crate) const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) const fn has(self, kind: StructureKind) -> bool {
        self.0 & (1 << place(kind)) != 0
    }

    const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Returns the place of a kind among all.
pub(crate) const fn place(kind: StructureKind) -> usize {
    match kind {
        StructureKind::Tree => 0,
        StructureKind::Coarse => 1,
        StructureKind::Field => 2,
        StructureKind::Medial => 3,
    }
}

impl Candidate {
    /// Returns the structures of both bodies that the candidate needs.
    pub(crate) fn needs(&self, pair: PairId) -> [StructureSet; 2] {
        let tree = StructureSet::of(StructureKind::Tree);
        let bodies = pair.bodies();
        [0, 1].map(|side| match self.method {
            DetectionMethod::Coarse if self.is_coarse[side] => {
                StructureSet::of(StructureKind::Coarse)
            }
            DetectionMethod::Field if self.bone == Some(bodies[side]) => {
                tree.with(StructureSet::of(StructureKind::Field))
            }
            DetectionMethod::Balls => tree.with(StructureSet::of(StructureKind::Medial)),
            _ => tree,
        })
    }
}

impl Options {
    /// Chooses a candidate for each pair: the cheapest together, or whole surfaces for all where that saves too
    /// little beside these.
    pub(crate) fn choose(&self) -> Choice {
        let (cheapest, whole) = (self.cheapest(), self.whole());
        let is_worthwhile = cheapest.seconds <= WORTHWHILE_SHARE * whole.seconds;
        if is_worthwhile { cheapest } else { whole }
    }

    /// Finds the cheapest candidates.
    fn cheapest(&self) -> Choice {
        let mut search = Search::new(self);
        for _ in 0..MAX_ROUNDS {
            if !search.improve() {
                break;
            }
        }
        search.finish()
    }

    /// Takes the exact candidate of each pair that has one.
    fn whole(&self) -> Choice {
        let mut candidates = Vec::new();
        for pair in &self.pairs {
            let is_whole = |candidate: &Candidate| {
                candidate.method == DetectionMethod::Exact && candidate.is_coarse == [false; 2]
            };
            candidates.push(pair.candidates.iter().position(is_whole).unwrap_or(0));
        }
        let (seconds, structures) = (self.seconds(&candidates), self.needs(&candidates));
        Choice { candidates, structures, seconds }
    }

    /// Computes the time of construction and of all frames for some candidates \[s\].
    pub(crate) fn seconds(&self, candidates: &[usize]) -> f64 {
        let structures = self.needs(candidates);
        let mut seconds = 0.0;
        for (body, set) in self.bodies.iter().zip(structures) {
            seconds += body.seconds(set);
        }
        for (pair, &candidate) in self.pairs.iter().zip(candidates) {
            seconds += self.frames * pair.candidates[candidate].seconds;
        }
        seconds
    }

    /// Returns the structures that some candidates need, per body.
    fn needs(&self, candidates: &[usize]) -> Vec<StructureSet> {
        let mut structures = vec![StructureSet::default(); self.bodies.len()];
        for (pair, &candidate) in self.pairs.iter().zip(candidates) {
            let needs = pair.candidates[candidate].needs(pair.pair);
            for (id, needs) in pair.pair.bodies().into_iter().zip(needs) {
                structures[id.index()] = structures[id.index()].with(needs);
            }
        }
        structures
    }
}

impl BodyOptions {
    /// Computes the time of a set of structures \[s\].
    fn seconds(&self, set: StructureSet) -> f64 {
        let mut seconds = 0.0;
        for (kind, &each) in self.seconds.iter().enumerate() {
            if set.0 & (1 << kind) != 0 {
                seconds += each;
            }
        }
        seconds
    }
}

/// Search for the cheapest structures.
struct Search<'a> {
    options: &'a Options,
    structures: Vec<StructureSet>,
    /// Structures that forced methods need, per body.
    forced: Vec<StructureSet>,
    /// Pairs of each body.
    pairs_of: Vec<Vec<usize>>,
}

impl<'a> Search<'a> {
    fn new(options: &'a Options) -> Self {
        let count = options.bodies.len();
        let mut pairs_of = vec![Vec::new(); count];
        let mut forced = vec![StructureSet::default(); count];
        for (number, pair) in options.pairs.iter().enumerate() {
            for (side, id) in pair.pair.bodies().into_iter().enumerate() {
                pairs_of[id.index()].push(number);
                if let [only] = &pair.candidates[..] {
                    let needs = only.needs(pair.pair)[side];
                    forced[id.index()] = forced[id.index()].with(needs);
                }
            }
        }

        // Trees of all bodies allow the exact candidate of every free pair.
        let mut structures = forced.clone();
        for (set, pairs) in structures.iter_mut().zip(&pairs_of) {
            if !pairs.is_empty() {
                *set = set.with(StructureSet::of(StructureKind::Tree));
            }
        }
        Self { options, structures, forced, pairs_of }
    }

    /// Tries all sets of each body, and of both bodies of each pair; returns true if one saves
    /// time.
    fn improve(&mut self) -> bool {
        // Bodies by themselves first; what two of them share may pay only for both together.
        let mut is_better = false;
        for body in 0..self.structures.len() {
            if !self.pairs_of[body].is_empty() {
                is_better |= self.improve_bodies(&[body]);
            }
        }
        for number in 0..self.options.pairs.len() {
            let pair = &self.options.pairs[number];
            if pair.candidates.len() > 1 {
                is_better |= self.improve_bodies(&pair.pair.bodies().map(BodyId::index));
            }
        }
        is_better
    }

    /// Takes the cheapest sets of one or two bodies, while all others keep theirs.
    fn improve_bodies(&mut self, bodies: &[usize]) -> bool {
        // Pairs that these bodies are in, once each.
        let mut pairs: Vec<usize> = Vec::new();
        for &body in bodies {
            pairs.extend(&self.pairs_of[body]);
        }
        pairs.sort_unstable();
        pairs.dedup();

        // Every combination of their free sets is tried: 8 for one body, 64 for two.
        let before = self.seconds(bodies, &pairs);
        let (mut least, mut best) = (before, self.sets(bodies));
        let combinations = FREE_SETS.pow(u32::try_from(bodies.len()).unwrap_or(1));
        for combination in 0..combinations {
            let mut rest = combination;
            for &body in bodies {
                self.structures[body] = self.forced[body].with(StructureSet(rest % FREE_SETS));
                rest /= FREE_SETS;
            }
            let seconds = self.seconds(bodies, &pairs);
            if seconds < least {
                (least, best) = (seconds, self.sets(bodies));
            }
        }

        // Without a saving, the best sets are those from before.
        for (&body, set) in bodies.iter().zip(best) {
            self.structures[body] = set;
        }
        least < before
    }

    fn sets(&self, bodies: &[usize]) -> Vec<StructureSet> {
        bodies.iter().map(|&body| self.structures[body]).collect()
    }

    /// Computes the time of some bodies and pairs with the present sets \[s\].
    fn seconds(&self, bodies: &[usize], pairs: &[usize]) -> f64 {
        let mut seconds = 0.0;
        for &body in bodies {
            seconds += self.options.bodies[body].seconds(self.structures[body]);
        }

        // A pair without an allowed candidate rules the sets out.
        for &number in pairs {
            seconds += self.cheapest(number).map_or(f64::INFINITY, |(seconds, _)| seconds);
        }
        seconds
    }

    /// Returns the time and number of the cheapest candidate that the present sets allow.
    fn cheapest(&self, number: usize) -> Option<(f64, usize)> {
        let pair = &self.options.pairs[number];
        let [a, b] = pair.pair.bodies().map(|id| self.structures[id.index()]);
        let mut cheapest: Option<(f64, usize)> = None;
        for (place, candidate) in pair.candidates.iter().enumerate() {
            let [needs_a, needs_b] = candidate.needs(pair.pair);
            let seconds = self.options.frames * candidate.seconds;
            let is_allowed = a.contains(needs_a) && b.contains(needs_b);
            if is_allowed && cheapest.is_none_or(|(least, _)| seconds < least) {
                cheapest = Some((seconds, place));
            }
        }
        cheapest
    }

    fn finish(self) -> Choice {
        let mut candidates = Vec::new();
        for number in 0..self.options.pairs.len() {
            candidates.push(self.cheapest(number).map_or(0, |(_, place)| place));
        }

        // Structures that no chosen candidate needs are left out.
        let seconds = self.options.seconds(&candidates);
        Choice { structures: self.options.needs(&candidates), candidates, seconds }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, Scene};

    use super::*;

    /// Two bodies whose trees take a second each, and coarse surfaces a share of it.
    #[test]
    fn whole_surfaces_are_taken_where_little_is_saved() {
        let mut scene = Scene::new();
        let bodies = ["bone", "muscle"].map(|name| {
            let mesh = shapes::icosphere(1.0, 1);
            scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions).expect("a body")
        });
        let candidate = |method, is_coarse| Candidate {
            method,
            is_coarse,
            bone: None,
            operations: OperationCounts::default(),
            seconds: 0.0,
        };
        let pair = PairOptions {
            pair: PairId::new(bodies[0], bodies[1]),
            candidates: vec![
                candidate(DetectionMethod::Exact, [false; 2]),
                candidate(DetectionMethod::Coarse, [true; 2]),
            ],
        };
        for (share, chosen) in [(0.8, 1), (0.9, 0), (1.1, 0)] {
            let body = BodyOptions { seconds: [1.0, share, 9.0, 9.0] };
            let options = Options { frames: 9.0, bodies: vec![body; 2], pairs: vec![pair.clone()] };
            assert_eq!(options.choose().candidates, [chosen], "{share}");
        }
    }
}
