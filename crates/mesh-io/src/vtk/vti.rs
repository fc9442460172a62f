//! VTK image data (`.vti`): values at the points of a grid.
//!
//! Written as appended raw data behind a 64-bit count of bytes, which VTK reads many
//! times as fast as base64. Read in every encoding of VTK's arrays.

use std::fmt::Display;
use std::str::FromStr;

use distance_field::{DistanceField, FieldGrid, NodeValues};
use glam::DVec3;

use super::array::DataArray;
use super::xml::Element;
use super::{Dialect, VtkFile};
use crate::ReadError;
use crate::error::Format;
use crate::stored_values::{StoredValues, common_value, node_count, single};
use crate::text::{numbers, quoted};

const VTI: Dialect = Dialect {
    format: Format {
        name: "VTI",
        remedy: "save it as one piece of image data along the axes with one spacing, \
                 uncompressed or compressed by zlib",
    },
    dataset: "ImageData",
};

/// Name of the written array of distances, and of the one that is read among several.
const DISTANCES: &str = "signed_distance";

/// The same where the values are multiples of a step.
const STEPS: &str = "signed_distance_in_steps";

/// Name of the array in the field data with the length of a step.
const STEP: &str = "distance_step";

/// Name of the array in the field data with the kind of node values: 0 for
/// interpolating, 1 for quasi-interpolating ones.
const NODES: &str = "quasi_interpolating_nodes";

const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// Returns a field as a file.
pub(crate) fn encode_vti(field: &DistanceField) -> Vec<u8> {
    let values = StoredValues::of(field);
    let mut bytes = header(field, &values).into_bytes();
    let data = values.little_endian();
    bytes.extend((data.len() as u64).to_le_bytes());
    bytes.extend(data);
    bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
    bytes
}

