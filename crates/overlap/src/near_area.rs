//! Area of one surface within a distance of another, as a certified bracket.
//!
//! The distance to one face is convex. Over a triangle it is at most the linear interpolation of its
//! values at the corners, and at least the height over the plane across the shortest way from the
//! center to the face: the part of the triangle within the margin holds one polygon and lies in
//! another, which differ to second order in the size of the triangle. The triangle whose polygons
//! differ most is split in four, until all of them together differ little.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use glam::DVec3;
use proximity::{FaceBoxes, NearFaces, SurfaceTree};
use surface::progress::{Interrupted, Progress};
use surface::triangle::{quarters, radius_about_center};
use surface::{TotalF64, closest_on_triangle, triangle};

/// Certified bracket on an area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AreaBracket {
    /// Area that is certainly within the margin.
    pub lower: f64,
    /// Area that is not certainly beyond it.
    pub upper: f64,
}

/// Triangle at the border of the margin.
#[derive(Debug)]
struct Cell {
    corners: [DVec3; 3],
    /// Places in [`Cells::faces`] of the faces that may be within the margin of it.
    near: Range<usize>,
    area: AreaBracket,
}

/// Triangles in the order in which they were made; split ones have no area of their own.
#[derive(Debug, Default)]
struct Cells {
    list: Vec<Cell>,
    /// Faces of the other surface, cell after cell.
    faces: Vec<u32>,
}

/// Areas of surfaces near others, pair after pair, in memory that is reused.
///
/// ```
/// use overlap::NearAreas;
/// use overlap::glam::DVec3;
/// use proximity::{PairProximity, PairSide, SurfaceTree};
/// use surface::progress::Progress;
///
/// // The sides of two cubes, 0.25 apart: all points of one are as near to the other.
/// let cube = fixtures::shapes::cube(1.0);
/// let other = cube.clone().translated(1.25 * DVec3::X);
/// let a = SurfaceTree::new(cube.surface(), cube.positions)?;
/// let b = SurfaceTree::new(other.surface(), other.positions)?;
/// let mut pair = PairProximity::default();
/// pair.compute(&a, &b, 0.25)?;
///
/// let near_faces = pair.sides().map(PairSide::near_faces);
/// let [area, _] = NearAreas::default().measure([&a, &b], 0.25, near_faces, Progress::none())?;
/// assert!(area.lower <= 1.0 && area.upper >= 1.0 && area.upper - area.lower <= 0.06);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct NearAreas {
    cells: Cells,
    /// Cells by the widths of their brackets.
    widest: BinaryHeap<(TotalF64, Reverse<usize>)>,
    memory: Memory,
}

/// Memory of a search.
#[derive(Debug, Default)]
struct Memory {
    /// Boxes and centers of the faces of the other surface.
    boxes: FaceBoxes,
    /// Faces that may be within the margin of a triangle.
    close: Vec<CloseFace>,
    /// The part of a triangle that is certainly beyond the margin, and memory to clip it in.
    beyond: Vec<DVec3>,
    clipped: Vec<DVec3>,
    /// Faces that may be within the margin of the triangle that is split.
    near: Vec<u32>,
}

/// Bounds on the part of triangles within the margin of the other surface.
struct Search<'a> {
    other: &'a SurfaceTree,
    margin: f64,
    memory: &'a mut Memory,
}

/// A face and its corners.
#[derive(Clone, Copy, Debug)]
struct CloseFace {
    face: u32,
    corners: [DVec3; 3],
}

impl NearAreas {
    /// Brackets the area of A's surface within `margin` (`>= 0`) of B's, and of B's within it of A's,
    /// to 5 % where a few thousand splits reach it.
    ///
    /// `near_faces` has the faces of A, and of B, each with the faces of the other surface that may
    /// be within the margin of it.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call.
    pub fn measure(
        &mut self,
        bodies: [&SurfaceTree; 2],
        margin: f64,
        near_faces: [&NearFaces; 2],
        progress: Progress<'_>,
    ) -> Result<[AreaBracket; 2], Interrupted> {
        let ([a, b], [near_to_a, near_to_b]) = (bodies, near_faces);
        let of_a = self.measure_one(a, b, margin, near_to_a, progress)?;
        let of_b = self.measure_one(b, a, margin, near_to_b, progress)?;
        Ok([of_a, of_b])
    }

