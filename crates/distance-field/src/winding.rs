//! Generalized winding number above one half, at every node.
//!
//! Closed by the caps of its [`Chain`], the surface encloses a node a whole
//! number of times, which one count of crossings along each row gives for all
//! its nodes. The winding number of the surface is that number less what the
//! caps contribute, their solid angle over 4π. This falls off with the square
//! of the distance: far from any hole it is less than one half, and the whole
//! number alone decides. Only in the few blocks of nodes where a bound on it
//! does not say so are solid angles summed, nearest cap first, until what is
//! left cannot matter.
//!
//! So a closed surface costs its crossings, whatever it does to itself; holes,
//! flipped and repeated faces cost what their surroundings do.
//!
//! Sources: A. Jacobson, L. Kavan and O. Sorkine-Hornung, "Robust inside-outside
//! segmentation using generalized winding numbers", ACM TOG 32(4), 2013;
//! C. Martens and M. Bessmeltsev, "One-shot method for computing generalized
//! winding numbers", 2024 (arXiv 2408.04466), for the one ray and the boundary;
//! A. van Oosterom and J. Strackee, "The solid angle of a plane triangle", IEEE
//! Trans. Biomed. Eng. 30(2), 1983.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use surface::{Positions, TriangleSurface};

use crate::chain::{Cap, Chain};
use crate::crossings::{self, Crossing, by_row, cross, side};
use crate::grid::{FieldGrid, bounds};
use crate::inside::Inside;
use crate::par;

/// Nodes along each side of the blocks in which solid angles are summed.
///
/// Larger blocks sum them where nothing is in doubt; smaller ones cost more to
/// find than they save.
const BLOCK: usize = 4;

/// Faces that are searched for crossings at a time.
const BATCH: usize = 4096;

/// Rounding of a winding number: what is nearer to one half than this counts as
/// outside. Some thousand solid angles, each right to 1e-15.
const ROUNDING: f64 = 1e-12;

/// Inside by winding number, and what was found on the way.
#[derive(Debug)]
pub(crate) struct Winding {
    pub(crate) inside: Inside,
    /// Whether the surface encloses a negative volume, and was turned around.
    pub(crate) inverted: bool,
    /// Edges of its boundary.
    pub(crate) chain: usize,
}

pub(crate) fn winding(surface: &TriangleSurface, x: Positions<'_>, grid: &FieldGrid) -> Winding {
    let chain = Chain::new(surface, x);
    let caps = chain.caps(x);
    let inverted = volume(surface, x, &caps) < 0.0;
    let crossings = all_crossings(surface, x, grid, &caps);
    let count = Count { grid, crossings: &crossings, caps: &caps, inverted };
    let inside = count.inside();
    Winding { inside, inverted, chain: chain.len() }
}

/// Volume that a surface and its caps enclose; negative when it is inside out.
pub(crate) fn enclosed_volume(surface: &TriangleSurface, x: Positions<'_>) -> f64 {
    volume(surface, x, &Chain::new(surface, x).caps(x))
}

fn volume(surface: &TriangleSurface, x: Positions<'_>, caps: &[Cap]) -> f64 {
    let (lo, hi) = bounds(x.as_slice());
    let faces = surface.faces().iter().map(|&face| (x.corners(face), 1));
    let covers = caps.iter().flat_map(|cap| cap.triangles.iter().copied());
    signed_volume(faces.chain(covers), 0.5 * (lo + hi))
}

/// Volume enclosed by triangles, each counted `times`, about `center`.
fn signed_volume(triangles: impl Iterator<Item = ([DVec3; 3], i32)>, center: DVec3) -> f64 {
    let six_fold = |([a, b, c], times): ([DVec3; 3], i32)| {
        f64::from(times) * (a - center).dot((b - center).cross(c - center))
    };
    triangles.map(six_fold).sum::<f64>() / 6.0
}

/// Crossings of the faces alone, sorted.
pub(crate) fn face_crossings(
    surface: &TriangleSurface,
    x: Positions<'_>,
    grid: &FieldGrid,
) -> Vec<Crossing> {
    let batches: Vec<&[[u32; 3]]> = surface.faces().chunks(BATCH).collect();
    let found = par::map(batches.len(), |b| {
        let mut out = Vec::new();
        for &face in batches[b] {
            cross(grid, x.corners(face), 1, &mut out);
        }
        out
    });
    crossings::sorted(found.concat())
}

fn all_crossings(
    surface: &TriangleSurface,
    x: Positions<'_>,
    grid: &FieldGrid,
    caps: &[Cap],
) -> Vec<Crossing> {
    let mut all = face_crossings(surface, x, grid);
    for (triangle, times) in caps.iter().flat_map(|cap| &cap.triangles) {
        cross(grid, *triangle, *times, &mut all);
    }
    crossings::sorted(all)
}

/// A whole number a node, and the caps that take some of it away.
struct Count<'a> {
    grid: &'a FieldGrid,
    crossings: &'a [Crossing],
    caps: &'a [Cap],
    inverted: bool,
}

/// Nodes from the first up to, not including, the second.
type Block = [Range<usize>; 3];

