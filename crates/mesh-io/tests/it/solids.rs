//! Solid elements of every shape, linear and quadratic, in every format.

use fixtures::volume::Block;
use glam::DVec3;
use mesh_io::{ReadError, Volume, parse_mesh, replace_positions, write_vtu};
use volume_mesh::{Cell, MiddleNode, VolumeMesh};

use crate::volumes::volume;
use crate::{ROUNDS, Random, damaged};

/// Type of solid elements in files: its numbers in VTK, Gmsh and Abaqus, and its edges in the orders of these.
struct SolidType {
    vtk: u8,
    msh: u8,
    inp: &'static str,
    edges: &'static [[usize; 2]],
    edges_of_msh: &'static [[usize; 2]],
}

/// Types of tetrahedra, wedges and hexahedra: linear, then quadratic.
const SOLID_TYPES: [[SolidType; 2]; 3] = [
    [
        SolidType { vtk: 10, msh: 4, inp: "C3D4", edges: &[], edges_of_msh: &[] },
        SolidType {
            vtk: 24,
            msh: 11,
            inp: "C3D10M",
            edges: &[[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]],
            edges_of_msh: &[[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]],
        },
    ],
    [
        SolidType { vtk: 13, msh: 6, inp: "C3D6", edges: &[], edges_of_msh: &[] },
        SolidType {
            vtk: 26,
            msh: 18,
            inp: "C3D15",
            edges: &[[0, 1], [1, 2], [0, 2], [3, 4], [4, 5], [3, 5], [0, 3], [1, 4], [2, 5]],
            edges_of_msh: &[[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [3, 5], [4, 5]],
        },
    ],
    [
        SolidType { vtk: 12, msh: 5, inp: "C3D8R", edges: &[], edges_of_msh: &[] },
        SolidType {
            vtk: 25,
            msh: 17,
            inp: "C3D20R",
            edges: &[
                [0, 1],
                [1, 2],
                [2, 3],
                [0, 3],
                [4, 5],
                [5, 6],
                [6, 7],
                [4, 7],
                [0, 4],
                [1, 5],
                [2, 6],
                [3, 7],
            ],
            edges_of_msh: &[
                [0, 1],
                [0, 3],
                [0, 4],
                [1, 2],
                [1, 5],
                [2, 3],
                [2, 6],
                [3, 7],
                [4, 5],
                [4, 7],
                [5, 6],
                [6, 7],
            ],
        },
    ],
];

/// Solid elements of one type with all their nodes, and a surface element at the first ones.
struct Elements {
    nodes: Vec<DVec3>,
    middle_nodes: Vec<MiddleNode>,
    cells: Vec<Cell>,
}

impl Elements {
    fn new(block: &Block, cells: Vec<Cell>, edges: &[[usize; 2]]) -> Self {
        let (mut nodes, mut middle_nodes) = (block.nodes.clone(), Vec::<MiddleNode>::new());
        for cell in &cells {
            for edge in edges {
                let mut ends = edge.map(|place| cell.nodes()[place]);
                ends.sort_unstable();
                if middle_nodes.iter().all(|middle| middle.ends != ends) {
                    let node = u32::try_from(nodes.len()).expect("few nodes");
                    let [a, b] = ends.map(|end| nodes[end as usize]);
                    nodes.push(0.5 * (a + b));
                    middle_nodes.push(MiddleNode { node, ends });
                }
            }
        }
        Self { nodes, middle_nodes, cells }
    }

    /// Returns the nodes of each element, counted from `first`: corners, then those in the middle of edges.
    fn nodes_of_elements(&self, edges: &[[usize; 2]], first: u32) -> Vec<Vec<u32>> {
        let mut elements = Vec::new();
        for cell in &self.cells {
            let mut nodes = cell.nodes().to_vec();
            for edge in edges {
                let middle = MiddleNode::new(0, edge.map(|place| cell.nodes()[place]));
                let known = self.middle_nodes.iter().find(|known| known.ends == middle.ends);
                nodes.push(known.expect("each edge has one").node);
            }
            elements.push(nodes.iter().map(|node| node + first).collect());
        }
        elements
    }

    fn inp(&self, kind: &SolidType) -> String {
        let mut text = "*Node\n".to_owned();
        for (number, x) in (1..).zip(&self.nodes) {
            text += &format!("{number}, {:?}, {:?}, {:?}\n", x.x, x.y, x.z);
        }
        text += &format!("*Element, type={}\n", kind.inp);
        for (number, nodes) in (1..).zip(self.nodes_of_elements(kind.edges, 1)) {
            // At most eight numbers on a line, as long ones are written.
            text += &format!("{number}");
            for (place, node) in nodes.iter().enumerate() {
                text += if place % 8 == 7 { ",\n" } else { ", " };
                text += &node.to_string();
            }
            text += "\n";
        }
        text
    }

    fn msh(&self, kind: &SolidType) -> String {
        let mut text =
            format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", self.nodes.len());
        for (number, x) in (1..).zip(&self.nodes) {
            text += &format!("{number} {:?} {:?} {:?}\n", x.x, x.y, x.z);
        }
        text += &format!("$EndNodes\n$Elements\n{}\n", self.cells.len() + 1);
        // A curved triangle, as which Gmsh writes the faces of quadratic elements, all at known nodes.
        text += "1 9 2 1 1 1 2 3 1 2 3\n";
        for (number, nodes) in (2..).zip(self.nodes_of_elements(kind.edges_of_msh, 1)) {
            let nodes: Vec<String> = nodes.iter().map(ToString::to_string).collect();
            text += &format!("{number} {} 2 1 1 {}\n", kind.msh, nodes.join(" "));
        }
        text + "$EndElements\n"
    }

    /// Returns a legacy file, whose wedges are in the order of VTK, or in that of other writers.
    fn vtk(&self, kind: &SolidType, is_in_order: bool) -> String {
        let mut text = format!(
            "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
            self.nodes.len()
        );
        for x in &self.nodes {
            text += &format!("{:?} {:?} {:?}\n", x.x, x.y, x.z);
        }
        let mut elements = self.nodes_of_elements(kind.edges, 0);
        if is_in_order && kind.inp.starts_with("C3D6") {
            for nodes in &mut elements {
                *nodes = [0, 2, 1, 3, 5, 4].map(|place| nodes[place]).to_vec();
            }
        } else if is_in_order && kind.inp.starts_with("C3D15") {
            let order = [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13];
            for nodes in &mut elements {
                *nodes = order.map(|place| nodes[place]).to_vec();
            }
        }
        let size: usize = elements.iter().map(|nodes| nodes.len() + 1).sum();
        text += &format!("CELLS {} {size}\n", elements.len());
        for nodes in &elements {
            let nodes: Vec<String> = nodes.iter().map(ToString::to_string).collect();
            text += &format!("{} {}\n", nodes.len(), nodes.join(" "));
        }
        text += &format!("CELL_TYPES {}\n", elements.len());
        text + &format!("{}\n", kind.vtk).repeat(elements.len())
    }
}

/// Returns the cells of a block of each shape, in the order of [`SOLID_TYPES`].
fn shapes(block: &Block) -> [Vec<Cell>; 3] {
    [
        block.tetrahedra().into_iter().map(Cell::Tetrahedron).collect(),
        block.wedges().into_iter().map(Cell::Wedge).collect(),
        block.hexahedra.iter().copied().map(Cell::Hexahedron).collect(),
    ]
}

/// Corners of quadratic elements are their cells; every format has the nodes in the middle of edges in an
/// order of its own.
#[test]
fn solids_of_every_shape_and_order_are_read() {
    let size = DVec3::new(3.0, 2.0, 1.5);
    let block = Block::new(size, [2, 2, 3]).with_noise(size, 0.1);
    for (cells, kinds) in shapes(&block).into_iter().zip(&SOLID_TYPES) {
        let mesh = VolumeMesh::new(block.nodes.len(), cells.clone()).expect("valid nodes");
        let boundary = mesh.boundary().expect("a boundary");
        let mut written = vec![write_vtu(&block.nodes, &mesh, &[], None)];

        for kind in kinds {
            let elements = Elements::new(&block, cells.clone(), kind.edges);
            let files = [
                ("inp", elements.inp(kind)),
                ("msh", elements.msh(kind)),
                ("vtk", elements.vtk(kind, true)),
                ("vtk", elements.vtk(kind, false)),
            ];
            for (extension, file) in files {
                let mesh = parse_mesh(file.as_bytes(), extension).expect(&file);
                assert_eq!((mesh.skipped.as_ref(), &mesh.faces), (None, &boundary.faces), "{file}");
                let volume = volume(mesh);
                assert_eq!(volume.mesh.cells(), cells, "{file}");
                assert_eq!(volume.mesh.middle_nodes(), elements.middle_nodes, "{file}");
                assert_eq!(volume.nodes, elements.nodes, "{file}");
                written.push(write_vtu(
                    &volume.nodes[..block.nodes.len()],
                    &mesh_of(&volume),
                    &[],
                    None,
                ));
            }
        }
        assert!(written.iter().all(|file| *file == written[0]), "cells are written alike");
        let again = volume(parse_mesh(written[0].as_bytes(), "vtu").expect("a grid"));
        assert_eq!((again.mesh, again.nodes), (mesh, block.nodes.clone()));
    }
}

/// Returns the cells of a file over the corners alone.
fn mesh_of(volume: &Volume) -> VolumeMesh {
    let middle = volume.mesh.middle_nodes().len();
    let cells = volume.mesh.cells().to_vec();
    VolumeMesh::new(volume.nodes.len() - middle, cells).expect("corners stand first")
}

/// Inverted wedges are not turned with those that are in another order.
#[test]
fn an_inverted_wedge_among_others_stays_inverted() {
    let block = Block::new(DVec3::ONE, [2; 3]);
    let [_, mut wedges, _] = shapes(&block);
    let Cell::Wedge([a, b, c, d, e, f]) = wedges[3] else { panic!("a wedge") };
    wedges[3] = Cell::Wedge([a, c, b, d, f, e]);
    let elements = Elements::new(&block, wedges, &[]);
    for is_in_order in [true, false] {
        let file = elements.vtk(&SOLID_TYPES[1][0], is_in_order);
        let volume = volume(parse_mesh(file.as_bytes(), "vtk").expect(&file));
        let quality = volume.mesh.quality(&volume.nodes);
        assert_eq!((quality.inverted, quality.worst_cell), (1, 3), "{file}");
    }
}

#[test]
fn curved_edges_are_refused_with_their_nodes() {
    let block = Block::new(DVec3::ONE, [1; 3]).translated(DVec3::new(500.0, 0.0, 0.0));
    let [tetrahedra, ..] = shapes(&block);
    let kind = &SOLID_TYPES[0][1];
    let mut elements = Elements::new(&block, tetrahedra, kind.edges);
    let MiddleNode { node, ends: [a, b] } = elements.middle_nodes[3];
    let straight = elements.nodes[node as usize];

    // What single precision does to coordinates is no curve.
    for (offset, is_straight) in [(1e-4, true), (1e-3, true), (3e-3, false), (0.2, false)] {
        elements.nodes[node as usize] = straight + offset * DVec3::Z;
        let result = parse_mesh(elements.inp(kind).as_bytes(), "inp");
        match result {
            Ok(mesh) => assert!(is_straight && mesh.volume.is_some(), "{offset}"),
            Err(ReadError::CurvedEdge { node: found, ends, offset: distance, .. }) => {
                assert!(!is_straight, "{offset}");
                // Nodes are numbered from 1 there.
                assert_eq!(
                    (found, ends),
                    (u64::from(node) + 1, [u64::from(a) + 1, u64::from(b) + 1])
                );
                assert!((distance - offset).abs() < 1e-9, "{distance}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// Nodes in the middle of edges are written as all others are.
#[test]
fn quadratic_elements_are_written_again_with_all_their_nodes() {
    let block = Block::new(DVec3::ONE, [1; 3]);
    for (cells, [_, kind]) in shapes(&block).into_iter().zip(&SOLID_TYPES) {
        let elements = Elements::new(&block, cells, kind.edges);
        let moved: Vec<DVec3> = elements.nodes.iter().map(|x| *x + DVec3::X).collect();
        for (extension, file) in [
            ("inp", elements.inp(kind)),
            ("msh", elements.msh(kind)),
            ("vtk", elements.vtk(kind, true)),
        ] {
            let written = replace_positions(file.as_bytes(), extension, &moved).expect(&file);
            let volume = volume(parse_mesh(&written, extension).expect("a mesh"));
            assert_eq!(volume.nodes, moved, "{file}");
            assert_eq!(volume.mesh.middle_nodes(), elements.middle_nodes, "{file}");
        }
    }
}

#[test]
fn damaged_solids_never_panic() {
    let block = Block::new(DVec3::ONE, [1; 3]);
    let mut files = Vec::new();
    for (cells, kinds) in shapes(&block).into_iter().zip(&SOLID_TYPES) {
        for kind in kinds {
            let elements = Elements::new(&block, cells.clone(), kind.edges);
            files.push(("inp", elements.inp(kind)));
            files.push(("msh", elements.msh(kind)));
            files.push(("vtk", elements.vtk(kind, true)));
        }
    }
    let mut random = Random(12);
    for round in 0..ROUNDS {
        let (extension, content) = &files[round % files.len()];
        let Ok(mesh) = parse_mesh(&damaged(content.as_bytes(), &mut random), extension) else {
            continue;
        };
        let in_range = |&vertex: &u32| (vertex as usize) < mesh.positions.len();
        assert!(mesh.faces.iter().flatten().all(in_range), "round {round}");
    }
}