    /// Brackets the area of a surface within `margin` of another, on either side of it.
    fn measure_one(
        &mut self,
        body: &SurfaceTree,
        other: &SurfaceTree,
        margin: f64,
        near_faces: &NearFaces,
        progress: Progress<'_>,
    ) -> Result<AreaBracket, Interrupted> {
        /// Width of the bracket that is narrow enough, relative to its upper end.
        const RELATIVE_WIDTH: f64 = 0.05;
        /// Cells to split at most, some milliseconds; the bracket reached by then is returned. Twice as
        /// many quarter the width in general.
        const MAX_SPLITS: u32 = 8000;
        /// Splits between two polls for interruption: about a millisecond.
        const POLLED_SPLITS: u32 = 64;

        let Self { cells, widest, memory } = self;
        cells.list.clear();
        cells.faces.clear();
        widest.clear();
        memory.boxes.reset(other);
        let mut search = Search { other, margin, memory };
        search.add_faces(body, near_faces, cells, progress)?;
        let mut total = cells.area();
        for (number, cell) in cells.list.iter().enumerate() {
            widest.push((TotalF64(cell.area.width()), Reverse(number)));
        }

        // The cell whose bracket is widest is split: few cells have most of the width.
        let mut polls = progress.every(POLLED_SPLITS);
        for _ in 0..MAX_SPLITS {
            polls.step()?;
            if total.width() <= RELATIVE_WIDTH * total.upper {
                break;
            }
            let Some((_, Reverse(number))) = widest.pop() else { break };
            total = total.without(cells.list[number].area);
            for part in search.split(number, cells) {
                let area = cells.list[part].area;
                total = total.with(area);
                widest.push((TotalF64(area.width()), Reverse(part)));
            }
        }

        // The sum anew, without what rounding has left of the split cells.
        Ok(cells.area())
    }
}

impl AreaBracket {
    fn width(self) -> f64 {
        self.upper - self.lower
    }

    fn with(self, other: Self) -> Self {
        Self { lower: self.lower + other.lower, upper: self.upper + other.upper }
    }

    fn without(self, other: Self) -> Self {
        Self { lower: self.lower - other.lower, upper: self.upper - other.upper }
    }
}

impl Cells {
    /// Adds a triangle that is within the margin as a whole.
    fn add_whole(&mut self, corners: [DVec3; 3]) {
        let (area, end) = (triangle::area(corners), self.faces.len());
        let area = AreaBracket { lower: area, upper: area };
        self.list.push(Cell { corners, near: end..end, area });
    }

    /// Sums the areas of all cells.
    fn area(&self) -> AreaBracket {
        let mut area = AreaBracket::default();
        for cell in &self.list {
            area = area.with(cell.area);
        }
        area
    }
}

