//! Grid of points that are inside or outside a volume.

use std::ops::Range;

use glam::DVec3;
use surface::progress::{Interrupted, Progress, ProgressSteps};
use surface::{Aabb, UnionFind};

use crate::medial_surface::bounds_of;
use crate::{FootRule, MedialError, MedialSurface};

/// Maximum number of grid points: a byte of memory each, and seconds of work.
const MAX_POINTS: usize = 1 << 28;

/// Points between two reports of progress: less than a millisecond of work.
const REPORT_INTERVAL: usize = 1 << 10;

/// Grid points around a box, the outermost layer free.
pub(super) struct Grid {
    origin: DVec3,
    spacing: f64,
    size: [usize; 3],
    is_inside: Vec<bool>,
}

/// Box of grid points, both ends included.
#[derive(Clone, Copy)]
struct PointBox {
    from: [usize; 3],
    to: [usize; 3],
}

impl PointBox {
    /// Returns the number of points; 0 where an end is before its start.
    fn count(&self) -> usize {
        let sides = [0, 1, 2].map(|axis| (self.to[axis] + 1).saturating_sub(self.from[axis]));
        sides[0] * sides[1] * sides[2]
    }
}

/// Counter of points, which reports them in intervals.
struct Counter<'a> {
    steps: ProgressSteps<'a>,
    unreported: usize,
}

impl<'a> Counter<'a> {
    const fn new(progress: Progress<'a>, count: usize) -> Self {
        Self { steps: progress.steps(count), unreported: 0 }
    }

    /// Counts a point that is begun.
    #[inline]
    fn add_point(&mut self) -> Result<(), Interrupted> {
        self.unreported += 1;
        if self.unreported < REPORT_INTERVAL {
            return Ok(());
        }
        let done = std::mem::take(&mut self.unreported);
        self.steps.advance(done)
    }
}

impl Grid {
    pub(super) fn around(bounds: Aabb, spacing: f64) -> Result<Self, MedialError> {
        let cells = (bounds.sides() / spacing).ceil() + 3.0;
        let points = cells.x * cells.y * cells.z;
        if points > crate::real(MAX_POINTS) {
            let (kind, count) = ("grid points", to_usize(points));
            return Err(MedialError::TooMany { kind, count, limit: MAX_POINTS });
        }

        // One layer more than the box on every side.
        let size = cells.to_array().map(to_usize);
        let is_inside = vec![false; size[0] * size[1] * size[2]];
        Ok(Self { origin: bounds.min - spacing, spacing, size, is_inside })
    }

    /// Marks the points inside the primitives.
    pub(super) fn fill(
        &mut self,
        medial: &MedialSurface,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let count = medial.primitives().len();
        let boxes: Vec<PointBox> =
            (0_u32..).take(count).map(|k| self.points_around(medial, k)).collect();
        let points = boxes.iter().map(PointBox::count).sum();
        let mut counter = Counter::new(progress, points);
        for (primitive, within) in (0_u32..).zip(boxes) {
            self.fill_primitive(medial, primitive, within, &mut counter)?;
        }
        Ok(())
    }

    /// Returns the points in the box of a primitive: only these can be inside.
    fn points_around(&self, medial: &MedialSurface, primitive: u32) -> PointBox {
        let bounds = bounds_of(&medial.primitive_balls(primitive));
        let cell = |p: DVec3| (p - self.origin) / self.spacing;
        let from = cell(bounds.min).ceil().to_array().map(to_usize);
        let to = cell(bounds.max).floor().to_array().map(to_usize);
        PointBox { from, to }
    }

    /// Marks the points inside a primitive.
    fn fill_primitive(
        &mut self,
        medial: &MedialSurface,
        primitive: u32,
        PointBox { from, to }: PointBox,
        counter: &mut Counter<'_>,
    ) -> Result<(), Interrupted> {
        for k in from[2]..=to[2] {
            for j in from[1]..=to[1] {
                for i in from[0]..=to[0] {
                    counter.add_point()?;
                    let place = self.place([i, j, k]);
                    let p = self.origin + self.spacing * DVec3::from([i, j, k].map(crate::real));
                    self.is_inside[place] = self.is_inside[place]
                        || medial.foot(p, primitive, FootRule::Exact).distance <= 0.0;
                }
            }
        }
        Ok(())
    }

    /// Counts the parts of the inside, joined along the axes.
    pub(super) fn component_count(&self, progress: Progress<'_>) -> Result<usize, Interrupted> {
        self.count_parts(true, Neighbors::AlongAxes, progress)
    }

    /// Counts the parts of the outside, joined across corners as well, which keeps the Euler
    /// numbers of inside and outside consistent.
    pub(super) fn outside_component_count(
        &self,
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        self.count_parts(false, Neighbors::AcrossCorners, progress)
    }

