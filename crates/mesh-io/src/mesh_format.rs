//! File formats of meshes: recognized, read, and written from a surface.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use crate::inp_model::{self, InpModel};
use crate::parts::PartNodes;
use crate::text::{split_mark, starts_in_utf_16};
use crate::vtk::{is_legacy, parse_legacy, parse_vtp, parse_vtu, write_vtp};
use crate::{Mesh, ReadError, Space, extension, feb, msh, obj, off, ply, stl};

/// File format of a triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Object file format, of Geomview.
    Off,
    /// Stanford polygon file.
    Ply,
    /// Stereolithography.
    Stl,
    /// VTK XML polygonal data.
    Vtp,
}

/// Maximum distance of an XML file's opening tag from its start, behind a declaration
/// and comments.
const XML_TAG_WITHIN: usize = 1024;

impl MeshFormat {
    const ALL: [Self; 5] = [Self::Obj, Self::Off, Self::Ply, Self::Stl, Self::Vtp];

    /// Returns the format that the extension of a path stands for.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        Self::of_extension(&extension(path))
    }

    /// Returns the extension of this format's files, in lower case.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Off => "off",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Vtp => "vtp",
        }
    }

    /// Returns a surface as a file that reads back to the bit: the same positions and
    /// faces, in the same order, in the same space where there is one.
    ///
    /// PLY is binary. STL is text, since binary STL has single precision, in which
    /// surfaces at a small distance could overlap. It has no vertices of their own:
    /// those without a face are lost, equal ones are merged, and the order is that of
    /// their first faces.
    #[must_use]
    pub fn encode(self, positions: &[DVec3], faces: &[[u32; 3]], space: Option<Space>) -> Vec<u8> {
        match self {
            Self::Obj => obj::encode(positions, faces, space),
            Self::Off => off::encode(positions, faces, space),
            Self::Ply => ply::encode(positions, faces, space),
            Self::Stl => stl::encode(positions, faces, space),
            Self::Vtp => write_vtp(positions, faces, &[], space).into_bytes(),
        }
    }

    fn of_extension(extension: &str) -> Option<Self> {
        let mut formats = Self::ALL.into_iter();
        formats.find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }
}

/// File format of a mesh, with or without a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileFormat {
    Surface(MeshFormat),
    /// VTK XML unstructured grid.
    Vtu,
    /// Legacy VTK.
    Vtk,
    /// Gmsh.
    Msh,
    /// Abaqus input.
    Inp,
    /// FEBio model.
    Feb,
}

impl FileFormat {
    /// Returns the format by the content, or else by the extension.
    pub(crate) fn recognize(bytes: &[u8], extension: &str) -> Result<Self, ReadError> {
        let head = &bytes[..bytes.len().min(XML_TAG_WITHIN)];
        let holds = |tag: &[u8]| head.windows(tag.len()).any(|window| window == tag);
        if bytes.is_empty() {
            return Err(ReadError::Empty);
        }
        if starts_in_utf_16(head) && !stl::is_likely(bytes) {
            return Err(ReadError::Utf16);
        }
        if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
            return Ok(Self::Surface(MeshFormat::Ply));
        }
        if holds(b"<VTKFile") {
            let is_volume = holds(b"UnstructuredGrid");
            return Ok(if is_volume { Self::Vtu } else { Self::Surface(MeshFormat::Vtp) });
        }
        if is_legacy(head) {
            return Ok(Self::Vtk);
        }
        if holds(b"<febio_spec") {
            return Ok(Self::Feb);
        }
        if head.starts_with(b"$MeshFormat") {
            return Ok(Self::Msh);
        }
        if off::is_likely(head) {
            return Ok(Self::Surface(MeshFormat::Off));
        }

        // The others begin with anything: the extension decides, if it is one of ours.
        let likely = stl::is_likely(bytes).then_some(Self::Surface(MeshFormat::Stl));
        let expected = "PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP or FEB";
        Self::of_extension(extension).or(likely).ok_or(ReadError::UnknownFormat { expected })
    }

    fn of_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "vtu" => Some(Self::Vtu),
            "vtk" => Some(Self::Vtk),
            "msh" => Some(Self::Msh),
            "inp" => Some(Self::Inp),
            "feb" => Some(Self::Feb),
            other => MeshFormat::of_extension(other).map(Self::Surface),
        }
    }
}