impl Search<'_> {
    /// Adds a bracket for every face of a body that has near faces.
    fn add_faces(
        &mut self,
        body: &SurfaceTree,
        near_faces: &NearFaces,
        cells: &mut Cells,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        /// Faces between two polls for interruption: some milliseconds at most.
        const POLLED_FACES: u32 = 64;

        let mut near = std::mem::take(&mut self.memory.near);
        let mut polls = progress.every(POLLED_FACES);
        for (face, faces) in near_faces.iter() {
            polls.step()?;
            // Most faces are within the margin as a whole, by the nearest of these faces.
            let corners = body.corners(face);
            if self.is_within_nearest(corners, faces) {
                cells.add_whole(corners);
                continue;
            }

            // The order of the faces is that of all sums, whatever order they were found in.
            near.clear();
            near.extend_from_slice(faces);
            near.sort_unstable();
            self.add_cell(corners, &near, cells);
        }
        self.memory.near = near;
        Ok(())
    }

    /// Splits a cell in four; returns the places of the parts.
    fn split(&mut self, number: usize, cells: &mut Cells) -> Range<usize> {
        let first = cells.list.len();
        let cell = &mut cells.list[number];
        cell.area = AreaBracket::default();
        let parts = quarters(cell.corners);
        let mut near = std::mem::take(&mut self.memory.near);
        near.clear();
        near.extend_from_slice(&cells.faces[cell.near.clone()]);

        for corners in parts {
            if self.is_within_nearest(corners, &near) {
                cells.add_whole(corners);
            } else {
                self.add_cell(corners, &near, cells);
            }
        }
        self.memory.near = near;
        first..cells.list.len()
    }

    /// Returns true if a triangle is within the margin of the face whose center is nearest to its
    /// own, where that is no farther than the margin from the ball around the triangle.
    ///
    /// A quick test that [`bracket`](Self::bracket) repeats for faces whose centers are farther.
    fn is_within_nearest(&mut self, corners: [DVec3; 3], near: &[u32]) -> bool {
        let (center, radius) = radius_about_center(corners);
        let (mut nearest, mut least) = (u32::MAX, f64::INFINITY);
        for &face in near {
            // Of equally near centers the first counts, in whatever order the faces are.
            let distance = self.memory.boxes.get(self.other, face).center.distance_squared(center);
            if distance < least || (distance <= least && face < nearest) {
                (nearest, least) = (face, distance);
            }
        }

        let reach = self.margin + radius;
        if nearest == u32::MAX || least > reach * reach {
            return false;
        }
        let nearest = CloseFace { face: nearest, corners: self.other.corners(nearest) };
        corners.iter().all(|&corner| nearest.distance_to(corner) <= self.margin)
    }

    /// Adds a triangle with those of some faces that may be within the margin of it.
    fn add_cell(&mut self, corners: [DVec3; 3], near: &[u32], cells: &mut Cells) {
        let start = cells.faces.len();
        let area = self.bracket(corners, near, &mut cells.faces);
        cells.list.push(Cell { corners, near: start..cells.faces.len(), area });
    }

    /// Brackets the part of a triangle within the margin of some faces; writes those that may be
    /// within the margin, unless the whole triangle is.
    fn bracket(&mut self, corners: [DVec3; 3], near: &[u32], kept: &mut Vec<u32>) -> AreaBracket {
        let (center, radius) = radius_about_center(corners);
        let whole = triangle::area(corners);
        if let Some(nearest) = self.keep_close(center, radius, near)
            && corners.iter().all(|&corner| nearest.distance_to(corner) <= self.margin)
        {
            return AreaBracket { lower: whole, upper: whole };
        }

        let first = kept.len();
        let mut lower: f64 = 0.0;
        self.memory.beyond.clear();
        self.memory.beyond.extend(corners);
        for close in &self.memory.close {
            // No point of the face is beyond the plane across the shortest way to it: that is through
            // the foot, and farther only where rounding has turned a way that is hardly longer.
            let foot = closest_on_triangle(center, close.corners).point;
            let outward = (center - foot).normalize_or_zero();
            let beyond = close.corners.map(|corner| outward.dot(corner - foot));
            let reach = self.margin + beyond.into_iter().fold(0.0, f64::max);
            let height = |p: DVec3| outward.dot(p - foot) - reach;
            let heights = corners.map(height);
            if heights.iter().all(|&height| height > 0.0) {
                continue;
            }
            kept.push(close.face);
            clip(&self.memory.beyond, height, &mut self.memory.clipped);
            std::mem::swap(&mut self.memory.beyond, &mut self.memory.clipped);

            // What interpolates to less than the margin is nearer than that. The heights bound the
            // distances below: most faces cannot add to the area that is known.
            let at_most = whole * share_below(heights, 0.0);
            if at_most > lower {
                let distances = corners.map(|corner| close.distance_to(corner));
                lower = lower.max(whole * share_below(distances, self.margin));
            }
            if lower >= whole {
                break;
            }
        }
        let is_near = kept.len() > first;
        let upper =
            if is_near { (whole - polygon_area(&self.memory.beyond)).max(lower) } else { 0.0 };
        AreaBracket { lower, upper }
    }

    /// Keeps the faces whose boxes are within the margin of the ball around a triangle; returns the
    /// one whose center is nearest.
    fn keep_close(&mut self, center: DVec3, radius: f64, near: &[u32]) -> Option<CloseFace> {
        /// Share of the reach that rounding may take.
        const ROUNDING: f64 = 1e-9;

        let reach = (self.margin + radius) * (1.0 + ROUNDING);
        self.memory.close.clear();
        let mut nearest = None;
        let mut least = f64::INFINITY;
        for &face in near {
            let found = self.memory.boxes.get(self.other, face);
            if found.distance_squared(center) > reach * reach {
                continue;
            }
            let distance = found.center.distance_squared(center);
            let close = CloseFace { face, corners: self.other.corners(face) };
            self.memory.close.push(close);
            if distance < least {
                (least, nearest) = (distance, Some(close));
            }
        }
        nearest
    }
}

