//! File of one body after overlap removal, and the state that it holds.
//!
//! A body is written into its own file, in which only positions change. A volume mesh follows its surface
//! first. What was written is read again and taken into the scene, so that all that is proved and reported
//! afterwards holds of the file: of the triangles into which this program splits its polygons.

use std::path::Path;

use glam::DVec3;
use mesh_io::{Mesh, MeshFormat, ReadError, Space, Volume};
use musculo_collide::volume_mesh::{FollowParams, Followed};
use musculo_collide::{BodyId, Progress, Scene};

use crate::failure::Failure;
use crate::report::{ElementsRecord, QualityRecord};
use crate::scene::BodyDescription;
use crate::terminal;

/// Warning about a file of text in the place of a binary STL file.
const ONE_IN_SINGLE_PRECISION: &str = "vertices that were moved are one in single precision: the file \
                                       that is written is text, in double precision";

/// Warning about a file of triangles in the place of one with polygons.
const SPLIT_OTHERWISE: &str = "polygons that were moved are split otherwise: the file that is written \
                               has triangles, and no other attributes";

/// Refusal of a file whose elements cannot be replaced by triangles.
pub(super) const NO_TRIANGLES: &str = "polygons that were moved are split otherwise, and nothing else of the file would \
                            stay: split them into triangles first";

/// File of a body at the end.
#[derive(Debug)]
pub(super) struct BodyFile {
    /// Content of its file; `None` where that is the file of a body before.
    pub(super) content: Option<Vec<u8>>,
    /// Displacements of the vertices from the start to what the file holds.
    pub(super) displacements: Vec<DVec3>,
    /// Nodes of the volume mesh in the file, and their displacements.
    pub(super) nodes: Option<[Vec<DVec3>; 2]>,
    /// Elements of the volume mesh, where it followed its surface.
    pub(super) elements: Option<ElementsRecord>,
}

/// Returns true if a body is written into a copy of its file. A pipe is read once, and a mesh that
/// the scene has placed stands elsewhere in its file: these are written as new files.
pub(super) fn is_rewritten(body: &BodyDescription) -> bool {
    body.placement.is_none() && body.path.is_file()
}

