//! VTK XML image data (`.vti`): values at the points of a grid.
//!
//! Written as appended raw data behind a 64-bit count of bytes, which VTK reads
//! many times as fast as base64. Read in every encoding that the arrays of
//! `.vtp` files come in.
//!
//! Source: "VTK XML File Formats", the VTK documentation.

use std::fmt::Display;

use glam::DVec3;
use musculo_collide::distance_field::{DistanceField, NodeValues};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::{Values, VolumeError, count, field, single};
use crate::read::{Appended, Array, Conventions, attribute, cut_appended, text_of};

const FORMAT: &str = "VTI";

/// Name of the array that is written, and of the one that is read where there
/// are several.
const NAME: &str = "signed_distance";

/// The same where values are whole steps, and of the array in the field data that
/// holds the length of one.
const NAME_IN_STEPS: &str = "signed_distance_in_steps";
const STEP: &str = "distance_step";

/// Name of the array there that says what values are right for: 0 for the nodes
/// themselves, 1 for all that lies between them.
const NODES: &str = "quasi_interpolating_nodes";

/// A field as a file.
pub(super) fn encode(field: &DistanceField) -> Vec<u8> {
    let values = Values::of(field);
    let mut bytes = header(field, &values).into_bytes();
    let data = values.little_endian();
    bytes.extend((data.len() as u64).to_le_bytes());
    bytes.extend(data);
    bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
    bytes
}

pub(super) fn header(field: &DistanceField, values: &Values) -> String {
    let (DVec3 { x, y, z }, h) = (field.grid().origin(), field.grid().spacing());
    let [i, j, k] = field.grid().dims().map(|n| n - 1);
    let (number, name, step) = match values {
        Values::Floats(_) => ("Float32", NAME, String::new()),
        Values::Steps(_, step) => ("Int16", NAME_IN_STEPS, number_array("Float64", STEP, *step)),
    };
    let nodes = match field.node_values() {
        NodeValues::Interpolating => 0,
        NodeValues::QuasiInterpolating => 1,
    };
    let nodes = number_array("Int32", NODES, nodes);
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<ImageData WholeExtent="0 {i} 0 {j} 0 {k}" Origin="{x} {y} {z}" Spacing="{h} {h} {h}" Direction="1 0 0 0 1 0 0 0 1">
<FieldData>
{nodes}{step}</FieldData>
<Piece Extent="0 {i} 0 {j} 0 {k}">
<PointData Scalars="{name}">
<DataArray type="{number}" Name="{name}" NumberOfComponents="1" format="appended" offset="0"/>
</PointData>
</Piece>
</ImageData>
<AppendedData encoding="raw">
_"#
    )
}

/// An array of the field data that holds one number.
fn number_array(number_type: &str, name: &str, number: impl Display) -> String {
    format!(
        r#"<DataArray type="{number_type}" Name="{name}" NumberOfTuples="1" format="ascii">{number}</DataArray>
"#
    )
}

/// Reads one piece of image data along the axes, of one spacing.
pub(super) fn decode(bytes: &[u8]) -> Result<DistanceField, VolumeError> {
    let (xml, appended) = cut_appended(bytes)?;
    let document = Document::read(xml)?;
    let [dims, piece] = [document.whole, document.piece].map(|extent| extent.map(Extent::dims));
    let dims = dims.ok_or_else(|| malformed("the file has no ImageData".to_owned()))?;
    if piece.is_some_and(|piece| piece != dims) {
        return Err(unsupported("a part of a grid".to_owned()));
    }
    let array = document.array()?;
    let conventions = &document.conventions;
    let values = if array.number_type == "Int16" {
        let steps = array.integers(conventions, appended)?.into_iter().map(i16::try_from);
        let steps: Result<Vec<i16>, _> = steps.collect();
        let steps = steps.map_err(|_| malformed("a step is beyond 16 bits".to_owned()))?;
        check_count(array, dims, steps.len())?;
        Values::Steps(steps, document.step(appended)?)
    } else {
        let values = array.floats(conventions, appended)?;
        check_count(array, dims, values.len())?;
        Values::Floats(values.into_iter().map(single).collect())
    };
    let first = document.whole.map_or([0; 3], |extent| extent.0.map(|[first, _]| first));
    let origin = document.origin + document.spacing * DVec3::from_array(first.map(f64::from));
    field((origin, document.spacing, dims), values, document.nodes(appended)?)
}

