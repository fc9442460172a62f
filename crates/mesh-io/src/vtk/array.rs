//! Data arrays of VTK XML files: ASCII, inline base64 or appended, of any number type
//! and byte order, plain or compressed by zlib.
//!
//! Before its bytes an array has their number (a header of one integer) or, compressed,
//! the sizes of its blocks. Writers encode header and content as one run of base64 or as
//! two; decoding by whole runs accepts both.
//!
//! Source: "VTK XML File Formats", the VTK documentation, sections on data arrays and on
//! the compressed header.

use std::borrow::Cow;
use std::io::Read;
use std::str::FromStr;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

use super::xml::Element;
use super::{Appended, VtkFile};
use crate::text::{number, quoted, words};
use crate::{FilePlace, ReadError};

/// Maximum number of numbers in whose memory a text fits.
const MAX_TEXT: usize = 64;

/// Maximum number of bytes of a number.
const MAX_WIDTH: usize = 8;

/// Data array of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct DataArray<'a> {
    file: &'a VtkFile<'a>,
    element: &'a Element,
}

impl<'a> DataArray<'a> {
    pub(super) fn new(file: &'a VtkFile<'a>, element: &'a Element) -> Self {
        Self { file, element }
    }

    pub(super) fn name(&self) -> &'a str {
        self.element.attribute("Name").unwrap_or("Points")
    }

    pub(super) fn number_type(&self) -> &'a str {
        self.element.attribute("type").unwrap_or_default()
    }

    fn encoding(&self) -> &'a str {
        self.element.attribute("format").unwrap_or("ascii")
    }

    /// Returns the numbers of an array of coordinates or of values, text in the number type of the array.
    ///
    /// Compressed arrays of more than `max_count` numbers are refused before they take
    /// memory.
    pub(super) fn floats(&self, max_count: usize) -> Result<Vec<f64>, ReadError> {
        if self.encoding() == "ascii" {
            let is_single = self.number_type() == "Float32";
            return if is_single { self.ascii::<f32>().map(widened) } else { self.ascii() };
        }
        let bytes = self.bytes(max_count)?;
        match self.number_type() {
            "Float32" => Ok(widened(self.decode(&bytes, f32::from_le_bytes))),
            "Float64" => Ok(self.decode(&bytes, f64::from_le_bytes)),
            other => Err(self.malformed(format!("coordinates of type {}", quoted(other)))),
        }
    }

    /// Returns the numbers of an array of indices or of steps.
    ///
    /// An index beyond the range of `i64` becomes a negative one: both are no vertex.
    /// Compressed arrays of more than `max_count` numbers are refused before they take
    /// memory.
    pub(super) fn integers(&self, max_count: usize) -> Result<Vec<i64>, ReadError> {
        if self.encoding() == "ascii" {
            return self.ascii();
        }
        let bytes = self.bytes(max_count)?;
        match self.number_type() {
            "Int8" => Ok(widened(self.decode(&bytes, i8::from_le_bytes))),
            "UInt8" => Ok(widened(self.decode(&bytes, u8::from_le_bytes))),
            "Int16" => Ok(widened(self.decode(&bytes, i16::from_le_bytes))),
            "UInt16" => Ok(widened(self.decode(&bytes, u16::from_le_bytes))),
            "Int32" => Ok(widened(self.decode(&bytes, i32::from_le_bytes))),
            "UInt32" => Ok(widened(self.decode(&bytes, u32::from_le_bytes))),
            "Int64" | "UInt64" => Ok(self.decode(&bytes, i64::from_le_bytes)),
            other => Err(self.malformed(format!("indices of type {}", quoted(other)))),
        }
    }

    /// Returns the bytes of an array of short text.
    pub(super) fn text(&self) -> Option<Vec<u8>> {
        let text = if self.encoding() == "ascii" { self.ascii() } else { self.bytes(MAX_TEXT) };
        text.ok()
    }

    fn ascii<T: FromStr>(&self) -> Result<Vec<T>, ReadError> {
        let mut numbers = Vec::new();
        for word in words(&self.element.text) {
            let Some(number) = number(word) else {
                return Err(self.malformed(format!("{} is not a number here", quoted(word))));
            };
            numbers.push(number);
        }
        Ok(numbers)
    }

    /// Splits bytes into numbers; `number` gets them in little-endian order.
    fn decode<const N: usize, T>(&self, bytes: &[u8], number: fn([u8; N]) -> T) -> Vec<T> {
        let mut numbers = Vec::with_capacity(bytes.len() / N);

        for &(mut bytes) in bytes.as_chunks::<N>().0 {
            if self.file.is_big_endian {
                bytes.reverse();
            }
            numbers.push(number(bytes));
        }
        numbers
    }

    /// Returns the decoded, uncompressed bytes.
    fn bytes(&self, max_count: usize) -> Result<Vec<u8>, ReadError> {
        let source = self.source()?;
        match self.file.compressor.as_deref() {
            None => self.plain(&source),
            Some("vtkZLibDataCompressor") => self.inflate(&source, max_count),
            Some(other) => {
                let feature = format!("data compressed by {}", quoted(other));
                Err(self.file.dialect.format.unsupported(feature))
            }
        }
    }

    fn source(&self) -> Result<Source<'a>, ReadError> {
        match (self.encoding(), self.file.appended) {
            ("binary", _) => {
                let mut bytes = self.element.text.clone();
                bytes.retain(|byte| !byte.is_ascii_whitespace());
                Ok(Source { bytes: Cow::Owned(bytes), is_base64: true })
            }
            ("appended", Some(appended)) => self.appended(appended),
            ("appended", None) => Err(self.malformed("its appended data are missing")),
            (other, _) => Err(self.malformed(format!("the format {} is unknown", quoted(other)))),
        }
    }

    /// Returns the appended data from the offset of the array on.
    fn appended(&self, appended: Appended<'a>) -> Result<Source<'a>, ReadError> {
        let (bytes, is_base64) = match appended {
            Appended::Raw(bytes) => (bytes, false),
            Appended::Base64(bytes) => (bytes, true),
        };

        let text = self.element.attribute("offset").unwrap_or_default();
        let Ok(offset) = text.trim().parse::<usize>() else {
            return Err(self.malformed(format!("its offset {} is no count", quoted(text))));
        };
        match bytes.get(offset..) {
            Some(rest) => Ok(Source { bytes: Cow::Borrowed(rest), is_base64 }),
            None => {
                Err(self.malformed(format!("its offset {offset} is behind the end of the file")))
            }
        }
    }

    fn plain(&self, source: &Source<'_>) -> Result<Vec<u8>, ReadError> {
        let [length] = self.header(source)?;
        let header = self.file.header_bytes;
        let mut bytes = self.first(source, header.saturating_add(length))?;
        bytes.drain(..header);
        Ok(bytes)
    }

    /// Decompresses blocks of equal size but the last, each compressed by itself.
    fn inflate(&self, source: &Source<'_>, max_count: usize) -> Result<Vec<u8>, ReadError> {
        // The header has three integers, then the compressed size of each block.
        let word = self.file.header_bytes;
        let [blocks, block_size, last_size] = self.header(source)?;
        let full = if last_size > 0 { blocks.saturating_sub(1) } else { blocks };
        let inflated_size = full.saturating_mul(block_size).saturating_add(last_size);
        if inflated_size > max_count.saturating_mul(MAX_WIDTH) {
            let problem = format!("its {inflated_size} bytes are more than {max_count} numbers");
            return Err(self.malformed(problem));
        }

        let header = word.saturating_mul(blocks.saturating_add(3));
        let sizes = self.first(source, header)?;
        let sizes: Vec<usize> =
            sizes[3 * word..].chunks_exact(word).map(|size| self.integer(size)).collect();

        let mut total = header;
        for size in &sizes {
            total = total.saturating_add(*size);
        }
        let bytes = self.first(source, total)?;

        // Each block by itself, as large as the header says and no larger.
        let (mut inflated, mut at) = (Vec::new(), header);
        for (block, size) in sizes.iter().enumerate() {
            let is_short = block + 1 == blocks && last_size > 0;
            let expected = if is_short { last_size } else { block_size };
            self.inflate_block(&bytes[at..at + size], expected, &mut inflated)?;
            at += size;
        }
        Ok(inflated)
    }

    fn inflate_block(
        &self,
        block: &[u8],
        expected: usize,
        inflated: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        // One byte more than expected shows that a block is too long.
        let before = inflated.len();
        let limit = u64::try_from(expected).unwrap_or(u64::MAX).saturating_add(1);
        if let Err(error) = ZlibDecoder::new(block).take(limit).read_to_end(inflated) {
            return Err(self.malformed(format!("a compressed block is damaged: {error}")));
        }
        if inflated.len() - before == expected {
            return Ok(());
        }
        Err(self.malformed(format!("a compressed block does not have {expected} bytes")))
    }

    /// Returns the first `N` integers of the header.
    fn header<const N: usize>(&self, source: &Source<'_>) -> Result<[usize; N], ReadError> {
        let word = self.file.header_bytes;
        let bytes = self.first(source, N * word)?;
        Ok(std::array::from_fn(|i| self.integer(&bytes[i * word..(i + 1) * word])))
    }

    /// Returns an unsigned integer of the header.
    ///
    /// An integer beyond any memory becomes the largest one; then bytes are missing.
    fn integer(&self, bytes: &[u8]) -> usize {
        let mut digits = [0; 8];

        // Padded at the end, where little-endian order has the largest digits.
        digits[..bytes.len()].copy_from_slice(bytes);
        if self.file.is_big_endian {
            digits[..bytes.len()].reverse();
        }
        usize::try_from(u64::from_le_bytes(digits)).unwrap_or(usize::MAX)
    }

    /// Returns the first `count` bytes of the source, decoded.
    fn first(&self, source: &Source<'_>, count: usize) -> Result<Vec<u8>, ReadError> {
        match source.first(count) {
            Ok(bytes) if bytes.len() == count => Ok(bytes),
            Ok(bytes) => {
                let found = bytes.len();
                Err(self.malformed(format!("it declares {count} bytes, but {found} are left")))
            }
            Err(error) => Err(self.malformed(error.to_string())),
        }
    }

    pub(super) fn malformed(&self, problem: impl AsRef<str>) -> ReadError {
        self.file.dialect.format.malformed(FilePlace::Array(self.name().to_owned()), problem)
    }
}

