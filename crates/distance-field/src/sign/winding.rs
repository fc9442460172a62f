//! Generalized winding number above one half, at every node.
//!
//! Closed by the caps of its [`Chain`], the surface encloses a node a whole number of times,
//! which one count of crossings along each row gives for all its nodes. The winding number of
//! the surface is that number less the contribution of the caps, their solid angle over 4π.
//! This falls off with the square of the distance: far from any hole it is less than one
//! half, and the whole number alone decides. Only in the few blocks of nodes where a bound on
//! it exceeds that are solid angles summed, largest bound first, until the rest cannot
//! matter.
//!
//! So a closed surface costs its crossings, whatever it does to itself; holes, reversed and
//! repeated faces cost as much as their surroundings.
//!
//! Source: A. Jacobson, L. Kavan and O. Sorkine-Hornung, "Robust inside-outside segmentation
//! using generalized winding numbers", ACM TOG 32(4), 2013; C. Martens and M. Bessmeltsev,
//! "One-shot method for computing generalized winding numbers", 2024 (arXiv 2408.04466), for
//! the one ray and the boundary; A. van Oosterom and J. Strackee, "The solid angle of a plane
//! triangle", IEEE Trans. Biomed. Eng. 30(2), 1983.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use robust::{Coord3D, orient3d};
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, Positions, TriangleSurface, parallel, triangle};

use super::chain::{Cap, Chain};
use super::crossings::{Crossing, cross};
use crate::memory::zeroed;
use crate::{FieldError, FieldGrid};

/// Nodes along each side of the blocks in which solid angles are summed.
///
/// Larger blocks sum them where nothing is in doubt; smaller ones cost more to find than they
/// save.
const BLOCK: usize = 4;

/// Faces per task of a search for crossings.
const TASK: usize = 4096;

/// Rounding of a winding number: a number that is nearer to one half counts as outside. Some
/// thousand solid angles, each right to 1e-15.
const ROUNDING: f64 = 1e-12;

/// Inside by winding number, with what it reveals of the surface.
#[derive(Debug)]
pub(crate) struct Winding {
    /// Per node, true if the surface encloses it.
    pub(crate) inside: Vec<bool>,
    /// True if the surface encloses a negative volume and was reversed.
    pub(crate) is_inverted: bool,
    /// Number of boundary edges.
    pub(crate) boundary_edges: usize,
}

/// Computes which nodes a surface encloses.
pub(crate) fn winding(
    surface: &TriangleSurface,
    x: Positions<'_>,
    grid: &FieldGrid,
    progress: Progress<'_>,
) -> Result<Winding, FieldError> {
    let chain = Chain::new(surface, x);
    let caps = chain.caps(x);
    let is_inverted = volume(surface, x, &caps) < 0.0;
    let crossings = crossings(surface, x, grid, &caps, progress.part(0.0, 0.5))?;
    let enclosure = Enclosure { grid, crossings: &crossings, caps: &caps, is_inverted };

    // Rows decide for surface and caps together, and are mended near the caps.
    let mut inside = zeroed(grid.node_count())?;
    enclosure.fill_rows(&mut inside);
    for node in enclosure.exceptions(progress.part(0.5, 1.0))? {
        inside[node] = !inside[node];
    }
    Ok(Winding { inside, is_inverted, boundary_edges: chain.len() })
}

/// Volume that a surface and its caps enclose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Enclosed {
    /// The volume, negative where the surface faces inward.
    pub(crate) volume: f64,
    /// Number of boundary edges.
    pub(crate) boundary_edges: usize,
}

/// Computes the volume that a surface and its caps enclose.
pub(crate) fn enclosed(surface: &TriangleSurface, x: Positions<'_>) -> Enclosed {
    let chain = Chain::new(surface, x);
    let volume = volume(surface, x, &chain.caps(x));
    Enclosed { volume, boundary_edges: chain.len() }
}

fn volume(surface: &TriangleSurface, x: Positions<'_>, caps: &[Cap]) -> f64 {
    // About the center, the cones over the triangles lose the fewest digits.
    let center = Aabb::of_points(x.as_slice().iter().copied()).center();
    let mut six_volumes = 0.0;
    for &face in surface.faces() {
        six_volumes += triangle::triple_product(x.corners(face), center);
    }
    for cap in caps {
        // The center itself takes part for a sheet: an apex beside it would decide its orientation.
        for &([b, a, _], times) in &cap.triangles {
            let corners = [b, a, cap.center];
            six_volumes += f64::from(times) * triangle::triple_product(corners, center);
        }
    }
    six_volumes / 6.0
}