/// One value a node.
fn check_count(array: &Array, dims: [usize; 3], found: usize) -> Result<(), VolumeError> {
    if count(dims) == Some(found) {
        return Ok(());
    }
    let width: u8 = match array.number_type.as_str() {
        "Float64" => 8,
        "Int16" => 2,
        _ => 4,
    };
    let nodes = |bytes: u128, &n: &usize| bytes.saturating_mul(n as u128);
    let expected = dims.iter().fold(width.into(), nodes);
    let found = found * usize::from(width);
    Err(VolumeError::Size { format: FORMAT, dims, expected, found })
}

/// Numbers of the first and last node along each axis.
#[derive(Clone, Copy, Debug)]
struct Extent([[i32; 2]; 3]);

impl Extent {
    /// Nodes along each axis, as many as a malformed extent has: 0.
    fn dims(self) -> [usize; 3] {
        self.0.map(|[first, last]| {
            usize::try_from(i64::from(last) - i64::from(first) + 1).unwrap_or(0)
        })
    }
}

/// What the array that is read next belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    Points,
    Field,
    #[default]
    Elsewhere,
}

/// What a file says of its grid, with the arrays at its points.
#[derive(Debug, Default)]
struct Document {
    conventions: Conventions,
    whole: Option<Extent>,
    piece: Option<Extent>,
    origin: DVec3,
    spacing: f64,
    /// The array that the file calls active.
    active: Option<String>,
    place: Place,
    arrays: Vec<Array>,
    /// The array with the length of a step, and that with what values are right for.
    step: Option<Array>,
    nodes: Option<Array>,
}

impl Document {
    fn read(xml: &[u8]) -> Result<Self, VolumeError> {
        let (mut reader, mut document) = (Reader::from_reader(xml), Self::default());
        loop {
            let place = format!("byte {}", reader.buffer_position());
            let event = reader.read_event().map_err(|e| malformed_at(&place, e.to_string()))?;
            match &event {
                Event::Start(tag) if tag.name().as_ref() == "DataArray" => {
                    let text = text_of(&mut reader, tag, &place)?;
                    document.keep(tag, text, &place)?;
                }
                Event::Empty(tag) if tag.name().as_ref() == "DataArray" => {
                    document.keep(tag, Vec::new(), &place)?;
                }
                Event::Start(tag) | Event::Empty(tag) => document.open(tag, &place)?,
                Event::End(tag) if ["PointData", "FieldData"].contains(&tag.name().as_ref()) => {
                    document.place = Place::Elsewhere;
                }
                Event::Eof => return Ok(document),
                _ => {}
            }
        }
    }

    fn open(&mut self, tag: &BytesStart<'_>, place: &str) -> Result<(), VolumeError> {
        let get = |name: &str| attribute(tag, name, place).map_err(VolumeError::from);
        match tag.name().as_ref() {
            "VTKFile" => {
                let kind = get("type")?.unwrap_or_default();
                if kind != "ImageData" {
                    return Err(unsupported(format!("data of type '{kind}'")));
                }
                let [order, header] = [get("byte_order")?, get("header_type")?];
                let compressor = get("compressor")?;
                self.conventions =
                    Conventions::new(order.as_deref(), header.as_deref(), compressor);
            }
            "ImageData" => {
                self.whole = Some(extent(get("WholeExtent")?, place)?);
                self.origin = DVec3::from_array(numbers(get("Origin")?, "0 0 0", place)?);
                self.spacing = one_spacing(numbers(get("Spacing")?, "1 1 1", place)?)?;
                let along: [f64; 9] = numbers(get("Direction")?, "1 0 0 0 1 0 0 0 1", place)?;
                if along.map(f64::to_bits) != IDENTITY.map(f64::to_bits) {
                    return Err(unsupported(format!("a grid along {along:?}")));
                }
            }
            "Piece" if self.piece.is_some() => {
                return Err(unsupported("a grid in several pieces".to_owned()));
            }
            "Piece" => self.piece = Some(extent(get("Extent")?, place)?),
            "PointData" => {
                self.place = Place::Points;
                self.active = get("Scalars")?;
            }
            "FieldData" => self.place = Place::Field,
            _ => {}
        }
        Ok(())
    }

