//! Selected pairs: random pairs of faces that walk to local minima of their distance.
//!
//! In every step some pairs of faces are drawn, and walk over neighboring faces of either surface
//! to a local minimum of their distance. Pairs within a margin are kept and walk again in the next
//! step, so that contacts are followed as bodies move. A crossing is traced from a crossing pair
//! to its neighbors. A contact that no pair walks to is missed; the longer bodies stay in contact,
//! the less likely that is.
//!
//! Sources: S. Guy and G. Debunne, "Monte-Carlo collision detection", INRIA research report 5136,
//! 2004; L. Raghupathi, L. Grisoni, F. Faure, D. Marchal, M.-P. Cani and C. Chaillou, "An
//! intestinal surgery simulator: real-time collision processing and visualization", IEEE TVCG
//! 10(6), 2004 (walks and tracing). Pairs are drawn without repetition, in strides through all of
//! them: with a budget for all, none is left out.
//!
//! # Example
//!
//! ```
//! use baselines::selected_pairs::{SelectedPairs, SelectedPairsParams};
//! use baselines::{PlacedSurface, glam::DVec3};
//! use surface::TriangleSurface;
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let a = PlacedSurface { surface: &surface, x: surface.positions(&first)? };
//! let b = PlacedSurface { surface: &surface, x: surface.positions(&second)? };
//!
//! let mut pairs = SelectedPairs::new(1);
//! let found = pairs.step(a, b, &SelectedPairsParams { draws: 3, ..SelectedPairsParams::new(1.0) })?;
//! assert!(found.overlap, "any pair of so few leads to the crossing");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;

use surface::{Meeting, closest_between_triangles, triangles_meet};

use crate::error::{BaselineError, check};
use crate::findings::{PairFindings, PlacedSurface};
use crate::generator::SplitMix64;

/// A face of the first and one of the second surface.
type FacePair = [u32; 2];

/// Parameters of the pairs and of their walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedPairsParams {
    /// Pairs drawn per step, `>= 1`; more than there are draws all.
    pub draws: u32,
    /// Maximum number of moves of a pair per step.
    pub max_moves: u32,
    /// Distance up to which a pair is kept for the next step \[length unit\], `>= 0`.
    pub margin: f64,
    /// Maximum number of pairs tested per step: the budget. Kept pairs come first, then those
    /// drawn.
    pub max_tests: u64,
}

impl SelectedPairsParams {
    /// Returns parameters with a margin: 200 pairs, 20 moves, no budget.
    #[must_use]
    pub const fn new(margin: f64) -> Self {
        Self { draws: 200, max_moves: 20, margin, max_tests: u64::MAX }
    }

    /// Checks that all parameters are in range.
    ///
    /// # Errors
    ///
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), BaselineError> {
        let Self { draws, margin, .. } = *self;
        check("draws", draws.into(), draws > 0, "at least 1")?;
        let is_length = margin >= 0.0 && margin.is_finite();
        check("margin", margin, is_length, "a finite length of at least 0")
    }
}

/// Pairs of faces that are followed from step to step.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectedPairs {
    kept: BTreeSet<FacePair>,
    generator: SplitMix64,
}

impl SelectedPairs {
    /// Starts without pairs. Draws depend on the seed only.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { kept: BTreeSet::new(), generator: SplitMix64(seed) }
    }

    /// Moves all pairs, draws new ones, and traces crossings.
    ///
    /// The crossings found are exact; others may be missed. The surfaces must have the same faces
    /// in each step.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range.
    pub fn step(
        &mut self,
        a: PlacedSurface<'_>,
        b: PlacedSurface<'_>,
        params: &SelectedPairsParams,
    ) -> Result<PairFindings, BaselineError> {
        params.validate()?;
        let counts = [a.face_count(), b.face_count()];
        let drawn = Draws::new(counts, params.draws, &mut self.generator);
        let kept = std::mem::take(&mut self.kept);
        let in_range = |pair: &FacePair| pair[0] < counts[0] && pair[1] < counts[1];

        // Kept pairs first, within the budget.
        let mut walk = Walk { a, b, params, tests: 0 };
        let mut crossing = BTreeSet::new();
        for pair in kept.into_iter().filter(in_range).chain(drawn) {
            if walk.is_spent() {
                break;
            }
            let (pair, distance) = walk.descend(pair);
            if distance <= params.margin {
                self.kept.insert(pair);
            }
            if distance <= 0.0 {
                walk.trace(pair, &mut crossing);
            }
        }
        Ok(PairFindings {
            overlap: !crossing.is_empty(),
            crossing_faces: Some(crossing.into_iter().collect()),
            tests: walk.tests,
            ..PairFindings::default()
        })
    }
}

