//! Numbers and points from bytes, zeros where these end.

use glam::DVec3;

/// Bytes that are taken from the front.
pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub(crate) fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    /// Returns a coordinate: on a coarse lattice, beside one by the last bit, on a fine
    /// lattice, or any number at all.
    pub(crate) fn coordinate(&mut self) -> f64 {
        let (kind, value) = (self.byte(), i8::from_le_bytes([self.byte()]));
        match kind % 8 {
            0..=3 => f64::from(value % 4),
            4 => f64::from(value % 4).next_up(),
            5 => f64::from(value) / 64.0,
            6 => f64::from(value) * 1e6,
            _ => self.any(),
        }
    }

    pub(crate) fn any(&mut self) -> f64 {
        f64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    pub(crate) fn point(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.coordinate()))
    }

    pub(crate) fn points<const N: usize>(&mut self) -> [DVec3; N] {
        std::array::from_fn(|_| self.point())
    }
}
