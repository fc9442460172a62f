//! Binary PLY in the layout of most files: vertices of scalars, faces of one list of corners.
//!
//! It is read in place, many times as fast as through the general parser. `None` stands for any
//! other layout, and for files that end early: the parser reads the former, and names the problem of
//! the latter.

use glam::DVec3;
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType};

use crate::mesh::Polygons;

/// Place of a coordinate in the record of a vertex.
#[derive(Clone, Copy)]
enum Coordinate {
    Float(usize),
    Double(usize),
}

/// Reads vertices with coordinates in floats or doubles, and moves `bytes` behind them.
pub(crate) fn read_vertices(
    bytes: &mut &[u8],
    element: &ElementDef,
    header: &Header,
) -> Option<Vec<DVec3>> {
    if header.encoding != Encoding::BinaryLittleEndian {
        return None;
    }

    // Records have the same length where all properties are scalars.
    let mut coordinates = [None; 3];
    let mut record_length = 0;
    for PropertyDef { name, data_type } in element.properties.values() {
        let PropertyType::Scalar(scalar) = data_type else { return None };
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
            coordinates[axis] = Coordinate::new(scalar, record_length);
        }
        record_length += size_of_scalar(scalar);
    }

    let [x, y, z] = [coordinates[0]?, coordinates[1]?, coordinates[2]?];
    let (records, rest) = bytes.split_at_checked(record_length.checked_mul(element.count)?)?;
    let mut positions = Vec::with_capacity(element.count);
    for record in records.chunks_exact(record_length) {
        positions.push(DVec3::new(x.read(record)?, y.read(record)?, z.read(record)?));
    }
    *bytes = rest;
    Some(positions)
}

/// Reads faces that are lists of 32-bit corners, and moves `bytes` behind them.
pub(crate) fn read_faces(
    bytes: &mut &[u8],
    element: &ElementDef,
    header: &Header,
) -> Option<Polygons> {
    if header.encoding != Encoding::BinaryLittleEndian || element.properties.len() != 1 {
        return None;
    }
    let corner = match element.properties.values().next()?.data_type {
        PropertyType::List(ScalarType::UChar, ScalarType::Int) => signed_corner,
        PropertyType::List(ScalarType::UChar, ScalarType::UInt) => unsigned_corner,
        _ => return None,
    };

    // Each face takes as many bytes as its corners and their number: more do not fit.
    let mut polygons = Polygons::with_capacity(element.count.min(bytes.len() / 13));
    let mut rest = *bytes;
    for _ in 0..element.count {
        let (&count, behind) = rest.split_first()?;
        let (corners, behind) = behind.split_at_checked(4 * usize::from(count))?;
        polygons.push(corners.as_chunks().0.iter().map(corner));
        rest = behind;
    }
    *bytes = rest;
    Some(polygons)
}

impl Coordinate {
    fn new(scalar: &ScalarType, offset: usize) -> Option<Self> {
        match scalar {
            ScalarType::Float => Some(Self::Float(offset)),
            ScalarType::Double => Some(Self::Double(offset)),
            _ => None,
        }
    }

    #[inline]
    fn read(self, record: &[u8]) -> Option<f64> {
        match self {
            Self::Float(offset) => {
                record[offset..].first_chunk().map(|&bytes| f32::from_le_bytes(bytes).into())
            }
            Self::Double(offset) => {
                record[offset..].first_chunk().map(|&bytes| f64::from_le_bytes(bytes))
            }
        }
    }
}

fn signed_corner(bytes: &[u8; 4]) -> i64 {
    i32::from_le_bytes(*bytes).into()
}

fn unsigned_corner(bytes: &[u8; 4]) -> i64 {
    u32::from_le_bytes(*bytes).into()
}

pub(crate) const fn size_of_scalar(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}
