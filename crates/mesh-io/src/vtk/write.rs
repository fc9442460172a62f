//! Writer of VTK polygonal data with values per vertex.
//!
//! Arrays stand inline in base64: raw appended data would be smaller but is not XML, and
//! readers with a strict parser refuse it. Of the values, the first are active: viewers
//! color the surface by them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

/// Values at the vertices of a surface, with their name.
#[derive(Clone, Copy, Debug)]
pub enum PointValues<'a> {
    /// |V| numbers.
    Scalars(&'static str, &'a [f64]),
    /// |V| vectors.
    Vectors(&'static str, &'a [DVec3]),
}

/// Returns a surface with values per vertex as a `.vtp` file.
#[must_use]
pub fn write_vtp(positions: &[DVec3], faces: &[[u32; 3]], values: &[PointValues<'_>]) -> String {
    let active = values.first().map_or("", |values| values.name());
    let point_data: String = values.iter().map(PointValues::array).collect();
    let points = PointValues::Vectors("Points", positions).array();

    // Corners one after the other, and the number of corners up to the end of each face.
    let corners = faces.iter().flatten().copied();
    let connectivity = array("UInt32", "connectivity", 1, corners.map(u32::to_le_bytes));
    let ends = (3_u64..).step_by(3).take(faces.len());
    let offsets = array("UInt64", "offsets", 1, ends.map(u64::to_le_bytes));

    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
<Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{}">
<PointData Scalars="{active}">
{point_data}</PointData>
<Points>
{points}</Points>
<Polys>
{connectivity}{offsets}</Polys>
</Piece>
</PolyData>
</VTKFile>
"#,
        positions.len(),
        faces.len(),
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
            Self::Scalars(name, values) => {
                array("Float64", name, 1, values.iter().copied().map(f64::to_le_bytes))
            }
            Self::Vectors(name, values) => {
                let components = values.iter().flat_map(DVec3::to_array);
                array("Float64", name, 3, components.map(f64::to_le_bytes))
            }
        }
    }
}

/// Returns an array with the number of its bytes before them, as the format demands.
fn array<const N: usize>(
    number_type: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = [u8; N]>,
) -> String {
    let content: Vec<u8> = values.flatten().collect();

    // The length stands in the same run of base64 as the content.
    let mut bytes = (content.len() as u64).to_le_bytes().to_vec();
    bytes.extend(content);

    format!(
        "<DataArray type=\"{number_type}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{}</DataArray>\n",
        STANDARD.encode(bytes)
    )
}