fn header(field: &DistanceField, values: &StoredValues) -> String {
    let (DVec3 { x, y, z }, h) = (field.grid().origin(), field.grid().spacing());
    // The ends of VTK's extents are included, so that nodes count from 0 to one less.
    let [i, j, k] = field.grid().dims().map(|n| n - 1);

    // Rounded distances are multiples of a step, which a reader needs with them.
    let (number, name, step) = match values {
        StoredValues::Distances(_) => ("Float32", DISTANCES, String::new()),
        StoredValues::Steps { step, .. } => {
            ("Int16", STEPS, one_number_array("Float64", STEP, *step))
        }
    };
    let nodes = match field.node_values() {
        NodeValues::Interpolating => 0,
        NodeValues::QuasiInterpolating => 1,
    };
    let nodes = one_number_array("Int32", NODES, nodes);

    // The values follow as raw bytes, at once behind the underscore.
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

/// Returns an array of the field data.
fn one_number_array(number_type: &str, name: &str, number: impl Display) -> String {
    format!(
        r#"<DataArray type="{number_type}" Name="{name}" NumberOfTuples="1" format="ascii">{number}</DataArray>
"#
    )
}

/// Reads one piece of image data along the axes, of one spacing.
pub(crate) fn parse_vti(bytes: &[u8]) -> Result<DistanceField, ReadError> {
    let file = VtkFile::parse(bytes, &VTI)?;
    let image = &file.dataset;

    // The grid: the extent gives the numbers of the first and last node per axis.
    let whole = Extent::of(image, "WholeExtent")?;
    let origin = DVec3::from_array(numbers_of(image, "Origin", [0.0; 3])?);
    let spacings = numbers_of(image, "Spacing", [1.0; 3])?;
    let [x, y, z] = spacings;
    let Some(spacing) = common_value(spacings) else {
        return Err(VTI.format.unsupported(format!("a grid of spacings {x} {y} {z}")));
    };
    let direction = numbers_of(image, "Direction", IDENTITY)?;
    if direction.map(f64::to_bits) != IDENTITY.map(f64::to_bits) {
        return Err(VTI.format.unsupported(format!("a grid along {direction:?}")));
    }
    let origin = origin + spacing * whole.first();

    // The values: those of the only piece.
    let dims = whole.dims();
    let piece = only_piece(image, dims)?;
    let values = read_values(&file, piece, dims)?;
    let nodes = read_node_kind(&file)?;
    values.into_field(FieldGrid::new(origin, spacing, dims)?, nodes)
}

/// Returns the piece of a grid that is not divided.
fn only_piece(image: &Element, dims: [usize; 3]) -> Result<&Element, ReadError> {
    let mut pieces = image.children("Piece");
    let Some(piece) = pieces.next() else {
        return Err(VTI.malformed_at(image, "the image data have no piece"));
    };
    if pieces.next().is_some() {
        return Err(VTI.format.unsupported("a grid in several pieces"));
    }
    if Extent::of(piece, "Extent")?.dims() != dims {
        return Err(VTI.format.unsupported("a part of a grid"));
    }
    Ok(piece)
}

fn read_values(
    file: &VtkFile<'_>,
    piece: &Element,
    dims: [usize; 3],
) -> Result<StoredValues, ReadError> {
    let array = DataArray::new(file, array_of_distances(piece)?);
    let count = usize::try_from(node_count(dims)).unwrap_or(usize::MAX);

    // Distances as they are, or whole multiples of the step in the field data.
    if array.number_type() != "Int16" {
        let values = array.floats(count)?;
        let width = if array.number_type() == "Float64" { 8 } else { 4 };
        check_count(width, dims, values.len())?;
        return Ok(StoredValues::Distances(values.into_iter().map(single).collect()));
    }

    let steps: Result<Vec<i16>, _> =
        array.integers(count)?.into_iter().map(i16::try_from).collect();
    let steps = steps.map_err(|_| array.malformed("a step is beyond 16 bits"))?;
    check_count(2, dims, steps.len())?;
    let Some(length) = field_array(file, STEP) else {
        let problem = format!("values of 16 bits need an array '{STEP}' in the field data");
        return Err(array.malformed(problem));
    };
    let step = only_number(&length, &length.floats(1)?)?;
    Ok(StoredValues::Steps { steps, step })
}

/// Checks that there is one value per node.
fn check_count(width: usize, dims: [usize; 3], found: usize) -> Result<(), ReadError> {
    let expected = node_count(dims);
    if expected == found as u128 {
        return Ok(());
    }
    let (expected, found) = (expected.saturating_mul(width as u128), found * width);
    Err(ReadError::WrongSize { format: VTI.format.name, dims, expected, found })
}

/// Returns the array of distances at the points of a piece: by its name, or else the
/// active one, or else the only one.
fn array_of_distances(piece: &Element) -> Result<&Element, ReadError> {
    let Some(points) = piece.child("PointData") else {
        return Err(VTI.malformed_at(piece, "there are no values at its points"));
    };
    let active = points.attribute("Scalars").unwrap_or_default();

    // Another program may have added arrays, or renamed the only one.
    let known = [DISTANCES, STEPS, active].map(|name| points.array(name));
    if let Some(array) = known.into_iter().flatten().next() {
        return Ok(array);
    }

    let arrays: Vec<&Element> = points.children("DataArray").collect();
    let [only] = arrays[..] else {
        let count = arrays.len();
        let problem = format!("none of {count} arrays at its points is '{DISTANCES}' or active");
        return Err(VTI.malformed_at(points, problem));
    };
    Ok(only)
}

/// Reads the kind of node values, interpolating where the file does not say.
fn read_node_kind(file: &VtkFile<'_>) -> Result<NodeValues, ReadError> {
    let Some(array) = field_array(file, NODES) else {
        return Ok(NodeValues::Interpolating);
    };
    match only_number(&array, &array.integers(1)?)? {
        0 => Ok(NodeValues::Interpolating),
        1 => Ok(NodeValues::QuasiInterpolating),
        other => Err(array.malformed(format!("is {other}, neither 0 nor 1"))),
    }
}

fn field_array<'a>(file: &'a VtkFile<'a>, name: &str) -> Option<DataArray<'a>> {
    let array = file.dataset.child("FieldData")?.array(name)?;
    Some(DataArray::new(file, array))
}

fn only_number<T: Copy>(array: &DataArray<'_>, numbers: &[T]) -> Result<T, ReadError> {
    match *numbers {
        [number] => Ok(number),
        _ => Err(array.malformed(format!("has {} numbers, not one", numbers.len()))),
    }
}

/// Numbers of the first and last node along each axis.
#[derive(Clone, Copy, Debug)]
struct Extent([i32; 6]);

impl Extent {
    fn of(element: &Element, name: &str) -> Result<Self, ReadError> {
        let text = element.attribute(name).unwrap_or_default();
        let Some(extent) = numbers(text) else {
            let problem = format!("{name}={} is not the extent of a grid", quoted(text));
            return Err(VTI.malformed_at(element, problem));
        };
        Ok(Self(extent))
    }

    fn first(self) -> DVec3 {
        let [x, _, y, _, z, _] = self.0.map(f64::from);
        DVec3::new(x, y, z)
    }

    /// Returns the number of nodes along each axis, 0 where the extent is reversed.
    fn dims(self) -> [usize; 3] {
        let [x0, x1, y0, y1, z0, z1] = self.0.map(i64::from);
        [x1 - x0, y1 - y0, z1 - z0].map(|steps| usize::try_from(steps + 1).unwrap_or(0))
    }
}

/// Returns the numbers of an attribute, `default` where it is left out.
fn numbers_of<const N: usize, T: FromStr>(
    element: &Element,
    name: &str,
    default: [T; N],
) -> Result<[T; N], ReadError> {
    let Some(text) = element.attribute(name) else {
        return Ok(default);
    };
    match numbers(text) {
        Some(numbers) => Ok(numbers),
        None => {
            let problem = format!("{name}={} is not {N} numbers", quoted(text));
            Err(VTI.malformed_at(element, problem))
        }
    }
}