    /// Computes points − edges + squares − cubes of the inside.
    pub(super) fn euler_number(&self, progress: Progress<'_>) -> Result<i64, Interrupted> {
        let mut counter = Counter::new(progress, self.is_inside.len());
        let mut euler = 0;
        for [i, j, k] in self.points() {
            counter.add_point()?;
            if !self.is_inside[self.place([i, j, k])] || i * j * k == 0 {
                continue;
            }

            // Each element is counted at its corner with the highest numbers.
            let at =
                |a: usize, b: usize, c: usize| self.is_inside[self.place([i - a, j - b, k - c])];
            let edges = [at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)];
            let [x, y, z] = edges;
            let squares = [x && y && at(1, 1, 0), x && z && at(1, 0, 1), y && z && at(0, 1, 1)];
            let is_cube = squares == [true; 3] && at(1, 1, 1);
            euler += 1 - count(edges) + count(squares) - i64::from(is_cube);
        }
        Ok(euler)
    }

    /// Counts the connected sets of points that are inside, or that are not, by the runs of their rows.
    fn count_parts(
        &self,
        inside: bool,
        neighbors: Neighbors,
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        let [nx, ny, nz] = self.size;
        let (mut runs, mut starts) = (Vec::new(), vec![0]);
        for row in self.is_inside.chunks(nx) {
            add_runs(row, inside, &mut runs);
            starts.push(runs.len());
        }

        // Each row with those before it that touch it.
        let runs_of = |row: usize| (starts[row], &runs[starts[row]..starts[row + 1]]);
        let (mut sets, steps) = (UnionFind::new(runs.len()), progress.steps(nz));
        for k in 0..nz {
            for j in 0..ny {
                for &[dj, dk] in neighbors.rows_before() {
                    let at = (j.checked_add_signed(dj), k.checked_add_signed(dk));
                    if let (Some(other_j), Some(other_k)) = at
                        && other_j < ny
                    {
                        let rows = [runs_of(k * ny + j), runs_of(other_k * ny + other_j)];
                        join_runs(rows, neighbors.reach(), &mut sets);
                    }
                }
            }
            steps.advance(1)?;
        }

        let is_first = |&run: &u32| sets.find(run) == run;
        Ok((0_u32..).take(runs.len()).filter(is_first).count())
    }

    /// Returns the place of a point in the list.
    fn place(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    /// Returns all points, in the order of their places.
    fn points(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [nx, ny, _] = self.size;
        (0..self.is_inside.len()).map(move |place| [place % nx, place / nx % ny, place / nx / ny])
    }
}

/// Points that are joined.
#[derive(Clone, Copy)]
enum Neighbors {
    /// The six along the axes.
    AlongAxes,
    /// All 26.
    AcrossCorners,
}

impl Neighbors {
    /// Returns the steps in `j` and `k` to the rows that touch a row and come before it.
    const fn rows_before(self) -> &'static [[isize; 2]] {
        match self {
            Self::AlongAxes => &[[-1, 0], [0, -1]],
            Self::AcrossCorners => &[[-1, 0], [-1, -1], [0, -1], [1, -1]],
        }
    }

    /// Returns the number of points by which runs that touch may miss each other.
    const fn reach(self) -> usize {
        match self {
            Self::AlongAxes => 0,
            Self::AcrossCorners => 1,
        }
    }
}

/// Adds the runs of a row that are inside, or that are not.
fn add_runs(row: &[bool], inside: bool, runs: &mut Vec<Range<usize>>) {
    let mut from = 0;
    for run in row.chunk_by(|p, q| p == q) {
        if run[0] == inside {
            runs.push(from..from + run.len());
        }
        from += run.len();
    }
}

/// Joins the runs of two rows that touch, each row with the number of its first run.
fn join_runs(
    [(first_a, a), (first_b, b)]: [(usize, &[Range<usize>]); 2],
    reach: usize,
    sets: &mut UnionFind,
) {
    let (mut p, mut q) = (0, 0);
    while p < a.len() && q < b.len() {
        if a[p].start < b[q].end + reach && b[q].start < a[p].end + reach {
            sets.join(crate::index(first_a + p), crate::index(first_b + q));
        }
        if a[p].end < b[q].end { p += 1 } else { q += 1 }
    }
}

fn count(flags: [bool; 3]) -> i64 {
    flags.map(i64::from).iter().sum()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a conversion from floating point ends at the nearest whole number there is"
)]
fn to_usize(count: f64) -> usize {
    count as usize
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    /// Counts parts by flood fill.
    fn flooded_parts(grid: &Grid, inside: bool, is_joined: impl Fn([isize; 3]) -> bool) -> usize {
        let mut is_left: Vec<bool> = grid.is_inside.iter().map(|is| *is == inside).collect();
        let mut parts = 0;
        for start in grid.points() {
            if !std::mem::replace(&mut is_left[grid.place(start)], false) {
                continue;
            }
            parts += 1;
            let mut stack = vec![start];
            while let Some(from) = stack.pop() {
                for number in 0..27_isize {
                    let step = [number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1];
                    let to = [0, 1, 2].map(|axis| from[axis].wrapping_add_signed(step[axis]));
                    let is_in_grid = to.iter().zip(grid.size).all(|(to, size)| *to < size);
                    if is_joined(step)
                        && is_in_grid
                        && std::mem::replace(&mut is_left[grid.place(to)], false)
                    {
                        stack.push(to);
                    }
                }
            }
        }
        parts
    }

    #[test]
    fn parts_by_runs_are_those_of_a_flood_fill() {
        let mut random = Random(17);
        for number in 0..300 {
            let size = [(); 3].map(|()| 1 + random.below(6));
            let share = random.unit();
            let points = size.iter().product();
            let is_inside = (0..points).map(|_| random.unit() < share).collect();
            let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, size, is_inside };
            let along_axes = |step: [isize; 3]| step.map(isize::abs).iter().sum::<isize>() == 1;
            assert_eq!(
                grid.component_count(Progress::none()),
                Ok(flooded_parts(&grid, true, along_axes)),
                "{number}: {:?}",
                grid.is_inside
            );
            assert_eq!(
                grid.outside_component_count(Progress::none()),
                Ok(flooded_parts(&grid, false, |_| true)),
                "{number}: {:?}",
                grid.is_inside
            );
        }
    }
}
