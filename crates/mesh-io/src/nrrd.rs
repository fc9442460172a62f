//! NRRD, "nearly raw raster data": a header of text lines, an empty line, data.
//!
//! Source: G. Kindlmann, "Definition of NRRD file format", Teem, version 5.

use std::borrow::Cow;
use std::io::{Read, Write};
use std::str::FromStr;

use distance_field::{DistanceField, FieldGrid, NodeValues};
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use glam::DVec3;

use crate::ReadError;
use crate::error::Format;
use crate::stored_values::{StoredValues, common_value, node_count, single};
use crate::text::{Lines, numbers, quoted};

const NRRD: Format = Format {
    name: "NRRD",
    remedy: "save it as floats or steps behind their header, raw or compressed by gzip, on a grid \
             along the axes with one spacing, left-posterior-superior",
};

/// Encoding of the data behind the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Gzip,
}

/// Key of the length of a step, where values are multiples of it.
const STEP: &str = "distance step";

/// Key of the kind of node values.
const NODES: &str = "distance nodes";

/// Fields of the ends of the axes.
const MINS: &str = "axis mins";
const MAXS: &str = "axis maxs";

/// Kinds of node values, by their names in files.
const KINDS: [(&str, NodeValues); 2] = [
    ("interpolating", NodeValues::Interpolating),
    ("quasi-interpolating", NodeValues::QuasiInterpolating),
];

/// Returns a field as a file with its header attached.
pub(crate) fn encode(field: &DistanceField, encoding: Encoding) -> Vec<u8> {
    let values = StoredValues::of(field);
    let mut bytes = header(field, &values, encoding).into_bytes();
    let data = values.little_endian();
    match encoding {
        Encoding::Raw => bytes.extend(data),
        Encoding::Gzip => bytes = compress(&data, bytes),
    }
    bytes
}

/// Appends compressed data to a file. The same data give the same bytes: no time is
/// stored with them.
fn compress(data: &[u8], file: Vec<u8>) -> Vec<u8> {
    // Memory takes all that is written.
    let mut encoder = GzEncoder::new(file, Compression::default());
    let _ = encoder.write_all(data);
    encoder.finish().unwrap_or_default()
}

fn header(field: &DistanceField, values: &StoredValues, encoding: Encoding) -> String {
    let (DVec3 { x, y, z }, h) = (field.grid().origin(), field.grid().spacing());
    let [nx, ny, nz] = field.grid().dims();
    let (unit, number, key) = match values {
        StoredValues::Distances(_) => ("", "float", String::new()),
        StoredValues::Steps { step, .. } => (" in steps", "short", format!("{STEP}:={step}\n")),
    };
    let encoding = match encoding {
        Encoding::Raw => "raw",
        Encoding::Gzip => "gzip",
    };

    let [(one, first), (other, _)] = KINDS;
    let kind = if field.node_values() == first { one } else { other };

    // Numbers are written with as many digits as distinguish them.
    format!(
        "NRRD0004
# Nodes of a signed distance field, in the frame and the length unit of its mesh.
content: signed distance{unit}, negative inside
type: {number}
dimension: 3
space: left-posterior-superior
sizes: {nx} {ny} {nz}
space directions: ({h},0,0) (0,{h},0) (0,0,{h})
kinds: domain domain domain
endian: little
encoding: {encoding}
space origin: ({x},{y},{z})
{NODES}:={kind}
{key}
"
    )
}

/// Reads floats, doubles or 16-bit steps on a grid along the axes, of one spacing.
pub(crate) fn decode(bytes: &[u8]) -> Result<DistanceField, ReadError> {
    let (header, data) = Header::cut(bytes)?;
    header.check_supported()?;
    let dims = header.numbers_of("sizes", "three counts")?;
    let spacing = header.spacing()?;
    let origin = header.origin(dims, spacing)?;

    // The data are as large as the grid says before memory is reserved for it.
    let values = header.values(data, dims)?;
    values.into_field(FieldGrid::new(origin, spacing, dims)?, header.node_kind()?)
}

/// Names and values in a header.
struct Header<'a> {
    fields: Vec<(&'a str, &'a str)>,
    /// Keys and values of applications.
    keys: Vec<(&'a str, &'a str)>,
}

