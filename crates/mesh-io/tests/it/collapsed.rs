//! Hexahedra and wedges with repeated nodes: one planted block, in every format.

use std::fmt::Write;

use glam::DVec3;
use mesh_io::{Mesh, ReadError, parse_mesh, replace_positions};
use volume_mesh::Cell;

use crate::volumes::{NODES, volume};

/// Elements in the order of [`Cell`], by the places of their nodes.
type Elements = Vec<Vec<usize>>;

/// The lower half of a cube as a hexahedron, the upper half as a wedge, and two tetrahedra on it: as a hexahedron and
/// as a wedge.
fn block() -> Elements {
    vec![
        vec![0, 1, 2, 3, 0, 1, 6, 7],
        vec![0, 7, 4, 1, 6, 5],
        vec![4, 5, 6, 6, 8, 8, 8, 8],
        vec![4, 6, 7, 8, 8, 8],
    ]
}

/// Returns the lines of the nodes, with a separator between their numbers.
fn node_lines(separator: &str) -> String {
    let line = |(number, [x, y, z]): (usize, [f64; 3])| {
        format!("{number}{separator}{x}{separator}{y}{separator}{z}\n")
    };
    (1..).zip(NODES).map(line).collect()
}

fn inp(elements: &Elements) -> String {
    let mut file = format!("*Node\n{}", node_lines(", "));
    for (number, nodes) in (1..).zip(elements) {
        let kind = if nodes.len() == 8 { "C3D8" } else { "C3D6" };
        let nodes: String = nodes.iter().map(|node| format!(", {}", node + 1)).collect();
        write!(file, "*Element, type={kind}\n{number}{nodes}\n").expect("a string");
    }
    file
}

fn feb(elements: &Elements) -> String {
    let mut file = "<febio_spec version=\"4.0\"><Mesh><Nodes name=\"n\">\n".to_owned();
    for (number, [x, y, z]) in (1..).zip(NODES) {
        writeln!(file, "<node id=\"{number}\">{x},{y},{z}</node>").expect("a string");
    }
    file += "</Nodes>\n";
    for (number, nodes) in (1..).zip(elements) {
        let kind = if nodes.len() == 8 { "hex8" } else { "penta6" };
        let nodes: Vec<String> = nodes.iter().map(|node| (node + 1).to_string()).collect();
        writeln!(
            file,
            "<Elements type=\"{kind}\" name=\"p\"><elem id=\"{number}\">{}</elem></Elements>",
            nodes.join(",")
        )
        .expect("a string");
    }
    file + "</Mesh></febio_spec>\n"
}

fn msh(elements: &Elements) -> String {
    let mut file =
        format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n{}$EndNodes\n", node_lines(" "));
    writeln!(file, "$Elements\n{}", elements.len()).expect("a string");
    for (number, nodes) in (1..).zip(elements) {
        let kind = if nodes.len() == 8 { 5 } else { 6 };
        let nodes: String = nodes.iter().map(|node| format!(" {}", node + 1)).collect();
        writeln!(file, "{number} {kind} 2 1 1{nodes}").expect("a string");
    }
    file + "$EndElements\n"
}

/// Wedges are in the order of VTK, or in that of others.
fn vtk(elements: &Elements, has_order_of_vtk: bool) -> String {
    let mut file =
        "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n"
            .to_owned();
    for [x, y, z] in NODES {
        writeln!(file, "{x} {y} {z}").expect("a string");
    }
    let size: usize = elements.iter().map(|nodes| 1 + nodes.len()).sum();
    writeln!(file, "CELLS {} {size}", elements.len()).expect("a string");
    for nodes in elements {
        let mut nodes = nodes.clone();
        if nodes.len() == 6 && has_order_of_vtk {
            nodes.swap(1, 2);
            nodes.swap(4, 5);
        }
        let text: String = nodes.iter().map(|node| format!(" {node}")).collect();
        writeln!(file, "{}{text}", nodes.len()).expect("a string");
    }
    writeln!(file, "CELL_TYPES {}", elements.len()).expect("a string");
    for nodes in elements {
        writeln!(file, "{}", if nodes.len() == 8 { 12 } else { 13 }).expect("a string");
    }
    file
}

