//! Colours, in linear light, and the scale that stands for depth.
//!
//! Source of the scale: S. van der Walt and N. Smith, "viridis", the default
//! colour map of matplotlib since 2015 (CC0). Equal steps look equal, in print
//! without colour and to most colour-blind eyes too.

use std::ops::{Add, Mul};

use super::number::{byte, floor};

/// Red, green and blue in linear light, `0.0..=1.0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Colour([f64; 3]);

impl Colour {
    pub(crate) const WHITE: Self = Self([1.0; 3]);

    /// From the bytes that a style sheet writes.
    pub(crate) fn from_srgb(bytes: [u8; 3]) -> Self {
        Self(bytes.map(|byte| {
            let channel = f64::from(byte) / 255.0;
            if channel <= 0.04045 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
        }))
    }

    /// As a style sheet and a picture file write it.
    pub(crate) fn to_srgb(self) -> [u8; 3] {
        self.0.map(|channel| {
            let channel = channel.clamp(0.0, 1.0);
            byte(if channel <= 0.003_130_8 {
                channel * 12.92
            } else {
                1.055 * channel.powf(1.0 / 2.4) - 0.055
            })
        })
    }

    /// This colour with `share` of another laid over it.
    pub(crate) fn under(self, over: Self, share: f64) -> Self {
        self * (1.0 - share) + over * share
    }
}

impl Add for Colour {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Mul<f64> for Colour {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|channel| channel * factor))
    }
}

/// The scale at equal steps from 0 to 1.
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

/// The colour at `t` of the scale; beyond `0.0..=1.0` that of its end.
pub(crate) fn viridis(t: f64) -> Colour {
    let at = t.clamp(0.0, 1.0) * 16.0;
    let lower = floor(at).min(15);
    let share = at - f64::from(u8::try_from(lower).unwrap_or(15));
    let between = |i: usize| {
        let [from, to] = [VIRIDIS[lower][i], VIRIDIS[lower + 1][i]].map(f64::from);
        byte((from + share * (to - from)) / 255.0)
    };
    Colour::from_srgb([between(0), between(1), between(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_the_way_through_linear_light() {
        for byte in 0..=u8::MAX {
            let bytes = [byte, 255 - byte, 7];
            assert_eq!(Colour::from_srgb(bytes).to_srgb(), bytes);
        }
    }

    #[test]
    fn the_scale_passes_through_its_stops_and_grows_lighter() {
        let luminance = |t: f64| {
            let [r, g, b] = viridis(t).0;
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for (step, stop) in (0_u8..).zip(VIRIDIS) {
            assert_eq!(viridis(f64::from(step) / 16.0).to_srgb(), stop);
        }
        for step in 0_u8..100 {
            let t = f64::from(step) / 100.0;
            assert!(luminance(t) < luminance(t + 0.01), "darker above {t}");
        }
    }
}
