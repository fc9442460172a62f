//! Legacy VTK files: the planted house and block, as text and binary, in lists of both versions.

use std::fmt::Write as _;

use glam::DVec3;
use mesh_io::{Precision, Space, coordinate_precision, parse_mesh, replace_positions};

use crate::element_surfaces::{SQUARES, TRIANGLES, planted, planted_elements};
use crate::volumes::{self, NODES};
use crate::{ROUNDS, Random, damaged};

/// Ways to write a file.
#[derive(Clone, Copy, Debug)]
struct Style {
    is_binary: bool,
    has_two_arrays: bool,
    is_single: bool,
}

fn styles() -> Vec<Style> {
    let both = [false, true];
    let mut styles = Vec::new();
    for is_binary in both {
        for has_two_arrays in both {
            styles.extend(both.map(|is_single| Style { is_binary, has_two_arrays, is_single }));
        }
    }
    styles
}

/// File that is being written.
struct File {
    style: Style,
    bytes: Vec<u8>,
}

impl File {
    fn new(style: Style, kind: &str) -> Self {
        let version = if style.has_two_arrays { "5.1" } else { "3.0" };
        let encoding = if style.is_binary { "BINARY" } else { "ASCII" };
        let header = format!("# vtk DataFile Version {version}\nPOINTS of a house\n{encoding}\n");
        let mut file = Self { style, bytes: header.into_bytes() };
        file.line(&format!("DATASET {kind}"));
        file
    }

    fn line(&mut self, line: &str) {
        self.bytes.extend(line.as_bytes());
        self.bytes.push(b'\n');
    }

    fn integers(&mut self, numbers: &[usize], width: usize) {
        let mut text = String::new();
        for &number in numbers {
            match (self.style.is_binary, width) {
                (true, 1) => self.bytes.push(u8::try_from(number).expect("small")),
                (true, 4) => self.bytes.extend(u32::try_from(number).expect("small").to_be_bytes()),
                (true, _) => self.bytes.extend((number as u64).to_be_bytes()),
                (false, _) => drop(write!(text, "{number} ")),
            }
        }
        self.line(&text);
    }

    /// Field data with numbers, the space, and meta data behind them.
    fn field_data(&mut self) {
        self.line("FIELD FieldData 3");
        self.line("flags 2 3 unsigned_char");
        self.integers(&[1, 2, 3, 4, 5, 6], 1);
        self.meta_data();
        self.line("SPACE 1 1 string");
        // Bits of the width of a length, and the length: three letters.
        if self.style.is_binary {
            self.bytes.push(0b1100_0011);
        }
        self.line("RAS");
        self.meta_data();
        self.line("times 1 1 vtktypeint64");
        self.integers(&[7], 8);
    }

    fn meta_data(&mut self) {
        self.line(
            "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n",
        );
    }

    #[expect(clippy::cast_possible_truncation, reason = "the number type of the file")]
    fn points(&mut self) {
        let Style { is_single, is_binary, .. } = self.style;
        self.line(&format!("POINTS 9 {}", if is_single { "float" } else { "double" }));
        let mut text = String::new();
        for x in NODES.as_flattened() {
            match (is_binary, is_single) {
                (true, true) => self.bytes.extend((*x as f32).to_be_bytes()),
                (true, false) => self.bytes.extend(x.to_be_bytes()),
                (false, _) => drop(write!(text, "{x} ")),
            }
        }
        self.line(&text);
        self.meta_data();
    }

    fn cells(&mut self, name: &str, cells: &[Vec<usize>]) {
        let points = cells.concat();
        if !self.style.has_two_arrays {
            let lists = cells.iter().map(|cell| [&[cell.len()], &cell[..]].concat());
            let list: Vec<usize> = lists.flatten().collect();
            self.line(&format!("{name} {} {}", cells.len(), list.len()));
            self.integers(&list, 4);
            return;
        }
        let mut offsets = vec![0];
        for cell in cells {
            offsets.push(offsets[offsets.len() - 1] + cell.len());
        }
        self.line(&format!("{name} {} {}", offsets.len(), points.len()));
        self.line("OFFSETS vtktypeint64");
        self.integers(&offsets, 8);
        self.line("CONNECTIVITY vtktypeint64");
        self.integers(&points, 8);
    }
}

