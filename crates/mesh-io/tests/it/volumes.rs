//! Volume meshes: one planted block of a hexahedron with tetrahedra on top, in every format.

use fixtures::volume::Block;
use glam::DVec3;
use mesh_io::{Mesh, ReadError, Space, Volume, parse_mesh, write_vtu};
use volume_mesh::{Cell, VolumeMesh};

use crate::{ROUNDS, Random, damaged};

/// A unit cube, and a pyramid of two tetrahedra on it; numbered from 11 in steps of 10 by text files.
pub(crate) const NODES: [[f64; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
    [0.5, 0.5, 1.75],
];

pub(crate) fn cells() -> Vec<Cell> {
    vec![
        Cell::Hexahedron([0, 1, 2, 3, 4, 5, 6, 7]),
        Cell::Tetrahedron([4, 5, 6, 8]),
        Cell::Tetrahedron([4, 6, 7, 8]),
    ]
}

pub(crate) const INP: &str = "*Heading\n** a comment\n*Part, name=block\n*Node, nset=all\n\
    11, 0., 0., 0.\n21, 1., 0, 0\n 31 , 1.0, 1.0, 0.0\n41, 0., 1., 0.\n51, 0., 0., 1.\n\
    61, 1., 0., 1.\n71, 1., 1., 1.\n81, 0., 1., 1.\n91, 0.5, 5e-1, 1.75\n\
    *Element, type=C3D8R, elset=base\n3, 11, 21, 31, 41,\n  51, 61, 71, 81\n\
    *ELEMENT, TYPE = c3d4\n7, 51, 61, 71, 91\n8, 51, 71, 81, 91\n\
    *Element, type=S3\n9, 11, 21, 31\n*Nset, nset=top\n91,\n*End Part\n\
    *Assembly, name=a\n*Instance, name=i, part=block\n*End Instance\n*Node Output\nU\n";

pub(crate) const MSH_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n\
    11 0 0 0\n21 1 0 0\n31 1 1 0\n41 0 1 0\n51 0 0 1\n61 1 0 1\n71 1 1 1\n81 0 1 1\n\
    91 0.5 0.5 1.75\n$EndNodes\n$Elements\n4\n1 2 2 1 1 11 21 31\n3 5 2 1 1 11 21 31 41 51 61 71 81\n\
    7 4 2 1 1 51 61 71 91\n8 4 2 1 1 51 71 81 91\n$EndElements\n";

pub(crate) const MSH_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n\
    $Nodes\n2 9 11 91\n2 1 0 4\n11\n21\n31\n41\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 1 0 5\n51\n61\n71\n81\n\
    91\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n0.5 0.5 1.75\n$EndNodes\n$Elements\n3 4 1 8\n2 1 2 1\n1 11 21 31\n\
    3 1 5 1\n3 11 21 31 41 51 61 71 81\n3 1 4 2\n7 51 61 71 91\n8 51 71 81 91\n$EndElements\n";

const MSH_1: &str =
    "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 1 1 4 1 2 3 4\n$ENDELM\n";

fn vtu() -> String {
    let mesh = VolumeMesh::new(NODES.len(), cells()).expect("valid nodes");
    write_vtu(&NODES.map(DVec3::from_array), &mesh, &[], None)
}

/// Name, extension and content of each file, with the numbers of its cells.
fn files() -> [(&'static str, String, [u64; 3]); 4] {
    [
        ("vtu", vtu(), [0, 1, 2]),
        ("msh", MSH_2.to_owned(), [3, 7, 8]),
        ("msh", MSH_4.to_owned(), [3, 7, 8]),
        ("inp", INP.to_owned(), [3, 7, 8]),
    ]
}

pub(crate) fn volume(mesh: Mesh) -> Volume {
    mesh.volume.expect("a volume mesh")
}

/// Returns the elements that are no part of a mesh, by type.
fn skipped(mesh: &Mesh) -> Option<Vec<(String, usize)>> {
    mesh.skipped.clone().map(|skipped| skipped.counts.into_iter().collect())
}

/// A surface beside the cells, at nodes of its own, is not lost without a word.
#[test]
fn surfaces_at_nodes_of_no_cell_are_counted_by_type() {
    let nodes = "101 5 0 0\n102 6 0 0\n103 6 1 0\n104 5 1 0\n";
    let msh_2 = MSH_2.replace("$Nodes\n9\n", &format!("$Nodes\n13\n{nodes}")).replace(
        "$Elements\n4\n",
        "$Elements\n9\n51 2 2 1 1 101 102 103\n52 2 2 1 1 11 102 21\n53 3 2 1 1 101 102 103 104\n\
         54 9 2 1 1 101 102 103 11 21 31\n55 1 2 1 1 101 102\n",
    );
    let msh_4 = MSH_4
        .replace("$Nodes\n2 9", "$Nodes\n3 13")
        .replace(
            "\n2 1 0 4\n",
            "\n2 1 0 4\n101\n102\n103\n104\n5 0 0\n6 0 0\n6 1 0\n5 1 0\n2 1 0 4\n",
        )
        .replace("$Elements\n3 4", "$Elements\n6 8")
        .replace(
            "\n2 1 2 1\n",
            "\n2 1 2 2\n51 101 102 103\n52 11 102 21\n2 1 3 1\n53 101 102 103 104\n\
                 2 1 9 1\n54 101 102 103 11 21 31\n2 1 2 1\n",
        );
    let corners = "0 1 2 9 10 11 0 10 1 9 10 11 12 9 10 11 0 1 2 ";
    let vtu = ascii_vtu(corners, "3 6 9 13 19 ", "5 5 5 9 22 ");
    for (extension, content, curved) in [
        ("msh", msh_2, "element type 9"),
        ("msh", msh_4, "element type 9"),
        ("vtu", vtu, "VTK's type 22"),
    ] {
        let mesh = parse_mesh(content.as_bytes(), extension).expect(&content);
        let mut expected = vec![
            (curved.to_owned(), 1),
            ("quadrilateral".to_owned(), 1),
            ("triangle".to_owned(), 2),
        ];
        expected.sort();
        assert_eq!(skipped(&mesh), Some(expected), "{content}");
        assert_eq!(volume(mesh).mesh.cells().len(), 3, "{content}");
    }
}

/// Returns the planted block as text, with other cells before its own.
fn ascii_vtu(corners: &str, ends: &str, types: &str) -> String {
    let (mut corners, mut ends, mut types) =
        (corners.to_owned(), ends.to_owned(), types.to_owned());
    let mut end = corners.split_whitespace().count();
    for cell in cells() {
        end += cell.nodes().len();
        corners += &cell.nodes().iter().map(|node| format!("{node} ")).collect::<String>();
        ends += &format!("{end} ");
        types += if cell.nodes().len() == 4 { "10 " } else { "12 " };
    }
    let more = [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 1.0, 0.0], [5.0, 1.0, 0.0]];
    let points = NODES.iter().chain(&more).map(|[x, y, z]| format!("{x} {y} {z} "));
    let points = points.collect::<String>();
    let count = types.split_whitespace().count();
    let array = |kind: &str, name: &str, content: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{content}</DataArray>")
    };
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid><Piece NumberOfPoints=\"13\" NumberOfCells=\"{count}\">\n\
         <Points>{}</Points>\n<Cells>{}{}{}</Cells>\n</Piece></UnstructuredGrid></VTKFile>\n",
        array("Float64", "Points", &points)
            .replace("Float64\"", "Float64\" NumberOfComponents=\"3\""),
        array("Int64", "connectivity", &corners),
        array("Int64", "offsets", &ends),
        array("UInt8", "types", &types),
    )
}

