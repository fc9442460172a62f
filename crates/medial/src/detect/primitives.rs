//! Pairs of primitives of two medial surfaces.

use glam::DVec3;
use kdop::Workspace;
use surface::Term;

use super::sieve::SeparatingDirections;
use super::{ParticleOffsets, TestCounts, normal};
use crate::{Foot, MedialSurface, PrimitiveTree, pair_foot};

/// Two primitives that come within reach of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveContact {
    /// Number of the primitive of the first medial surface, then of the second.
    pub primitives: [u32; 2],
    /// Weights of the balls of each.
    pub weights: [[f64; 3]; 2],
    /// Unit vector from the second's ball to the first's; where their centers
    /// coincide, a normal of the second.
    pub normal: DVec3,
    /// Sum of the radii.
    pub offset: f64,
    /// Distance of the two balls, negative where they overlap.
    pub gap: f64,
}

impl PrimitiveContact {
    fn of(primitives: [u32; 2], a: &MedialSurface, b: &MedialSurface) -> Self {
        let balls = b.primitive_balls(primitives[1]);
        let foot = pair_foot(&a.primitive_balls(primitives[0]), &balls);
        let on_b = Foot { weights: foot.weights_b, ball: foot.b, distance: foot.distance };
        Self {
            primitives,
            weights: [foot.weights_a, foot.weights_b],
            normal: normal(foot.a.center, &on_b, &balls, DVec3::ZERO),
            offset: foot.a.radius + foot.b.radius,
            gap: foot.distance,
        }
    }

    /// The particles with their weights β, as in [`Contact`](surface::Contact): those of the first
    /// medial surface (numbered from `particles.first_point`) sum to −1, those
    /// of the second (from `particles.first_ball`) to 1. At most six.
    #[must_use]
    pub fn terms(
        &self,
        a: &MedialSurface,
        b: &MedialSurface,
        particles: ParticleOffsets,
    ) -> Vec<Term> {
        let side = |medial: &MedialSurface, k: usize, first: u32, sign: f64| {
            let balls = medial.primitives()[self.primitives[k] as usize];
            let terms = balls.into_iter().zip(self.weights[k]).filter(|&(_, w)| w > 0.0);
            terms
                .map(|(ball, w)| Term { particle: ball + first, weight: sign * w })
                .collect::<Vec<_>>()
        };
        let mut terms = side(a, 0, particles.first_point, -1.0);
        terms.extend(side(b, 1, particles.first_ball, 1.0));
        terms
    }
}

/// Finds all pairs of primitives of two medial surfaces whose unions come within
/// `reach`: what balls against primitives miss where only insides of primitives
/// meet.
///
/// The gap of each pair is the exact least distance or deepest overlap. Pairs
/// stand in ascending order.
#[must_use]
pub fn primitive_contacts(
    a: (&MedialSurface, &PrimitiveTree),
    b: (&MedialSurface, &PrimitiveTree),
    reach: f64,
    workspace: &mut Workspace,
) -> (Vec<PrimitiveContact>, TestCounts) {
    let mut pairs = Vec::new();
    a.1.tree().pairs(b.1.tree(), reach, workspace, |i, j| pairs.push((i, j)));
    let bound_tests = workspace.counters().bound_tests;
    let mut found = Vec::new();
    let counts = primitive_contacts_among(&mut pairs, a.0, b.0, reach, &mut found);
    (found, TestCounts { bound_tests, ..counts })
}

/// As [`primitive_contacts`], among pairs of primitives that the caller found, and
/// with memory that is the caller's: `pairs` is sorted, and what `out` held is
/// lost. The bounds that were tested are not counted.
///
/// # Panics
///
/// When there is no such primitive.
pub fn primitive_contacts_among(
    pairs: &mut [(u32, u32)],
    a: &MedialSurface,
    b: &MedialSurface,
    reach: f64,
    out: &mut Vec<PrimitiveContact>,
) -> TestCounts {
    pairs.sort_unstable();
    out.clear();
    let mut sieve = SeparatingDirections::default();
    for &(i, j) in &*pairs {
        if sieve.parts(&a.primitive_balls(i), &b.primitive_balls(j), reach) {
            continue;
        }
        sieve.leaf_tests += 1;
        let contact = PrimitiveContact::of([i, j], a, b);
        if contact.gap <= reach {
            out.push(contact);
        }
    }
    TestCounts { bound_tests: 0, direction_tests: sieve.tests, leaf_tests: sieve.leaf_tests }
}
