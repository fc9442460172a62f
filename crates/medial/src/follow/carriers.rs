//! Carriers of balls: combinations of surface vertices that reproduce a center at rest.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec3};
use surface::{Positions, Term};

use super::{Link, combine};
use crate::{Ball, MedialSurface, index};

/// Share of the spread of a ball's vertices that is added to their moments in every direction.
///
/// Without it, vertices in a plane leave the center's offset from them undetermined; a hundred times
/// larger, and affine motions are no longer followed to a thousandth.
const STIFFENING: f64 = 1e-5;

/// Maximum distance of a combination from the center of its ball at rest, in radii.
const MAX_MISPLACEMENT: f64 = 1e-3;

/// Maximum sum of the magnitudes of a ball's weights, by which noise of the vertices is multiplied.
///
/// Vertices on one side of a ball, nearly in a plane, define its center by differences that amount
/// to hundreds.
const MAX_AMPLIFICATION: f64 = 8.0;

/// Weight of vertices that touch a neighbor of a ball, relative to its own.
const NEIGHBOR_SHARE: f64 = 0.1;

/// Search for the carriers of the balls of a medial surface.
struct CarrierSearch<'a> {
    medial: &'a MedialSurface,
    x: Positions<'a>,
    /// Vertices that touch each ball, with its weights at their feet.
    touching: Vec<Vec<Term>>,
    /// Balls that share a primitive with each ball.
    neighbors: Vec<Vec<u32>>,
}

/// Combination of vertices for the center of a ball.
struct Carriers {
    terms: Vec<Term>,
    /// Misplacement or amplification in units of its maximum: acceptable up to 1.
    fault: f64,
}

/// Finds the carriers of each ball.
pub(super) fn find_carriers(
    medial: &MedialSurface,
    links: &[Link],
    x: Positions<'_>,
) -> Vec<Vec<Term>> {
    let mut touching = vec![Vec::new(); medial.balls().len()];
    for (vertex, link) in (0_u32..).zip(links) {
        let balls = medial.primitives()[link.primitive as usize];
        for (ball, weight) in balls.into_iter().zip(link.weights) {
            if weight > 0.0 {
                touching[ball as usize].push(Term { particle: vertex, weight });
            }
        }
    }

    let search = CarrierSearch { medial, x, touching, neighbors: neighbors(medial) };
    (0..index(medial.balls().len())).map(|ball| search.find(ball)).collect()
}

impl CarrierSearch<'_> {
    /// Finds the carriers of a ball among the vertices that touch it, those that touch its
    /// neighbors, and so on, until they define the center.
    fn find(&self, ball: u32) -> Vec<Term> {
        let (mut ring, mut reached) = (vec![ball], BTreeSet::from([ball]));
        let mut vertices: BTreeMap<u32, f64> = BTreeMap::new();
        let mut share = 1.0;
        let mut best = Carriers { terms: Vec::new(), fault: f64::INFINITY };
        while best.fault > 1.0 && !ring.is_empty() {
            // Vertices nearer to the ball count for more.
            for &ball in &ring {
                for term in &self.touching[ball as usize] {
                    vertices.entry(term.particle).or_insert(share * term.weight);
                }
            }
            if let Some(found) = self.combine_for(self.medial.balls()[ball as usize], &vertices)
                && (best.terms.is_empty() || found.fault < best.fault)
            {
                best = found;
            }

            // The next ring of neighbors.
            let mut next = Vec::new();
            for &other in ring.iter().flat_map(|&ball| &self.neighbors[ball as usize]) {
                if reached.insert(other) {
                    next.push(other);
                }
            }
            ring = next;
            share *= NEIGHBOR_SHARE;
        }
        best.terms
    }

    /// Combines vertices to the center of a ball; `None` where they do not define it.
    fn combine_for(&self, ball: Ball, vertices: &BTreeMap<u32, f64>) -> Option<Carriers> {
        let weighted = vertices.iter().map(|(&particle, &weight)| Term { particle, weight });
        let terms = combination(ball.center, &weighted.collect::<Vec<_>>(), self.x);
        let unit = (MAX_MISPLACEMENT * ball.radius).max(f64::MIN_POSITIVE);
        let misplacement = combine(&terms, self.x).distance(ball.center) / unit;
        let amplification: f64 = terms.iter().map(|term| term.weight.abs()).sum();

        // Vertices that nearly coincide have weights that are not numbers.
        let is_defined = amplification.is_finite() && !terms.is_empty();
        let fault = misplacement.max(amplification / MAX_AMPLIFICATION);
        is_defined.then_some(Carriers { terms, fault })
    }
}

/// Finds the balls that share a primitive with each ball.
fn neighbors(medial: &MedialSurface) -> Vec<Vec<u32>> {
    let mut neighbors = vec![Vec::new(); medial.balls().len()];
    for &[a, b, c] in medial.primitives() {
        for [from, to] in [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]] {
            if from != to {
                neighbors[from as usize].push(to);
            }
        }
    }
    for of_ball in &mut neighbors {
        of_ball.sort_unstable();
        of_ball.dedup();
    }
    neighbors
}

/// Computes weights of vertices that reproduce `center` from their positions at rest, and its image
/// under every affine map of them: those of the weighted mean, with the smallest change that moves
/// it to the center.
fn combination(center: DVec3, touching: &[Term], x: Positions<'_>) -> Vec<Term> {
    let total: f64 = touching.iter().map(|term| term.weight).sum();
    if total <= 0.0 {
        return Vec::new();
    }

    // Weighted mean and second moments.
    let mean = combine(touching, x) / total;
    let mut moments = DMat3::ZERO;
    for term in touching {
        let d = x.at(term.particle) - mean;
        let column = |along: f64| term.weight / total * along * d;
        moments += DMat3::from_cols(column(d.x), column(d.y), column(d.z));
    }

    // A linear change of the weights that moves the mean to the center.
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    let stiffened = moments + DMat3::from_diagonal(DVec3::splat(STIFFENING * trace));
    let slope = if trace > 0.0 { stiffened.inverse() * (center - mean) } else { DVec3::ZERO };
    let mut terms = touching.to_vec();
    for term in &mut terms {
        let tilt = 1.0 + slope.dot(x.at(term.particle) - mean);
        term.weight = term.weight / total * tilt;
    }
    terms
}
