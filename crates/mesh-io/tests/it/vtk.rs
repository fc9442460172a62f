//! One planted tetrahedron in every way that VTK writes arrays: inline or
//! appended, raw or base64, either byte order and width of header, plain or
//! compressed in blocks.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;
use mesh_io::{
    CellValues, Cells, Mesh, PointValues, ReadError, parse_mesh, replace_positions, write_vtp,
    write_vtp_cells,
};

use crate::{ROUNDS, Random, damaged};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// Encoding of the arrays of a file.
#[derive(Clone, Copy, Debug)]
struct Style {
    place: Place,
    wide_header: bool,
    big_endian: bool,
    compressed: bool,
}

const COORDINATES: [f64; 12] = [0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, -3.0];
const CORNERS: [i32; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];

impl Style {
    fn all() -> Vec<Self> {
        let mut styles = Vec::new();
        for place in [Place::Inline, Place::AppendedRaw, Place::AppendedBase64] {
            for bits in 0_u8..8 {
                let [wide_header, big_endian, compressed] = [1, 2, 4].map(|bit| bits & bit != 0);
                styles.push(Self { place, wide_header, big_endian, compressed });
            }
        }
        styles
    }

    /// Returns an integer of the header.
    fn word(self, value: usize) -> Vec<u8> {
        let mut bytes =
            (value as u64).to_le_bytes()[..if self.wide_header { 8 } else { 4 }].to_vec();
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn number<const N: usize>(self, mut little_endian: [u8; N]) -> [u8; N] {
        if self.big_endian {
            little_endian.reverse();
        }
        little_endian
    }

    /// Returns an array with its header, as it stands in the file.
    fn array(self, content: &[u8]) -> Vec<u8> {
        let parts = if self.compressed { self.blocks(content) } else { self.plain(content) };
        if self.place == Place::AppendedRaw {
            return parts.concat();
        }
        // VTK encodes the header of compressed arrays by itself.
        parts.into_iter().flat_map(|part| STANDARD.encode(part).into_bytes()).collect()
    }

    fn plain(self, content: &[u8]) -> Vec<Vec<u8>> {
        vec![[self.word(content.len()), content.to_vec()].concat()]
    }

    fn blocks(self, content: &[u8]) -> Vec<Vec<u8>> {
        const BLOCK: usize = 40; // so that the last is shorter, in most arrays
        let blocks: Vec<Vec<u8>> = content.chunks(BLOCK).map(deflated).collect();
        let header = [blocks.len(), BLOCK, content.len() % BLOCK]
            .into_iter()
            .chain(blocks.iter().map(Vec::len))
            .flat_map(|value| self.word(value));
        vec![header.collect(), blocks.concat()]
    }

    fn file(self) -> Vec<u8> {
        self.file_of(1)
    }

    /// Returns a file of several pieces, each with arrays of its own.
    fn file_of(self, pieces: usize) -> Vec<u8> {
        let coordinates = COORDINATES.iter().flat_map(|x| self.number(x.to_le_bytes())).collect();
        let corners = CORNERS.iter().flat_map(|v| self.number(v.to_le_bytes())).collect();
        let ends =
            [3_i64, 6, 9, 12].iter().flat_map(|end| self.number(end.to_le_bytes())).collect();
        let contents: [Vec<u8>; 3] = [coordinates, corners, ends];
        let arrays = contents.map(|content| self.array(&content));
        let declared =
            ["Float64\" Name=\"Points", "Int32\" Name=\"connectivity", "Int64\" Name=\"offsets"];
        let mut offset = 0;
        let mut tags = Vec::new();
        for (array, declared) in arrays.iter().zip(declared).cycle().take(3 * pieces) {
            tags.push(if self.place == Place::Inline {
                let text = std::str::from_utf8(array).expect("base64 is text");
                format!("<DataArray type=\"{declared}\" format=\"binary\">\n {text}\n</DataArray>")
            } else {
                format!("<DataArray type=\"{declared}\" format=\"appended\" offset=\"{offset}\"/>")
            });
            offset += array.len();
        }
        let order = if self.big_endian { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide_header { "UInt64" } else { "UInt32" };
        let compressor = if self.compressed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let mut file = format!(
            "<VTKFile type=\"PolyData\" byte_order=\"{order}\" header_type=\"{header}\"{compressor}>\
            <PolyData>"
        )
        .into_bytes();
        for [points, connectivity, offsets] in tags.as_chunks::<3>().0 {
            let piece = format!(
                "<Piece NumberOfPoints=\"4\" NumberOfPolys=\"4\"><Points>{points}</Points>\
                 <Polys>{connectivity}{offsets}</Polys></Piece>"
            );
            file.extend(piece.into_bytes());
        }
        file.extend(b"</PolyData>");
        if self.place != Place::Inline {
            let encoding = if self.place == Place::AppendedRaw { "raw" } else { "base64" };
            file.extend(format!("<AppendedData encoding=\"{encoding}\">\n_").into_bytes());
            file.extend(arrays.concat().repeat(pieces));
            file.extend(b"\n</AppendedData>");
        }
        file.extend(b"</VTKFile>\n");
        file
    }
}

/// Each piece counts its points from 0, and has its arrays behind those of the piece before.
#[test]
fn many_pieces_are_one_mesh() {
    const PIECES: usize = 30;
    let one = planted();
    let mut faces = Vec::new();
    for first in (0..).step_by(one.positions.len()).take(PIECES) {
        faces.extend(one.faces.iter().map(|face| face.map(|corner| corner + first)));
    }
    let positions = one.positions.repeat(PIECES);
    let moved: Vec<DVec3> = positions.iter().map(|x| *x + DVec3::X).collect();

    for style in Style::all() {
        let file = style.file_of(PIECES);
        let mesh = parse_mesh(&file, "vtp").unwrap_or_else(|error| panic!("{style:?}: {error}"));
        assert_eq!((&mesh.positions, &mesh.faces), (&positions, &faces), "{style:?}");
        let written = replace_positions(&file, "vtp", &moved).expect("a file");
        let mesh = parse_mesh(&written, "vtp").unwrap_or_else(|error| panic!("{style:?}: {error}"));
        assert_eq!((mesh.positions, &mesh.faces), (moved.clone(), &faces), "{style:?}");
    }
}

fn deflated(block: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(block).expect("memory takes it");
    encoder.finish().expect("memory takes it")
}

fn planted() -> Mesh {
    let positions = COORDINATES.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect();
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    Mesh {
        positions,
        faces,
        object_count: 1,
        polygons_fanned: 0,
        unread: None,
        skipped: None,
        space: None,
        vertex_numbers: None,
        nodes: None,
        volume: None,
        is_rigid: false,
    }
}

fn read(bytes: &[u8]) -> Result<Mesh, ReadError> {
    parse_mesh(bytes, "vtp")
}

#[test]
fn every_way_of_writing_gives_the_planted_mesh() {
    for style in Style::all() {
        assert_eq!(read(&style.file()).unwrap(), planted(), "{style:?}");
    }
}

/// Other points in every way of writing; the arrays of the faces stay where they are.
#[test]
fn points_are_replaced_in_every_way_of_writing() {
    let mut expected = planted();
    for x in &mut expected.positions {
        *x = 3.0 * *x + DVec3::new(0.1, -7.0, 1e-3);
    }
    for style in Style::all() {
        let file = replace_positions(&style.file(), "vtp", &expected.positions).unwrap();
        assert_eq!(read(&file).unwrap(), expected, "{style:?}");
    }
}

/// Numbers in text are rounded as those in binary are: a file that is written with its own positions keeps them.
#[test]
fn text_is_read_in_the_number_type_of_its_array() {
    let corners = "0.1 -.7 1e-9 16777217 0.3 0 0 1 0";
    let points = |kind: &str| {
        format!(
            "<Points><DataArray type=\"{kind}\" format=\"ascii\">{corners}</DataArray></Points>"
        )
    };
    let array = |name: &str, content: &str| {
        format!("<DataArray type=\"Int32\" Name=\"{name}\" format=\"ascii\">{content}</DataArray>")
    };
    let (connectivity, offsets) = (array("connectivity", "0 1 2"), array("offsets", "3"));
    let types = array("types", "5");
    let vtp = |kind: &str| {
        format!(
            "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">\
             {}<Polys>{connectivity}{offsets}</Polys></Piece></PolyData></VTKFile>",
            points(kind)
        )
    };
    let vtu = |kind: &str| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>\
             <Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">{}\
             <Cells>{connectivity}{offsets}{types}</Cells></Piece></UnstructuredGrid></VTKFile>",
            points(kind)
        )
    };
    let single = [0.1_f32, -0.7, 1e-9, 16_777_216.0, 0.3, 0.0, 0.0, 1.0, 0.0].map(f64::from);
    let double = [0.1, -0.7, 1e-9, 16_777_217.0, 0.3, 0.0, 0.0, 1.0, 0.0];
    for (kind, expected) in [("Float32", single), ("Float64", double)] {
        for (extension, file) in [("vtp", vtp(kind)), ("vtu", vtu(kind))] {
            let mesh = parse_mesh(file.as_bytes(), extension).expect(&file);
            let read: Vec<f64> = mesh.positions.iter().flat_map(DVec3::to_array).collect();
            assert_eq!(read, expected, "{extension} of {kind}");
            let written = replace_positions(file.as_bytes(), extension, &mesh.positions);
            let again = parse_mesh(&written.expect("a file"), extension).expect("a mesh");
            assert_eq!(again.positions, mesh.positions, "{extension} of {kind}");
        }
    }