impl BodyFile {
    /// Completes the file of a body, and moves the body to what it holds. `start` has the positions before overlap
    /// removal.
    pub(super) fn complete(
        description: &BodyDescription,
        volume: Option<&Volume>,
        space: Option<Space>,
        scene: &mut Scene,
        id: BodyId,
        start: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Self, Failure> {
        let (path, positions) = (&description.path, scene.body(id).positions());

        // A body without a file to edit becomes a new one, of its surface alone.
        if !is_rewritten(description) {
            let format = MeshFormat::of(path).unwrap_or(MeshFormat::Ply);
            let content = format.encode(positions, scene.body(id).surface().faces(), space);
            return Ok(Self::new(Some(content), start, positions));
        }
        let original = mesh_io::read_file(path)?;
        if positions == start {
            return Ok(Self {
                nodes: volume.map(at_rest),
                ..Self::new(Some(original), start, start)
            });
        }

        // The nodes inside follow the surface; a mesh without volume has no others.
        let followed = match volume {
            Some(volume) => Some(follow(volume, positions, progress)?),
            None => None,
        };
        let written = followed.as_ref().map_or(positions, |followed| &followed.positions);
        let faces = scene.body(id).surface().faces();
        let (content, mesh) = rewritten(path, &original, written, faces, space)?;

        // What is reported and checked from here on are the positions that are written.
        let mut file = Self::new(Some(content), start, &mesh.positions);
        if let (Some(volume), Some(followed), Some(written)) = (volume, followed, mesh.volume) {
            file.elements = Some(elements(volume, &followed, &written.nodes));
            file.set_nodes(&volume.nodes, written.nodes);
        }
        scene.move_body(id, &mesh.positions)?;
        Ok(file)
    }

    /// Returns a file without a volume mesh.
    pub(super) fn new(content: Option<Vec<u8>>, start: &[DVec3], positions: &[DVec3]) -> Self {
        let displacements = difference(start, positions);
        Self { content, displacements, nodes: None, elements: None }
    }

    /// Keeps the nodes of the volume mesh, which were at `start`.
    pub(super) fn set_nodes(&mut self, start: &[DVec3], written: Vec<DVec3>) {
        let u = difference(start, &written);
        self.nodes = Some([written, u]);
    }
}

/// Returns a file with other positions, and the mesh that others read from it.
///
/// Polygons are split into triangles by where their corners are. If they are split otherwise at the new
/// positions, the file has the triangles in their place, and nothing else. Corners of STL facets are one
/// vertex where they are equal. If vertices are one in the single precision of a binary file, the file
/// has text in double precision. A file that has been replaced states the space, where there is one.
fn rewritten(
    path: &Path,
    original: &[u8],
    positions: &[DVec3],
    faces: &[[u32; 3]],
    space: Option<Space>,
) -> Result<(Vec<u8>, Mesh), Failure> {
    let refused = |error: ReadError| Failure::in_file(path, error);
    let extension = mesh_io::extension(path);
    let content = mesh_io::replace_positions(original, &extension, positions).map_err(refused)?;

    // Parsed as others will read it: positions are rounded to the number type of the file.
    let (format, problem) = match mesh_io::parse_mesh(&content, &extension) {
        Ok(mesh) if mesh.faces == faces => return Ok((content, mesh)),
        Ok(mesh) if mesh.polygons_fanned == 0 => (MeshFormat::Stl, ONE_IN_SINGLE_PRECISION),
        Ok(_) | Err(ReadError::NotFannable { .. }) => {
            let Some(format) = MeshFormat::of(path) else {
                return Err(Failure::in_file(path, NO_TRIANGLES));
            };
            (format, SPLIT_OTHERWISE)
        }
        Err(error) => return Err(refused(error)),
    };
    terminal::print_line("warning", &format!("{}: {problem}", path.display()));
    let content = format.encode(positions, faces, space);
    let mesh = mesh_io::parse_mesh(&content, &extension).map_err(refused)?;
    if mesh.faces == faces {
        return Ok((content, mesh));
    }
    Err(Failure::in_file(
        path,
        "vertices that were moved are one, which an STL file cannot tell apart",
    ))
}

fn at_rest(volume: &Volume) -> [Vec<DVec3>; 2] {
    [volume.nodes.clone(), vec![DVec3::ZERO; volume.nodes.len()]]
}

/// Moves the nodes of a volume mesh after its surface.
pub(super) fn follow(
    volume: &Volume,
    positions: &[DVec3],
    progress: Progress<'_>,
) -> Result<Followed, Failure> {
    let Volume { mesh, nodes, boundary, .. } = volume;
    Ok(mesh.follow(nodes, boundary, positions, &FollowParams::default(), progress)?)
}

/// Describes the elements of a volume mesh whose nodes were written.
pub(super) fn elements(volume: &Volume, followed: &Followed, written: &[DVec3]) -> ElementsRecord {
    let blocking = followed.blocking.filter(|_| followed.share < 1.0);
    ElementsRecord {
        count: volume.mesh.cells().len(),
        followed_share: followed.share,
        steps: followed.steps,
        before: QualityRecord::new(&followed.before, volume),
        after: QualityRecord::new(&volume.mesh.quality(written), volume),
        blocking_element: blocking.map(|blocking| volume.cell_numbers[blocking.cell]),
    }
}

fn difference(from: &[DVec3], to: &[DVec3]) -> Vec<DVec3> {
    from.iter().zip(to).map(|(from, to)| *to - *from).collect()
}

#[cfg(test)]
mod tests {
    use musculo_collide::BodyKind;
    use musculo_collide::surface::TriangleSurface;

    use super::*;

    /// A pyramid whose base is one polygon, split along the other diagonal once a corner has crossed
    /// the first.
    const PYRAMID: &str = "# bone of a fish\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n\
        f 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

    fn content_of(file: &BodyFile) -> &[u8] {
        file.content.as_ref().expect("a file of its own")
    }

