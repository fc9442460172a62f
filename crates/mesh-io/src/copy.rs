//! Copies of files in which numbers change, in the number type of the file.

use std::ops::Range;

use glam::DVec3;

use crate::ReadError;
use crate::error::Format;
use crate::stored_values::single;
use crate::text::number;

/// Number type of a file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floating point.
    Single,
    /// 64-bit floating point.
    Double,
    /// As many digits as fit into 20 characters, the longest number of an Abaqus input file.
    TwentyCharacters,
}

impl Precision {
    /// Rounds a coordinate.
    pub(crate) fn round(self, value: f64) -> f64 {
        match self {
            Self::Single => single(value).into(),
            Self::Double | Self::TwentyCharacters => value,
        }
    }

    /// Writes a coordinate, so that it reads back to the same number in either precision.
    pub(crate) fn text(self, value: f64) -> String {
        let text = format!("{:?}", self.round(value));
        let is_long = self == Self::TwentyCharacters && text.len() > 20;
        if is_long { format!("{value:.12e}") } else { text }
    }

    /// Returns a bound on the distance by which a position is rounded whose coordinates are at most
    /// `max_coordinate`; 0 in double precision.
    #[must_use]
    pub fn max_rounding(self, max_coordinate: f64) -> f64 {
        let unit = match self {
            Self::Single => 0.5 * f64::from(f32::EPSILON),
            Self::Double => 0.0,
            Self::TwentyCharacters => 5e-13,
        };
        3.0_f64.sqrt() * unit * max_coordinate
    }
}

/// Returns a bound on the distance by which a position in an Abaqus input file is rounded whose coordinates are at
/// most `max_coordinate`.
pub(crate) fn max_rounding_in_text(max_coordinate: f64) -> f64 {
    // From 0.1 up to there, all digits of a number fit into 20 characters.
    const MAX_IN_FULL: f64 = 1e15;
    let cut = if max_coordinate < MAX_IN_FULL { max_coordinate.min(0.1) } else { max_coordinate };
    Precision::TwentyCharacters.max_rounding(cut)
}

/// Refuses positions of another number than the file has.
pub(crate) fn check_count(expected: usize, positions: &[DVec3]) -> Result<(), ReadError> {
    let found = positions.len();
    if found == expected { Ok(()) } else { Err(ReadError::PositionCount { expected, found }) }
}

/// Refuses positions beyond the range of a number type; the first one has number `first` in the file.
pub(crate) fn check_range(
    precision: Precision,
    positions: &[DVec3],
    first: usize,
) -> Result<(), ReadError> {
    let max = if precision == Precision::Single { f64::from(f32::MAX) } else { f64::MAX };
    for (vertex, &at) in (first..).zip(positions) {
        // Not a number is beyond any range.
        if !at.abs().to_array().iter().all(|x| *x <= max) {
            return Err(ReadError::OutOfRange { vertex, at });
        }
    }
    Ok(())
}

/// Returns the position of a vertex, or a refusal where there are too few.
pub(crate) fn position(
    format: &Format,
    positions: &[DVec3],
    vertex: usize,
) -> Result<DVec3, ReadError> {
    let missing = || format.in_header(format!("vertex {vertex} has no position"));
    positions.get(vertex).copied().ok_or_else(missing)
}

/// Places of the coordinates of a position in text.
#[derive(Clone, Debug)]
pub(crate) struct CoordinatePlaces {
    /// Bytes of each coordinate, none at the end of those that are given for those that are left out.
    pub(crate) bytes: [Range<usize>; 3],
    /// Number of coordinates that are given: others are 0.
    pub(crate) given: usize,
}

/// Copy of a file in which places, in ascending order, get other content.
#[derive(Debug)]
pub(crate) struct Copy<'a> {
    file: &'a [u8],
    content: Vec<u8>,
    /// Byte of the file up to which it is copied.
    copied: usize,
}

impl<'a> Copy<'a> {
    pub(crate) fn new(file: &'a [u8]) -> Self {
        Self { file, content: Vec::with_capacity(file.len()), copied: 0 }
    }

    /// Returns the file that is copied.
    pub(crate) fn file(&self) -> &'a [u8] {
        self.file
    }

    /// Replaces the bytes of a place, which lies behind the last one.
    pub(crate) fn put(&mut self, place: Range<usize>, content: &[u8]) {
        self.content.extend(self.file.get(self.copied..place.start).unwrap_or_default());
        self.content.extend(content);
        self.copied = place.end;
    }

    /// Replaces a number in text, unless the text stands for it already.
    pub(crate) fn put_number(&mut self, place: Range<usize>, value: f64, precision: Precision) {
        // Text is read in the number type of the file: 0.1 stands for the single nearest to it.
        let text = self.file.get(place.clone()).unwrap_or_default();
        let is_same = match precision {
            _ if text.is_empty() => value == 0.0,
            Precision::Single => number(text) == Some(single(value)),
            Precision::Double | Precision::TwentyCharacters => number(text) == Some(value),
        };
        if !is_same {
            self.put(place, precision.text(value).as_bytes());
        }
    }

    /// Replaces the coordinates of a position in text, and adds those that are left out up to the last one that is
    /// not 0, behind commas.
    pub(crate) fn put_position(
        &mut self,
        places: &CoordinatePlaces,
        x: DVec3,
        precision: Precision,
    ) {
        let CoordinatePlaces { bytes, given } = places;
        let coordinates = x.to_array();
        let (given, left_out) = coordinates.split_at(*given);
        for (place, value) in bytes.iter().zip(given) {
            self.put_number(place.clone(), *value, precision);
        }

        let count = left_out.iter().rposition(|value| *value != 0.0).map_or(0, |last| last + 1);
        let added = left_out[..count].iter().map(|value| format!(", {}", precision.text(*value)));
        if count > 0 {
            self.put(bytes[2].clone(), added.collect::<String>().as_bytes());
        }
    }

    /// Returns the copy up to the end of the file.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.content.extend(self.file.get(self.copied..).unwrap_or_default());
        self.content
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_that_stand_for_a_single_keep_their_spelling() {
        let replaced = |value: f64, precision| {
            let mut copy = Copy::new(b"x 0.1 y");
            copy.put_number(2..5, value, precision);
            String::from_utf8(copy.finish()).expect("text")
        };
        let read = f64::from(0.1_f32);
        assert_eq!(replaced(read, Precision::Single), "x 0.1 y");
        assert_eq!(replaced(0.25, Precision::Single), "x 0.25 y");
        assert_eq!(replaced(read, Precision::Double), "x 0.10000000149011612 y");
    }

    #[test]
    fn numbers_of_limited_length_fit_and_read_back() {
        let mut value: f64 = -1.0 / 3.0;
        for _ in 0..400 {
            value *= 0.173;
            for value in [value, (value * 1e20).round(), value * 2.0_f64.powi(700)] {
                let text = Precision::TwentyCharacters.text(value);
                assert!(text.len() <= 20, "{text}");
                let read: f64 = text.parse().expect("a number");
                assert!((read - value).abs() <= 5e-13 * value.abs(), "{text} for {value:e}");
                let bound = max_rounding_in_text(value.abs());
                assert!((read - value).abs() <= bound, "{text} for {value:e}");
            }
        }
    }
}
