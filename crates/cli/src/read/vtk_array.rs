//! The arrays of a VTK XML file: ascii, inline base64 or appended, of any
//! number type and byte order, plain or compressed by zlib.
//!
//! Before its bytes an array says how many they are (a header of one integer)
//! or, compressed, in which blocks they come. Writers encode header and content
//! as one run of base64 or as two; decoding by whole runs takes both.
//!
//! Source: "VTK XML File Formats", the VTK documentation, sections on data
//! arrays and on the compressed header.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

use super::MeshError;
use super::vtp::{malformed, unsupported};

/// What holds for every array of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Conventions {
    big_endian: bool,
    /// Whether headers hold 64-bit integers rather than 32-bit ones.
    wide_header: bool,
    /// VTK's name for it; none where data are plain.
    compressor: Option<String>,
}

/// The data behind the XML, to which arrays point by offset.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Appended<'a> {
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

/// One array as declared, with its text where the data stand inline.
#[derive(Debug)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) number_type: String,
    pub(crate) format: String,
    pub(crate) offset: Option<usize>,
    pub(crate) text: Vec<u8>,
}

impl Conventions {
    /// From the attributes of the tag `VTKFile`, with VTK's defaults.
    pub(crate) fn new(
        byte_order: Option<&str>,
        header_type: Option<&str>,
        compressor: Option<String>,
    ) -> Self {
        Self {
            big_endian: byte_order == Some("BigEndian"),
            wide_header: header_type == Some("UInt64"),
            compressor: compressor.filter(|name| !name.is_empty()),
        }
    }

    fn header_bytes(&self) -> usize {
        if self.wide_header { 8 } else { 4 }
    }
}

impl Array {
    /// The numbers of an array of coordinates.
    pub(crate) fn floats(
        &self,
        conventions: &Conventions,
        appended: Option<Appended<'_>>,
    ) -> Result<Vec<f64>, MeshError> {
        if self.format == "ascii" {
            return self.ascii();
        }
        let bytes = self.bytes(conventions, appended)?;
        let big = conventions.big_endian;
        match self.number_type.as_str() {
            "Float32" => Ok(decode(&bytes, big, |b| f32::from_le_bytes(b).into())),
            "Float64" => Ok(decode(&bytes, big, f64::from_le_bytes)),
            other => Err(self.problem(format!("coordinates of type '{other}'"))),
        }
    }

    /// The numbers of an array of indices or of steps.
    pub(crate) fn integers(
        &self,
        conventions: &Conventions,
        appended: Option<Appended<'_>>,
    ) -> Result<Vec<i64>, MeshError> {
        if self.format == "ascii" {
            return self.ascii();
        }
        let bytes = self.bytes(conventions, appended)?;
        let big = conventions.big_endian;
        match self.number_type.as_str() {
            "Int8" => Ok(decode(&bytes, big, |b| i8::from_le_bytes(b).into())),
            "UInt8" => Ok(decode(&bytes, big, |b| u8::from_le_bytes(b).into())),
            "Int16" => Ok(decode(&bytes, big, |b| i16::from_le_bytes(b).into())),
            "UInt16" => Ok(decode(&bytes, big, |b| u16::from_le_bytes(b).into())),
            "Int32" => Ok(decode(&bytes, big, |b| i32::from_le_bytes(b).into())),
            "UInt32" => Ok(decode(&bytes, big, |b| u32::from_le_bytes(b).into())),
            // An index past the range of i64 stays one that no vertex has.
            "UInt64" => Ok(decode(&bytes, big, |b| {
                i64::try_from(u64::from_le_bytes(b)).unwrap_or(i64::MAX)
            })),
            "Int64" => Ok(decode(&bytes, big, i64::from_le_bytes)),
            other => Err(self.problem(format!("indices of type '{other}'"))),
        }
    }

    fn ascii<T: std::str::FromStr>(&self) -> Result<Vec<T>, MeshError> {
        self.text
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .map(|word| {
                let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                number.ok_or_else(|| {
                    self.problem(format!(
                        "'{}' is not a number here",
                        String::from_utf8_lossy(word)
                    ))
                })
            })
            .collect()
    }

    /// The decoded, uncompressed bytes.
    fn bytes(
        &self,
        conventions: &Conventions,
        appended: Option<Appended<'_>>,
    ) -> Result<Vec<u8>, MeshError> {
        let source = self.source(appended)?;
        match conventions.compressor.as_deref() {
            None => self.plain(&source, conventions),
            Some("vtkZLibDataCompressor") => self.inflate(&source, conventions),
            Some(other) => Err(unsupported(format!("data compressed by {other}"))),
        }
    }