    fn written(extension: &str, content: &[u8], corner: DVec3) -> (Vec<[u32; 3]>, BodyFile) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("fish.{extension}"));
        std::fs::write(&path, content).expect("a file");
        let mesh = mesh_io::read_mesh(&path).expect("a mesh");
        let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces.clone());
        let mut scene = Scene::new();
        let (kind, surface) = (BodyKind::Deformable, surface.expect("a surface"));
        let id = scene.add("fish", kind, surface, mesh.positions.clone()).expect("a body");

        let mut positions = mesh.positions.clone();
        positions[1] = corner;
        scene.move_body(id, &positions).expect("positions");
        let description = BodyDescription {
            name: "fish".to_owned(),
            file: path.display().to_string(),
            path,
            kind: Some(kind),
            follows: None,
            stiffness: None,
            uncross: false,
            placement: None,
            parts: Vec::new(),
        };
        let (start, progress) = (&mesh.positions, Progress::none());
        let file =
            BodyFile::complete(&description, None, mesh.space, &mut scene, id, start, progress);
        let file = file.unwrap_or_else(|failure| panic!("{extension}: {:?}", failure.problems));
        let again = mesh_io::parse_mesh(content_of(&file), extension).expect("a mesh");
        assert_eq!(again.positions, scene.body(id).positions(), "{extension}");
        assert_eq!(again.faces, scene.body(id).surface().faces(), "{extension}");
        assert_eq!(file.displacements[1], again.positions[1] - start[1], "{extension}");
        (mesh.faces, file)
    }

    /// All that is proved holds of the triangles of the scene, so that the file has to give them.
    #[test]
    fn polygons_that_are_split_otherwise_are_written_as_triangles() {
        let vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n";
        let faces = "4 0 3 2 1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
             property float z\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n\
             {vertices}{faces}"
        );
        let files = [("obj", PYRAMID.to_owned()), ("ply", ply)];
        for (extension, content) in files {
            // A little move leaves the polygons, and all else.
            let little = DVec3::new(1.0, 0.25, 0.0);
            let (_, file) = written(extension, content.as_bytes(), little);
            let text = String::from_utf8(content_of(&file).to_vec()).expect("text");
            let expected = content.replacen("1 0 0", "1 0.25 0", 1);
            assert_eq!(text.lines().count(), expected.lines().count(), "{extension}");

            let (faces, file) = written(extension, content.as_bytes(), DVec3::new(0.25, 0.75, 0.0));
            let again = mesh_io::parse_mesh(content_of(&file), extension).expect("a mesh");
            assert_eq!((again.faces, again.polygons_fanned), (faces, 0), "{extension}");
        }
    }

    /// No fan of a polygon of which two corners cross the whole others is without a fold.
    #[test]
    fn polygons_that_cannot_be_split_any_more_are_written_as_triangles() {
        let star = "v 0 0 0\nv 2 -1 0\nv 4 0 0\nv 5 2 0\nv 4 4 0\nv 2 5 0\nv 0 4 0\nv -1 2 0\n\
                    v 2 2 5\nf 8 7 6 5 4 3 2 1\nf 1 2 9\nf 2 3 9\nf 3 4 9\nf 4 5 9\nf 5 6 9\nf 6 7 9\n\
                    f 7 8 9\nf 8 1 9\n";
        let (faces, file) = written("obj", star.as_bytes(), DVec3::new(2.0, 9.0, 0.0));
        let again = mesh_io::parse_mesh(content_of(&file), "obj").expect("a mesh");
        assert_eq!((again.faces, again.polygons_fanned), (faces, 0));
    }

    /// Returns a binary STL file of a tetrahedron.
    fn binary_stl(header: &str, size: f32) -> Vec<u8> {
        let corners = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
        let mut file = format!("{header:80}").into_bytes();
        file.extend(4_u32.to_le_bytes());
        for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            file.extend([0; 12]);
            file.extend(
                face.map(|k| corners[k].map(f32::to_le_bytes)).as_flattened().as_flattened(),
            );
            file.extend([0; 2]);
        }
        file
    }

    /// Vertices of STL files are one where their coordinates are: text has those of the scene.
    #[test]
    fn vertices_that_would_be_one_in_single_precision_are_written_as_text() {
        let near = DVec3::new(0.5, 1.0, 1.0);
        for (header, size) in [("made by hand", 1.0), ("solid", 0.125)] {
            let file = binary_stl(header, size);
            let start = mesh_io::parse_mesh(&file, "stl").expect("a mesh").positions;
            let corner = start[2].lerp(start[1], 0.5);
            let (_, moved) = written("stl", &file, corner);
            assert_eq!(
                content_of(&moved).len(),
                file.len(),
                "what has distinct singles stays binary"
            );

            // Two corners less than a rounding apart, beside others that do not move.
            let mut positions = start.clone();
            (positions[1], positions[2]) = (near, near + DVec3::X * 1e-13 + DVec3::Y * 1e-13);
            let faces = mesh_io::parse_mesh(&file, "stl").expect("a mesh").faces;
            let (content, mesh) = rewritten(Path::new("a.stl"), &file, &positions, &faces, None)
                .unwrap_or_else(|failure| panic!("{:?}", failure.problems));
            assert_eq!((mesh.positions, mesh.faces), (positions, faces));
            assert!(content.starts_with(b"solid "), "text");
        }

        // A space that the file states is stated by the text.
        let file = binary_stl("3D Slicer output. SPACE=RAS", 1.0);
        let mesh = mesh_io::parse_mesh(&file, "stl").expect("a mesh");
        let mut positions = mesh.positions;
        positions[1] = positions[2] + DVec3::X * 1e-13;
        let (_, again) = rewritten(Path::new("a.stl"), &file, &positions, &mesh.faces, mesh.space)
            .unwrap_or_else(|failure| panic!("{:?}", failure.problems));
        assert_eq!((again.space, again.positions), (mesh.space, positions));
    }

    #[test]
    fn triangles_state_the_space_of_the_polygons() {
        let content = format!("# SPACE=RAS\n{PYRAMID}");
        let corner = DVec3::new(0.25, 0.75, 0.0);
        let (faces, file) = written("obj", content.as_bytes(), corner);
        let again = mesh_io::parse_mesh(content_of(&file), "obj").expect("a mesh");
        assert_eq!((again.faces, again.polygons_fanned), (faces, 0));
        assert_eq!(again.space, Some(Space::RightAnteriorSuperior));
    }
}
