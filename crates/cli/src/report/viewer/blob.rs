//! Binary arrays of a page, one after the other.

use glam::DVec3;
use musculo_collide::surface::Aabb;
use serde::Serialize;

/// Arrays of a page. Each begins at a multiple of four bytes, as views of numbers must.
#[derive(Debug, Default)]
pub(super) struct Blob {
    bytes: Vec<u8>,
}

/// Place of an array: its first byte, and its number of entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Span {
    at: usize,
    count: usize,
}

/// Box of positions, which are stored as 16-bit fractions of its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantizer {
    pub(super) origin: DVec3,
    pub(super) extent: DVec3,
}

impl Quantizer {
    pub(super) fn new(bounds: Aabb) -> Self {
        // A side without length has no fractions.
        let extent = bounds.sides().max(DVec3::splat(f64::MIN_POSITIVE));
        Self { origin: bounds.min, extent }
    }

    pub(super) fn place(&self, position: DVec3) -> [u16; 3] {
        ((position - self.origin) / self.extent).to_array().map(|share| fraction(share, u16::MAX))
    }
}

/// Rounds a share in `0.0..=1.0` to a number in `0..=one`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the share is clamped, and a float saturates when it is cast"
)]
pub(super) fn fraction(share: f64, one: u16) -> u16 {
    (share.clamp(0.0, 1.0) * f64::from(one) + 0.5) as u16
}

impl Blob {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Adds an array of records of `N` numbers.
    pub(super) fn add_u16<const N: usize>(&mut self, records: &[[u16; N]]) -> Span {
        let at = self.align();
        for number in records.iter().flatten() {
            self.bytes.extend(number.to_le_bytes());
        }
        Span { at, count: records.len() }
    }

    /// Adds an array of triples of wide numbers.
    pub(super) fn add_u32(&mut self, records: &[[u32; 3]]) -> Span {
        let at = self.align();
        for number in records.iter().flatten() {
            self.bytes.extend(number.to_le_bytes());
        }
        Span { at, count: records.len() }
    }

    /// Adds an array of records of 12 numbers: the upper rows of maps.
    pub(super) fn add_f32(&mut self, records: &[[f32; 12]]) -> Span {
        let at = self.align();
        for number in records.iter().flatten() {
            self.bytes.extend(number.to_le_bytes());
        }
        Span { at, count: records.len() }
    }

    fn align(&mut self) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_within_half_a_step() {
        let bounds = Aabb::of_points([DVec3::new(-100.0, 0.0, 5.0), DVec3::new(300.0, 1.0, 5.0)]);
        let quantizer = Quantizer::new(bounds);
        for share in [0.0, 0.123_456, 0.5, 1.0] {
            let position = bounds.min + share * bounds.sides();
            let [x, y, z] = quantizer.place(position).map(|number| f64::from(number) / 65_535.0);
            assert!((x - share).abs() <= 0.5 / 65_535.0 + 1e-12, "{x} for {share}");
            assert!((y - share).abs() <= 0.5 / 65_535.0 + 1e-12 && z <= 1.0, "{y} {z}");
        }
    }

    #[test]
    fn arrays_begin_at_multiples_of_four() {
        let mut blob = Blob::default();
        assert_eq!(blob.add_u16(&[[1_u16, 2, 3]]), Span { at: 0, count: 1 });
        assert_eq!(blob.add_u32(&[[7, 8, 9]]), Span { at: 8, count: 1 });
        assert_eq!(blob.add_f32(&[[1.5; 12], [2.5; 12]]), Span { at: 20, count: 2 });
        assert_eq!(blob.bytes()[8..12], 7_u32.to_le_bytes());
        assert_eq!(blob.bytes().len(), 20 + 2 * 48);
    }
}