/// Finds the crossings of all rows with a surface and its caps, sorted by row and node.
fn crossings(
    surface: &TriangleSurface,
    x: Positions<'_>,
    grid: &FieldGrid,
    caps: &[Cap],
    progress: Progress<'_>,
) -> Result<Vec<Crossing>, Interrupted> {
    let tasks: Vec<&[[u32; 3]]> = surface.faces().chunks(TASK).collect();
    let steps = progress.steps(tasks.len());
    let found = parallel::map(tasks.len(), |task| {
        steps.advance(1)?;
        let mut crossings = Vec::new();
        for &face in tasks[task] {
            cross(grid, x.corners(face), 1, &mut crossings);
        }
        Ok(crossings)
    });

    // Sorted as a whole, they do not depend on the order of the faces.
    let mut crossings = found.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
    for cap in caps {
        for &(corners, times) in &cap.triangles {
            cross(grid, corners, times, &mut crossings);
        }
    }
    parallel::sort_unstable(&mut crossings);
    Ok(crossings)
}

/// Number of times that a surface with caps encloses each node.
struct Enclosure<'a> {
    grid: &'a FieldGrid,
    crossings: &'a [Crossing],
    caps: &'a [Cap],
    is_inverted: bool,
}

/// Block of nodes, a range per axis.
type Block = [Range<usize>; 3];

/// Cap with a bound on its contribution to a winding number.
#[derive(Clone, Copy)]
struct BoundedCap<'a> {
    cap: &'a Cap,
    bound: f64,
    /// Sum of the bounds of this cap and all after it.
    remaining: f64,
}

