//! One body as VTK XML polygonal data, with its contact as point data.
//!
//! Arrays stand inline in base64: raw appended data would be smaller but is not
//! XML, and readers built with a strict parser refuse it. The first of the
//! point data is active and so coloured when the file is opened: `signed_gap`
//! beside `penetration_depth`, or `displacement_length` beside `displacement`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::ContactField;

/// A `.vtp` file of a surface and its contact.
pub(crate) fn vtp(positions: &[DVec3], faces: &[[u32; 3]], field: &ContactField) -> String {
    let data =
        scalars("signed_gap", &field.signed_gaps) + &scalars("penetration_depth", &field.depths);
    poly_data(positions, faces, "signed_gap", &data)
}

/// A `.vtp` file of a surface and how far its vertices have moved.
pub(crate) fn displacement_vtp(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    displacements: &[DVec3],
) -> String {
    let lengths: Vec<f64> = displacements.iter().map(|u| u.length()).collect();
    let data = scalars("displacement_length", &lengths) + &vectors("displacement", displacements);
    poly_data(positions, faces, "displacement_length", &data)
}

/// A `.vtp` file of a surface and its vertices' signed distances from a medial one.
pub(crate) fn deviation_vtp(positions: &[DVec3], faces: &[[u32; 3]], distances: &[f64]) -> String {
    let data = scalars("medial_distance", distances);
    poly_data(positions, faces, "medial_distance", &data)
}

fn poly_data(positions: &[DVec3], faces: &[[u32; 3]], active: &str, data: &str) -> String {
    let points = vectors("Points", positions);
    let connectivity = array(
        "UInt32",
        "connectivity",
        1,
        faces.iter().flatten().map(|corner| corner.to_le_bytes()),
    );
    let offsets =
        array("UInt32", "offsets", 1, (1..).zip(faces).map(|(face, _)| u32::to_le_bytes(3 * face)));
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
<Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{}">
<PointData Scalars="{active}">
{data}</PointData>
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

fn scalars(name: &str, values: &[f64]) -> String {
    array("Float64", name, 1, values.iter().map(|value| value.to_le_bytes()))
}

fn vectors(name: &str, values: &[DVec3]) -> String {
    let components = values.iter().flat_map(|v| v.to_array().map(f64::to_le_bytes));
    array("Float64", name, 3, components)
}

/// An array with the number of its bytes before them, as the format asks.
fn array<const N: usize>(
    number_type: &str,
    name: &str,
    components: usize,
    values: impl Iterator<Item = [u8; N]>,
) -> String {
    let content: Vec<u8> = values.flatten().collect();
    let mut bytes = (content.len() as u64).to_le_bytes().to_vec();
    bytes.extend(content);
    format!(
        "<DataArray type=\"{number_type}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{}</DataArray>\n",
        STANDARD.encode(bytes)
    )
}
