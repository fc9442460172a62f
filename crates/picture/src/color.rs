//! Colors in linear light, and the color map of depth.
//!
//! Source of the map: S. van der Walt and N. Smith, "viridis", the default color map of
//! matplotlib since 2015 (CC0). It is perceptually uniform, also in print without color
//! and for most color-blind readers.

use std::ops::{Add, Mul};
use std::sync::LazyLock;

use crate::cast::{byte, float, floor};

/// Red, green and blue in linear light, `0.0..=1.0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color([f64; 3]);

impl Color {
    /// All light.
    pub const WHITE: Self = Self([1.0; 3]);

    /// Converts from sRGB bytes.
    #[must_use]
    pub fn from_srgb(bytes: [u8; 3]) -> Self {
        Self(bytes.map(|byte| LIGHT[usize::from(byte)]))
    }

    /// Converts to sRGB bytes, as style sheets and picture files have them.
    #[must_use]
    pub fn to_srgb(self) -> [u8; 3] {
        self.0.map(from_linear)
    }

    /// Blends another color over this one with an opacity in `0.0..=1.0`.
    #[must_use]
    pub fn under(self, over: Self, opacity: f64) -> Self {
        self * (1.0 - opacity) + over * opacity
    }
}

/// Light of all sRGB bytes: a picture needs them for every sample.
static LIGHT: LazyLock<[f64; 256]> = LazyLock::new(|| std::array::from_fn(to_linear));

/// Returns the light of an sRGB byte.
fn to_linear(byte: usize) -> f64 {
    let channel = float(byte) / 255.0;
    if channel <= 0.04045 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
}

/// Returns the sRGB byte nearest to a light, clamped to `0.0..=1.0`.
fn from_linear(channel: f64) -> u8 {
    let channel = channel.clamp(0.0, 1.0);

    // Linear near black, where a power would be infinitely steep.
    byte(if channel <= 0.003_130_8 {
        channel * 12.92
    } else {
        1.055 * channel.powf(1.0 / 2.4) - 0.055
    })
}

impl Add for Color {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Mul<f64> for Color {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|channel| channel * factor))
    }
}

/// The color map at equal steps from 0 to 1.
const VIRIDIS: [[u8; 3]; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Returns the color at `t` of the map, clamped to `0.0..=1.0`.
#[must_use]
pub fn viridis(t: f64) -> Color {
    // The stops on both sides.
    let at = t.clamp(0.0, 1.0) * 16.0;
    let lower = floor(at).min(15);
    let fraction = at - float(lower);

    // Between them the map is linear in sRGB, as it was made.
    let mut bytes = VIRIDIS[lower];
    for (channel, upper) in bytes.iter_mut().zip(VIRIDIS[lower + 1]) {
        let [from, to] = [*channel, upper].map(f64::from);
        *channel = byte((from + fraction * (to - from)) / 255.0);
    }
    Color::from_srgb(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_linear_light() {
        for byte in 0..=u8::MAX {
            let bytes = [byte, 255 - byte, 7];
            assert_eq!(Color::from_srgb(bytes).to_srgb(), bytes);
        }
    }

    fn luminance(t: f64) -> f64 {
        let [r, g, b] = viridis(t).0;
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn the_map_passes_through_its_stops_and_grows_lighter() {
        for (step, stop) in (0_u8..).zip(VIRIDIS) {
            assert_eq!(viridis(f64::from(step) / 16.0).to_srgb(), stop);
        }

        for step in 0_u8..100 {
            let t = f64::from(step) / 100.0;
            assert!(luminance(t) < luminance(t + 0.01), "darker above {t}");
        }
    }
}
