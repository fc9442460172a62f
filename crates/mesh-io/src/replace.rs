//! Files written again with other positions, and everything else as it was.
//!
//! Only the bytes of coordinates change: format, encoding, number type, order, attributes, groups
//! and comments stay. Text that stands for a coordinate already is kept as it is spelled. What is
//! written reads back to positions that are rounded to the file's number type.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::copy::{Copy, Precision, check_count, check_range};
use crate::inp_model::{self, InpModel};
use crate::mesh_format::FileFormat;
use crate::text::split_mark;
use crate::text_nodes::TextNodes;
use crate::vtk::{VtkPoints, legacy_precision, replace_legacy, replace_points};
use crate::{MeshFormat, ReadError, feb, msh, obj, off, ply_replace, stl};

/// Writes a mesh file again with other positions: those of its vertices, or of all nodes of a volume
/// mesh.
///
/// Normals of STL facets that move are computed anew; other attributes stay as they are. Points of
/// VTK files whose length would change are written inline.
///
/// # Errors
///
/// The reason, where the content is not a mesh, has another number of positions, or has them in a
/// form that cannot be written again.
pub fn replace_positions(
    file: &[u8],
    extension: &str,
    positions: &[DVec3],
) -> Result<Vec<u8>, ReadError> {
    // The mark stays where it was.
    let (mark, file) = split_mark(file);
    let content = replaced(file, extension, positions)?;
    Ok(if mark.is_empty() { content } else { [mark, &content].concat() })
}

fn replaced(file: &[u8], extension: &str, positions: &[DVec3]) -> Result<Vec<u8>, ReadError> {
    match FileFormat::recognize(file, extension)? {
        FileFormat::Surface(MeshFormat::Obj) => obj::replace(file, positions),
        FileFormat::Surface(MeshFormat::Off) => off::replace(file, positions),
        FileFormat::Surface(MeshFormat::Ply) => ply_replace::replace(file, positions),
        FileFormat::Surface(MeshFormat::Stl) => stl::replace(file, positions),
        FileFormat::Surface(MeshFormat::Vtp) => {
            replace_points(file, VtkPoints::PolyData, positions)
        }
        FileFormat::Vtu => replace_points(file, VtkPoints::UnstructuredGrid, positions),
        FileFormat::Vtk => replace_legacy(file, positions),
        FileFormat::Msh => {
            replace_nodes(file, &msh::parse_nodes(file)?, Precision::Double, positions)
        }
        FileFormat::Inp => {
            let model = InpModel::read_nodes(file)?;
            check_count(model.node_count(), positions)?;
            model.move_nodes(file, (0..).zip(positions.iter().copied()))
        }
        FileFormat::Feb => {
            replace_nodes(file, &feb::parse(file)?.nodes, Precision::Double, positions)
        }
    }
}

/// Writes a file with parts again, with some of its nodes elsewhere, by their indices.
///
/// # Errors
///
/// [`ReadError::NoParts`] of other files; a position that is not finite, and a node that the file has not;
/// [`ReadError::SharedPart`] of a node that several instances have.
pub fn move_nodes(
    file: &[u8],
    extension: &str,
    moves: &BTreeMap<u32, DVec3>,
) -> Result<Vec<u8>, ReadError> {
    let (mark, file) = split_mark(file);
    let places = match FileFormat::recognize(file, extension)? {
        FileFormat::Feb => feb::parse(file)?.nodes.places,
        FileFormat::Msh => msh::parse_nodes(file)?.places,
        FileFormat::Inp => {
            let moves = moves.iter().map(|(&node, &x)| (node, x));
            let content = InpModel::read_nodes(file)?.move_nodes(file, moves)?;
            return Ok([mark, &content].concat());
        }
        _ => return Err(ReadError::NoParts),
    };
    let mut copy = Copy::new(file);
    for (&node, &x) in moves {
        check_range(Precision::Double, &[x], node as usize)?;
        let Some(places) = places.get(node as usize) else {
            let (expected, found) = (places.len(), node as usize + 1);
            return Err(ReadError::PositionCount { expected, found });
        };
        copy.put_position(places, x, Precision::Double);
    }
    Ok([mark, &copy.finish()].concat())
}

/// Returns the number type in which [`replace_positions`] writes coordinates into a file.
///
/// # Errors
///
/// The reason, where the content is not a mesh, or its coordinates cannot be written again.
pub fn coordinate_precision(file: &[u8], extension: &str) -> Result<Precision, ReadError> {
    let (_, file) = split_mark(file);
    match FileFormat::recognize(file, extension)? {
        FileFormat::Surface(MeshFormat::Obj | MeshFormat::Off)
        | FileFormat::Msh
        | FileFormat::Feb => Ok(Precision::Double),
        FileFormat::Surface(MeshFormat::Ply) => ply_replace::precision(file),
        FileFormat::Surface(MeshFormat::Stl) => Ok(stl::precision(file)),
        FileFormat::Surface(MeshFormat::Vtp) => VtkPoints::PolyData.precision(file),
        FileFormat::Vtu => VtkPoints::UnstructuredGrid.precision(file),
        FileFormat::Vtk => legacy_precision(file),
        FileFormat::Inp => Ok(Precision::TwentyCharacters),
    }
}

/// Returns bounds on the distances by which positions of bodies are rounded because they are written in the axes of
/// parts of the file; 0 where the file has them where they are read. Bodies are given by the names of their parts,
/// none for all, each with the maximum of its coordinates.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn placement_roundings(
    file: &[u8],
    extension: &str,
    bodies: &[&[String]],
    max_coordinates: &[f64],
) -> Result<Vec<f64>, ReadError> {
    let (_, file) = split_mark(file);
    match FileFormat::recognize(file, extension)? {
        FileFormat::Inp => inp_model::placement_roundings(file, bodies, max_coordinates),
        _ => Ok(vec![0.0; bodies.len()]),
    }
}

/// Writes nodes of a text file.
fn replace_nodes(
    file: &[u8],
    nodes: &TextNodes,
    precision: Precision,
    positions: &[DVec3],
) -> Result<Vec<u8>, ReadError> {
    check_count(nodes.places.len(), positions)?;
    check_range(precision, positions, 0)?;
    let mut copy = Copy::new(file);
    for (places, x) in nodes.places.iter().zip(positions) {
        copy.put_position(places, *x, precision);
    }
    Ok(copy.finish())
}