fn house() -> Vec<Vec<usize>> {
    let squares = SQUARES.iter().map(|square| square.to_vec());
    squares.chain(TRIANGLES.iter().map(|triangle| triangle.to_vec())).collect()
}

/// Returns the house as polygonal data, with an edge, no strips, and values behind it.
fn polygons(style: Style) -> Vec<u8> {
    let mut file = File::new(style, "POLYDATA");
    file.field_data();
    file.points();
    file.cells("LINES", &[vec![0, 1]]);
    file.cells("POLYGONS", &house());
    file.line("TRIANGLE_STRIPS 0 0");
    file.line("POINT_DATA 9\nSCALARS height double\nLOOKUP_TABLE default");
    file.bytes.extend(b"POINTS 1 float\n\xff\xff\xff");
    file.bytes
}

/// Returns cells of types as a grid.
fn grid(style: Style, cells: &[Vec<usize>], types: &[usize]) -> Vec<u8> {
    let mut file = File::new(style, "UNSTRUCTURED_GRID");
    file.points();
    file.cells("CELLS", cells);
    file.line(&format!("CELL_TYPES {}", types.len()));
    file.integers(types, 4);
    file.line("CELL_DATA 1");
    file.bytes
}

/// Returns the house as a grid of squares, polygons and triangles, with a point.
fn house_grid(style: Style) -> Vec<u8> {
    let cells = [house(), vec![vec![3]]].concat();
    grid(style, &cells, &[9, 9, 7, 9, 9, 5, 5, 5, 5, 1])
}

/// Returns a hexahedron with two tetrahedra on it, and a triangle.
fn block(style: Style) -> Vec<u8> {
    let cells = [vec![0, 2, 1], (0..8).collect(), vec![4, 5, 6, 8], vec![4, 6, 7, 8]];
    grid(style, &cells, &[5, 12, 10, 10])
}

#[test]
fn every_way_of_writing_gives_the_planted_meshes() {
    for style in styles() {
        let mesh = parse_mesh(&polygons(style), "").expect("a mesh");
        assert_eq!(mesh.positions, NODES.map(DVec3::from_array), "{style:?}");
        assert_eq!((mesh.faces, mesh.polygons_fanned), (planted(), 5), "{style:?}");
        assert_eq!(mesh.space, Some(Space::RightAnteriorSuperior), "{style:?}");

        let mesh = parse_mesh(&house_grid(style), "").expect("a mesh");
        assert_eq!((mesh.positions.len(), mesh.faces), (9, planted_elements()), "{style:?}");
        assert_eq!((mesh.space, mesh.volume), (None, None), "{style:?}");

        let volume = parse_mesh(&block(style), "").expect("a mesh").volume.expect("a volume");
        assert_eq!(volume.mesh.cells(), volumes::cells(), "{style:?}");
        assert_eq!(volume.cell_numbers, [1, 2, 3], "{style:?}");
        assert_eq!(volume.nodes, NODES.map(DVec3::from_array), "{style:?}");
    }
}

#[test]
fn a_file_that_is_written_again_has_other_points_alone() {
    for style in styles() {
        for file in [polygons(style), house_grid(style), block(style)] {
            let before = parse_mesh(&file, "").expect("a mesh");
            let moved = NODES.map(|x| DVec3::from_array(x) * 1.5 + DVec3::Y);
            let written = replace_positions(&file, "", &moved).expect("a file");
            let again = parse_mesh(&written, "").expect("a mesh");
            let positions = again.volume.as_ref().map_or(&again.positions, |volume| &volume.nodes);
            assert_eq!((&positions[..], &again.faces), (&moved[..], &before.faces), "{style:?}");
            let back = replace_positions(&written, "", &NODES.map(DVec3::from_array));
            let back = back.expect("a file");
            assert_eq!(parse_mesh(&back, "").expect("a mesh"), before, "{style:?}");
            assert!(!style.is_binary || back == file, "{style:?}");

            // Positions as they are keep their spelling.
            let same = replace_positions(&file, "", &NODES.map(DVec3::from_array));
            assert_eq!(same.expect("a file"), file, "{style:?}");
            let precision = coordinate_precision(&file, "").expect("a mesh");
            assert_eq!(precision == Precision::Single, style.is_single);
        }
    }
}

