//! Surfaces of elements without volume: one planted house of squares and triangles, in every format.

use std::fmt::Write as _;

use glam::DVec3;
use mesh_io::{Mesh, parse_mesh, replace_positions};

use crate::volumes::NODES;
use crate::{ROUNDS, Random, damaged};

/// A floor and four walls, corners of each in their order around it.
pub(crate) const SQUARES: [[usize; 4]; 5] =
    [[0, 3, 2, 1], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A roof of triangles over the walls.
pub(crate) const TRIANGLES: [[usize; 3]; 4] = [[4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]];

/// Returns the number of a node in text files.
fn number(node: usize) -> usize {
    10 * node + 11
}

fn numbers(nodes: &[usize], separator: &str) -> String {
    let words: Vec<String> = nodes.iter().map(|&node| number(node).to_string()).collect();
    words.join(separator)
}

/// Returns an Abaqus file of two types, with a mass at a node.
fn inp([squares, triangles]: [&str; 2]) -> String {
    let mut file = "*Node\n".to_owned();
    for (node, [x, y, z]) in NODES.iter().enumerate() {
        let _ = writeln!(file, "{}, {x}, {y}, {z}", number(node));
    }
    let _ = writeln!(file, "*Element, type={squares}, elset=walls");
    for (element, nodes) in SQUARES.iter().enumerate() {
        let _ = writeln!(file, "{element}, {}", numbers(nodes, ", "));
    }
    let _ = writeln!(file, "*Element, type={triangles}");
    for (element, nodes) in TRIANGLES.iter().enumerate() {
        let _ = writeln!(file, "{}, {}", element + 5, numbers(nodes, ",\n"));
    }
    file + "*Element, type=MASS\n20, 11\n"
}

/// Returns a Gmsh file of version 2, with a point and an edge.
fn msh_2() -> String {
    let mut file = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n".to_owned();
    for (node, [x, y, z]) in NODES.iter().enumerate() {
        let _ = writeln!(file, "{} {x} {y} {z}", number(node));
    }
    file += "$EndNodes\n$Elements\n11\n1 15 2 0 1 11\n2 1 2 0 1 11 21\n";
    for nodes in SQUARES {
        let _ = writeln!(file, "3 3 2 0 1 {}", numbers(&nodes, " "));
    }
    for nodes in TRIANGLES {
        let _ = writeln!(file, "4 2 2 0 1 {}", numbers(&nodes, " "));
    }
    file + "$EndElements\n"
}

/// Returns a Gmsh file of version 4.1.
fn msh_4() -> String {
    let mut file = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9 11 91\n2 1 0 9\n".to_owned();
    for node in 0..NODES.len() {
        let _ = writeln!(file, "{}", number(node));
    }
    for [x, y, z] in NODES {
        let _ = writeln!(file, "{x} {y} {z}");
    }
    file += "$EndNodes\n$Elements\n2 9 1 9\n2 1 3 5\n";
    for nodes in SQUARES {
        let _ = writeln!(file, "1 {}", numbers(&nodes, " "));
    }
    file += "2 2 2 4\n";
    for nodes in TRIANGLES {
        let _ = writeln!(file, "1 {}", numbers(&nodes, " "));
    }
    file + "$EndElements\n"
}

/// Returns a VTK file: the floor row by row, three walls, one as a polygon, the roof, and an edge.
fn vtu() -> String {
    let (mut connectivity, mut offsets, mut end) = (String::new(), String::new(), 0);
    let [[a, b, c, d], walls @ ..] = SQUARES;
    let mut cells = vec![vec![a, b, d, c]];
    cells.extend(walls.map(|wall| wall.to_vec()));
    cells.extend(TRIANGLES.map(|triangle| triangle.to_vec()));
    cells.push(vec![0, 8]);
    for cell in cells {
        end += cell.len();
        for node in cell {
            let _ = write!(connectivity, "{node} ");
        }
        let _ = write!(offsets, "{end} ");
    }
    let array = |kind: &str, name: &str, content: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{content}</DataArray>")
    };
    let points: String = NODES.iter().map(|[x, y, z]| format!("{x} {y} {z} ")).collect();
    format!(
        "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid><Piece NumberOfPoints=\"9\" NumberOfCells=\"10\">\n\
         <Points>{}</Points>\n<Cells>{}{}{}</Cells>\n</Piece></UnstructuredGrid></VTKFile>\n",
        array("Float64", "Points", &points),
        array("Int64", "connectivity", &connectivity),
        array("Int64", "offsets", &offsets),
        array("UInt8", "types", "8 9 9 9 7 5 5 5 5 3"),
    )
}