    fn keep(
        &mut self,
        tag: &BytesStart<'_>,
        text: Vec<u8>,
        place: &str,
    ) -> Result<(), VolumeError> {
        if self.place == Place::Elsewhere {
            return Ok(());
        }
        let get = |name: &str| attribute(tag, name, place).map_err(VolumeError::from);
        let offset = get("offset")?.map(|text| text.trim().parse());
        let array = Array {
            name: get("Name")?.unwrap_or_default(),
            number_type: get("type")?.unwrap_or_default(),
            format: get("format")?.unwrap_or_else(|| "ascii".to_owned()),
            offset: offset
                .transpose()
                .map_err(|_| malformed_at(place, "the offset is not a count".to_owned()))?,
            text,
        };
        match self.place {
            Place::Points => self.arrays.push(array),
            Place::Field if array.name == STEP => self.step = Some(array),
            Place::Field if array.name == NODES => self.nodes = Some(array),
            _ => {}
        }
        Ok(())
    }

    /// Length of a step.
    fn step(&self, appended: Option<Appended<'_>>) -> Result<f64, VolumeError> {
        let Some(array) = &self.step else {
            let problem = format!("values of 16 bits need an array '{STEP}' in the field data");
            return Err(malformed(problem));
        };
        only(array, &array.floats(&self.conventions, appended)?)
    }

    /// What values are right for.
    fn nodes(&self, appended: Option<Appended<'_>>) -> Result<NodeValues, VolumeError> {
        let Some(array) = &self.nodes else {
            return Ok(NodeValues::Interpolating);
        };
        match only(array, &array.integers(&self.conventions, appended)?)? {
            0 => Ok(NodeValues::Interpolating),
            1 => Ok(NodeValues::QuasiInterpolating),
            other => Err(malformed(format!("the array '{NODES}' is {other}, neither 0 nor 1"))),
        }
    }

    /// The array of distances: by its name, else the active one, else the only
    /// one.
    fn array(&self) -> Result<&Array, VolumeError> {
        let named = |name: &str| self.arrays.iter().find(|array| array.name == name);
        let only = if let [only] = &self.arrays[..] { Some(only) } else { None };
        named(NAME)
            .or_else(|| named(NAME_IN_STEPS))
            .or_else(|| named(self.active.as_deref()?))
            .or(only)
            .ok_or_else(|| {
                let count = self.arrays.len();
                malformed(format!("none of {count} arrays at its points is '{NAME}' or active"))
            })
    }
}

/// The one number of an array.
fn only<T: Copy>(array: &Array, numbers: &[T]) -> Result<T, VolumeError> {
    match *numbers {
        [number] => Ok(number),
        _ => {
            let (name, count) = (&array.name, numbers.len());
            Err(malformed(format!("the array '{name}' holds {count} numbers, not one")))
        }
    }
}

const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

fn extent(text: Option<String>, place: &str) -> Result<Extent, VolumeError> {
    let text = text.unwrap_or_default();
    let numbers: Option<Vec<i32>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[a, b, c, d, e, f]) => Ok(Extent([[a, b], [c, d], [e, f]])),
        _ => Err(malformed_at(place, format!("'{text}' is not the extent of a grid"))),
    }
}

fn numbers<const N: usize>(
    text: Option<String>,
    default: &str,
    place: &str,
) -> Result<[f64; N], VolumeError> {
    let text = text.unwrap_or_else(|| default.to_owned());
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| malformed_at(place, format!("'{text}' is not {N} numbers")))
}

fn one_spacing([x, y, z]: [f64; 3]) -> Result<f64, VolumeError> {
    if x.total_cmp(&y).is_eq() && x.total_cmp(&z).is_eq() {
        return Ok(x);
    }
    Err(unsupported(format!("a grid of spacings {x} {y} {z}")))
}

fn malformed(problem: String) -> VolumeError {
    malformed_at("ImageData", problem)
}

fn malformed_at(place: &str, problem: String) -> VolumeError {
    VolumeError::Malformed { format: FORMAT, place: place.to_owned(), problem }
}

fn unsupported(feature: String) -> VolumeError {
    let advice = "save it as one piece of image data along the axes with one spacing";
    VolumeError::Unsupported { format: FORMAT, feature, advice }
}
