//! Slices through a distance field: depth inside in colour, level lines outside.
//!
//! Three slices along the axes meet at the deepest node, where a leak or a lost
//! interior shows at once. The surface is a black line.

use glam::DVec3;
use musculo_collide::distance_field::{DistanceField, Interpolation};

use super::colour::{Colour, viridis};
use super::image::Image;
use super::number::{float, floor};

/// Pixels along the longest side of the field, near enough.
const LONGEST: f64 = 800.0;

/// Level lines outside, over the distance that the field reaches.
const LEVELS: f64 = 8.0;

/// White between slices, in pixels.
const MARGIN: usize = 8;

/// Slices across z, y and x, side by side.
pub(crate) fn slices(field: &DistanceField) -> Image {
    let scale = Scale::of(field);
    let slices = [[0, 1, 2], [0, 2, 1], [1, 2, 0]].map(|axes| slice(field, axes, &scale));
    Image::beside(&slices)
}

/// What pixels and colours stand for.
struct Scale {
    /// Where the slices meet.
    centre: DVec3,
    /// Side of a pixel, in the length unit.
    pixel: f64,
    /// Depth at the end of the colour scale.
    deepest: f64,
    /// Distance from one level line to the next.
    level: f64,
}

impl Scale {
    fn of(field: &DistanceField) -> Self {
        let grid = field.grid();
        let [nx, ny, _] = grid.dims();
        let values = field.values();
        let deepest = (0..).zip(&values).min_by(|(_, a), (_, b)| a.total_cmp(b));
        let (node, deepest) = deepest.map_or((0, 0.0), |(node, &value)| (node, value));
        let farthest = values.iter().fold(0.0_f32, |most, &value| most.max(value));
        let longest = grid.dims().map(|n| float(n - 1) * grid.spacing()).into_iter();
        Self {
            centre: grid.position([node % nx, node / nx % ny, node / (nx * ny)]),
            pixel: longest.fold(0.0, f64::max) / LONGEST,
            deepest: f64::from(-deepest).max(f64::MIN_POSITIVE),
            level: round_level(f64::from(farthest) / LEVELS),
        }
    }

    fn colour(&self, distance: f64) -> Colour {
        let near = |level: f64| (distance - level).abs() < 0.75 * self.pixel;
        if near(0.0) {
            return Colour::from_srgb([0, 0, 0]);
        }
        if distance < 0.0 {
            return viridis(-distance / self.deepest);
        }
        let is_line = near((distance / self.level).round() * self.level);
        Colour::from_srgb(if is_line { [170, 180, 190] } else { [238, 241, 244] })
    }
}

/// 1, 2 or 5 times a power of ten, at or above `least`.
fn round_level(least: f64) -> f64 {
    let least = least.max(f64::MIN_POSITIVE);
    let power = 10.0_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * power);
    steps.into_iter().find(|&step| step >= least).unwrap_or(10.0 * power)
}

/// The slice with the first axis to the right, the second up, across the third.
fn slice(field: &DistanceField, [right, up, _]: [usize; 3], scale: &Scale) -> Image {
    let grid = field.grid();
    let pixels =
        |axis: usize| floor(float(grid.dims()[axis] - 1) * grid.spacing() / scale.pixel).max(1);
    let (width, height) = (pixels(right), pixels(up));
    let mut image = Image::new(width + MARGIN, height);
    for row in 0..height {
        for column in 0..width {
            let mut p = scale.centre;
            p[right] = grid.origin()[right] + (float(column) + 0.5) * scale.pixel;
            p[up] = grid.origin()[up] + (float(height - row) - 0.5) * scale.pixel;
            if let Some(sample) = field.evaluate(p, Interpolation::Trilinear) {
                image.samples_mut()[row * (width + MARGIN) + column] =
                    scale.colour(sample.distance);
            }
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use musculo_collide::distance_field::{FieldGrid, Storage};

    use super::*;

    #[test]
    fn levels_are_round() {
        for (least, expected) in [(1.0, 1.0), (1.9, 2.0), (0.021, 0.05), (7.0, 10.0)] {
            assert!((round_level(least) - expected).abs() < 1e-12, "{least}");
        }
    }

    /// Distances from the plane x = 4.2 over a grid that is longer along x.
    #[test]
    fn a_plane_is_a_black_line_between_colour_and_grey() {
        let grid = FieldGrid::new(DVec3::ZERO, 1.0, [9, 3, 5]).unwrap();
        let values = (0_u8..135).map(|node| f32::from(node % 9) - 4.2).collect();
        let field = DistanceField::from_values(grid, values, Storage::Float).unwrap();
        let scale = Scale::of(&field);
        assert!((scale.pixel - 0.01).abs() < 1e-15);
        let mut image = slice(&field, [0, 2, 1], &scale);
        let colours: Vec<[u8; 3]> =
            image.samples_mut()[..800].iter().map(|colour| colour.to_srgb()).collect();
        assert_eq!(colours[420], [0; 3], "the surface");
        assert_eq!(colours[0], viridis(4.195 / 4.2).to_srgb(), "the deepest");
        assert_eq!(colours[445], [238, 241, 244], "outside");
        assert_eq!(colours[470], [170, 180, 190], "the first level line, at 0.5");
    }
}