fn files() -> Vec<(&'static str, String)> {
    let mut files = vec![("vtu", vtu()), ("msh", msh_2()), ("msh", msh_4())];
    for kinds in [
        ["S4R", "S3R"],
        ["S4R5", "STRI3"],
        ["R3D4", "R3D3"],
        ["M3D4R", "M3D3"],
        ["SFM3D4", "SFM3D3"],
        ["DS4", "DS3"],
        ["F3D4", "F3D3"],
        ["CPS4", "CPS3"],
        ["CPE4RH", "CPE3"],
    ] {
        files.push(("inp", inp(kinds)));
    }
    files
}

/// Returns the triangles of the house, squares split at their first corner.
pub(crate) fn planted() -> Vec<[u32; 3]> {
    triangles(SQUARES)
}

/// Returns the triangles of the house as elements: squares are split at their first node in the file, as solids are.
pub(crate) fn planted_elements() -> Vec<[u32; 3]> {
    triangles(SQUARES.map(|mut square| {
        let first = (0..4).min_by_key(|&place| square[place]).expect("a corner");
        square.rotate_left(first);
        square
    }))
}

fn triangles(squares: [[usize; 4]; 5]) -> Vec<[u32; 3]> {
    let halves = squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let faces = halves.chain(TRIANGLES);
    faces.map(|face| face.map(|corner| u32::try_from(corner).expect("few"))).collect()
}

#[test]
fn every_format_gives_the_planted_house() {
    for (extension, content) in files() {
        let mesh = parse_mesh(content.as_bytes(), extension).expect(&content);
        assert_eq!(mesh.positions, NODES.map(DVec3::from_array), "{content}");
        assert_eq!((mesh.faces, mesh.polygons_fanned), (planted_elements(), 5), "{content}");
        assert!(mesh.volume.is_none());
        let last = if extension == "vtu" { 8 } else { 91 };
        assert_eq!(mesh.vertex_numbers.expect("nodes").last(), Some(&last), "{content}");
        let skipped = mesh.skipped.map(|skipped| skipped.counts.into_iter().collect::<Vec<_>>());
        let masses = (extension == "inp").then(|| vec![("MASS".to_owned(), 1)]);
        assert_eq!(skipped, masses, "{content}");
    }
}

#[test]
fn all_but_positions_stays_in_a_file_that_is_written_again() {
    for (extension, content) in files() {
        let moved = NODES.map(|x| DVec3::from_array(x) * 2.0 + DVec3::X);
        let file = replace_positions(content.as_bytes(), extension, &moved).expect(extension);
        let again = parse_mesh(&file, extension).expect(extension);
        assert_eq!(
            (&again.positions[..], again.faces),
            (&moved[..], planted_elements()),
            "{extension}"
        );
        let back = replace_positions(&file, extension, &NODES.map(DVec3::from_array));
        let back = parse_mesh(&back.expect(extension), extension);
        assert_eq!(back.expect(extension), parse_mesh(content.as_bytes(), extension).unwrap());
    }
}