impl<'a> Header<'a> {
    /// Splits a file at the empty line behind its header.
    fn cut(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), ReadError> {
        if !bytes.starts_with(b"NRRD000") {
            return Err(NRRD.on_line(1, "does not begin with NRRD000 and a digit"));
        }
        if let Some(line) = Lines::new(bytes).next()
            && bytes.get(line.text.len()) == Some(&b'\r')
        {
            return Err(NRRD.on_line(1, "ends with a carriage return alone, not with a line feed"));
        }

        // One field, key or comment per line, up to an empty line; the first is the magic.
        let mut header = Self { fields: Vec::new(), keys: Vec::new() };
        let mut rest = bytes;
        for number in 1.. {
            let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
                return Err(NRRD.on_line(number, "the file ends in its header"));
            };
            let Ok(line) = std::str::from_utf8(&rest[..end]) else {
                return Err(NRRD.on_line(number, "is not text"));
            };
            rest = &rest[end + 1..];
            match line.trim_end() {
                "" => break,
                line if number > 1 => header.add(number, line)?,
                _ => {}
            }
        }
        Ok((header, rest))
    }

    fn add(&mut self, number: usize, line: &'a str) -> Result<(), ReadError> {
        if line.starts_with('#') {
            return Ok(());
        }
        let Some((name, value)) = line.split_once(':') else {
            return Err(NRRD.on_line(number, format!("{} is not a field", quoted(line))));
        };

        // Applications separate their keys by := from the values.
        match value.strip_prefix('=') {
            Some(value) => self.keys.push((name, value.trim())),
            None => self.fields.push((name.trim(), value.trim())),
        }
        Ok(())
    }

    /// Returns the value of a field, whose name may be written without its blank.
    fn get(&self, name: &str) -> Option<&'a str> {
        let field = self.fields.iter().find(|(known, _)| letters(known).eq(letters(name)))?;
        Some(field.1)
    }

    fn need(&self, name: &'static str) -> Result<&'a str, ReadError> {
        match self.get(name) {
            Some(value) => Ok(value),
            None => Err(NRRD.in_field(name, "is missing")),
        }
    }

    /// Returns the numbers of a field, which has to be there.
    fn numbers_of<T: FromStr>(&self, name: &'static str, kind: &str) -> Result<[T; 3], ReadError> {
        let text = self.need(name)?;
        match numbers(text) {
            Some(numbers) => Ok(numbers),
            None => Err(NRRD.in_field(name, format!("{} is not {kind}", quoted(text)))),
        }
    }

    fn key(&self, key: &str) -> Option<&'a str> {
        let pair = self.keys.iter().find(|(known, _)| *known == key)?;
        Some(pair.1)
    }

    fn check_supported(&self) -> Result<(), ReadError> {
        // A skip of 0 is the same as none.
        for name in ["data file", "line skip", "byte skip"] {
            if self.get(name).is_some_and(|value| value != "0") {
                return Err(NRRD.unsupported(format!("data in another place ('{name}')")));
            }
        }

        let dimension = self.need("dimension")?;
        if dimension != "3" {
            return Err(NRRD.unsupported(format!("an array of dimension {}", quoted(dimension))));
        }

        // The axes of the mesh, as far as the file says: no other space is converted.
        match self.get("space") {
            None | Some("left-posterior-superior" | "LPS" | "3D-right-handed") => Ok(()),
            Some(other) => Err(NRRD.unsupported(format!("a grid in the space {}", quoted(other)))),
        }
    }

    /// Returns the position of the first node, 0 where the file does not say.
    fn origin(&self, dims: [usize; 3], spacing: f64) -> Result<DVec3, ReadError> {
        let ends = [self.positions_of(MINS)?, self.positions_of(MAXS)?];
        let Some(text) = self.get("space origin") else {
            return match ends {
                [None, None] => Ok(DVec3::ZERO),
                [Some(mins), maxs] => self.origin_of_ends(mins, maxs, dims, spacing),
                [None, Some(_)] => Err(NRRD.unsupported(format!("ends of axes without '{MINS}'"))),
            };
        };

        // The format forbids both, and they could contradict each other.
        if let [Some(_), _] | [_, Some(_)] = ends {
            return Err(NRRD.unsupported(format!("'{MINS}' beside an origin")));
        }
        match vectors(text).as_deref() {
            Some(&[origin]) => Ok(origin),
            _ => Err(NRRD.in_field("space origin", format!("{} is not a vector", quoted(text)))),
        }
    }

    /// Returns the position of the first node by the ends of the axes: those of nodes are at the
    /// first and the last, those of cells half a spacing outside.
    fn origin_of_ends(
        &self,
        mins: DVec3,
        maxs: Option<DVec3>,
        dims: [usize; 3],
        spacing: f64,
    ) -> Result<DVec3, ReadError> {
        let outside = self.outside_nodes()?;
        let Some(maxs) = maxs else { return Ok(mins + spacing * outside) };

        // The last node, as far from its end as the first is. Ends are rounded as they are written.
        let steps = DVec3::from_array(dims.map(last_node)) + 2.0 * outside;
        let expected = mins + spacing * steps;
        let largest = mins.abs().max(maxs.abs()).max_element();
        if (maxs - expected).abs().max_element() > 1e-6 * (spacing + largest) {
            let text = quoted(self.get(MAXS).unwrap_or_default());
            let problem = format!("{text} does not fit '{MINS}' with {spacing} between nodes");
            return Err(NRRD.in_field(MAXS, problem));
        }
        Ok(mins + spacing * outside)
    }

    /// Returns how far the ends of the axes are outside the first and last nodes, in spacings.
    fn outside_nodes(&self) -> Result<DVec3, ReadError> {
        let text = match self.get("centerings") {
            Some(text) => text,
            None => self.need("centers")?,
        };
        let mut outside = Vec::new();
        for word in text.split_whitespace() {
            match word.to_ascii_lowercase().as_str() {
                "node" => outside.push(0.0),
                "cell" => outside.push(0.5),
                _ => break,
            }
        }
        match <[f64; 3]>::try_from(outside) {
            Ok(outside) => Ok(DVec3::from_array(outside)),
            Err(_) => {
                let problem = format!("{} is not 'cell' or 'node' per axis", quoted(text));
                Err(NRRD.in_field("centers", problem))
            }
        }
    }

    /// Returns the positions in a field, none where it is absent or has no numbers.
    fn positions_of(&self, name: &'static str) -> Result<Option<DVec3>, ReadError> {
        if self.get(name).is_none() {
            return Ok(None);
        }
        let positions = DVec3::from_array(self.numbers_of(name, "three positions")?);
        if positions.is_nan_mask().all() {
            return Ok(None);
        }
        if !positions.is_finite() {
            let text = quoted(self.get(name).unwrap_or_default());
            return Err(NRRD.in_field(name, format!("{text} is not three positions")));
        }
        Ok(Some(positions))
    }

    /// Returns the one spacing of all axes, from either field that may have it.
    fn spacing(&self) -> Result<f64, ReadError> {
        if let Some(text) = self.get("space directions") {
            let Some(&[x, y, z]) = vectors(text).as_deref() else {
                let problem = format!("{} is not three vectors", quoted(text));
                return Err(NRRD.in_field("space directions", problem));
            };

            // The cells of a field are cubes along the axes, exactly.
            let across = [x.with_x(0.0), y.with_y(0.0), z.with_z(0.0)];
            return match common_value([x.x, y.y, z.z]) {
                Some(spacing) if across == [DVec3::ZERO; 3] => self.agreed(spacing),
                _ => Err(NRRD.unsupported(format!("a grid along {}", quoted(text)))),
            };
        }

        let [x, y, z] = self.numbers_of("spacings", "three lengths")?;
        match common_value([x, y, z]) {
            Some(spacing) => Ok(spacing),
            None => Err(NRRD.unsupported(format!("a grid of spacings {x} {y} {z}"))),
        }
    }

    /// Returns the spacing by directions, unless `spacings` beside them are others.
    fn agreed(&self, spacing: f64) -> Result<f64, ReadError> {
        let others = self.positions_of("spacings")?;
        if others.is_some_and(|others| others != DVec3::splat(spacing)) {
            return Err(NRRD.unsupported("'spacings' beside other 'space directions'"));
        }
        Ok(spacing)
    }

    fn values(&self, data: &[u8], dims: [usize; 3]) -> Result<StoredValues, ReadError> {
        let data = Data {
            bytes: data,
            encoding: self.encoding()?,
            is_big_endian: self.is_big_endian()?,
            dims,
        };

        // The names that Teem, ITK and 3D Slicer write.
        match self.need("type")? {
            "float" => data.numbers(f32::from_le_bytes).map(StoredValues::Distances),
            "double" => {
                let values = data.numbers(f64::from_le_bytes)?;
                Ok(StoredValues::Distances(values.into_iter().map(single).collect()))
            }
            "short" | "short int" | "signed short" | "int16" | "int16_t" => {
                let steps = data.numbers(i16::from_le_bytes)?;
                Ok(StoredValues::Steps { steps, step: self.step()? })
            }
            other => Err(NRRD.unsupported(format!("values of type {}", quoted(other)))),
        }
    }

    fn encoding(&self) -> Result<Encoding, ReadError> {
        match self.need("encoding")? {
            "raw" => Ok(Encoding::Raw),
            "gzip" | "gz" => Ok(Encoding::Gzip),
            other => Err(NRRD.unsupported(format!("data encoded as {}", quoted(other)))),
        }
    }

    fn is_big_endian(&self) -> Result<bool, ReadError> {
        match self.need("endian")? {
            "little" => Ok(false),
            "big" => Ok(true),
            other => {
                let problem = format!("{} is neither little nor big", quoted(other));
                Err(NRRD.in_field("endian", problem))
            }
        }
    }

    fn step(&self) -> Result<f64, ReadError> {
        let Some(text) = self.key(STEP) else {
            let problem = format!("values of 16 bits need a line '{STEP}:=' and the length of one");
            return Err(NRRD.in_header(problem));
        };
        match text.parse() {
            Ok(step) => Ok(step),
            Err(_) => Err(NRRD.in_field(STEP, format!("{} is not a length", quoted(text)))),
        }
    }

    /// Returns the kind of node values, interpolating where the file does not say.
    fn node_kind(&self) -> Result<NodeValues, ReadError> {
        let Some(text) = self.key(NODES) else {
            return Ok(NodeValues::Interpolating);
        };
        let [(one, first), (other, second)] = KINDS;
        match text {
            _ if text == one => Ok(first),
            _ if text == other => Ok(second),
            _ => {
                let problem = format!("{} is neither '{one}' nor '{other}'", quoted(text));
                Err(NRRD.in_field(NODES, problem))
            }
        }
    }
}

