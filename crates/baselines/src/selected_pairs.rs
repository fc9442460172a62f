//! Selected pairs: faces drawn at random, led to where they come closest.
//!
//! In every step some pairs of faces are drawn and walk, face by neighbouring
//! face on either body, to where their distance is least nearby. Pairs within
//! reach are kept and walk again in the next step, so that what was found is
//! followed as bodies move. From a pair that crosses, the crossing is traced
//! to neighbouring pairs. A contact that no pair has walked to is missed; the
//! longer bodies stay in contact, the less likely that is.
//!
//! Sources: S. Guy and G. Debunne, "Monte-Carlo collision detection", INRIA
//! research report 5136, 2004; L. Raghupathi, L. Grisoni, F. Faure, D. Marchal,
//! M.-P. Cani and C. Chaillou, "An intestinal surgery simulator: real-time
//! collision processing and visualization", IEEE TVCG 10(6), 2004 (walks and
//! tracing). Pairs are drawn without repetition, in steps through all of them:
//! with a budget for all, none is left out.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use surface::TriangleSurface;
//! use baselines::{PlacedSurface, selected_pairs::{SelectedPairsParams, SelectedPairs}};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| x + DVec3::splat(0.2));
//! let (x, y) = (surface.positions(&first)?, surface.positions(&second)?);
//! let (a, b) = (PlacedSurface { surface: &surface, x }, PlacedSurface { surface: &surface, x: y });
//! let mut pairs = SelectedPairs::new(1);
//! let found = pairs.step(a, b, &SelectedPairsParams { draws: 3, margin: 1.0, ..SelectedPairsParams::DEFAULT })?;
//! assert!(found.overlap, "any pair of so few leads to the crossing");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;

use surface::{Meeting, closest_between_triangles, triangles_meet};

use crate::error::{BaselineError, check_count};
use crate::findings::{PairFindings, PlacedSurface};
use crate::generator::Generator;

/// How many pairs are drawn, and how far they are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedPairsParams {
    /// Pairs drawn in a step, in `1..=2^32`; more than there are draws all.
    pub draws: u64,
    /// Moves of a pair to a closer one in a step, at most.
    pub hops: u32,
    /// Distance up to which a pair is kept for the next step \[length unit\], `>= 0`.
    pub margin: f64,
    /// Pairs tested in a step, at most: the budget. Pairs that
    /// were kept come first, then those drawn.
    pub max_tests: u64,
}

impl SelectedPairsParams {
    /// 200 pairs, 20 moves, 5 (millimetres) of reach, no limit.
    pub const DEFAULT: Self = Self { draws: 200, hops: 20, margin: 5.0, max_tests: u64::MAX };

    fn check(&self) -> Result<(), BaselineError> {
        check_count("draws", self.draws, 1 << 32)?;
        if !(self.margin >= 0.0 && self.margin.is_finite()) {
            return Err(BaselineError::Distance { name: "margin", value: self.margin });
        }
        Ok(())
    }
}

impl Default for SelectedPairsParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Pairs of faces that are followed from step to step.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectedPairs {
    kept: BTreeSet<[u32; 2]>,
    generator: Generator,
}

impl SelectedPairs {
    /// No pairs yet. What is drawn depends on the seed alone.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { kept: BTreeSet::new(), generator: Generator::new(seed) }
    }

    /// Pairs that were within reach at the end of the last step.
    #[must_use]
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether no pair was within reach.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Moves all pairs on, draws new ones, and traces what crosses.
    ///
    /// The crossings found do cross; others may be missed. The bodies must have
    /// the same faces in each step.
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
        params.check()?;
        let counts = [a.face_count(), b.face_count()];
        let drawn = Draws::new(counts, params.draws, &mut self.generator);
        let kept = std::mem::take(&mut self.kept);
        let in_range = |pair: &[u32; 2]| pair[0] < counts[0] && pair[1] < counts[1];
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

/// Pairs of faces drawn without repetition: by a stride that is prime to the
/// number of all.
struct Draws {
    counts: [u32; 2],
    at: u64,
    stride: u64,
    left: u64,
}

