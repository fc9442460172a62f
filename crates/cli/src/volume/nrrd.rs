//! NRRD, "nearly raw raster data": a header of text lines, an empty line, data.
//!
//! Source: G. Kindlmann, "Definition of NRRD file format", Teem, version 5.

use glam::DVec3;
use musculo_collide::distance_field::{DistanceField, NodeValues};

use super::{Values, VolumeError, count, field, single};

const FORMAT: &str = "NRRD";

/// Key of the length of a step, where values are whole steps.
const STEP: &str = "distance step";

/// Key of what values are right for.
const NODES: &str = "distance nodes";

/// A field as a file with its header attached.
pub(super) fn encode(field: &DistanceField) -> Vec<u8> {
    let values = Values::of(field);
    let mut bytes = header(field, &values).into_bytes();
    bytes.extend(values.little_endian());
    bytes
}

pub(super) fn header(field: &DistanceField, values: &Values) -> String {
    let (DVec3 { x, y, z }, h) = (field.grid().origin(), field.grid().spacing());
    let [nx, ny, nz] = field.grid().dims();
    let (unit, number, key) = match values {
        Values::Floats(_) => ("", "float", String::new()),
        Values::Steps(_, step) => (" in steps", "short", format!("{STEP}:={step}\n")),
    };
    let nodes = name(field.node_values());
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
encoding: raw
space origin: ({x},{y},{z})
{NODES}:={nodes}
{key}
"
    )
}

/// What values are right for, by name.
fn name(nodes: NodeValues) -> &'static str {
    match nodes {
        NodeValues::Interpolating => "interpolating",
        NodeValues::QuasiInterpolating => "quasi-interpolating",
    }
}

/// Reads raw floats, doubles or 16-bit steps on a grid along the axes, of one spacing.
pub(super) fn decode(bytes: &[u8]) -> Result<DistanceField, VolumeError> {
    let (header, data) = Header::cut(bytes)?;
    header.check_supported()?;
    let dims = header.sizes()?;
    let (origin, spacing) = (header.origin()?, header.spacing()?);
    let values = header.values(data, dims)?;
    field((origin, spacing, dims), values, header.nodes()?)
}

/// What a header says, by name.
struct Header<'a> {
    fields: Vec<(&'a str, &'a str)>,
    /// Keys and values of applications.
    keys: Vec<(&'a str, &'a str)>,
}

impl<'a> Header<'a> {
    /// Splits a file at the empty line behind its header.
    fn cut(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), VolumeError> {
        if !bytes.starts_with(b"NRRD000") {
            return Err(malformed("line 1", "does not begin with NRRD000 and a digit".to_owned()));
        }
        let (mut fields, mut keys, mut rest) = (Vec::new(), Vec::new(), bytes);
        for number in 1.. {
            let place = format!("line {number}");
            let end = rest.iter().position(|&byte| byte == b'\n');
            let Some(end) = end else {
                return Err(malformed(&place, "the file ends within its header".to_owned()));
            };
            let line = std::str::from_utf8(&rest[..end]);
            let line = line.map_err(|_| malformed(&place, "is not text".to_owned()))?.trim_end();
            rest = &rest[end + 1..];
            match line.split_once(':') {
                _ if line.is_empty() => break,
                _ if number == 1 || line.starts_with('#') => {}
                Some((name, value)) => match value.strip_prefix('=') {
                    Some(value) => keys.push((name, value)),
                    None => fields.push((name.trim(), value.trim())),
                },
                None => return Err(malformed(&place, format!("'{line}' is no field"))),
            }
        }
        Ok((Self { fields, keys }, rest))
    }

