//! Area of one surface within a distance of another, as a certified bracket.
//!
//! The distance to one face is convex. Over a triangle it is at most the linear interpolation of its
//! values at the corners, and at least the height over the plane across the shortest way from the
//! center to the face: the part of the triangle within the margin holds one polygon and lies in
//! another, which differ to second order in the size of the triangle. Triangles whose polygons differ
//! are split in four, level by level, until all of them together differ little.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::{closest_on_triangle, triangle};

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
struct Cell {
    corners: [DVec3; 3],
    /// Faces of the other surface that may be within the margin of it.
    near: Vec<u32>,
    area: AreaBracket,
}

/// Brackets the area of one surface within `margin` of another, on either side of it.
pub(crate) fn near_area(
    body: &SurfaceTree,
    other: &SurfaceTree,
    margin: f64,
    traversal: &mut Workspace,
) -> AreaBracket {
    /// Width of the bracket that is narrow enough, relative to its upper end.
    const RELATIVE_WIDTH: f64 = 0.05;
    /// Cells to split at most, some milliseconds. Each level doubles their number and quarters the
    /// width in general; the bracket reached by then is returned.
    const MAX_CELLS: usize = 4000;
    /// Levels of splits, beyond which cells have the size of rounding.
    const MAX_LEVELS: u32 = 40;

    // Faces within the margin of some face, each with all of those.
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    body.tree().pairs(other.tree(), margin, traversal, |face, near| pairs.push([face, near]));
    pairs.sort_unstable();
    let mut cells: Vec<Cell> = Vec::new();
    for group in pairs.chunk_by(|p, q| p[0] == q[0]) {
        let near: Vec<u32> = group.iter().map(|pair| pair[1]).collect();
        cells.push(Cell::new(body.corners(group[0][0]), &near, other, margin));
    }

    // Settled cells leave the list; the others are split.
    let mut settled = AreaBracket::default();
    for _ in 0..MAX_LEVELS {
        let total = cells.iter().fold(settled, |sum, cell| sum.with(cell.area));
        if total.width() <= RELATIVE_WIDTH * total.upper || cells.len() > MAX_CELLS {
            return total;
        }
        let mut parts = Vec::new();
        for cell in cells {
            if cell.area.width() <= 0.25 * RELATIVE_WIDTH * cell.area.upper {
                settled = settled.with(cell.area);
                continue;
            }
            let [a, b, c] = cell.corners;
            let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                parts.push(Cell::new(corners, &cell.near, other, margin));
            }
        }
        cells = parts;
    }
    cells.iter().fold(settled, |sum, cell| sum.with(cell.area))
}

impl AreaBracket {
    fn width(self) -> f64 {
        self.upper - self.lower
    }

    fn with(self, other: Self) -> Self {
        Self { lower: self.lower + other.lower, upper: self.upper + other.upper }
    }
}

impl Cell {
    /// Brackets the part of a triangle within the margin of some faces.
    fn new(corners: [DVec3; 3], near: &[u32], other: &SurfaceTree, margin: f64) -> Self {
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let whole = triangle::area(corners);
        let mut kept = Vec::new();
        let mut lower: f64 = 0.0;
        let mut beyond = corners.to_vec();
        for &face in near {
            let face_corners = other.corners(face);

            // No point of the face is behind the plane across the shortest way to it.
            let foot = closest_on_triangle(center, face_corners).point;
            let outward = (center - foot).normalize_or_zero();
            let height = |p: &DVec3| outward.dot(*p - foot) - margin;
            if corners.iter().all(|corner| height(corner) > 0.0) {
                continue;
            }
            kept.push(face);
            beyond = clipped(&beyond, height);

            // What interpolates to less than the margin is nearer than that.
            let distances = corners
                .map(|corner| closest_on_triangle(corner, face_corners).point.distance(corner));
            lower = lower.max(whole * share_below(distances, margin));
            if lower >= whole {
                break;
            }
        }
        let upper = if kept.is_empty() { 0.0 } else { (whole - polygon_area(&beyond)).max(lower) };
        Self { corners, near: kept, area: AreaBracket { lower, upper } }
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

/// Keeps the part of a convex polygon in which a linear function is above 0.
fn clipped(polygon: &[DVec3], height: impl Fn(&DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, from) in polygon.iter().enumerate() {
        let to = &polygon[(i + 1) % polygon.len()];
        let [here, next] = [height(from), height(to)];
        if here > 0.0 {
            kept.push(*from);
        }
        if (here > 0.0) != (next > 0.0) {
            kept.push(*from + here / (here - next) * (*to - *from));
        }
    }
    kept
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
            let height = |p: &DVec3| {
                values[0] + p.x * (values[1] - values[0]) + p.y * (values[2] - values[0]) - limit
            };
            let above = polygon_area(&clipped(&corners, height));
            assert!((above - 0.5 * (1.0 - exact)).abs() < 1e-15, "{values:?}: {above}");
        }
    }
}