/// Extension and content of a file in each format.
fn files(elements: &Elements) -> [(&'static str, String); 5] {
    [
        ("inp", inp(elements)),
        ("feb", feb(elements)),
        ("msh", msh(elements)),
        ("vtk", vtk(elements, true)),
        ("vtk", vtk(elements, false)),
    ]
}

/// Returns six times the volume inside the faces.
fn volume_inside(mesh: &Mesh) -> f64 {
    let corner = |vertex: u32| mesh.positions[vertex as usize];
    let of_face = |face: &[u32; 3]| {
        let [a, b, c] = face.map(corner);
        a.dot(b.cross(c))
    };
    mesh.faces.iter().map(of_face).sum()
}

#[test]
fn elements_with_repeated_nodes_are_wedges_and_tetrahedra_in_every_format() {
    for (extension, content) in files(&block()) {
        let mesh = parse_mesh(content.as_bytes(), extension).expect(&content);
        assert!((volume_inside(&mesh) - 7.5).abs() < 1e-12, "{content}");
        let volume = volume(mesh);
        let counts = volume.mesh.cells().iter().map(|cell| cell.nodes().len());
        assert_eq!(counts.collect::<Vec<_>>(), [6, 6, 4, 4], "{content}");
        assert_eq!(volume.mesh.quality(&volume.nodes).inverted, 0, "{content}");
        assert_eq!(volume.cell_numbers.len(), 4, "{content}");
    }
}

/// Tetrahedra as wedges alone: two of three edges between bases are repeated, so that their first corner is flat.
#[test]
fn the_order_of_collapsed_wedges_is_that_of_the_file() {
    for (extension, content) in files(&vec![vec![0, 1, 3, 0, 1, 4], vec![1, 2, 3, 1, 2, 6]]) {
        let volume = volume(parse_mesh(content.as_bytes(), extension).expect(&content));
        assert_eq!(volume.mesh.quality(&volume.nodes).inverted, 0, "{content}");
        assert!(matches!(volume.mesh.cells()[0], Cell::Tetrahedron(_)), "{content}");
    }
}

#[test]
fn elements_stay_as_they_are_when_nodes_move() {
    for (extension, content) in files(&block()) {
        let mesh = parse_mesh(content.as_bytes(), extension).expect(&content);
        let moved: Vec<DVec3> = mesh.positions.iter().map(|&x| x + DVec3::Z).collect();
        let written =
            replace_positions(content.as_bytes(), extension, &moved).expect("as many positions");
        let read = parse_mesh(&written, extension).expect("a file as before");
        assert_eq!((read.positions, read.faces), (moved, mesh.faces), "{content}");
        let written = String::from_utf8(written).expect("text");
        let (_, elements) = content.split_at(content.rfind("0.5").expect("the last node"));
        let (_, end) = elements.split_once('\n').expect("elements");
        assert!(written.ends_with(end), "{content}\n{written}");
    }
}

#[test]
fn other_elements_with_repeated_nodes_are_refused_by_number() {
    let others = [
        ("a pyramid", vec![4, 5, 6, 7, 8, 8, 8, 8]),
        ("a pyramid", vec![4, 5, 6, 4, 8, 7]),
        ("one edge", vec![0, 1, 2, 3, 4, 5, 6, 6]),
        ("a diagonal", vec![4, 5, 4, 7, 8, 1, 2, 3]),
    ];
    for (kind, other) in others {
        for (extension, content) in files(&vec![vec![0, 1, 2, 3, 4, 5, 6, 7], other]) {
            let result: Result<Mesh, ReadError> = parse_mesh(content.as_bytes(), extension);
            let message = result.expect_err(&content).to_string();
            let number = if extension == "vtk" { 1 } else { 2 };
            assert!(message.contains(&format!("element {number} has node ")), "{kind}: {message}");
            assert!(message.contains("twice: save it as one of fewer nodes, or as"), "{message}");
        }
    }
}

/// Repeated nodes are read in linear elements alone.
#[test]
fn quadratic_elements_with_repeated_nodes_are_refused() {
    let mut file = format!("*Node\n{}", node_lines(", "));
    for (number, [x, y, z]) in (10..).zip([[0.5, 0.0, 0.0]; 6]) {
        writeln!(file, "{number}, {x}, {y}, {z}").expect("a string");
    }
    file += "*Element, type=C3D15\n7, 1, 2, 4, 5, 5, 5, 10, 11, 12, 5, 5, 5, 13, 14, 15\n";
    let message = parse_mesh(file.as_bytes(), "inp").expect_err("a quadratic wedge").to_string();
    assert!(message.contains("element 7 has node 5 twice"), "{message}");
}