    fn source<'a>(&self, appended: Option<Appended<'a>>) -> Result<Source<'a>, MeshError> {
        match (self.format.as_str(), appended, self.offset) {
            ("binary", _, _) => {
                let text: Vec<u8> =
                    self.text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect();
                Ok(Source { bytes: Cow::Owned(text), base64: true })
            }
            ("appended", Some(appended), Some(offset)) => {
                let (bytes, base64) = match appended {
                    Appended::Raw(bytes) => (bytes, false),
                    Appended::Base64(bytes) => (bytes, true),
                };
                let rest = bytes.get(offset..).ok_or_else(|| {
                    self.problem(format!("its offset {offset} is behind the end of the file"))
                })?;
                Ok(Source { bytes: Cow::Borrowed(rest), base64 })
            }
            ("appended", _, _) => Err(self.problem("its appended data are missing".to_owned())),
            (other, _, _) => Err(self.problem(format!("the format '{other}' is unknown"))),
        }
    }

    fn plain(&self, source: &Source<'_>, conventions: &Conventions) -> Result<Vec<u8>, MeshError> {
        let header = conventions.header_bytes();
        let [length] = self.header(source, conventions)?;
        let mut bytes = self.first(source, header.saturating_add(length))?;
        bytes.drain(..header);
        Ok(bytes)
    }

    /// Blocks of equal size but the last, each compressed by itself.
    fn inflate(
        &self,
        source: &Source<'_>,
        conventions: &Conventions,
    ) -> Result<Vec<u8>, MeshError> {
        let word = conventions.header_bytes();
        let [blocks, block_size, last_size] = self.header(source, conventions)?;
        let header = word.saturating_mul(blocks.saturating_add(3));
        let sizes: Vec<usize> = self.first(source, header)?[3 * word..]
            .chunks_exact(word)
            .map(|size| integer(size, conventions))
            .collect();
        let total = sizes.iter().fold(header, |sum, size| sum.saturating_add(*size));
        let bytes = self.first(source, total)?;
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
    ) -> Result<(), MeshError> {
        let before = inflated.len();
        let limit = u64::try_from(expected).unwrap_or(u64::MAX).saturating_add(1);
        ZlibDecoder::new(block)
            .take(limit)
            .read_to_end(inflated)
            .map_err(|error| self.problem(format!("a compressed block is damaged: {error}")))?;
        if inflated.len() - before == expected {
            return Ok(());
        }
        Err(self.problem(format!("a compressed block does not hold {expected} bytes")))
    }

    /// The first `N` integers of the header.
    fn header<const N: usize>(
        &self,
        source: &Source<'_>,
        conventions: &Conventions,
    ) -> Result<[usize; N], MeshError> {
        let word = conventions.header_bytes();
        let bytes = self.first(source, N * word)?;
        Ok(std::array::from_fn(|i| integer(&bytes[i * word..(i + 1) * word], conventions)))
    }

    /// The first `count` bytes of the source, decoded.
    fn first(&self, source: &Source<'_>, count: usize) -> Result<Vec<u8>, MeshError> {
        let bytes = source.first(count).map_err(|error| self.problem(error.to_string()))?;
        if bytes.len() < count {
            let found = bytes.len();
            return Err(self.problem(format!("it declares {count} bytes, but {found} are left")));
        }
        Ok(bytes)
    }

    fn problem(&self, problem: String) -> MeshError {
        malformed(&format!("array '{}'", self.name), problem)
    }
}

/// Where an array's bytes begin; they may go on into the next array's.
#[derive(Debug)]
struct Source<'a> {
    bytes: Cow<'a, [u8]>,
    base64: bool,
}

impl Source<'_> {
    /// Up to `count` bytes, fewer where the source ends.
    fn first(&self, count: usize) -> Result<Vec<u8>, base64::DecodeError> {
        if !self.base64 {
            return Ok(self.bytes[..count.min(self.bytes.len())].to_vec());
        }
        let (mut decoded, mut rest) = (Vec::new(), &self.bytes[..]);
        while decoded.len() < count && !rest.is_empty() {
            let groups = (count - decoded.len()).div_ceil(3);
            let wanted = groups.saturating_mul(4).min(rest.len());
            // Padding ends a run; what follows is a run of its own.
            let padding = rest[..wanted].iter().position(|&byte| byte == b'=');
            let run = padding.map_or(wanted, |at| (at / 4 + 1) * 4).min(rest.len());
            STANDARD.decode_vec(&rest[..run], &mut decoded)?;
            rest = &rest[run..];
        }
        decoded.truncate(count);
        Ok(decoded)
    }
}

/// Splits bytes into numbers; `number` takes them in little-endian order.
fn decode<const N: usize, T>(
    bytes: &[u8],
    big_endian: bool,
    number: impl Fn([u8; N]) -> T,
) -> Vec<T> {
    let (numbers, _) = bytes.as_chunks::<N>();
    numbers
        .iter()
        .map(|&(mut bytes)| {
            if big_endian {
                bytes.reverse();
            }
            number(bytes)
        })
        .collect()
}

/// An unsigned integer of a header; one that no memory could hold is as large
/// as can be, and then fails for lack of bytes.
fn integer(bytes: &[u8], conventions: &Conventions) -> usize {
    let join = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
    let value = if conventions.big_endian {
        bytes.iter().fold(0, join)
    } else {
        bytes.iter().rev().fold(0, join)
    };
    usize::try_from(value).unwrap_or(usize::MAX)
}
