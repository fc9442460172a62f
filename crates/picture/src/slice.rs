//! Slices through a distance field: depth inside in color, level lines outside.
//!
//! Three slices along the axes meet at the deepest node, where a leak or a lost interior
//! shows at once. The surface is a black line.

use distance_field::{DistanceField, Interpolation};
use glam::DVec3;

use crate::cast::{float, floor};
use crate::color::{Color, viridis};
use crate::image::Image;

/// Approximate number of pixels along the longest side of the field.
const LONGEST_SIDE: f64 = 800.0;

/// Number of level lines outside, up to the maximum distance.
const LEVELS: f64 = 8.0;

/// White between slices, in pixels.
const MARGIN: usize = 8;

/// Draws slices across z, y and x, side by side.
#[must_use]
pub fn draw_slices(field: &DistanceField) -> Image {
    let scale = SliceScale::of(field);
    let slices = [[0, 1], [0, 2], [1, 2]].map(|axes| draw_slice(field, axes, &scale));
    Image::beside(&slices)
}

/// Lengths of pixels and colors.
struct SliceScale {
    /// Common point of the slices.
    center: DVec3,
    /// Side of a pixel, in length units.
    pixel: f64,
    /// Depth at the top of the color map.
    max_depth: f64,
    /// Distance between level lines.
    level: f64,
}

impl SliceScale {
    fn of(field: &DistanceField) -> Self {
        // The deepest node, and both extremes.
        let grid = field.grid();
        let values = field.values();
        let (mut deepest, mut min, mut max) = (0, f32::INFINITY, 0.0_f32);
        for (node, &value) in values.iter().enumerate() {
            max = max.max(value);
            if value < min {
                (deepest, min) = (node, value);
            }
        }

        // Nodes are stored along x, then y, then z.
        let [nx, ny, nz] = grid.dims();
        let longest = float(nx.max(ny).max(nz) - 1) * grid.spacing();
        Self {
            center: grid.position([deepest % nx, deepest / nx % ny, deepest / (nx * ny)]),
            pixel: longest / LONGEST_SIDE,
            max_depth: f64::from(-min).max(f64::MIN_POSITIVE),
            level: round_up(f64::from(max) / LEVELS),
        }
    }

    /// Returns true within a line about a level.
    fn is_near(&self, distance: f64, level: f64) -> bool {
        (distance - level).abs() < 0.75 * self.pixel
    }

    fn color(&self, distance: f64) -> Color {
        // The surface, and depth below it.
        if self.is_near(distance, 0.0) {
            return Color::from_srgb([0, 0, 0]);
        }
        if distance < 0.0 {
            return viridis(-distance / self.max_depth);
        }

        // Level lines on gray outside.
        let is_line = self.is_near(distance, (distance / self.level).round() * self.level);
        Color::from_srgb(if is_line { [170, 180, 190] } else { [238, 241, 244] })
    }
}

/// Returns the next 1, 2 or 5 times a power of ten.
fn round_up(length: f64) -> f64 {
    let length = length.max(f64::MIN_POSITIVE);
    let power = 10.0_f64.powf(length.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * power);
    steps.into_iter().find(|&step| step >= length).unwrap_or(10.0 * power)
}

/// Draws the slice with the first axis to the right and the second up.
fn draw_slice(field: &DistanceField, [right, up]: [usize; 2], scale: &SliceScale) -> Image {
    // Pixels from one end of the grid to the other.
    let grid = field.grid();
    let [width, height] = [right, up]
        .map(|axis| floor(float(grid.dims()[axis] - 1) * grid.spacing() / scale.pixel).max(1));

    // The distance at the middle of each pixel; rows go down.
    let mut image = Image::new(width + MARGIN, height);
    for (row, colors) in image.pixels_mut().chunks_exact_mut(width + MARGIN).enumerate() {
        for (column, color) in colors[..width].iter_mut().enumerate() {
            let mut p = scale.center;
            p[right] = grid.origin()[right] + (float(column) + 0.5) * scale.pixel;
            p[up] = grid.origin()[up] + (float(height - row) - 0.5) * scale.pixel;
            if let Some(sample) = field.evaluate(p, Interpolation::Trilinear) {
                *color = scale.color(sample.distance);
            }
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use distance_field::{FieldGrid, Storage};

    use super::*;

    #[test]
    fn levels_are_round() {
        for (least, expected) in [(1.0, 1.0), (1.9, 2.0), (0.021, 0.05), (7.0, 10.0)] {
            assert!((round_up(least) - expected).abs() < 1e-12, "{least}");
        }
    }

    /// Distances from the plane x = 4.2 over a grid that is longer along x.
    #[test]
    fn a_plane_is_a_black_line_between_color_and_gray() {
        let grid = FieldGrid::new(DVec3::ZERO, 1.0, [9, 3, 5]).unwrap();
        let values = (0_u8..135).map(|node| f32::from(node % 9) - 4.2).collect();
        let field = DistanceField::from_values(grid, values, Storage::Float).unwrap();
        let scale = SliceScale::of(&field);
        assert!((scale.pixel - 0.01).abs() < 1e-15);
        let mut image = draw_slice(&field, [0, 2], &scale);
        let colors: Vec<[u8; 3]> =
            image.pixels_mut()[..800].iter().map(|color| color.to_srgb()).collect();
        assert_eq!(colors[420], [0; 3], "the surface");
        assert_eq!(colors[0], viridis(4.195 / 4.2).to_srgb(), "the deepest");
        assert_eq!(colors[445], [238, 241, 244], "outside");
        assert_eq!(colors[470], [170, 180, 190], "the first level line, at 0.5");
    }
}
