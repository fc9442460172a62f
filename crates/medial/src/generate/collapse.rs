//! Edge collapse: balls merge, the cheapest pair first, until only the requested number is left.
//!
//! Pairs that may merge are the surface's edges and, across the sheet, each vertex with one near the
//! other point that its ball touches: these close the two layers of the surface into one sheet. The
//! surface's triangles follow: each refers to the balls that its corners merged into, which makes it
//! a slab, a cone or nothing.
//!
//! Source: the quadrics and the collapse of J.-M. Thiery, É. Guy and T. Boubekeur, "Sphere-Meshes",
//! ACM TOG 32(6), 2013. Differs in the pairs across, and in the plane at the opposite point in each
//! quadric, which fixes the radius where the surface is flat.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use surface::TotalF64;
use surface::progress::{Interrupted, Progress};
use surface::triangle;

use super::connectivity::{merged, sheet_neighbors};
use super::quadric::Quadric;
use super::seeds::Seeds;
use super::shrink::MaximalBall;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialError, MedialSurface, index, real};

/// Weight of the distance from the vertex's own ball, relative to that of touching its planes.
///
/// Below, balls of flat regions drift; above, merged balls do not grow into the shape.
const STAY: f64 = 1e-3;

/// Number of merges between two polls of the progress handler: some milliseconds.
const MERGES_PER_POLL: usize = 256;

/// Pair of balls with the cost of merging them, ordered by the cost.
///
/// Its versions are outdated once another merge has changed one of the balls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MergeCandidate {
    cost: TotalF64,
    pair: [u32; 2],
    versions: [u32; 2],
}

/// Balls that merge, from one per seed down.
pub(super) struct Collapse<'a> {
    faces: &'a [[u32; 3]],
    /// Seed of each vertex.
    owners: Vec<u32>,
    /// Point that balls and quadrics are relative to.
    origin: DVec3,
    balls: Vec<Ball>,
    quadrics: Vec<Quadric>,
    neighbors: Vec<Vec<u32>>,
    versions: Vec<u32>,
    /// Ball that a seed's ball was merged into, itself while it is left.
    merged_into: Vec<u32>,
    heap: BinaryHeap<Reverse<MergeCandidate>>,
    remaining: usize,
}

impl<'a> Collapse<'a> {
    pub(super) fn new(
        distance: &SurfaceDistance<'a>,
        seeds: &Seeds,
        maximal: &[MaximalBall],
    ) -> Self {
        // Quadrics square coordinates: near the origin they keep their digits.
        let x = distance.x.as_slice();
        let origin = x.iter().sum::<DVec3>() / real(x.len());
        let own = |maximal: &MaximalBall| relative(maximal.ball, -origin);
        let balls: Vec<Ball> = maximal.iter().map(own).collect();

        let mut collapse = Self {
            faces: distance.surface.faces(),
            origin,
            quadrics: quadrics(distance, &seeds.owners, maximal, origin),
            neighbors: sheet_neighbors(distance, &seeds.owners, maximal),
            owners: seeds.owners.clone(),
            versions: vec![0; balls.len()],
            merged_into: (0..index(balls.len())).collect(),
            heap: BinaryHeap::new(),
            remaining: balls.len(),
            balls,
        };

        // Each pair once.
        for i in 0..collapse.balls.len() {
            for k in 0..collapse.neighbors[i].len() {
                let j = collapse.neighbors[i][k];
                if index(i) < j {
                    collapse.push_candidate(index(i), j);
                }
            }
        }
        collapse
    }

    /// Merges until `target` balls are left, or no pair is.
    pub(super) fn run(&mut self, target: usize, progress: Progress<'_>) -> Result<(), Interrupted> {
        let excess = self.remaining.saturating_sub(target);
        while self.remaining > target
            && let Some(Reverse(MergeCandidate { pair, versions, .. })) = self.heap.pop()
        {
            // One of the balls has merged since, and its pairs are in the heap again.
            if versions != self.versions_of(pair) {
                continue;
            }
            self.merge(pair);

            let merges = excess - (self.remaining - target);
            if merges.is_multiple_of(MERGES_PER_POLL) {
                progress.report(real(merges) / real(excess))?;
            }
        }
        Ok(())
    }

