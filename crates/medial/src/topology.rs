//! Parts, tunnels and cavities of a union of balls, counted on a grid.
//!
//! The connectivity of the primitives says little about the volume: slabs that
//! lie in each other leave pockets in the complex that are none in the union.
//! So the union itself is sampled at grid points, which are joined along the
//! axes; the Euler number of the squares and cubes between them, its parts and
//! those of the outside give the rest.
//!
//! Necks, gaps and holes narrower than a grid cell are not told from what they
//! are on the grid.

use glam::DVec3;
use surface::{Positions, TriangleSurface, inspect};

use crate::{FootRule, MedialError, MedialSurface};

/// What a volume is made of, up to bending and stretching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Topology {
    /// Connected parts.
    pub components: usize,
    /// Independent ways to pass through: one for a ring.
    pub tunnels: i64,
    /// Enclosed spaces that are outside.
    pub cavities: usize,
}

/// Grid points at most: a bit of memory each, and seconds of work.
const MAX_POINTS: usize = 1 << 28;

impl Topology {
    /// The topology of a medial surface's union of balls, on a grid with this
    /// `spacing`.
    ///
    /// # Errors
    ///
    /// - [`MedialError::Parameter`] for a spacing that is not positive and finite.
    /// - [`MedialError::TooMany`] before anything is allocated, for a spacing
    ///   that is too fine for the size.
    pub fn of_union(medial: &MedialSurface, spacing: f64) -> Result<Self, MedialError> {
        if !spacing.is_finite() || spacing <= 0.0 {
            let range = "positive and finite";
            return Err(MedialError::Parameter { name: "spacing", value: spacing, range });
        }
        let mut grid = Grid::around(medial.bounds(), spacing)?;
        for (primitive, _) in (0_u32..).zip(medial.primitives()) {
            grid.fill(medial, primitive);
        }
        Ok(grid.topology())
    }

    /// The topology of the volume inside a closed manifold surface whose parts
    /// do not lie in each other.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] for a surface that is open or not manifold.
    pub fn of_inside(surface: &TriangleSurface, x: Positions<'_>) -> Result<Self, MedialError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        let inspection = inspect(surface, x);
        let components = inspection.components;
        let tunnels = signed(components) - inspection.euler / 2;
        Ok(Self { components, tunnels, cavities: 0 })
    }
}

/// Grid points around a box, the outermost layer free.
struct Grid {
    origin: DVec3,
    spacing: f64,
    size: [usize; 3],
    inside: Vec<bool>,
}

impl Grid {
    fn around([low, high]: [DVec3; 2], spacing: f64) -> Result<Self, MedialError> {
        let cells = ((high - low) / spacing).ceil() + 3.0;
        let points = cells.x * cells.y * cells.z;
        if points > crate::real(MAX_POINTS) {
            let (what, count) = ("grid points", whole(points));
            return Err(MedialError::TooMany { what, count, limit: MAX_POINTS });
        }
        let size = cells.to_array().map(whole);
        let inside = vec![false; size[0] * size[1] * size[2]];
        Ok(Self { origin: low - spacing, spacing, size, inside })
    }

    fn place(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    fn fill(&mut self, medial: &MedialSurface, primitive: u32) {
        let balls = medial.primitive_balls(primitive);
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = balls.iter().fold(empty, |(low, high), ball| {
            (low.min(ball.center - ball.radius), high.max(ball.center + ball.radius))
        });
        let cell = |p: DVec3| (p - self.origin) / self.spacing;
        let from = cell(low).ceil().to_array().map(whole);
        let to = cell(high).floor().to_array().map(whole);
        for k in from[2]..=to[2] {
            for j in from[1]..=to[1] {
                for i in from[0]..=to[0] {
                    let place = self.place([i, j, k]);
                    let p = self.origin + self.spacing * DVec3::from([i, j, k].map(crate::real));
                    self.inside[place] = self.inside[place]
                        || medial.foot(p, primitive, FootRule::Exact).distance <= 0.0;
                }
            }
        }
    }

    /// With grid points joined along the axes inside, and across corners as well
    /// outside: what keeps the Euler numbers of both consistent.
    fn topology(&self) -> Topology {
        let components = self.parts(true, &AXES);
        let outside = self.parts(false, &around());
        let cavities = outside.saturating_sub(1);
        let tunnels = signed(components) + signed(cavities) - self.euler();
        Topology { components, tunnels, cavities }
    }

    /// Points − edges + squares − cubes of the inside.
    fn euler(&self) -> i64 {
        let mut euler = 0;
        for [i, j, k] in self.points() {
            if !self.inside[self.place([i, j, k])] || i * j * k == 0 {
                continue;
            }
            // Each element is counted at its corner with the highest numbers.
            let at = |a: usize, b: usize, c: usize| self.inside[self.place([i - a, j - b, k - c])];
            let [x, y, z] = [at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)];
            let [xy, xz, yz] =
                [x && y && at(1, 1, 0), x && z && at(1, 0, 1), y && z && at(0, 1, 1)];
            let cube = xy && xz && yz && at(1, 1, 1);
            let count = |flags: &[bool]| signed(flags.iter().filter(|flag| **flag).count());
            euler += 1 - count(&[x, y, z]) + count(&[xy, xz, yz]) - count(&[cube]);
        }
        euler
    }

    /// Connected sets of points that are inside, or that are not.
    fn parts(&self, inside: bool, steps: &[[isize; 3]]) -> usize {
        let mut seen = vec![false; self.inside.len()];
        let mut parts = 0;
        let mut stack = Vec::new();
        for start in self.points() {
            let place = self.place(start);
            if seen[place] || self.inside[place] != inside {
                continue;
            }
            parts += 1;
            seen[place] = true;
            stack.push(start);
            while let Some(from) = stack.pop() {
                for next in steps.iter().filter_map(|step| self.step(from, *step)) {
                    let place = self.place(next);
                    if !seen[place] && self.inside[place] == inside {
                        seen[place] = true;
                        stack.push(next);
                    }
                }
            }
        }
        parts
    }

    fn step(&self, from: [usize; 3], by: [isize; 3]) -> Option<[usize; 3]> {
        let mut to = from;
        for axis in 0..3 {
            to[axis] = from[axis].checked_add_signed(by[axis]).filter(|&n| n < self.size[axis])?;
        }
        Some(to)
    }

    fn points(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [nx, ny, nz] = self.size;
        (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
    }
}

const AXES: [[isize; 3]; 6] = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];

fn around() -> Vec<[isize; 3]> {
    let sides = [-1, 0, 1];
    sides
        .into_iter()
        .flat_map(|i| sides.into_iter().flat_map(move |j| sides.map(|k| [i, j, k])))
        .filter(|step| *step != [0; 3])
        .collect()
}

#[expect(clippy::cast_possible_wrap, reason = "counts stay below 2^28")]
fn signed(count: usize) -> i64 {
    count as i64
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a conversion from floating point ends at the nearest whole number there is"
)]
fn whole(count: f64) -> usize {
    count as usize
}