/// Pairs of faces drawn without repetition, by a stride that is coprime to the number of all.
struct Draws {
    counts: [u32; 2],
    next: u64,
    stride: u64,
    left: u64,
}

impl Draws {
    fn new(counts: [u32; 2], draws: u32, generator: &mut SplitMix64) -> Self {
        let all = u64::from(counts[0]) * u64::from(counts[1]);
        let (mut next, mut stride) = (generator.next(), generator.next());
        if all > 0 {
            next %= all;
            stride = stride % all + 1;
            while greatest_common_divisor(stride, all) != 1 {
                stride = stride % all + 1;
            }
        }
        Self { counts, next, stride, left: u64::from(draws).min(all) }
    }
}

impl Iterator for Draws {
    type Item = FacePair;

    #[expect(
        clippy::cast_possible_truncation,
        reason = "remainders and quotients of 32-bit counts"
    )]
    fn next(&mut self) -> Option<FacePair> {
        self.left = self.left.checked_sub(1)?;
        let columns = u64::from(self.counts[1]);
        let pair = [(self.next / columns) as u32, (self.next % columns) as u32];

        // The sum of two numbers of 64 bits may overflow.
        let all = u64::from(self.counts[0]) * columns;
        let sum = u128::from(self.next) + u128::from(self.stride);
        self.next = (sum % u128::from(all)) as u64;
        Some(pair)
    }
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Moves over pairs of faces, and the number of their tests.
struct Walk<'a> {
    a: PlacedSurface<'a>,
    b: PlacedSurface<'a>,
    params: &'a SelectedPairsParams,
    tests: u64,
}

impl Walk<'_> {
    fn is_spent(&self) -> bool {
        self.tests >= self.params.max_tests
    }

    /// Moves a pair to neighbors as long as its distance falls; returns it with its distance.
    fn descend(&mut self, mut pair: FacePair) -> (FacePair, f64) {
        let mut distance = self.distance(pair);
        for _ in 0..self.params.max_moves {
            // The nearest of all neighbors, by faces of either surface.
            let (mut best, mut best_distance) = (pair, distance);
            for next in neighbors(self.a, self.b, pair) {
                if distance <= 0.0 || self.is_spent() {
                    break;
                }
                let next_distance = self.distance(next);
                if next_distance < best_distance {
                    (best, best_distance) = (next, next_distance);
                }
            }
            if best_distance >= distance {
                break;
            }
            (pair, distance) = (best, best_distance);
        }
        (pair, distance)
    }

    /// Computes the distance of a pair, 0 if it crosses.
    fn distance(&mut self, [f, g]: FacePair) -> f64 {
        if self.crosses([f, g]) {
            return 0.0;
        }
        closest_between_triangles(self.a.corners(f), self.b.corners(g)).distance()
    }

    fn crosses(&mut self, [f, g]: FacePair) -> bool {
        self.tests += 1;
        triangles_meet(self.a.corners(f), self.b.corners(g)) == Meeting::Crossing
    }

    /// Collects the crossing pairs that neighbors connect with a pair.
    fn trace(&mut self, pair: FacePair, crossing: &mut BTreeSet<FacePair>) {
        let mut open = vec![pair];
        while let Some(pair) = open.pop() {
            if self.is_spent() {
                return;
            }
            if !crossing.contains(&pair) && self.crosses(pair) {
                crossing.insert(pair);
                open.extend(neighbors(self.a, self.b, pair));
            }
        }
    }
}

/// Returns the pairs in which one of the faces is replaced by one that shares a vertex.
fn neighbors(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    [f, g]: FacePair,
) -> impl Iterator<Item = FacePair> {
    let of_a = adjacent_faces(a, f).map(move |f| [f, g]);
    of_a.chain(adjacent_faces(b, g).map(move |g| [f, g]))
}

/// Returns the faces that share a vertex with a face; those that share an edge come twice.
fn adjacent_faces(body: PlacedSurface<'_>, face: u32) -> impl Iterator<Item = u32> {
    let corners = body.surface.faces()[face as usize];
    let faces = corners.into_iter().flat_map(move |v| body.surface.vertex_faces(v).iter().copied());
    faces.filter(move |other| *other != face)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{Draws, SplitMix64};

    #[test]
    fn each_pair_is_drawn_once() {
        for seed in 0..50 {
            let drawn = Draws::new([12, 10], 1000, &mut SplitMix64(seed));
            let drawn: Vec<[u32; 2]> = drawn.collect();
            assert_eq!(drawn.len(), 120);
            assert_eq!(drawn.iter().collect::<BTreeSet<_>>().len(), 120, "seed {seed}");
            assert!(drawn.iter().all(|[f, g]| *f < 12 && *g < 10), "seed {seed}");
        }
    }
}