/// As old exporters write them: no version that counts, in capitals or not, with ends of lines of any kind.
#[test]
fn text_may_have_any_spacing_and_case() {
    let file = "# vtk DataFile Version 2.0\r\n\r\nascii\r\nDataset PolyData\r\nPoints 4 FLOAT\r\n0 0 0 1\r\n\
                0 0 0 1 0 0 0\r\n1\r\nPolygons 4 16\r\n3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3";
    for end in ["\r\n", "\n", "\r"] {
        let mesh = parse_mesh(file.replace("\r\n", end).as_bytes(), "vtk").expect("a mesh");
        assert_eq!(mesh.faces, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], "{end:?}");
        assert_eq!(mesh.positions[3], DVec3::Z, "{end:?}");
    }
}

#[test]
fn defects_are_named_with_their_place() {
    let text = Style { is_binary: false, has_two_arrays: false, is_single: false };
    let [old, new] = [false, true].map(|has_two_arrays| {
        String::from_utf8_lossy(&polygons(Style { has_two_arrays, ..text })).into_owned()
    });
    let grid = String::from_utf8(block(text)).expect("text");
    let binary = polygons(Style { is_binary: true, ..text });
    let cut = |length: usize| binary[..length].to_vec();
    let changed = |file: &str, from: &str, to: &str| {
        assert!(file.contains(from), "{from}");
        file.replacen(from, to, 1).into_bytes()
    };
    for (file, expected) in [
        (changed(&old, "Version 3.0", "Version"), "VTK file: header: the first line ends with"),
        (changed(&old, "ASCII", "UTF"), "header: 'UTF' is neither ASCII nor BINARY"),
        (changed(&old, "POLYDATA", "STRUCTURED_GRID"), "data of type 'STRUCTURED_GRID' cannot"),
        (changed(&old, "9 double", "9 int"), "points of type 'int' cannot be read"),
        (changed(&old, "0.5 1.75", "x 1.75"), "VTK file: line 23: 'x' is not a coordinate"),
        (changed(&old, "POLYGONS 9", "POLYGONS 8"), "a list of 41 numbers is not that of 8 cells"),
        (changed(&old, "LINES", "WIRES"), "line 29: unknown keyword 'WIRES'"),
        (changed(&old, "STRIPS 0 0", "STRIPS 1 4\n3 0 1 2"), "1 triangle strips cannot be read"),
        (changed(&old, "4 5 8", "4 5 9"), "face 5 refers to vertex 9"),
        (changed(&new, "OFFSETS", "ENDS"), "OFFSETS expected, not 'ENDS'"),
        (changed(&new, "0 4 8 12", "0 4 3 12"), "offset 1 does not lie within the connectivity"),
        (changed(&grid, "12 10 10", "12 10 14"), "cells of VTK's type 14 cannot be read"),
        (changed(&grid, "12 10 10", "10 10 10"), "element 'CELLS': cell 1 of type 10 has 8 points"),
        (
            changed(&grid, "CELL_TYPES 4\n5 ", "CELL_TYPES 3\n"),
            "'CELL_TYPES': 4 cells, but 3 types",
        ),
        (changed(&grid, "POINTS 9", "POINTS 99999999999999"), "is not a coordinate"),
        (cut(binary.len() / 2), "VTK file: byte"),
        (cut(110), "VTK file: byte"),
    ] {
        let error = parse_mesh(&file, "vtk").expect_err(expected).to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let files: Vec<Vec<u8>> = styles()
        .into_iter()
        .flat_map(|style| [polygons(style), house_grid(style), block(style)])
        .collect();
    let mut random = Random(13);
    for round in 0..ROUNDS / 4 {
        let file = damaged(&files[round % files.len()], &mut random);
        let _ = replace_positions(&file, "vtk", &NODES.map(DVec3::from_array));
        let Ok(mesh) = parse_mesh(&file, "vtk") else { continue };
        let in_range = |&vertex: &u32| (vertex as usize) < mesh.positions.len();
        assert!(mesh.faces.iter().flatten().all(in_range), "round {round}");
    }
}