    // Beyond the range of its type, a number is no coordinate.
    let beyond = vtp("Float32").replace("16777217", "1e39");
    let error = read(beyond.as_bytes()).expect_err("a number too large").to_string();
    assert!(error.contains("not finite"), "{error}");
}

#[test]
fn a_written_surface_reads_back() {
    let Mesh { positions, faces, .. } = planted();
    let values = [PointValues::Scalars("height", &[0.0; 4])];
    let file = write_vtp(&positions, &faces, &values, None);
    assert_eq!(read(file.as_bytes()).unwrap(), planted());
}

#[test]
fn written_polygons_read_back_and_chains_are_no_faces() {
    let Mesh { positions, .. } = planted();
    let heights = [0.0; 4];
    let values = [PointValues::Scalars("height", &heights)];
    let numbers = [CellValues::Numbers("region", &[7])];
    let cell = [vec![0, 1, 2, 3]];
    let file = write_vtp_cells(&positions, Cells::Polygons(&cell), &values, &numbers, None);
    let read_back = read(file.as_bytes()).expect("a mesh");
    assert_eq!((read_back.positions, read_back.faces.len()), (positions.clone(), 2));
    assert_eq!(read_back.polygons_fanned, 1);
    assert!(file.contains("<CellData>") && file.contains("Name=\"region\""), "{file}");

    let chain = write_vtp_cells(&positions, Cells::Lines(&cell), &[], &[], None);
    assert!(chain.contains("NumberOfLines=\"1\"") && !chain.contains("CellData"), "{chain}");
    assert!(chain.contains("NumberOfPolys=\"0\""), "{chain}");
}

