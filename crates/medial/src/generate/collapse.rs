//! Merging balls, cheapest first, until as few are left as asked for.
//!
//! Pairs to merge are the surface's edges and, across the sheet, each vertex
//! with one near the other point that its ball touches: these close the two
//! layers of the surface into one sheet. The surface's triangles go along: each
//! names the balls that its corners ended in, which makes it a slab, a cone or
//! nothing.
//!
//! Source: the quadrics and the collapse of J.-M. Thiery, É. Guy and
//! T. Boubekeur, "Sphere-Meshes", ACM TOG 32(6), 2013. Differs in the pairs
//! across, and in the plane at the opposite point in each quadric, which fixes
//! the radius where the surface is flat.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use glam::DVec3;

use super::quadric::Quadric;
use super::seeds::Seeds;
use super::shrink::MaximalBall;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialError, MedialSurface, index};

/// Weight of staying at the vertex's own ball, beside that of touching its
/// planes. Smaller lets balls of flat regions drift; larger keeps merged balls
/// from growing into the shape.
const STAY: f64 = 1e-3;

/// A pair of balls with the cost of merging them. Versions tell pairs that a
/// merge has since changed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    cost: f64,
    pair: [u32; 2],
    versions: [u32; 2],
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.cost
            .total_cmp(&other.cost)
            .then_with(|| self.pair.cmp(&other.pair))
            .then_with(|| self.versions.cmp(&other.versions))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Balls that merge, from one a seed down.
pub(super) struct Collapse<'a> {
    faces: &'a [[u32; 3]],
    /// Seed that stands for each vertex.
    owners: Vec<u32>,
    origin: DVec3,
    balls: Vec<Ball>,
    quadrics: Vec<Quadric>,
    neighbors: Vec<Vec<u32>>,
    versions: Vec<u32>,
    /// Ball that a seed's ball was merged into, itself while it lasts.
    merged_into: Vec<u32>,
    heap: BinaryHeap<Reverse<Candidate>>,
    remaining: usize,
}

impl<'a> Collapse<'a> {
    pub(super) fn new(
        distance: &SurfaceDistance<'a>,
        seeds: &Seeds,
        maximal: &[MaximalBall],
    ) -> Self {
        let owners = seeds.owners.clone();
        let count = maximal.len();
        // Quadrics square coordinates: near the origin they keep their digits.
        let x = distance.x.as_slice();
        let origin = x.iter().sum::<DVec3>() / crate::real(x.len());
        let mut collapse = Self {
            faces: distance.surface.faces(),
            origin,
            balls: maximal
                .iter()
                .map(|m| Ball::new(m.ball.center - origin, m.ball.radius))
                .collect(),
            quadrics: quadrics(distance, &owners, maximal, origin),
            neighbors: neighbors(distance, &owners, maximal),
            owners,
            versions: vec![0; count],
            merged_into: (0..index(count)).collect(),
            heap: BinaryHeap::new(),
            remaining: count,
        };
        for i in 0..index(count) {
            for k in 0..collapse.neighbors[i as usize].len() {
                let j = collapse.neighbors[i as usize][k];
                if i < j {
                    collapse.offer(i, j);
                }
            }
        }
        collapse
    }

    /// Merges until `target` balls are left, or no pair is.
    pub(super) fn run(&mut self, target: usize) {
        while self.remaining > target {
            let Some(Reverse(Candidate { pair: [i, j], versions, .. })) = self.heap.pop() else {
                break;
            };
            if versions == [i, j].map(|ball| self.versions[ball as usize]) {
                self.merge(i, j);
            }
        }
    }

    /// The medial surface of the balls that are left.
    pub(super) fn medial_surface(&self) -> Result<MedialSurface, MedialError> {
        let mut number = vec![u32::MAX; self.balls.len()];
        let mut balls = Vec::with_capacity(self.remaining);
        for (seed, &into) in self.merged_into.iter().enumerate() {
            if into as usize == seed {
                number[seed] = index(balls.len());
                let ball = self.balls[seed];
                balls.push(Ball::new(ball.center + self.origin, ball.radius));
            }
        }
        let final_ball: Vec<u32> =
            self.owners.iter().map(|&seed| number[self.root(seed) as usize]).collect();
        let (cones, slabs) = joints(self.faces, &final_ball);
        MedialSurface::new(balls, cones, slabs)
    }

    fn root(&self, mut seed: u32) -> u32 {
        while self.merged_into[seed as usize] != seed {
            seed = self.merged_into[seed as usize];
        }
        seed
    }

    fn offer(&mut self, i: u32, j: u32) {
        let pair = [i.min(j), i.max(j)];
        let (cost, _) = self.merged(pair);
        let versions = pair.map(|ball| self.versions[ball as usize]);
        self.heap.push(Reverse(Candidate { cost, pair, versions }));
    }

