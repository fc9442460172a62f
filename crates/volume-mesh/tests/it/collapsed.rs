//! Cells with repeated nodes: all that there can be, with the volume inside their faces.

use volume_mesh::glam::DVec3;
use volume_mesh::{Cell, VolumeMesh};

/// Corners of a cube, in the order of a hexahedron.
const CUBE: [[u32; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Positions without symmetry: no two cells of other nodes have the same volume.
const POSITIONS: [[i64; 3]; 8] = [
    [0, 1, 3],
    [101, -7, 5],
    [113, 97, -11],
    [-13, 107, 17],
    [7, -19, 127],
    [109, 23, 131],
    [103, 139, 149],
    [-29, 137, 151],
];

/// Returns twelve times the volume inside the faces of a cell, bilinear in quadrilaterals.
fn volume(cell: &Cell) -> i64 {
    let faces: &[&[usize]] = match cell {
        Cell::Tetrahedron(_) => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        Cell::Wedge(_) => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
        Cell::Hexahedron(_) => &[
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
    };
    let at = |place: usize| POSITIONS[cell.nodes()[place] as usize];
    let triangle = |places: [usize; 3]| {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = places.map(at);
        ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    };
    let twice = |face: &&[usize]| match **face {
        [a, b, c] => 2 * triangle([a, b, c]),
        // The mean of both pairs of triangles.
        [a, b, c, d] => {
            let one = triangle([a, b, c]) + triangle([a, c, d]);
            one + triangle([b, c, d]) + triangle([b, d, a])
        }
        _ => 0,
    };
    faces.iter().map(twice).sum()
}

/// Returns all ways to number places by the first place with the same node.
fn partitions(places: u32) -> Vec<Vec<u32>> {
    let mut partitions = vec![Vec::new()];
    for place in 0..places {
        let extended = |numbers: &Vec<u32>| {
            let mut firsts: Vec<u32> = numbers.clone();
            firsts.push(place);
            firsts.sort_unstable();
            firsts.dedup();
            let of_first = |first: u32| numbers.iter().copied().chain([first]).collect::<Vec<_>>();
            firsts.into_iter().map(of_first).collect::<Vec<_>>()
        };
        partitions = partitions.iter().flat_map(extended).collect();
    }
    partitions
}

/// Counts the tetrahedra and wedges among collapsed cells, all with the volume and the nodes from before.
fn counts(cells: impl Iterator<Item = Cell>) -> [usize; 2] {
    let mut counts = [0; 2];
    for cell in cells.filter(|cell| cell.repeated_node().is_some()) {
        let Some(collapsed) = cell.collapsed() else { continue };
        assert_eq!(volume(&collapsed), volume(&cell), "{cell:?} {collapsed:?}");
        let sorted = |cell: &Cell| {
            let mut nodes = cell.nodes().to_vec();
            nodes.sort_unstable();
            nodes
        };
        let mut nodes = sorted(&cell);
        nodes.dedup();
        assert_eq!(sorted(&collapsed), nodes, "{cell:?} {collapsed:?}");
        counts[usize::from(matches!(collapsed, Cell::Wedge(_)))] += 1;
    }
    counts
}

#[test]
fn collapsed_cells_keep_their_volume_wherever_nodes_are_repeated() {
    let array = |numbers: &Vec<u32>| <[u32; 8]>::try_from(&numbers[..]).expect("eight nodes");
    let hexahedra = partitions(8);
    assert_eq!(hexahedra.len(), 4140, "Bell's number of eight");
    assert_eq!(counts(hexahedra.iter().map(|numbers| Cell::Hexahedron(array(numbers)))), [102, 12]);

    let array = |numbers: &Vec<u32>| <[u32; 6]>::try_from(&numbers[..]).expect("six nodes");
    let wedges = partitions(6);
    assert_eq!(counts(wedges.iter().map(|numbers| Cell::Wedge(array(numbers)))), [11, 0]);
}

#[test]
fn each_half_of_a_cube_is_a_regular_wedge() {
    let positions: Vec<DVec3> =
        CUBE.map(|corner| DVec3::from_array(corner.map(f64::from))).to_vec();
    let number = |corner: [u32; 3]| (0..).zip(CUBE).find(|(_, known)| *known == corner);
    for collapsed in 0..3 {
        // Two opposite edges of one of the four faces along the collapsed axis.
        for (across, side) in [(1, 0), (1, 1), (2, 0), (2, 1)] {
            let across = (collapsed + across) % 3;
            let nodes = CUBE.map(|mut corner| {
                if corner[across] == side {
                    corner[collapsed] = 0;
                }
                number(corner).expect("a corner of the cube").0
            });

            let cell = Cell::Hexahedron(nodes);
            let wedge = cell.collapsed();
            assert!(matches!(wedge, Some(Cell::Wedge(_))), "{cell:?}: {wedge:?}");
            let mesh = VolumeMesh::new(8, Vec::from_iter(wedge)).expect("a wedge");
            let jacobian = mesh.quality(&positions).min_scaled_jacobian;
            assert!((jacobian - 0.5 * (8.0_f64 / 3.0).sqrt()).abs() < 1e-9, "{cell:?}: {jacobian}");
        }
    }
}

#[test]
fn usual_spellings_of_tetrahedra_and_none_of_pyramids_are_read() {
    let collapsed = |nodes: [u32; 8]| Cell::Hexahedron(nodes).collapsed();
    assert_eq!(collapsed([0, 1, 2, 2, 4, 4, 4, 4]), Some(Cell::Tetrahedron([0, 1, 2, 4])));
    assert_eq!(Cell::Wedge([0, 1, 2, 3, 3, 3]).collapsed(), Some(Cell::Tetrahedron([0, 1, 2, 3])));
    assert_eq!(collapsed([0, 1, 2, 3, 4, 4, 4, 4]), None, "a pyramid");
    assert_eq!(collapsed([0, 1, 2, 3, 4, 5, 6, 4]), None, "one edge");
    assert_eq!(collapsed([0, 1, 2, 3, 0, 1, 2, 3]), None, "a flat hexahedron");
    assert_eq!(collapsed([0, 1, 0, 3, 4, 5, 4, 7]), None, "corners of a diagonal");
    assert_eq!(Cell::Wedge([0, 1, 2, 0, 4, 5]).collapsed(), None, "a pyramid");
    let whole = Cell::Hexahedron([0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(whole.collapsed(), Some(whole));
}