impl Draws {
    fn new(counts: [u32; 2], draws: u64, generator: &mut Generator) -> Self {
        let all = u64::from(counts[0]) * u64::from(counts[1]);
        let (mut at, mut stride) = (generator.next(), generator.next());
        if all > 0 {
            at %= all;
            stride = stride % all + 1;
            while divisor(stride, all) != 1 {
                stride = stride % all + 1;
            }
        }
        Self { counts, at, stride, left: draws.min(all) }
    }
}

impl Iterator for Draws {
    type Item = [u32; 2];

    #[expect(clippy::cast_possible_truncation, reason = "remainders and shares of 32-bit counts")]
    fn next(&mut self) -> Option<[u32; 2]> {
        self.left = self.left.checked_sub(1)?;
        let second = u64::from(self.counts[1]);
        let pair = [(self.at / second) as u32, (self.at % second) as u32];
        // A sum of two numbers of 64 bits may not fit one.
        let all = u64::from(self.counts[0]) * second;
        self.at = ((u128::from(self.at) + u128::from(self.stride)) % u128::from(all)) as u64;
        Some(pair)
    }
}

/// Greatest common divisor.
fn divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// Moves over the pairs of two bodies, and the tests that they took.
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

    /// Moves a pair to neighbouring ones as long as their distance falls.
    fn descend(&mut self, mut pair: [u32; 2]) -> ([u32; 2], f64) {
        let mut distance = self.distance(pair);
        for _ in 0..self.params.hops {
            let mut best = (distance, pair);
            for next in neighbours(self.a, self.b, pair) {
                if distance <= 0.0 || self.is_spent() {
                    break;
                }
                let nearer = self.distance(next);
                if nearer < best.0 {
                    best = (nearer, next);
                }
            }
            if best.0 >= distance {
                break;
            }
            (distance, pair) = best;
        }
        (pair, distance)
    }

    /// Distance of a pair: 0 if it crosses.
    fn distance(&mut self, [f, g]: [u32; 2]) -> f64 {
        if self.crosses([f, g]) {
            return 0.0;
        }
        closest_between_triangles(self.a.corners(f), self.b.corners(g)).distance()
    }

    fn crosses(&mut self, [f, g]: [u32; 2]) -> bool {
        self.tests += 1;
        triangles_meet(self.a.corners(f), self.b.corners(g)) == Meeting::Crossing
    }

    /// Follows a crossing from pair to neighbouring pair.
    fn trace(&mut self, pair: [u32; 2], crossing: &mut BTreeSet<[u32; 2]>) {
        let mut open = vec![pair];
        while let Some(pair) = open.pop() {
            if self.is_spent() {
                return;
            }
            if !crossing.contains(&pair) && self.crosses(pair) {
                crossing.insert(pair);
                let next = neighbours(self.a, self.b, pair);
                open.extend(next.filter(|next| !crossing.contains(next)));
            }
        }
    }
}

/// Pairs in which one of the faces is exchanged for one that shares a vertex.
fn neighbours(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    [f, g]: [u32; 2],
) -> impl Iterator<Item = [u32; 2]> {
    let of_a = around(a, f).map(move |f| [f, g]);
    of_a.chain(around(b, g).map(move |g| [f, g]))
}

/// The faces that share a vertex with one; those that share an edge come twice.
fn around(body: PlacedSurface<'_>, face: u32) -> impl Iterator<Item = u32> {
    let corners = body.surface.faces()[face as usize];
    let faces = corners.into_iter().flat_map(move |v| body.surface.vertex_faces(v).iter().copied());
    faces.filter(move |other| *other != face)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{Draws, Generator};

    #[test]
    fn each_pair_is_drawn_once() {
        for seed in 0..50 {
            let drawn = Draws::new([12, 10], 1000, &mut Generator::new(seed));
            let drawn: Vec<[u32; 2]> = drawn.collect();
            assert_eq!(drawn.len(), 120);
            assert_eq!(drawn.iter().collect::<BTreeSet<_>>().len(), 120, "seed {seed}");
            assert!(drawn.iter().all(|[f, g]| *f < 12 && *g < 10), "seed {seed}");
        }
    }
}