/// Reads the content of a mesh file, whose name would end in `extension`.
///
/// # Errors
///
/// The reason, where the content is not a mesh.
pub fn parse_mesh(bytes: &[u8], extension: &str) -> Result<Mesh, ReadError> {
    let (_, bytes) = split_mark(bytes);
    match FileFormat::recognize(bytes, extension)? {
        FileFormat::Surface(MeshFormat::Obj) => obj::parse(bytes),
        FileFormat::Surface(MeshFormat::Off) => off::parse(bytes),
        FileFormat::Surface(MeshFormat::Ply) => ply::parse(bytes),
        FileFormat::Surface(MeshFormat::Stl) => stl::parse(bytes),
        FileFormat::Surface(MeshFormat::Vtp) => parse_vtp(bytes),
        FileFormat::Vtu => parse_vtu(bytes),
        FileFormat::Vtk => parse_legacy(bytes),
        FileFormat::Msh => msh::parse(bytes),
        FileFormat::Inp => inp_model::parse(bytes),
        FileFormat::Feb => feb::parse(bytes)?.mesh(&[]),
    }
}

/// Reads the meshes of bodies in one file, each by the names of its parts; without names, it is the only part.
///
/// # Errors
///
/// The reason, where the content has no such parts, or these are no mesh; [`ReadError::NoParts`] for
/// names in a format without any.
pub fn parse_parts(
    bytes: &[u8],
    extension: &str,
    bodies: &[&[String]],
) -> Result<Vec<Mesh>, ReadError> {
    let (_, content) = split_mark(bytes);
    let has_names = bodies.iter().any(|parts| !parts.is_empty());
    match FileFormat::recognize(content, extension)? {
        FileFormat::Feb => {
            let model = feb::parse(content)?;
            bodies.iter().map(|parts| model.mesh(parts)).collect()
        }
        FileFormat::Inp if has_names => inp_model::parse_parts(content, bodies),
        FileFormat::Msh if has_names => {
            let parts = msh::parse_groups(content)?.parts;
            let mesh = |names: &&[String]| match names {
                [] => msh::parse(content),
                names => parts.mesh(names),
            };
            bodies.iter().map(mesh).collect()
        }
        _ if has_names => Err(ReadError::NoParts),
        _ => bodies.iter().map(|_| parse_mesh(bytes, extension)).collect(),
    }
}

/// Returns the names of the element sets that are meshes, of an Abaqus file that is one body unless they are named as
/// its parts, and of the physical groups of a Gmsh file likewise; none of other files.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn set_names(bytes: &[u8], extension: &str) -> Result<Vec<String>, ReadError> {
    let (_, content) = split_mark(bytes);
    match FileFormat::recognize(content, extension)? {
        FileFormat::Inp => inp_model::set_names(content),
        FileFormat::Msh => Ok(msh::parse_groups(content)?.parts.names()),
        _ => Ok(Vec::new()),
    }
}

/// Returns the names of the constraints of a model by which its surfaces are tied, which no mesh has; none of other
/// files.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn tie_names(bytes: &[u8], extension: &str) -> Result<Vec<String>, ReadError> {
    let (_, content) = split_mark(bytes);
    match FileFormat::recognize(content, extension)? {
        FileFormat::Feb => feb::tie_names(content),
        FileFormat::Inp => Ok(inp_model::tie_names(content)),
        _ => Ok(Vec::new()),
    }
}

/// Returns the nodes of each part by its name, whatever its elements are; none in a format without parts.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn nodes_by_part(
    bytes: &[u8],
    extension: &str,
) -> Result<BTreeMap<String, PartNodes>, ReadError> {
    let (_, content) = split_mark(bytes);
    match FileFormat::recognize(content, extension)? {
        FileFormat::Feb => Ok(feb::parse(content)?.nodes_by_part()),
        FileFormat::Inp => Ok(InpModel::read(content)?.nodes_by_part()),
        FileFormat::Msh => Ok(msh::parse_groups(content)?.parts.nodes_by_part()),
        _ => Ok(BTreeMap::new()),
    }
}

/// Returns the names of the instances that have the nodes of a part, by its name: of an Abaqus file with several
/// parts or instances, those without nodes of their own.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn instances_by_part(
    bytes: &[u8],
    extension: &str,
) -> Result<BTreeMap<String, Vec<String>>, ReadError> {
    let (_, content) = split_mark(bytes);
    match FileFormat::recognize(content, extension)? {
        FileFormat::Inp => inp_model::instances_by_part(content),
        _ => Ok(BTreeMap::new()),
    }
}

/// Returns the names of the parts that are meshes, none in a format without parts, and of an Abaqus file that is one
/// body: with one part or instance, or with element sets alone, each of which can be named as a part. Those of a Gmsh
/// file are its physical groups, where there are several with no element in two of them.
///
/// # Errors
///
/// The reason, where the content does not follow its format.
pub fn part_names(bytes: &[u8], extension: &str) -> Result<Vec<String>, ReadError> {
    let (_, content) = split_mark(bytes);
    match FileFormat::recognize(content, extension)? {
        FileFormat::Feb => Ok(feb::parse(content)?.names()),
        FileFormat::Inp => inp_model::part_names(content),
        FileFormat::Msh => Ok(msh::parse_groups(content)?.names_of_bodies()),
        _ => Ok(Vec::new()),
    }
}