#[test]
fn every_format_gives_the_planted_block() {
    for (extension, content, numbers) in files() {
        let mesh = parse_mesh(content.as_bytes(), extension).unwrap();
        // The triangle of the text files is a half of the base: nothing is missing without it.
        let shells = (extension == "inp").then(|| vec![("S3".to_owned(), 1)]);
        assert_eq!(skipped(&mesh), shells, "{extension}");
        // Five squares of the cube and five triangles of the pyramid; its base matches no square.
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (9, 6 * 2 + 6), "{extension}");
        let volume = volume(mesh);
        assert_eq!(volume.nodes, NODES.map(DVec3::from_array), "{extension}");
        assert_eq!(volume.mesh.cells(), cells(), "{extension}");
        assert_eq!(volume.cell_numbers, numbers, "{extension}");
        let last = if extension == "vtu" { 8 } else { 91 };
        assert_eq!((volume.node_numbers.len(), volume.node_numbers[8]), (9, last), "{extension}");
    }
}

#[test]
fn nodes_inside_are_no_vertices() {
    let block = Block::new(DVec3::ONE, [2; 3]);
    let cells = block.hexahedra.iter().copied().map(Cell::Hexahedron).collect();
    let mesh = VolumeMesh::new(27, cells).expect("valid nodes");
    let space = Some(Space::RightAnteriorSuperior);
    let file = write_vtu(&block.nodes, &mesh, &[], space);
    let read = parse_mesh(file.as_bytes(), "vtu").unwrap();
    assert_eq!((read.positions.len(), read.faces.len(), read.space), (26, 48, space));
    let volume = volume(read);
    assert_eq!((volume.nodes, volume.mesh), (block.nodes, mesh));
    assert!(!volume.boundary.nodes.contains(&13));
}