    /// Cost of merging a pair, and the ball it becomes.
    fn merged(&self, pair: [u32; 2]) -> (f64, Ball) {
        let [i, j] = pair.map(|ball| ball as usize);
        let quadric = self.quadrics[i].sum(&self.quadrics[j]);
        let ball = quadric.minimum().unwrap_or(self.balls[i]);
        (quadric.value(ball), ball)
    }

    fn merge(&mut self, i: u32, j: u32) {
        let (_, ball) = self.merged([i, j]);
        let (into, from) = (i as usize, j as usize);
        self.balls[into] = ball;
        self.quadrics[into] = self.quadrics[into].sum(&self.quadrics[from]);
        self.merged_into[from] = i;
        self.versions[into] += 1;
        self.versions[from] += 1;
        self.remaining -= 1;
        let lost = std::mem::take(&mut self.neighbors[from]);
        for &k in &lost {
            replace(&mut self.neighbors[k as usize], j, i);
        }
        let mut kept = std::mem::take(&mut self.neighbors[into]);
        kept.extend(lost);
        kept.retain(|&k| k != i && k != j);
        kept.sort_unstable();
        kept.dedup();
        for &k in &kept {
            self.offer(i, k);
        }
        self.neighbors[into] = kept;
    }
}

/// Puts `new` in the place of `old`, once.
fn replace(list: &mut Vec<u32>, old: u32, new: u32) {
    list.retain(|&k| k != old && k != new);
    list.push(new);
}

fn quadrics(
    distance: &SurfaceDistance<'_>,
    owners: &[u32],
    maximal: &[MaximalBall],
    origin: DVec3,
) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); maximal.len()];
    let mut areas = vec![0.0; maximal.len()];
    for (face, corners) in (0_u32..).zip(distance.surface.faces()) {
        let [a, b, c] = distance.corners(face);
        let third = (b - a).cross(c - a).length() / 6.0;
        let plane = Quadric::plane(a - origin, distance.normals.faces()[face as usize], third);
        for owner in corners.map(|corner| owners[corner as usize] as usize) {
            quadrics[owner].add(&plane);
            areas[owner] += third;
        }
    }
    for ((quadric, m), area) in quadrics.iter_mut().zip(maximal).zip(areas) {
        quadric.add(&Quadric::plane(m.opposite - origin, m.opposite_normal, area));
        let own = Ball::new(m.ball.center - origin, m.ball.radius);
        quadric.add(&Quadric::near(own, STAY * area));
    }
    quadrics
}

/// Neighbors along edges and across the sheet.
fn neighbors(
    distance: &SurfaceDistance<'_>,
    owners: &[u32],
    maximal: &[MaximalBall],
) -> Vec<Vec<u32>> {
    let mut neighbors = vec![Vec::new(); maximal.len()];
    let mut join = |i: u32, j: u32| {
        if i != j {
            neighbors[i as usize].push(j);
            neighbors[j as usize].push(i);
        }
    };
    for edge in distance.surface.edges() {
        let [i, j] = edge.map(|vertex| owners[vertex as usize]);
        join(i, j);
    }
    for (i, m) in (0_u32..).zip(maximal) {
        if let Some(face) = m.opposite_face {
            join(i, owners[nearest_corner(distance, face, m.opposite) as usize]);
        }
    }
    for list in &mut neighbors {
        list.sort_unstable();
        list.dedup();
    }
    neighbors
}

fn nearest_corner(distance: &SurfaceDistance<'_>, face: u32, p: DVec3) -> u32 {
    let [a, b, c] = distance.surface.faces()[face as usize];
    let [d_a, d_b, d_c] = distance.corners(face).map(|corner| corner.distance_squared(p));
    if d_a <= d_b && d_a <= d_c {
        a
    } else if d_b <= d_c {
        b
    } else {
        c
    }
}

/// The slabs and the other cones that faces become when their corners end in
/// `final_ball`.
pub(super) fn joints(faces: &[[u32; 3]], final_ball: &[u32]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    let mut slabs = BTreeSet::new();
    let mut edges = BTreeSet::new();
    for corners in faces {
        let mut balls = corners.map(|v| final_ball[v as usize]);
        balls.sort_unstable();
        let [a, b, c] = balls;
        match (a == b, b == c) {
            (false, false) => {
                slabs.insert([a, b, c]);
            }
            (true, true) => {}
            _ => {
                edges.insert([a, c]);
            }
        }
    }
    for &[a, b, c] in &slabs {
        for side in [[a, b], [b, c], [a, c]] {
            edges.remove(&side);
        }
    }
    (edges.into_iter().collect(), slabs.into_iter().collect())
}
