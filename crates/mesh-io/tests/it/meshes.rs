//! One planted mesh in every mesh format.

use glam::DVec3;
use mesh_io::{FilePlace, Mesh, MeshFormat, ReadError, Space, Unread, parse_mesh, read_mesh};

use crate::{ROUNDS, Random, damaged};

/// Returns a box with a quadrilateral lid, so that polygons are read too.
fn planted() -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1) * 2.0, f64::from(i >> 2) * 0.5];
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [0, 1, 5],
        [0, 5, 4],
        [1, 3, 7],
        [1, 7, 5],
        [3, 2, 6],
        [3, 6, 7],
        [2, 0, 4],
        [2, 4, 6],
    ];
    let mut faces: Vec<Vec<u32>> = faces.map(Vec::from).into();
    faces.push(vec![4, 5, 7, 6]);
    ((0..8).map(corner).collect(), faces)
}

#[expect(clippy::cast_possible_truncation, reason = "the planted coordinates are exact in f32")]
fn single(coordinate: f64) -> f32 {
    coordinate as f32
}

fn expected() -> Mesh {
    let (positions, faces) = planted();
    let mut triangles: Vec<[u32; 3]> =
        faces[..10].iter().map(|face| [face[0], face[1], face[2]]).collect();
    triangles.extend([[4, 5, 7], [4, 7, 6]]);
    Mesh {
        positions: positions.into_iter().map(DVec3::from_array).collect(),
        faces: triangles,
        object_count: 1,
        polygons_fanned: 1,
        unread: None,
        skipped: None,
        space: None,
        vertex_numbers: None,
        nodes: None,
        volume: None,
        is_rigid: false,
    }
}

fn ascii_ply() -> Vec<u8> {
    let (positions, faces) = planted();
    let mut text = "ply\nformat ascii 1.0\ncomment planted\nelement vertex 8\n\
        property double x\nproperty double y\nproperty double z\nproperty uchar red\n\
        element face 11\nproperty list uchar uint vertex_index\nend_header\n"
        .to_owned();
    for [x, y, z] in positions {
        text += &format!("{x} {y} {z} 255\n");
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(u32::to_string).collect();
        text += &format!("{} {}\n", face.len(), corners.join(" "));
    }
    text.into_bytes()
}

fn binary_ply(big_endian: bool) -> Vec<u8> {
    let (positions, faces) = planted();
    let order = if big_endian { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 8\nproperty float x\n\
        property float y\nproperty float z\nelement face 11\n\
        property list uchar int vertex_indices\nproperty float quality\nend_header\n"
    )
    .into_bytes();
    let mut push = |mut word: [u8; 4]| {
        if !big_endian {
            word.reverse();
        }
        bytes.extend(word);
    };
    for coordinate in positions.into_iter().flatten() {
        push(single(coordinate).to_be_bytes());
    }
    for face in faces {
        bytes.push(u8::try_from(face.len()).expect("few corners"));
        for word in face.iter().map(|corner| corner.to_be_bytes()).chain([[0; 4]]) {
            bytes.extend(word.iter().rev().copied().filter(|_| !big_endian));
            bytes.extend(word.iter().copied().filter(|_| big_endian));
        }
    }
    bytes
}

fn obj() -> Vec<u8> {
    let (positions, faces) = planted();
    let mut text = "# planted\no one\n".to_owned();
    for [x, y, z] in positions {
        text += &format!("v {x} {y} {z}\n");
    }
    for (number, face) in faces.iter().enumerate() {
        let corner = |c: &u32| match number % 3 {
            0 => format!("{}", c + 1),
            1 => format!("{}/7/3", c + 1),
            _ => format!("{}//1", i64::from(*c) - 8),
        };
        text += &format!("f {}\r\n", face.iter().map(corner).collect::<Vec<_>>().join(" "));
    }
    text.into_bytes()
}

fn off() -> Vec<u8> {
    let (positions, faces) = planted();
    let mut text = "OFF # planted\n\n8 11 0\n".to_owned();
    for [x, y, z] in positions {
        text += &format!("{x} {y} {z}\n");
    }
    for face in faces {
        let corners: Vec<String> = face.iter().map(u32::to_string).collect();
        text += &format!(" {}  {}\r\n", face.len(), corners.join(" "));
    }
    text.into_bytes()
}

