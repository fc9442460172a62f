//! From what a file lists to a triangle mesh whose indices and positions hold.
//!
//! Polygons are fanned from the first corner from which no triangle of the fan
//! turns against the polygon. A convex polygon is fanned from its first corner;
//! one that no corner sees whole is refused rather than folded.

use glam::DVec3;

use super::MeshError;

/// A triangle mesh as read: every index below the number of vertices, every
/// coordinate finite, at least one face.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mesh {
    /// |V| positions, in the unit of the file.
    pub(crate) positions: Vec<DVec3>,
    /// Corners of the faces, |F| × 3, in the order of the file.
    pub(crate) faces: Vec<[u32; 3]>,
    /// Faces of the file that had more than three corners.
    pub(crate) polygons_fanned: usize,
}

/// Faces as a file lists them, unchecked: any number of corners, any index.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    corners: Vec<i64>,
    ends: Vec<usize>,
}

impl Polygons {
    pub(super) fn with_capacity(faces: usize) -> Self {
        Self { corners: Vec::with_capacity(3 * faces), ends: Vec::with_capacity(faces) }
    }

    pub(super) fn push(&mut self, corners: impl IntoIterator<Item = i64>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    fn iter(&self) -> impl Iterator<Item = &[i64]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.corners[start..end])
    }
}

/// Checks what a reader found and fans polygons into triangles.
pub(super) fn assemble(positions: Vec<DVec3>, polygons: &Polygons) -> Result<Mesh, MeshError> {
    if polygons.ends.is_empty() {
        return Err(MeshError::NoFaces { vertices: positions.len() });
    }
    check_positions(&positions)?;
    let mut mesh =
        Mesh { positions, faces: Vec::with_capacity(polygons.ends.len()), polygons_fanned: 0 };
    let mut corners = Vec::new();
    for (face, listed) in polygons.iter().enumerate() {
        check_corners(face, listed, mesh.positions.len(), &mut corners)?;
        match corners[..] {
            [a, b, c] => mesh.faces.push([a, b, c]),
            _ => fan(face, &corners, &mut mesh)?,
        }
    }
    Ok(mesh)
}

fn check_positions(positions: &[DVec3]) -> Result<(), MeshError> {
    if u32::try_from(positions.len()).is_err() {
        return Err(MeshError::TooMany { what: "vertices", count: positions.len() });
    }
    match positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => {
            let DVec3 { x, y, z } = positions[vertex];
            Err(MeshError::NotFinite { vertex, x, y, z })
        }
        None => Ok(()),
    }
}

fn check_corners(
    face: usize,
    listed: &[i64],
    vertex_count: usize,
    corners: &mut Vec<u32>,
) -> Result<(), MeshError> {
    if listed.len() < 3 {
        return Err(MeshError::TooFewCorners { face, corners: listed.len() });
    }
    corners.clear();
    for &vertex in listed {
        match u32::try_from(vertex) {
            Ok(corner) if (corner as usize) < vertex_count => corners.push(corner),
            _ => return Err(MeshError::VertexOutOfRange { face, vertex, vertex_count }),
        }
    }
    Ok(())
}

fn fan(face: usize, corners: &[u32], mesh: &mut Mesh) -> Result<(), MeshError> {
    let count = corners.len();
    let apex = (0..count)
        .find(|&apex| fans_without_fold(corners, apex, &mesh.positions))
        .ok_or(MeshError::NotFannable { face, corners: count })?;
    mesh.faces.extend(triangles_from(corners, apex));
    mesh.polygons_fanned += 1;
    Ok(())
}

/// The fan of a polygon about its corner number `apex`.
fn triangles_from(corners: &[u32], apex: usize) -> impl Iterator<Item = [u32; 3]> {
    let corner = move |k: usize| corners[(apex + k) % corners.len()];
    (1..corners.len() - 1).map(move |k| [corner(0), corner(k), corner(k + 1)])
}

fn fans_without_fold(corners: &[u32], apex: usize, positions: &[DVec3]) -> bool {
    let area = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|vertex| positions[vertex as usize]);
        (b - a).cross(c - a)
    };
    let whole: DVec3 = triangles_from(corners, apex).map(area).sum();
    triangles_from(corners, apex).all(|triangle| area(triangle).dot(whole) >= 0.0)
}