#[test]
fn what_is_no_linear_surface_is_named() {
    let refusal = |extension: &str, content: String| -> String {
        parse_mesh(content.as_bytes(), extension).expect_err(&content).to_string()
    };
    for (message, expected) in [
        (refusal("inp", inp(["S8R", "S3"])), "elements of type 'S8R' cannot be read"),
        (refusal("inp", inp(["S4", "STRI65"])), "elements of type 'STRI65' cannot be read"),
        (refusal("inp", inp(["B31", "T3D2"])), "elements of type 'B31' cannot be read"),
        (refusal("inp", inp(["S3", "S3"])), "INP file: line 12: an element of 3 nodes has 4"),
        (refusal("msh", msh_2().replace("\n4 2 2", "\n4 9 2")), "element type 9 cannot be read"),
        (refusal("msh", msh_4().replace("\n2 2 2 4", "\n2 2 16 4")), "element type 16 cannot be"),
        (
            refusal("msh", msh_2().replace(" 81 41\n", " 82 41\n").replace(" 81 71\n", " 82 71\n")),
            "node 82 is not defined above",
        ),
        (refusal("vtu", vtu().replace("5 5 3<", "5 22 3<")), "cells of VTK's type 22 cannot be"),
        (refusal("vtu", vtu().replace("8 9 9", "5 9 9")), "cells of VTK's type 5 cannot be read"),
        (refusal("vtu", vtu().replace("5 6 8 ", "5 6 9 ")), "refers to vertex 9"),
    ] {
        assert!(message.contains(expected), "{expected}: {message}");
    }
}

/// Elements of an assembly are of its own nodes: they are no part of the surface.
#[test]
fn surfaces_of_an_assembly_are_left_out() {
    let kinds = ["R3D4", "R3D3"];
    let assembly = "*Assembly\n*Node\n1, 9, 9, 9\n*Element, type=S3\n1, 1, 2, 3\n*End Assembly\n";
    let mesh = parse_mesh((inp(kinds) + assembly).as_bytes(), "inp").expect("a mesh");
    assert_eq!((mesh.positions.len(), mesh.faces), (9, planted_elements()));
    let counts = mesh.skipped.expect("two elements").counts;
    assert_eq!(counts.into_iter().collect::<Vec<_>>(), [("MASS".into(), 1), ("S3".into(), 1)]);
}

#[test]
fn damaged_surfaces_never_panic() {
    let files = files();
    let mut random = Random(12);
    for round in 0..ROUNDS / 4 {
        let (extension, content) = &files[round % files.len()];
        let mesh: Result<Mesh, _> =
            parse_mesh(&damaged(content.as_bytes(), &mut random), extension);
        let Ok(mesh) = mesh else { continue };
        let in_range = |&vertex: &u32| (vertex as usize) < mesh.positions.len();
        assert!(mesh.faces.iter().flatten().all(in_range), "round {round}");
    }
}

/// A bone of shells below a solid, over the same nodes: the squares of both are split by the same diagonals, from
/// whatever corner a file lists them.
#[test]
fn shells_are_split_as_the_solids_upon_them() {
    let triangles = |mesh: &Mesh| {
        let nodes = mesh.nodes.as_ref().expect("a part of a file");
        let of_base = |face: &&[u32; 3]| face.iter().all(|&corner| nodes[corner as usize] < 4);
        let mut triangles: Vec<[u32; 3]> = mesh.faces.iter().filter(of_base).copied().collect();
        triangles.iter_mut().for_each(|face| {
            *face = face.map(|corner| nodes[corner as usize]);
            face.sort_unstable();
        });
        triangles.sort_unstable();
        triangles
    };
    for shell in ["1, 2, 3, 4", "2, 3, 4, 1", "4, 1, 2, 3", "4, 3, 2, 1"] {
        let model = format!(
            "*Node\n1, 0, 0, 0.1\n2, 1, 0, 0\n3, 1, 1, 0.1\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n\
             8, 0, 1, 1\n*Element, type=C3D8, elset=cartilage\n1, 1, 2, 3, 4, 5, 6, 7, 8\n\
             *Element, type=R3D4, elset=bone\n2, {shell}\n"
        );
        let [cartilage, bone] = ["cartilage", "bone"].map(|set| {
            let set = [set.to_owned()];
            let meshes = mesh_io::parse_parts(model.as_bytes(), "inp", &[&set]).expect(shell);
            meshes.into_iter().next().expect("a mesh")
        });
        assert_eq!(triangles(&bone), triangles(&cartilage), "{shell}");
        assert_eq!(bone.faces.len(), 2, "{shell}");
    }
}