    fn get(&self, name: &str) -> Option<&'a str> {
        self.fields
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(name))
            .map(|(_, value)| *value)
    }

    fn need(&self, name: &str) -> Result<&'a str, VolumeError> {
        self.get(name).ok_or_else(|| malformed("header", format!("the field '{name}' is missing")))
    }

    fn check_supported(&self) -> Result<(), VolumeError> {
        for name in ["data file", "datafile", "line skip", "lineskip", "byte skip", "byteskip"] {
            if self.get(name).is_some_and(|value| value != "0") {
                return Err(unsupported(format!("data elsewhere ('{name}')")));
            }
        }
        let encoding = self.need("encoding")?;
        if encoding != "raw" {
            return Err(unsupported(format!("data encoded as '{encoding}'")));
        }
        let dimension = self.need("dimension")?;
        if dimension != "3" {
            return Err(unsupported(format!("an array of dimension {dimension}")));
        }
        match self.get("space") {
            None | Some("left-posterior-superior" | "LPS" | "3D-right-handed") => Ok(()),
            Some(other) => Err(unsupported(format!("a grid in the space '{other}'"))),
        }
    }

    fn sizes(&self) -> Result<[usize; 3], VolumeError> {
        let text = self.need("sizes")?;
        let sizes: Option<Vec<usize>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
        sizes
            .and_then(|sizes| sizes.try_into().ok())
            .ok_or_else(|| malformed("sizes", format!("'{text}' is not three counts")))
    }

    /// Position of the first node; 0 where the file says nothing.
    fn origin(&self) -> Result<DVec3, VolumeError> {
        let Some(text) = self.get("space origin") else {
            return Ok(DVec3::ZERO);
        };
        match vectors(text).as_deref() {
            Some(&[origin]) => Ok(origin),
            _ => Err(malformed("space origin", format!("'{text}' is not a vector"))),
        }
    }

    /// The one spacing of all axes, from either field that may tell it.
    fn spacing(&self) -> Result<f64, VolumeError> {
        if let Some(text) = self.get("space directions") {
            let axes: Option<[DVec3; 3]> = vectors(text).and_then(|axes| axes.try_into().ok());
            let [x, y, z] = axes.ok_or_else(|| {
                malformed("space directions", format!("'{text}' is not three vectors"))
            })?;
            let across = [x.with_x(0.0), y.with_y(0.0), z.with_z(0.0)];
            let is_along_axes = across.iter().all(|&across| across == DVec3::ZERO);
            return equal([x.x, y.y, z.z])
                .filter(|_| is_along_axes)
                .ok_or_else(|| unsupported(format!("a grid along {text}")));
        }
        let text = self.need("spacings")?;
        let spacings: Option<Vec<f64>> = text.split_whitespace().map(|h| h.parse().ok()).collect();
        let spacings = spacings.and_then(|spacings| spacings.try_into().ok());
        let spacings = spacings
            .ok_or_else(|| malformed("spacings", format!("'{text}' is not three lengths")))?;
        equal(spacings).ok_or_else(|| unsupported(format!("a grid of spacings {text}")))
    }

    fn values(&self, data: &[u8], dims: [usize; 3]) -> Result<Values, VolumeError> {
        let is_big = match self.need("endian")? {
            "little" => false,
            "big" => true,
            other => return Err(malformed("endian", format!("'{other}' is no order of bytes"))),
        };
        match self.need("type")? {
            "float" => numbers(data, dims, is_big, f32::from_le_bytes).map(Values::Floats),
            "double" => numbers(data, dims, is_big, |bytes| single(f64::from_le_bytes(bytes)))
                .map(Values::Floats),
            "short" | "short int" | "signed short" | "int16" | "int16_t" => {
                let steps = numbers(data, dims, is_big, i16::from_le_bytes)?;
                Ok(Values::Steps(steps, self.step()?))
            }
            other => Err(unsupported(format!("values of type '{other}'"))),
        }
    }

    /// Length of a step.
    fn step(&self) -> Result<f64, VolumeError> {
        let Some(text) = self.key(STEP) else {
            let problem = format!("values of 16 bits need a line '{STEP}:=' and the length of one");
            return Err(malformed("header", problem));
        };
        text.parse().map_err(|_| malformed(STEP, format!("'{text}' is not a length")))
    }

    /// What values are right for.
    fn nodes(&self) -> Result<NodeValues, VolumeError> {
        let Some(text) = self.key(NODES) else {
            return Ok(NodeValues::Interpolating);
        };
        let known = [NodeValues::Interpolating, NodeValues::QuasiInterpolating];
        known.into_iter().find(|&nodes| name(nodes) == text).ok_or_else(|| {
            let [one, other] = known.map(name);
            malformed(NODES, format!("'{text}' is neither '{one}' nor '{other}'"))
        })
    }

    fn key(&self, key: &str) -> Option<&'a str> {
        self.keys.iter().find(|(known, _)| *known == key).map(|(_, value)| value.trim())
    }
}

/// Vectors written `(x,y,z)`; none where the text is anything else.
fn vectors(text: &str) -> Option<Vec<DVec3>> {
    let parts = text.split_terminator(')').map(|part| part.trim_start().strip_prefix('('));
    let vector = |part: Option<&str>| {
        let numbers: Option<Vec<f64>> = part?.split(',').map(|x| x.trim().parse().ok()).collect();
        Some(DVec3::from_array(numbers?.try_into().ok()?))
    };
    parts.map(vector).collect()
}

/// The one value of all three.
fn equal([x, y, z]: [f64; 3]) -> Option<f64> {
    (x.total_cmp(&y).is_eq() && x.total_cmp(&z).is_eq()).then_some(x)
}

fn numbers<const N: usize, T>(
    data: &[u8],
    dims: [usize; 3],
    is_big: bool,
    number: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>, VolumeError> {
    if count(dims).and_then(|count| count.checked_mul(N)) != Some(data.len()) {
        let expected = dims.iter().fold(N as u128, |bytes, &n| bytes.saturating_mul(n as u128));
        return Err(VolumeError::Size { format: FORMAT, dims, expected, found: data.len() });
    }
    let in_order = |&(mut bytes): &[u8; N]| {
        if is_big {
            bytes.reverse();
        }
        number(bytes)
    };
    Ok(data.as_chunks::<N>().0.iter().map(in_order).collect())
}

fn malformed(place: &str, problem: String) -> VolumeError {
    VolumeError::Malformed { format: FORMAT, place: place.to_owned(), problem }
}

fn unsupported(feature: String) -> VolumeError {
    let advice = "save it as raw floats or steps behind their header, on a grid along the axes with one \
                  spacing, left-posterior-superior";
    VolumeError::Unsupported { format: FORMAT, feature, advice }
}