/// Data behind a header, with the grid that they should fill.
struct Data<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    is_big_endian: bool,
    dims: [usize; 3],
}

impl Data<'_> {
    /// Splits the data into numbers; `number` gets bytes in little-endian order.
    fn numbers<const N: usize, T>(&self, number: fn([u8; N]) -> T) -> Result<Vec<T>, ReadError> {
        let expected = node_count(self.dims).saturating_mul(N as u128);
        let content = self.decoded(expected)?;
        let (dims, found) = (self.dims, content.len());
        if expected != found as u128 {
            return Err(ReadError::WrongSize { format: NRRD.name, dims, expected, found });
        }

        let mut numbers = Vec::with_capacity(found / N);
        for &(mut bytes) in content.as_chunks::<N>().0 {
            if self.is_big_endian {
                bytes.reverse();
            }
            numbers.push(number(bytes));
        }
        Ok(numbers)
    }

    /// Returns the data as the numbers need them, decompressed to at most `expected`
    /// bytes, however small a file may hold how many.
    fn decoded(&self, expected: u128) -> Result<Cow<'_, [u8]>, ReadError> {
        if self.encoding == Encoding::Raw {
            return Ok(Cow::Borrowed(self.bytes));
        }

        // One byte more than expected shows that there are too many.
        let limit = u64::try_from(expected).unwrap_or(u64::MAX).saturating_add(1);
        let mut content = Vec::new();
        let decoder = MultiGzDecoder::new(self.bytes);
        if let Err(error) = decoder.take(limit).read_to_end(&mut content) {
            let problem = format!("the data are damaged: {error}");
            return Err(NRRD.in_field("encoding", problem));
        }
        if content.len() as u128 > expected {
            let problem = format!("the data decompress to more than {expected} bytes");
            return Err(NRRD.in_field("encoding", problem));
        }
        Ok(Cow::Owned(content))
    }
}

/// Returns the letters of a field's name, in lower case.
fn letters(name: &str) -> impl Iterator<Item = u8> {
    let letters = name.bytes().filter(|byte| *byte != b' ');
    letters.map(|byte| byte.to_ascii_lowercase())
}

#[expect(clippy::cast_precision_loss, reason = "grids have far fewer nodes per axis than 2^53")]
fn last_node(count: usize) -> f64 {
    count.saturating_sub(1) as f64
}

/// Returns vectors that are written `(x,y,z)`, none for any other text.
fn vectors(text: &str) -> Option<Vec<DVec3>> {
    let mut vectors = Vec::new();
    for part in text.split_terminator(')') {
        let components = part.trim_start().strip_prefix('(')?.replace(',', " ");
        vectors.push(DVec3::from_array(numbers(&components)?));
    }
    Some(vectors)
}