#[test]
fn deep_nesting_is_refused() {
    let deep = format!("<VTKFile type=\"PolyData\">{}", "<a>".repeat(1_000_000));
    let error = read(deep.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("elements nest more than 32 deep"), "{error}");
}

/// Cut anywhere before the last byte of the last array, a file is refused.
#[test]
fn cut_arrays_are_refused() {
    for style in Style::all() {
        let file = style.file();
        let tail = file.len() - b"\n</AppendedData></VTKFile>\n".len();
        for end in 0..tail {
            assert!(read(&file[..end]).is_err(), "{style:?} cut at {end} of {}", file.len());
        }
    }
}

#[test]
fn damaged_arrays_never_panic() {
    let files: Vec<Vec<u8>> = Style::all().into_iter().map(Style::file).collect();
    let mut random = Random(2);
    for round in 0..ROUNDS {
        let Ok(mesh) = read(&damaged(&files[round % files.len()], &mut random)) else { continue };
        let in_range = |&vertex: &u32| (vertex as usize) < mesh.positions.len();
        assert!(mesh.faces.iter().flatten().all(in_range), "round {round}");
    }
}

#[test]
fn pieces_are_joined() {
    let piece = "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points><DataArray type=\"Float32\" \
        format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type=\"Int32\" \
        Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int32\" \
        Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece>";
    let file = format!("<VTKFile type=\"PolyData\"><PolyData>{piece}{piece}</PolyData></VTKFile>");
    let mesh = read(file.as_bytes()).unwrap();
    assert_eq!((mesh.positions.len(), mesh.faces), (6, vec![[0, 1, 2], [3, 4, 5]]));
}

#[test]
fn unsupported_features_are_named() {
    let lz4 =
        Style { place: Place::Inline, wide_header: true, big_endian: false, compressed: true };
    let text = String::from_utf8(lz4.file()).unwrap().replace("ZLib", "LZ4");
    let error = read(text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("'vtkLZ4DataCompressor' cannot be read"), "{error}");

    let strips =
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfStrips=\"2\"/></PolyData></VTKFile>";
    let error = read(strips.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("2 triangle strips cannot be read"), "{error}");
}

/// A block may decompress to a thousand times its size: arrays of more numbers than their
/// piece has points are refused before that.
#[test]
fn compressed_arrays_are_as_large_as_their_piece() {
    let style =
        Style { place: Place::Inline, wide_header: true, big_endian: false, compressed: true };
    let size = 200_000_000_usize;
    let header = [1, size, 0, 0].map(|word: usize| word.to_le_bytes()).concat();
    let array = STANDARD.encode(header) + &STANDARD.encode(deflated(&vec![0; 1000]));
    let file = String::from_utf8(style.file()).unwrap();
    let (before, rest) = file.split_once("format=\"binary\">\n ").unwrap();
    let (_, behind) = rest.split_once("\n</DataArray>").unwrap();
    let file = format!("{before}format=\"binary\">{array}</DataArray>{behind}");
    let error = read(file.as_bytes()).unwrap_err().to_string();
    let expected = "VTP file: array 'Points': its 200000000 bytes are more than 12 numbers";
    assert_eq!(error, expected);
}
