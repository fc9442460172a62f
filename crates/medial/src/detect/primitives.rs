//! Contacts between the primitives of two medial surfaces.

use glam::DVec3;
use kdop::Workspace;
use surface::Term;

use super::contact::{ParticleOffsets, contact_normal};
use super::separation::SeparatingDirections;
use super::{MedialBounds, TestCounts};
use crate::{Foot, MedialSurface, pair_foot};

/// Two primitives within the margin of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveContact {
    /// Number of the primitive of the first medial surface, then of the second.
    pub primitives: [u32; 2],
    /// Weights of the balls of each.
    pub weights: [[f64; 3]; 2],
    /// Unit vector from the ball of the second to that of the first; where their centers coincide,
    /// a normal of the second.
    pub normal: DVec3,
    /// Sum of the radii.
    pub offset: f64,
    /// Distance of the two balls, negative where they overlap.
    pub gap: f64,
}

impl PrimitiveContact {
    fn new(primitives: [u32; 2], a: &MedialSurface, b: &MedialSurface) -> Self {
        let balls = b.primitive_balls(primitives[1]);
        let foot = pair_foot(&a.primitive_balls(primitives[0]), &balls);
        let on_b = Foot { weights: foot.weights_b, ball: foot.b, distance: foot.distance };
        Self {
            primitives,
            weights: [foot.weights_a, foot.weights_b],
            normal: contact_normal(foot.a.center, &on_b, &balls),
            offset: foot.a.radius + foot.b.radius,
            gap: foot.distance,
        }
    }

    /// Returns the particles with their weights β, as in [`Contact`](surface::Contact): at most
    /// six.
    ///
    /// Those of the first medial surface (numbered from `particles.first_point`) sum to −1, those
    /// of the second (from `particles.first_ball`) to 1.
    #[must_use]
    pub fn terms(
        &self,
        a: &MedialSurface,
        b: &MedialSurface,
        particles: ParticleOffsets,
    ) -> Vec<Term> {
        let mut terms = Vec::new();
        let firsts = [particles.first_point, particles.first_ball];
        for (side, (medial, sign)) in [(a, -1.0), (b, 1.0)].into_iter().enumerate() {
            let balls = medial.primitives()[self.primitives[side] as usize];
            for (ball, weight) in balls.into_iter().zip(self.weights[side]) {
                if weight > 0.0 {
                    terms.push(Term { particle: ball + firsts[side], weight: sign * weight });
                }
            }
        }
        terms
    }
}

/// Finds all pairs of primitives of two medial surfaces whose unions come within `margin`.
///
/// Balls against primitives do not find pairs of which only the insides meet; this does. The gap
/// of each pair is its exact distance or depth of overlap. Pairs are in ascending order.
#[must_use]
pub fn primitive_contacts(
    a: MedialBounds<'_>,
    b: MedialBounds<'_>,
    margin: f64,
    workspace: &mut Workspace,
) -> (Vec<PrimitiveContact>, TestCounts) {
    let mut pairs = Vec::new();
    a.tree.tree().pairs(b.tree.tree(), margin, workspace, |i, j| pairs.push([i, j]));
    let bound_tests = workspace.counters().bound_tests;

    let mut found = Vec::new();
    let counts = primitive_contacts_among(&mut pairs, a.medial, b.medial, margin, &mut found);
    (found, TestCounts { bound_tests, ..counts })
}

/// Finds contacts as [`primitive_contacts`] does, among pairs of primitives that the caller has
/// found, in reused memory.
///
/// `pairs` is sorted, and `out` is cleared first. Tests of bounds are not counted.
///
/// # Panics
///
/// When there is no such primitive.
pub fn primitive_contacts_among(
    pairs: &mut [[u32; 2]],
    a: &MedialSurface,
    b: &MedialSurface,
    margin: f64,
    out: &mut Vec<PrimitiveContact>,
) -> TestCounts {
    pairs.sort_unstable();
    out.clear();

    let mut directions = SeparatingDirections::default();
    for &[i, j] in &*pairs {
        if directions.are_separated(&a.primitive_balls(i), &b.primitive_balls(j), margin) {
            continue;
        }
        directions.counts.leaf_tests += 1;
        let contact = PrimitiveContact::new([i, j], a, b);
        if contact.gap <= margin {
            out.push(contact);
        }
    }
    directions.counts
}