impl Enclosure<'_> {
    /// Marks the nodes that surface and caps enclose.
    fn fill_rows(&self, inside: &mut [bool]) {
        let [nx, ny, _] = self.grid.dims();
        for (r, row) in inside.chunks_mut(nx).enumerate() {
            // Between two crossings all nodes are on one side.
            let (mut count, mut from) = (0, 0);
            for crossing in self.row(r % ny, r / ny) {
                if self.encloses(count) {
                    row[from..crossing.node].fill(true);
                }
                count += crossing.turn;
                from = crossing.node;
            }
            if self.encloses(count) {
                row[from..].fill(true);
            }
        }
    }

    /// Returns the crossings of a row, ascending.
    fn row(&self, j: usize, k: usize) -> &[Crossing] {
        let row = j + self.grid.dims()[1] * k;
        let first = self.crossings.partition_point(|crossing| crossing.row < row);
        let rest = &self.crossings[first..];
        let count = rest.iter().take_while(|crossing| crossing.row == row).count();
        &rest[..count]
    }

    fn encloses(&self, count: i32) -> bool {
        if self.is_inverted { count < 0 } else { count > 0 }
    }

    /// Finds the nodes that the caps move to the other side.
    fn exceptions(&self, progress: Progress<'_>) -> Result<Vec<usize>, Interrupted> {
        if self.caps.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = Vec::new();
        self.doubtful(&self.grid.dims().map(|n| 0..n), progress, &mut blocks)?;

        let steps = progress.steps(blocks.len());
        let found = parallel::map(blocks.len(), |b| {
            steps.advance(1)?;
            Ok(self.exceptions_in(&blocks[b]))
        });
        Ok(found.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// Finds the blocks in which the caps may contribute one half or more.
    fn doubtful(
        &self,
        block: &Block,
        progress: Progress<'_>,
        blocks: &mut Vec<Block>,
    ) -> Result<(), Interrupted> {
        progress.report(0.0)?;

        // Less than one half leaves every node on the side that its count says.
        let (center, radius) = self.ball(block);
        let mut contribution = 0.0;
        for cap in self.caps {
            contribution += bound(cap, center, radius);
        }
        if contribution < 0.5 - ROUNDING {
            return Ok(());
        }

        if block.iter().all(|side| side.len() <= BLOCK) {
            blocks.push(block.clone());
            return Ok(());
        }
        for half in halves(block) {
            self.doubtful(&half, progress, blocks)?;
        }
        Ok(())
    }

    /// Returns the center and the radius of a ball around a block.
    fn ball(&self, [i, j, k]: &Block) -> (DVec3, f64) {
        let first = self.grid.position([i.start, j.start, k.start]);
        let last = self.grid.position([i.end - 1, j.end - 1, k.end - 1]);
        // A little more than half the diagonal, for rounding.
        (0.5 * (first + last), first.distance(last) * (0.5 + 1e-9))
    }

    /// Finds the nodes of a block that the caps move to the other side.
    fn exceptions_in(&self, block: &Block) -> Vec<usize> {
        let caps = self.bounded_caps(block);
        let [columns, rows, planes] = block;
        let mut exceptions = Vec::new();
        for k in planes.clone() {
            for j in rows.clone() {
                let row = self.row(j, k);
                for i in columns.clone() {
                    let (node, count) = ([i, j, k], count_at(row, i));
                    let is_inside = self.surface_encloses(count, self.grid.position(node), &caps);
                    if is_inside != self.encloses(count) {
                        exceptions.push(self.grid.index(node));
                    }
                }
            }
        }
        exceptions
    }

    /// Returns the caps with their bounds in a block, largest bound first.
    fn bounded_caps(&self, block: &Block) -> Vec<BoundedCap<'_>> {
        let (center, radius) = self.ball(block);
        let mut caps = Vec::with_capacity(self.caps.len());
        for cap in self.caps {
            caps.push(BoundedCap { cap, bound: bound(cap, center, radius), remaining: 0.0 });
        }
        caps.sort_by(|a, b| b.bound.total_cmp(&a.bound));

        let mut remaining = 0.0;
        for cap in caps.iter_mut().rev() {
            remaining += cap.bound;
            cap.remaining = remaining;
        }
        caps
    }

    /// Returns true if the winding number of the surface alone exceeds one half, given the
    /// count of surface and caps.
    fn surface_encloses(&self, count: i32, p: DVec3, caps: &[BoundedCap<'_>]) -> bool {
        let sign = if self.is_inverted { -1.0 } else { 1.0 };
        let mut winding = f64::from(count);
        for BoundedCap { cap, remaining, .. } in caps {
            // Once the rest cannot move the number across one half, it is decided.
            if (sign * winding - 0.5).abs() > remaining + ROUNDING {
                break;
            }
            let mut angles = 0.0;
            for &(corners, times) in &cap.triangles {
                angles += f64::from(times) * angle_fraction(p, corners);
            }
            winding -= angles;
        }
        sign * winding > 0.5 + ROUNDING
    }
}

/// Counts how often surface and caps enclose a node, given the crossings of its row.
fn count_at(row: &[Crossing], node: usize) -> i32 {
    let mut count = 0;
    for crossing in row.iter().take_while(|crossing| crossing.node <= node) {
        count += crossing.turn;
    }
    count
}

/// Bounds the contribution of a cap within a ball: a solid angle is at most the area over the
/// square of the distance, and a triangle fills at most half of all directions.
fn bound(cap: &Cap, center: DVec3, radius: f64) -> f64 {
    let max = 0.5 * cap.multiplicity();
    let distance = cap.center.distance(center) - cap.radius - radius;
    if distance <= 0.0 {
        return max;
    }
    max.min(cap.area / (4.0 * PI * distance * distance))
}

/// Halves a block along every axis along which it is too long.
fn halves(block: &Block) -> Vec<Block> {
    let mut parts = vec![block.clone()];
    for axis in 0..3 {
        if block[axis].len() > BLOCK {
            // Each part so far becomes a lower and an upper one.
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

/// Computes the solid angle of a triangle at `p`, over 4π, positive from below.
///
/// The side is decided exactly, as the crossings decide it, so that count and contribution
/// change together.
fn angle_fraction(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let is_below = is_below(p, [a, b, c]);
    let [u, v, w] = [a - p, b - p, c - p];
    let [x, y, z] = [u.length(), v.length(), w.length()];
    let triple = u.dot(v.cross(w)).abs();
    let cosines = x * y * z + u.dot(v) * z + v.dot(w) * x + w.dot(u) * y;
    let fraction = triple.atan2(cosines) / (2.0 * PI);
    if is_below { fraction } else { -fraction }
}

fn is_below(p: DVec3, corners: [DVec3; 3]) -> bool {
    // Positive below the triangle, from where its corners turn right.
    let [a, b, c, p] =
        [corners[0], corners[1], corners[2], p].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    let side = orient3d(a, b, c, p);
    if side != 0.0 {
        return side > 0.0;
    }

    // On its plane, the node is taken to be shifted along x, less along y, and least along
    // z; below is where the normal does not point.
    let normal = triangle::normal(corners).to_array();
    normal.into_iter().find(|n| *n != 0.0).is_some_and(|n| n < 0.0)
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    #[test]
    fn the_bound_of_a_cap_holds_its_solid_angle() {
        let mut random = Random(5);
        let mut point =
            |size: f64| size * DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
        let mut least_excess = f64::INFINITY;
        for _ in 0..2000 {
            let corners = [point(0.1), point(0.1), point(0.1)];
            let radius = corners.map(DVec3::length).into_iter().fold(0.0, f64::max);
            let area = 2.0 * triangle::area(corners);
            let cap = Cap { triangles: vec![(corners, 2)], center: DVec3::ZERO, radius, area };

            // About any block that holds the point.
            let (p, center) = (point(20.0), point(0.1));
            let contribution = 2.0 * angle_fraction(p, corners).abs();
            assert!(contribution <= bound(&cap, p, 0.0) + ROUNDING, "{corners:?} at {p}");
            let around = bound(&cap, p + center, center.length());
            assert!(contribution <= around + ROUNDING, "{corners:?} at {p}");
            least_excess = least_excess.min(bound(&cap, p, 0.0) / contribution);
        }
        assert!(least_excess < 1.1, "{least_excess}: some are seen at right angles from afar");
    }
}