impl Count<'_> {
    fn inside(&self) -> Inside {
        let [_, ny, nz] = self.grid.dims();
        let rows = by_row(self.crossings, ny * nz).map(|row| self.turns(row));
        Inside::from_rows(rows, self.exceptions())
    }

    /// Nodes at which a row's count passes between outside and inside.
    fn turns(&self, row: &[Crossing]) -> Vec<usize> {
        let mut turns = Vec::new();
        let (mut count, mut was_inside) = (0, false);
        for here in row.chunk_by(|a, b| a.node == b.node) {
            count += here.iter().map(|crossing| crossing.turn).sum::<i32>();
            if self.encloses(count) != was_inside {
                was_inside = !was_inside;
                turns.push(here[0].node);
            }
        }
        turns
    }

    fn encloses(&self, count: i32) -> bool {
        if self.inverted { count < 0 } else { count > 0 }
    }

    /// Nodes that the caps move to the other side, ascending.
    fn exceptions(&self) -> Vec<usize> {
        if self.caps.is_empty() {
            return Vec::new();
        }
        let mut blocks = Vec::new();
        let [nx, ny, nz] = self.grid.dims();
        self.doubtful(&[0..nx, 0..ny, 0..nz], &mut blocks);
        let found = par::map(blocks.len(), |b| self.exceptions_in(&blocks[b]));
        let mut exceptions = found.concat();
        exceptions.sort_unstable();
        exceptions
    }

    /// The blocks in which the caps may contribute one half or more.
    fn doubtful(&self, block: &Block, out: &mut Vec<Block>) {
        let (center, radius) = self.ball(block);
        let contribution: f64 = self.caps.iter().map(|cap| bound(cap, center, radius)).sum();
        if contribution < 0.5 - ROUNDING {
            return;
        }
        if block.iter().all(|side| side.len() <= BLOCK) {
            out.push(block.clone());
            return;
        }
        for part in halves(block) {
            self.doubtful(&part, out);
        }
    }

    fn ball(&self, [i, j, k]: &Block) -> (DVec3, f64) {
        let first = self.grid.position([i.start, j.start, k.start]);
        let last = self.grid.position([i.end - 1, j.end - 1, k.end - 1]);
        // A little more than half the diagonal, for rounding.
        (0.5 * (first + last), first.distance(last) * (0.5 + 1e-9))
    }

    fn exceptions_in(&self, block: &Block) -> Vec<usize> {
        let (center, radius) = self.ball(block);
        let mut near: Vec<(f64, &Cap)> =
            self.caps.iter().map(|cap| (bound(cap, center, radius), cap)).collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut rest: Vec<f64> = Vec::with_capacity(near.len());
        let mut sum = 0.0;
        for (bound, _) in near.iter().rev() {
            sum += bound;
            rest.push(sum);
        }
        rest.reverse();
        let mut exceptions = Vec::new();
        let [i, j, k] = block;
        for (j, k) in k.clone().flat_map(|k| j.clone().map(move |j| (j, k))) {
            for (i, count) in i.clone().zip(self.counts(i.clone(), j, k)) {
                let node = [i, j, k];
                let p = self.grid.position(node);
                if self.encloses_less(count, p, &near, &rest) != self.encloses(count) {
                    exceptions.push(self.grid.index(node));
                }
            }
        }
        exceptions
    }

    /// The whole numbers of some nodes of a row.
    fn counts(&self, nodes: Range<usize>, j: usize, k: usize) -> impl Iterator<Item = i32> {
        let row = j + self.grid.dims()[1] * k;
        let first = self.crossings.partition_point(|crossing| crossing.row < row);
        let row = self.crossings[first..].iter().take_while(move |crossing| crossing.row == row);
        nodes.map(move |node| {
            row.clone().take_while(|crossing| crossing.node <= node).map(|c| c.turn).sum()
        })
    }

    /// Whether the count less the caps' contribution passes one half.
    fn encloses_less(&self, count: i32, p: DVec3, near: &[(f64, &Cap)], rest: &[f64]) -> bool {
        let mut winding = f64::from(count);
        let way = if self.inverted { -1.0 } else { 1.0 };
        for ((_, cap), rest) in near.iter().zip(rest) {
            if (way * winding - 0.5).abs() > rest + ROUNDING {
                break;
            }
            winding -= cap.triangles.iter().map(|&(t, n)| f64::from(n) * share(p, t)).sum::<f64>();
        }
        way * winding > 0.5 + ROUNDING
    }
}

/// Most that a cap can contribute within a ball: a solid angle is at most the
/// area over the square of the distance, and a triangle fills at most half.
fn bound(cap: &Cap, center: DVec3, radius: f64) -> f64 {
    let most = 0.5 * cap.multiplicity();
    let distance = cap.center.distance(center) - cap.radius - radius;
    if distance <= 0.0 {
        return most;
    }
    most.min(cap.area / (4.0 * PI * distance * distance))
}

fn halves(block: &Block) -> Vec<Block> {
    let mut parts = vec![block.clone()];
    for axis in 0..3 {
        if block[axis].len() > BLOCK {
            let middle = block[axis].start + block[axis].len() / 2;
            let mut upper = parts.clone();
            for (lower, upper) in parts.iter_mut().zip(&mut upper) {
                lower[axis].end = middle;
                upper[axis].start = middle;
            }
            parts.extend(upper);
        }
    }
    parts
}

/// Solid angle of a triangle seen from `p`, over 4π, positive from below.
///
/// The side is decided exactly, and as the crossings decide it, so that count
/// and contribution change together.
pub(crate) fn share(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let is_below = below(p, [a, b, c]);
    let [u, v, w] = [a - p, b - p, c - p];
    let [x, y, z] = [u.length(), v.length(), w.length()];
    let triple = u.dot(v.cross(w)).abs();
    let cosines = x * y * z + u.dot(v) * z + v.dot(w) * x + w.dot(u) * y;
    let share = triple.atan2(cosines) / (2.0 * PI);
    if is_below { share } else { -share }
}

fn below(p: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let side = side(p, [a, b, c]);
    if side != 0.0 {
        return side > 0.0;
    }
    // On its plane, the node is thought to be shifted along x, less along y,
    // and least along z; below is where the normal does not point.
    let normal = (b - a).cross(c - a).to_array();
    normal.into_iter().find(|n| *n != 0.0).is_some_and(|n| n < 0.0)
}