impl CloseFace {
    fn distance_to(&self, point: DVec3) -> f64 {
        closest_on_triangle(point, self.corners).point.distance(point)
    }
}

/// Returns the share of a triangle in which linear interpolation between values at the corners is
/// at most a limit.
fn share_below(mut values: [f64; 3], limit: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let [low, middle, high] = values;
    if high <= limit {
        1.0
    } else if middle <= limit {
        1.0 - (high - limit) / (high - low) * ((high - limit) / (high - middle))
    } else if low <= limit {
        (limit - low) / (middle - low) * ((limit - low) / (high - low))
    } else {
        0.0
    }
}

/// Writes the part of a convex polygon in which a linear function is above 0.
fn clip(polygon: &[DVec3], height: impl Fn(DVec3) -> f64, kept: &mut Vec<DVec3>) {
    kept.clear();
    let Some(&first) = polygon.first() else { return };
    let first_height = height(first);

    // The height of a corner is that of the end of one edge and of the beginning of the next.
    let mut here = first_height;
    for (i, &from) in polygon.iter().enumerate() {
        let (to, next) = match polygon.get(i + 1) {
            Some(&to) => (to, height(to)),
            None => (first, first_height),
        };
        if here > 0.0 {
            kept.push(from);
        }
        if (here > 0.0) != (next > 0.0) {
            kept.push(from + here / (here - next) * (to - from));
        }
        here = next;
    }
}

fn polygon_area(polygon: &[DVec3]) -> f64 {
    let mut area = 0.0;
    for ends in polygon.windows(2).skip(1) {
        area += triangle::area([polygon[0], ends[0], ends[1]]);
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_clipped_triangles() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (values, limit, exact) in [
            ([0.0, 1.0, 1.0], 0.5, 0.25),
            ([1.0, 0.0, 0.0], 0.5, 0.75),
            ([0.0, 2.0, 4.0], 1.0, 0.125),
            ([0.0; 3], 0.0, 1.0),
            ([1.0; 3], 0.5, 0.0),
        ] {
            let share = share_below(values, limit);
            assert!((share - exact).abs() < 1e-15, "{values:?}: {share}");
            let height = |p: DVec3| {
                values[0] + p.x * (values[1] - values[0]) + p.y * (values[2] - values[0]) - limit
            };
            let mut clipped = Vec::new();
            clip(&corners, height, &mut clipped);
            let above = polygon_area(&clipped);
            assert!((above - 0.5 * (1.0 - exact)).abs() < 1e-15, "{values:?}: {above}");
        }
    }
}