#[test]
fn defects_are_named_with_their_place() {
    let refusal = |extension: &str, content: String| -> String {
        let result: Result<Mesh, ReadError> = parse_mesh(content.as_bytes(), extension);
        result.expect_err(&content).to_string()
    };
    let inp = |from: &str, to: &str| refusal("inp", INP.replacen(from, to, 1));
    let msh = |from: &str, to: &str| refusal("msh", MSH_2.replacen(from, to, 1));
    let msh_4 = |from: &str, to: &str| refusal("msh", MSH_4.replacen(from, to, 1));
    let vtu = |from: &str, to: &str| refusal("vtu", vtu().replacen(from, to, 1));

    let cases = [
        (inp("8, 51, 71", "8, 51, 99"), "INP file: line 19: node 99 is not defined above"),
        (msh("21 1 0 0", "21 1 0"), "MSH file: line 7: a node needs three coordinates"),
        (inp("21, 1., 0, 0", "21, 1., O, 0"), "INP file: line 6: 'O' is not a number"),
        (inp("21, 1., 0, 0", "11, 1., 0, 0"), "INP file: line 6: node 11 is defined again"),
        (inp("7, 51, 61, 71, 91", "7, 51, 61"), "an element of 4 nodes has 2"),
        (inp("  51, 61, 71, 81\n", ""), "INP file: line 16: element 3 ends early"),
        (
            inp("C3D8R", "C3D27R"),
            "elements of type 'C3D27R' cannot be read; save the nodes and elements of",
        ),
        (inp("C3D8R", "C3D20R"), "INP file: line 16: an element of 20 nodes has 8"),
        (inp("*Nset", "*Include"), "the keyword 'INCLUDE' cannot be read"),
        (inp("*End Part", "*Part, name=BLOCK"), "line 24: a second part is named 'BLOCK'"),
        (inp("part=block\n", "part=block\n1., 0., O.\n"), "line 27: 'O.' is no number of a tra"),
        (inp("7, 51, 61, 71, 91", "7, 51, 61, 51, 91"), "element 7 has node 51 twice: save it"),
        (msh("2.2 0 8", "2.2 1 8"), "MSH file: binary data cannot be read; save it as text"),
        (msh("2.2 0 8", "4 0 8"), "version '4' cannot be read"),
        (
            refusal("msh", MSH_1.to_owned()),
            "MSH file: version '1' cannot be read; save it as text in version 4.1 or 2.2",
        ),
        (msh("7 4 2 1 1", "7 7 2 1 1"), "element type 7 cannot be read"),
        (msh("7 4 2 1 1", "7 11 2 1 1"), "MSH file: line 20: an element of 10 nodes has 4"),
        (msh("51 61 71 91", "51 61 71 92"), "MSH file: line 20: node 92 is not defined above"),
        (msh("$Nodes\n9", "$Nodes\n10"), "a section ends before its declared end"),
        (msh("$Elements\n4", "$Elements\n5"), "a section ends before its declared end"),
        (msh("1 2 2 1 1 11 21 31", "1 2"), "an element has a number, a type and tags"),
        (msh("$Elements", "$Nothing"), "has 9 nodes and no tetrahedra, wedges or hexahedra"),
        (msh_4("2 1 0 4", "2 1 0"), "MSH file: line 9: 4 whole numbers expected"),
        (msh_4("\n31\n", "\nx\n"), "'x' is not a whole number"),
        (
            vtu("NumberOfCells=\"3\"", "NumberOfCells=\"4\""),
            "VTU file: element 'Cells': 4 cells, but 3 offsets",
        ),
        (vtu("NumberOfCells=\"3\"", "NumberOfCells=\"x\""), "NumberOfCells='x' is not a count"),
        (vtu("Name=\"types\"", "Name=\"kinds\""), "VTU file: array 'types': is missing"),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

#[test]
fn damaged_volumes_never_panic() {
    let files = files();
    let mut random = Random(11);
    for round in 0..ROUNDS {
        let (extension, content, _) = &files[round % files.len()];
        let Ok(mesh) = parse_mesh(&damaged(content.as_bytes(), &mut random), extension) else {
            continue;
        };
        let in_range = |&vertex: &u32| (vertex as usize) < mesh.positions.len();
        assert!(mesh.faces.iter().flatten().all(in_range), "round {round}");
    }
}
