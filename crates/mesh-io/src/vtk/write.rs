//! Writer of VTK polygonal data with values per vertex, and of arrays for other data.
//!
//! Arrays stand inline in base64: raw appended data would be smaller but is not XML, and
//! readers with a strict parser refuse it. Of the values, the first are active: viewers
//! color the surface by them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use crate::Space;

/// Values at the vertices of a surface, with their name.
#[derive(Clone, Copy, Debug)]
pub enum PointValues<'a> {
    /// |V| numbers.
    Scalars(&'static str, &'a [f64]),
    /// |V| vectors.
    Vectors(&'static str, &'a [DVec3]),
}

/// Values of cells, with their name.
#[derive(Clone, Copy, Debug)]
pub enum CellValues<'a> {
    /// One whole number per cell.
    Numbers(&'static str, &'a [u32]),
    /// One number per cell.
    Scalars(&'static str, &'a [f64]),
}

/// Cells of polygonal data: points of each, in order.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a> {
    /// Closed polygons.
    Polygons(&'a [Vec<u32>]),
    /// Chains of segments.
    Lines(&'a [Vec<u32>]),
}

/// Returns a surface with values per vertex as a `.vtp` file, which states the space of its positions
/// where there is one.
#[must_use]
pub fn write_vtp(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    values: &[PointValues<'_>],
    space: Option<Space>,
) -> String {
    let polygons = CellList::new(faces.iter().map(|face| &face[..]));
    poly_data(positions, values, [&polygons, &CellList::default()], &[], space)
}

/// Returns polygons or chains of segments as a `.vtp` file, with values per point and per cell, which
/// states the space of its positions where there is one.
#[must_use]
pub fn write_vtp_cells(
    positions: &[DVec3],
    cells: Cells<'_>,
    values: &[PointValues<'_>],
    cell_values: &[CellValues<'_>],
    space: Option<Space>,
) -> String {
    let (Cells::Polygons(list) | Cells::Lines(list)) = cells;
    let list = CellList::new(list.iter().map(|cell| &cell[..]));
    let none = CellList::default();
    let lists = if matches!(cells, Cells::Polygons(_)) { [&list, &none] } else { [&none, &list] };
    poly_data(positions, values, lists, cell_values, space)
}

/// Cells of one kind, as the file has them.
#[derive(Debug, Default)]
struct CellList {
    count: usize,
    /// Points of all cells, one after the other.
    points: Vec<u32>,
    /// Number of points up to the end of each cell.
    ends: Vec<u64>,
}

impl CellList {
    fn new<'a>(cells: impl Iterator<Item = &'a [u32]>) -> Self {
        let mut list = Self::default();
        for cell in cells {
            list.count += 1;
            list.points.extend(cell);
            list.ends.push(list.points.len() as u64);
        }
        list
    }

    /// Writes the list under the name of its kind, or nothing without cells.
    fn element(&self, kind: &str) -> String {
        if self.count == 0 {
            return String::new();
        }
        let points = self.points.iter().copied().map(u32::to_le_bytes);
        let connectivity = array("UInt32", "connectivity", 1, points);
        let ends = self.ends.iter().copied().map(u64::to_le_bytes);
        let offsets = array("UInt64", "offsets", 1, ends);
        format!("<{kind}>\n{connectivity}{offsets}</{kind}>\n")
    }
}

fn poly_data(
    positions: &[DVec3],
    values: &[PointValues<'_>],
    [polygons, lines]: [&CellList; 2],
    cell_values: &[CellValues<'_>],
    space: Option<Space>,
) -> String {
    let (point_data, points) = point_arrays(positions, values);

    // Without values per cell there is no element for them.
    let mut cell_data: String = cell_values.iter().map(CellValues::array).collect();
    if !cell_data.is_empty() {
        cell_data = format!("<CellData>\n{cell_data}</CellData>\n");
    }
    let (lines_element, polygons_element) = (lines.element("Lines"), polygons.element("Polys"));
    let field_data = field_data(space);
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
{field_data}<Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="{}" NumberOfStrips="0" NumberOfPolys="{}">
{point_data}{cell_data}{points}{lines_element}{polygons_element}</Piece>
</PolyData>
</VTKFile>
"#,
        positions.len(),
        lines.count,
        polygons.count,
    )
}

/// Writes the space of all points as 3D Slicer does, by the codes of its letters and a 0, or nothing.
pub(super) fn field_data(space: Option<Space>) -> String {
    let Some(space) = space else { return String::new() };
    let codes: String = space.to_string().bytes().map(|code| format!("{code} ")).collect();
    format!(
        "<FieldData>\n<Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" \
         format=\"ascii\">{codes}0</Array>\n</FieldData>\n"
    )
}

/// Writes the values at points, of which the first are active, and the points.
pub(super) fn point_arrays(positions: &[DVec3], values: &[PointValues<'_>]) -> (String, String) {
    let active = values.first().map_or("", |values| values.name());
    let arrays: String = values.iter().map(PointValues::array).collect();
    let points = PointValues::Vectors("Points", positions).array();
    (
        format!("<PointData Scalars=\"{active}\">\n{arrays}</PointData>\n"),
        format!("<Points>\n{points}</Points>\n"),
    )
}

impl PointValues<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Scalars(name, _) | Self::Vectors(name, _) => name,
        }
    }

    fn array(&self) -> String {
        match self {
            Self::Scalars(name, values) => scalars(name, values),
            Self::Vectors(name, values) => {
                let components = values.iter().flat_map(DVec3::to_array);
                array("Float64", name, 3, components.map(f64::to_le_bytes))
            }
        }
    }
}

impl CellValues<'_> {
    fn array(&self) -> String {
        match self {
            Self::Numbers(name, numbers) => {
                array("UInt32", name, 1, numbers.iter().copied().map(u32::to_le_bytes))
            }
            Self::Scalars(name, values) => scalars(name, values),
        }
    }
}

fn scalars(name: &str, values: &[f64]) -> String {
    array("Float64", name, 1, values.iter().copied().map(f64::to_le_bytes))
}

/// Returns an array with the number of its bytes before them, as the format demands.
pub(super) fn array<const N: usize>(
    number_type: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = [u8; N]>,
) -> String {
    // The length stands in the same run of base64 as the content, and is known after it.
    let mut bytes = vec![0; size_of::<u64>()];
    for value in values {
        bytes.extend_from_slice(&value);
    }
    let length = (bytes.len() - size_of::<u64>()) as u64;
    bytes[..size_of::<u64>()].copy_from_slice(&length.to_le_bytes());

    format!(
        "<DataArray type=\"{number_type}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{}</DataArray>\n",
        STANDARD.encode(bytes)
    )
}
