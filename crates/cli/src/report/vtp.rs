//! One body as VTK XML polygonal data, with its contact as point data.
//!
//! Arrays stand inline in base64: raw appended data would be smaller but is not
//! XML, and readers built with a strict parser refuse it. The point data are
//! `signed_gap`, which is active and so coloured when the file is opened, and
//! `penetration_depth`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::ContactField;

/// A `.vtp` file of a surface and its contact.
pub(crate) fn vtp(positions: &[DVec3], faces: &[[u32; 3]], field: &ContactField) -> String {
    let points = array(
        "Float64",
        "Points",
        3,
        positions.iter().flat_map(|p| p.to_array().map(f64::to_le_bytes)),
    );
    let connectivity = array(
        "UInt32",
        "connectivity",
        1,
        faces.iter().flatten().map(|corner| corner.to_le_bytes()),
    );
    let offsets =
        array("UInt32", "offsets", 1, (1..).zip(faces).map(|(face, _)| u32::to_le_bytes(3 * face)));
    let scalars = |name: &str, values: &[f64]| {
        array("Float64", name, 1, values.iter().map(|value| value.to_le_bytes()))
    };
    let gaps = scalars("signed_gap", &field.signed_gaps);
    let depths = scalars("penetration_depth", &field.depths);
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData>
<Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{}">
<PointData Scalars="signed_gap">
{gaps}{depths}</PointData>
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