fn inline_vtp() -> Vec<u8> {
    let (positions, faces) = planted();
    let join = |numbers: Vec<String>| numbers.join(" ");
    let coordinates = join(positions.iter().flatten().map(f64::to_string).collect());
    let connectivity = join(faces.iter().flatten().map(u32::to_string).collect());
    let mut end = 0;
    let offsets = join(
        faces
            .iter()
            .map(|f| {
                end += f.len();
                end.to_string()
            })
            .collect(),
    );
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
        <PolyData><Piece NumberOfPoints=\"8\" NumberOfPolys=\"11\">\n\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{coordinates}\
        <InformationKey name=\"range\">0 1</InformationKey></DataArray></Points>\n\
        <Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">{connectivity}</DataArray>\n\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">{offsets}</DataArray></Polys>\n\
        </Piece></PolyData></VTKFile>\n"
    )
    .into_bytes()
}

/// Returns the triangles of the planted mesh.
fn facets() -> Vec<[DVec3; 3]> {
    let mesh = expected();
    mesh.faces.iter().map(|face| face.map(|v| mesh.positions[v as usize])).collect()
}

fn ascii_stl() -> Vec<u8> {
    let mut text = "solid planted\n".to_owned();
    for (number, facet) in facets().into_iter().enumerate() {
        // Zero of either sign is one place.
        let minus = if number % 2 == 0 { "-" } else { "" };
        text += "facet normal 0 0 0\n outer loop\n";
        for DVec3 { x, y, z } in facet {
            let sign = if z > 0.0 { "" } else { minus };
            text += &format!("  vertex {x:e} {y} {sign}{z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    (text + "endsolid planted\n").into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid, says the header of many a binary file".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(12_u32.to_le_bytes());
    for facet in facets() {
        bytes.extend([0; 12]);
        for coordinate in facet.iter().flat_map(DVec3::to_array) {
            bytes.extend(single(coordinate).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn read(name: &str, bytes: &[u8]) -> Result<Mesh, ReadError> {
    parse_mesh(bytes, name.split_once('.').expect("an extension").1)
}

/// Returns a file of each kind, by its name.
pub(crate) fn files() -> [(&'static str, Vec<u8>); 8] {
    [
        ("ascii.ply", ascii_ply()),
        ("little.ply", binary_ply(false)),
        ("big.ply", binary_ply(true)),
        ("mesh.obj", obj()),
        ("mesh.off", off()),
        ("mesh.vtp", inline_vtp()),
        ("ascii.stl", ascii_stl()),
        ("binary.stl", binary_stl()),
    ]
}

#[test]
fn indexed_formats_give_the_planted_mesh() {
    for (name, bytes) in &files()[..6] {
        assert_eq!(read(name, bytes).unwrap(), expected(), "{name}");
    }
}

#[test]
fn loose_triangles_are_merged_where_equal() {
    for (name, bytes) in &files()[6..] {
        let mesh = read(name, bytes).unwrap();
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (8, 12), "{name}");
        for (face, facet) in mesh.faces.iter().zip(facets()) {
            assert_eq!(face.map(|v| mesh.positions[v as usize]), facet, "{name}");
        }
    }
}

#[test]
fn formats_are_recognized_by_content() {
    for (name, bytes) in files().iter().filter(|(name, _)| *name != "mesh.obj") {
        assert!(read("mesh.dat", bytes).is_ok(), "{name}");
    }
    let refusal = |name: &str, bytes: &[u8]| read(name, bytes).unwrap_err().to_string();
    let unknown = "unknown format: expected PLY, OBJ, OFF, STL, VTP, VTU, VTK, MSH, INP or FEB";
    assert_eq!(refusal("mesh.dat", b"nothing of the kind"), unknown);
    assert_eq!(refusal("mesh.ply", b""), "is empty (0 bytes)");
}

/// In formats that declare their size, a file cut anywhere before its last value is
/// refused.
#[test]
fn cut_files_are_refused() {
    for (name, bytes) in files() {
        let content = bytes.trim_ascii_end().len();
        for end in 0..content {
            let result = read(name, &bytes[..end]);
            let may_look_whole = name == "mesh.obj" || (name == "ascii.ply" && end + 1 >= content);
            let ends_as_stl = name == "ascii.stl" && bytes[..end].ends_with(b"endsolid")
                || bytes[..end].windows(8).any(|w| w == b"endsolid");
            assert!(result.is_err() || may_look_whole || ends_as_stl, "{name} cut at {end}");
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let files = files();
    let mut random = Random(1);
    for round in 0..ROUNDS {
        let (name, bytes) = &files[round % files.len()];
        let mesh = read(name, &damaged(bytes, &mut random));
        let Ok(Mesh { positions, faces, .. }) = mesh else { continue };
        assert!(positions.iter().all(|p| p.is_finite()), "{name} in round {round}");
        let in_range = |&vertex: &u32| (vertex as usize) < positions.len();
        assert!(faces.iter().flatten().all(in_range), "{name} in round {round}");
    }
}

#[test]
fn refusals_name_the_place() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = |body: &str| read("mesh.ply", format!("{header}{body}").as_bytes());
    let message = |result: Result<Mesh, ReadError>| result.unwrap_err().to_string();
    let cases = [
        (
            message(ply("0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n")),
            "PLY file: line 11: Couldn't read element line: '1 0 nan'",
        ),
        (
            message(ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n")),
            "face 0 refers to vertex -2, but there are 3 vertices (counted from 0)",
        ),
        (
            message(ply("0 0 0\n1 0 0\n0 1 0\n2 0 1\n")),
            "face 0 has 2 corners, fewer than a triangle",
        ),
        (message(read("mesh.obj", b"v 0 0 0\nv 1 0 0\n")), "has 2 vertices and no faces"),
        (
            message(read("mesh.obj", b"v 0 0 0\nv 1 zero 0\n")),
            "OBJ file: line 2: 'zero' is not a number",
        ),
        (
            message(read("mesh.obj", b"v 0 0 0\nf 0 1 2\n")),
            "OBJ file: line 2: vertex 0 does not exist: OBJ counts from 1",
        ),
        (
            message(read("mesh.stl", &binary_stl()[..400])),
            "STL file: facet 6: the file ends here, but declares 12 facets",
        ),
        (
            message(read("mesh.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nend_header\n")),
            "PLY file: header: there is no element 'face'",
        ),
        (
            message(read("mesh.vtp", b"<VTKFile type=\"ImageData\"></VTKFile>")),
            "VTP file: data of type 'ImageData' cannot be read; save it as polygonal data of plain polygons, uncompressed or compressed by zlib",
        ),
    ];
    for (got, expected) in cases {
        assert_eq!(got, expected);
    }
}

#[test]
fn truncated_binary_ply_names_the_element() {
    let bytes = binary_ply(false);
    let error = read("mesh.ply", &bytes[..bytes.len() - 30]).unwrap_err().to_string();
    assert!(error.starts_with("PLY file: element 'face': "), "{error}");
    assert!(error.contains("expected 11, got 9"), "{error}");
}

#[test]
fn a_header_cannot_declare_more_than_the_file_has() {
    let text = "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n";
    let error = read("mesh.ply", text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("do not fit in"), "{error}");
}

/// A dart has a corner from which its fan does not fold; a star has none.
#[test]
fn polygons_are_fanned_without_folds() {
    let dart = b"v 0 0 0\nv 2 1 0\nv 0 2 0\nv 1 1 0\nf 1 2 3 4\n";
    let mesh = read("dart.obj", dart).unwrap();
    assert_eq!(mesh.faces, [[1, 2, 3], [1, 3, 0]]);

    let mut star = String::new();
    for k in 0_u32..10 {
        let (radius, angle) = (if k % 2 == 0 { 1.0 } else { 0.1 }, f64::from(k) * 0.628_318);
        star += &format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin());
    }
    star += "f 1 2 3 4 5 6 7 8 9 10\n";
    let refused = read("star.obj", star.as_bytes());
    assert!(matches!(refused, Err(ReadError::NotFannable { face: 0, corners: 10 })), "{refused:?}");
}

#[test]
fn files_are_written_and_read_by_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("written.ply");
    let planted = Mesh { polygons_fanned: 0, ..expected() };
    let file = MeshFormat::Ply.encode(&planted.positions, &planted.faces, None);
    std::fs::write(&path, file).unwrap();
    assert_eq!(read_mesh(&path).unwrap(), planted);

    let missing = folder.path().join("missing.ply");
    let error = read_mesh(&missing).unwrap_err().to_string();
    let expected = format!("{}: cannot be read: No such file", missing.display());
    assert!(error.starts_with(&expected), "{error}");
}

/// The space that is stated, if any, is read again.
#[test]
fn each_format_states_the_space() {
    let planted = Mesh { polygons_fanned: 0, ..expected() };
    for format in FORMATS {
        for space in [None, Some(Space::LeftPosteriorSuperior), Some(Space::RightAnteriorSuperior)]
        {
            let file = format.encode(&planted.positions, &planted.faces, space);
            let again = parse_mesh(&file, format.extension()).unwrap();
            assert_eq!(
                (again.space, again.faces.len()),
                (space, planted.faces.len()),
                "{format:?}"
            );
        }
    }
}

const FORMATS: [MeshFormat; 5] =
    [MeshFormat::Obj, MeshFormat::Off, MeshFormat::Ply, MeshFormat::Stl, MeshFormat::Vtp];

/// Coordinates without a finite decimal, of every magnitude, with zeros of both signs.
#[test]
fn each_format_writes_what_it_reads() {
    let mut planted = Mesh { polygons_fanned: 0, ..expected() };
    planted.positions[1] = DVec3::new(1.0 / 3.0, -1e-300, 0.1 + 0.2);
    planted.positions[2] = DVec3::new(-0.0, 1e25, 5e-324);
    for format in FORMATS {
        assert_eq!(MeshFormat::of(format!("x.{}", format.extension()).as_ref()), Some(format));
        let file = format.encode(&planted.positions, &planted.faces, None);
        let again = parse_mesh(&file, format.extension()).unwrap();

        // STL has no vertices: it numbers corners in the order of the faces.
        if format == MeshFormat::Stl {
            assert_eq!(again.positions.len(), planted.positions.len());
            for (face, other) in again.faces.iter().zip(&planted.faces) {
                let corners = |mesh: &Mesh, face: &[u32; 3]| {
                    face.map(|v| mesh.positions[v as usize].to_array().map(f64::to_bits))
                };
                assert_eq!(corners(&again, face), corners(&planted, other));
            }
        } else {
            assert_eq!(again, planted, "{format:?}");
        }
        // What was read keeps its order from then on.
        let twice = parse_mesh(&format.encode(&again.positions, &again.faces, None), "");
        let twice = twice.or_else(|_| {
            parse_mesh(&format.encode(&again.positions, &again.faces, None), format.extension())
        });
        assert_eq!(twice.unwrap(), again, "{format:?}");
    }
}

#[test]
fn content_behind_the_declared_end_is_reported() {
    let behind = |name: &str, bytes: &[u8], more: &[u8]| {
        let mesh = read(name, &[bytes, more].concat()).unwrap();
        let whole = read(name, bytes).unwrap();
        assert_eq!(whole.unread, None, "{name}");
        assert_eq!((&mesh.positions, &mesh.faces), (&whole.positions, &whole.faces), "{name}");
        mesh.unread
    };
    let byte = |end: usize, bytes| Some(Unread { place: FilePlace::Byte(end as u64), bytes });

    let stl = binary_stl();
    assert_eq!(behind("a.stl", &stl, &stl[84..184]), byte(84 + 12 * 50, 100));
    assert_eq!(behind("a.stl", &stl, b"\0"), byte(84 + 12 * 50, 1));
    let ply = binary_ply(false);
    assert_eq!(behind("a.ply", &ply, b"abc"), byte(ply.len(), 3));

    let text = ascii_ply();
    let lines = text.iter().filter(|&&byte| byte == b'\n').count();
    assert_eq!(behind("a.ply", &text, b"\n  \n"), None);
    let unread = behind("a.ply", &text, b"\n 3 0 1 2\n").unwrap();
    assert_eq!(unread, Unread { place: FilePlace::Line(lines + 2), bytes: 8 });
    let expected = format!("8 bytes from line {} on, behind the declared end, not read", lines + 2);
    assert_eq!(unread.to_string(), expected);
}

/// A file may hold anything, but not write on the terminal.
#[test]
fn refusals_escape_control_characters() {
    let title = "\x1b]0;owned\x07";
    let cases = [
        ("mesh.obj", format!("v 0 {title} 0\n")),
        ("mesh.off", format!("OFF\n{title} 0 0\n")),
        ("mesh.stl", format!("solid\n{title}\nendsolid\n")),
        ("mesh.vtp", format!("<VTKFile type=\"{title}\"/>")),
        ("mesh.vtp", format!("<VTKFile type=\"PolyData\"><{title}>")),
        (
            "mesh.vtp",
            format!(
                "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"{title}\"/></PolyData></VTKFile>"
            ),
        ),
        ("mesh.ply", format!("ply\nformat ascii 1.0\n{title}\nend_header\n")),
        ("mesh.ply", format!("ply\nformat ascii 1.0\nelement {title} 1e99\nend_header\n")),
    ];
    for (name, text) in cases {
        let message = read(name, text.as_bytes()).unwrap_err().to_string();
        assert!(!message.contains(char::is_control), "{name}: {message:?}");
    }
}
