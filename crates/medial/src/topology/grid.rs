//! Grid of points that are inside or outside a volume.

use glam::DVec3;
use surface::Aabb;
use surface::progress::{Interrupted, Progress, ProgressSteps};

use crate::medial_surface::bounds_of;
use crate::{FootRule, MedialError, MedialSurface};

/// Maximum number of grid points: a byte of memory each, and seconds of work.
const MAX_POINTS: usize = 1 << 28;

/// Points or neighbors between two reports of progress: less than a millisecond of work.
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

/// Counter of points and of their neighbors, which reports them in intervals.
struct Counter<'a> {
    steps: ProgressSteps<'a>,
    unreported: usize,
}

impl<'a> Counter<'a> {
    const fn new(progress: Progress<'a>, count: usize) -> Self {
        Self { steps: progress.steps(count), unreported: 0 }
    }

    /// Counts points or neighbors that are begun.
    #[inline]
    fn add(&mut self, count: usize) -> Result<(), Interrupted> {
        self.unreported += count;
        if self.unreported < REPORT_INTERVAL {
            return Ok(());
        }
        let done = std::mem::take(&mut self.unreported);
        self.steps.advance(done)
    }
}

/// Neighbors along the axes.
const AXES: [[isize; 3]; 6] = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];

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
                    counter.add(1)?;
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
        self.count_parts(true, &AXES, progress)
    }

    /// Counts the parts of the outside, joined across corners as well, which keeps the Euler
    /// numbers of inside and outside consistent.
    pub(super) fn outside_component_count(
        &self,
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        self.count_parts(false, &all_neighbors(), progress)
    }

    /// Computes points − edges + squares − cubes of the inside.
    pub(super) fn euler_number(&self, progress: Progress<'_>) -> Result<i64, Interrupted> {
        let mut counter = Counter::new(progress, self.is_inside.len());
        let mut euler = 0;
        for [i, j, k] in self.points() {
            counter.add(1)?;
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

    /// Counts the connected sets of points that are inside, or that are not, by flood fill.
    fn count_parts(
        &self,
        inside: bool,
        steps: &[[isize; 3]],
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        // Every point may be a start. Those of the kind are reached once, each with its neighbors.
        let reached = self.is_inside.iter().filter(|&&is_inside| is_inside == inside).count();
        let mut counter = Counter::new(
            progress,
            reached.saturating_mul(steps.len()).saturating_add(self.is_inside.len()),
        );
        let mut is_visited = vec![false; self.is_inside.len()];
        let mut parts = 0;
        let mut stack = Vec::new();
        for start in self.points() {
            counter.add(1)?;
            let place = self.place(start);
            if is_visited[place] || self.is_inside[place] != inside {
                continue;
            }
            parts += 1;
            is_visited[place] = true;
            stack.push(start);

            // All points of the part.
            while let Some(from) = stack.pop() {
                counter.add(steps.len())?;
                for next in steps.iter().filter_map(|step| self.neighbor(from, *step)) {
                    let place = self.place(next);
                    if !is_visited[place] && self.is_inside[place] == inside {
                        is_visited[place] = true;
                        stack.push(next);
                    }
                }
            }
        }
        Ok(parts)
    }

    /// Returns the place of a point in the list.
    fn place(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    /// Returns the point a step away; `None` outside the grid.
    fn neighbor(&self, from: [usize; 3], step: [isize; 3]) -> Option<[usize; 3]> {
        let mut to = from;
        for axis in 0..3 {
            let moved = from[axis].checked_add_signed(step[axis]);
            to[axis] = moved.filter(|&n| n < self.size[axis])?;
        }
        Some(to)
    }

    /// Returns all points, in the order of their places.
    fn points(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [nx, ny, _] = self.size;
        (0..self.is_inside.len()).map(move |place| [place % nx, place / nx % ny, place / nx / ny])
    }
}

/// Returns the steps to all 26 neighbors.
fn all_neighbors() -> Vec<[isize; 3]> {
    let mut steps = Vec::new();
    for i in -1..=1 {
        for j in -1..=1 {
            for k in -1..=1 {
                steps.push([i, j, k]);
            }
        }
    }
    steps.retain(|step| *step != [0; 3]);
    steps
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