fn widened<T: Into<W>, W>(numbers: Vec<T>) -> Vec<W> {
    numbers.into_iter().map(Into::into).collect()
}

/// Bytes of an array, which may continue into those of the next array.
#[derive(Debug)]
struct Source<'a> {
    bytes: Cow<'a, [u8]>,
    is_base64: bool,
}

impl Source<'_> {
    /// Returns up to `count` decoded bytes, fewer where the source ends.
    fn first(&self, count: usize) -> Result<Vec<u8>, base64::DecodeError> {
        if !self.is_base64 {
            return Ok(self.bytes[..count.min(self.bytes.len())].to_vec());
        }

        // Four characters stand for three bytes.
        let (mut decoded, mut rest) = (Vec::new(), &self.bytes[..]);
        while decoded.len() < count && !rest.is_empty() {
            let groups = (count - decoded.len()).div_ceil(3);
            let wanted = groups.saturating_mul(4).min(rest.len());

            // Padding ends a run; a run of its own follows.
            let padding = rest[..wanted].iter().position(|&byte| byte == b'=');
            let run = padding.map_or(wanted, |at| (at / 4 + 1) * 4).min(rest.len());
            STANDARD.decode_vec(&rest[..run], &mut decoded)?;
            rest = &rest[run..];
        }

        decoded.truncate(count);
        Ok(decoded)
    }
}