    /// Builds the medial surface of the balls that are left.
    pub(super) fn medial_surface(&self) -> Result<MedialSurface, MedialError> {
        let mut balls: Vec<Ball> = Vec::with_capacity(self.balls.len());
        let mut roots: Vec<u32> = Vec::with_capacity(self.balls.len());
        for (seed, &ball) in (0..).zip(&self.balls) {
            balls.push(relative(ball, self.origin));
            roots.push(self.root(seed));
        }
        let mut triples = Vec::with_capacity(self.faces.len());
        for corners in self.faces {
            triples.push(corners.map(|vertex| self.owners[vertex as usize]));
        }
        merged(&balls, &triples, &roots)
    }

    /// Returns the ball that a seed's ball has ended in.
    fn root(&self, mut seed: u32) -> u32 {
        while self.merged_into[seed as usize] != seed {
            seed = self.merged_into[seed as usize];
        }
        seed
    }

    fn versions_of(&self, pair: [u32; 2]) -> [u32; 2] {
        pair.map(|ball| self.versions[ball as usize])
    }

    fn push_candidate(&mut self, i: u32, j: u32) {
        let pair = [i.min(j), i.max(j)];
        let (quadric, ball) = self.merged_ball(pair);
        let cost = TotalF64(quadric.value(ball));
        let versions = self.versions_of(pair);
        self.heap.push(Reverse(MergeCandidate { cost, pair, versions }));
    }

    /// Computes the quadric and the ball that a pair merges to.
    fn merged_ball(&self, pair: [u32; 2]) -> (Quadric, Ball) {
        let [i, j] = pair.map(|ball| ball as usize);
        let quadric = self.quadrics[i].sum(&self.quadrics[j]);
        (quadric, quadric.minimum().unwrap_or(self.balls[i]))
    }

    /// Merges the second ball of a pair into the first.
    fn merge(&mut self, [i, j]: [u32; 2]) {
        // The new ball, which outdates the pairs of both.
        let (into, from) = (i as usize, j as usize);
        (self.quadrics[into], self.balls[into]) = self.merged_ball([i, j]);
        self.merged_into[from] = i;
        self.versions[into] += 1;
        self.versions[from] += 1;
        self.remaining -= 1;

        // The first ball takes the place of the second among its neighbors.
        let lost = std::mem::take(&mut self.neighbors[from]);
        for &k in &lost {
            let of_neighbor = &mut self.neighbors[k as usize];
            of_neighbor.retain(|&other| other != i && other != j);
            of_neighbor.push(i);
        }
        let mut kept = std::mem::take(&mut self.neighbors[into]);
        kept.extend(lost);
        kept.retain(|&k| k != i && k != j);
        kept.sort_unstable();
        kept.dedup();

        // Its pairs have new costs.
        for &k in &kept {
            self.push_candidate(i, k);
        }
        self.neighbors[into] = kept;
    }
}

/// Sums the quadrics of each ball: the planes of its faces, the plane at the opposite point, and the
/// distance from its own place.
fn quadrics(
    distance: &SurfaceDistance<'_>,
    owners: &[u32],
    maximal: &[MaximalBall],
    origin: DVec3,
) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); maximal.len()];
    let mut areas = vec![0.0; maximal.len()];
    for (face, vertices) in (0_u32..).zip(distance.surface.faces()) {
        let corners = distance.corners(face);
        let third = triangle::normal(corners).length() / 6.0;
        let normal = distance.normals.faces()[face as usize];
        let plane = Quadric::plane(corners[0] - origin, normal, third);
        for vertex in vertices {
            let owner = owners[*vertex as usize] as usize;
            quadrics[owner].add(&plane);
            areas[owner] += third;
        }
    }

    for ((quadric, maximal), area) in quadrics.iter_mut().zip(maximal).zip(areas) {
        quadric.add(&Quadric::plane(maximal.opposite - origin, maximal.opposite_normal, area));
        quadric.add(&Quadric::near(relative(maximal.ball, -origin), STAY * area));
    }
    quadrics
}

/// Returns a ball moved by a vector.
fn relative(ball: Ball, by: DVec3) -> Ball {
    Ball::new(ball.center + by, ball.radius)
}
