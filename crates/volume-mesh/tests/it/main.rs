//! Blocks that are stretched, pressed and pressed too far.

mod collapsed;
mod equilibrium;

use std::ops::ControlFlow;
use std::sync::Mutex;

use fixtures::volume::Block;
use volume_mesh::glam::{DMat3, DVec3};
use volume_mesh::{
    Boundary, Cell, FollowParams, Followed, MiddleNode, Progress, VolumeError, VolumeMesh,
};

const SIZE: DVec3 = DVec3::new(3.0, 2.0, 1.0);

/// Blocks with displaced nodes inside: of hexahedra, of tetrahedra and of wedges.
fn blocks() -> [(VolumeMesh, Vec<DVec3>); 3] {
    let block = Block::new(SIZE, [5, 4, 4]).with_noise(SIZE, 0.08);
    let hexahedra = block.hexahedra.iter().copied().map(Cell::Hexahedron).collect();
    let tetrahedra = block.tetrahedra().into_iter().map(Cell::Tetrahedron).collect();
    let wedges = block.wedges().into_iter().map(Cell::Wedge).collect();
    let count = block.nodes.len();
    [hexahedra, tetrahedra, wedges]
        .map(|cells| (VolumeMesh::new(count, cells).expect("valid nodes"), block.nodes.clone()))
}

fn boundary(mesh: &VolumeMesh) -> Boundary {
    mesh.boundary().expect("faces of one or two cells")
}

fn follow(mesh: &VolumeMesh, rest: &[DVec3], target: &[DVec3]) -> Followed {
    let params = FollowParams::default();
    let boundary = boundary(mesh);
    mesh.follow(rest, &boundary, target, &params, Progress::none()).expect("valid input")
}

#[test]
fn the_boundary_is_closed_and_turned_outward() {
    for (mesh, nodes) in blocks() {
        let boundary = boundary(&mesh);
        let x = boundary.positions(&nodes);
        // A box of 5 × 4 × 4 parts: two triangles for each square, every node but 4 × 3 × 3.
        assert_eq!(boundary.faces.len(), 2 * 2 * (20 + 20 + 16));
        assert_eq!(boundary.nodes.len(), 6 * 5 * 5 - 36);
        let surface = surface::TriangleSurface::new(x.len(), boundary.faces.clone());
        let surface = surface.expect("valid corners");
        let inspection = surface::inspect(&surface, surface.positions(&x).expect("finite"));
        assert!(inspection.closed() && inspection.manifold() && inspection.oriented());
        assert!((inspection.volume - 6.0).abs() < 1e-12, "{}", inspection.volume);
    }
}

#[test]
fn quality_is_that_of_known_cells() {
    let quality = |cell: Cell, nodes: &[DVec3]| {
        let mesh = VolumeMesh::new(nodes.len(), vec![cell]).expect("valid nodes");
        mesh.quality(nodes).min_scaled_jacobian
    };
    let cube = Block::new(DVec3::splat(2.0), [1; 3]);
    assert!((quality(Cell::Hexahedron(cube.hexahedra[0]), &cube.nodes) - 1.0).abs() < 1e-12);

    // Every other corner of a cube is a regular tetrahedron.
    let corners = [
        DVec3::ZERO,
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::new(1.0, 0.0, 1.0),
    ];
    let jacobian = quality(Cell::Tetrahedron([0, 1, 2, 3]), &corners);
    assert!((jacobian - 1.0).abs() < 1e-12, "{jacobian}");
    let inverted = quality(Cell::Tetrahedron([1, 0, 2, 3]), &corners);
    assert!((inverted + 1.0).abs() < 1e-12, "{inverted}");

    // A wedge on an equilateral triangle, and one half of a cube.
    let wedge = |base: [DVec3; 3]| [base, base.map(|x| x + 4.0 * DVec3::Z)].concat();
    let equilateral = wedge([DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75_f64.sqrt(), 0.0)]);
    let jacobian = quality(Cell::Wedge([0, 1, 2, 3, 4, 5]), &equilateral);
    assert!((jacobian - 1.0).abs() < 1e-12, "{jacobian}");
    let jacobian = quality(Cell::Wedge([3, 4, 5, 0, 1, 2]), &equilateral);
    assert!((jacobian + 1.0).abs() < 1e-12, "{jacobian}");
    let half = wedge([DVec3::ZERO, DVec3::X, DVec3::Y]);
    let jacobian = quality(Cell::Wedge([0, 1, 2, 3, 4, 5]), &half);
    assert!((jacobian - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{jacobian}");

    // The tip of a corner tetrahedron: right angles, edges of 1, 1 and √2.
    let right = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let jacobian = quality(Cell::Tetrahedron([0, 1, 2, 3]), &right);
    assert!((jacobian - 0.5_f64.sqrt()).abs() < 1e-12, "{jacobian}");
}

/// A displacement that is linear in space is in equilibrium on any mesh.
#[test]
fn linear_displacements_are_reproduced() {
    let map = DMat3::from_cols_array(&[1.1, 0.05, 0.0, -0.2, 0.9, 0.1, 0.0, 0.15, 0.8]);
    let shift = DVec3::new(4.0, -1.0, 2.0);
    for (mesh, rest) in blocks() {
        let boundary = boundary(&mesh);
        let mapped: Vec<DVec3> = rest.iter().map(|x| map * *x + shift).collect();
        let followed = follow(&mesh, &rest, &boundary.positions(&mapped));
        assert_eq!((followed.share, followed.steps, followed.blocking), (1.0, 1, None));

        let mut error: f64 = 0.0;
        for (x, expected) in followed.positions.iter().zip(&mapped) {
            error = error.max(x.distance(*expected));
        }
        assert!(error < 1e-9, "{error}");
        assert!(followed.after.min_scaled_jacobian > 0.0);
    }
}

#[test]
fn a_boundary_that_stays_moves_nothing() {
    for (mesh, rest) in blocks() {
        let target = boundary(&mesh).positions(&rest);
        let followed = follow(&mesh, &rest, &target);
        assert_eq!((followed.positions, followed.steps), (rest, 0));
        assert_eq!(followed.before, followed.after);
    }
}

/// Returns a mesh with a node in the middle of each edge of its cells, behind all others.
fn quadratic(mesh: &VolumeMesh, rest: &[DVec3]) -> (VolumeMesh, Vec<DVec3>) {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for cell in mesh.cells() {
        let boundary = VolumeMesh::new(rest.len(), vec![*cell]).expect("a cell").boundary();
        for [a, b, c] in boundary.expect("one cell").faces {
            edges.extend([[a, b], [b, c], [c, a]].map(|edge| {
                let mut edge = edge.map(|place| {
                    let mut nodes = cell.nodes().to_vec();
                    nodes.sort_unstable();
                    nodes[place as usize]
                });
                edge.sort_unstable();
                edge
            }));
        }
    }
    edges.sort_unstable();
    edges.dedup();

    let (mut positions, mut middle_nodes) = (rest.to_vec(), Vec::new());
    for [a, b] in edges {
        let node = u32::try_from(positions.len()).expect("few nodes");
        positions.push(0.5 * (rest[a as usize] + rest[b as usize]));
        // Each edge comes from several cells, in either direction.
        middle_nodes.extend([[a, b], [b, a], [a, b]].map(|ends| MiddleNode::new(node, ends)));
    }
    let mesh = VolumeMesh::new(positions.len(), mesh.cells().to_vec()).expect("valid nodes");
    (mesh.with_middle_nodes(middle_nodes).expect("nodes apart from corners"), positions)
}

/// Quadratic elements with straight edges have the surface, the quality and the interior of their corners.
#[test]
fn nodes_in_the_middle_of_edges_stay_there() {
    for (linear, rest) in blocks() {
        let (mesh, rest_of_all) = quadratic(&linear, &rest);
        assert!(mesh.middle_nodes().len() > 3 * rest.len());
        assert_eq!(boundary(&mesh), boundary(&linear));

        // Those of edges that stay are not touched, though they are a little aside.
        let mut rest_of_all = rest_of_all;
        for x in &mut rest_of_all[rest.len()..] {
            *x += 1e-5;
        }
        let mut target = boundary(&linear).positions(&rest);
        let corner = target.len() - 1;
        target[corner] += DVec3::new(-0.1, 0.05, -0.1);
        let [with, without] =
            [(&mesh, &rest_of_all), (&linear, &rest)].map(|(mesh, x)| follow(mesh, x, &target));
        assert_eq!(with.positions[..rest.len()], without.positions);
        assert_eq!((with.before, with.after), (without.before, without.after));

        let (mut moved, x) = (0, &with.positions);
        for middle in mesh.middle_nodes() {
            let [a, b] = middle.ends.map(|end| end as usize);
            let expected = if [a, b].iter().all(|&end| x[end] == rest[end]) {
                rest_of_all[middle.node as usize]
            } else {
                moved += 1;
                (x[a] + x[b]) / 2.0
            };
            assert_eq!(x[middle.node as usize], expected, "{middle:?}");
        }
        assert!(0 < moved && moved < mesh.middle_nodes().len(), "{moved}");
    }
}

#[test]
fn nodes_that_are_in_the_middle_of_no_edge_are_refused() {
    let mesh = || VolumeMesh::new(6, vec![Cell::Tetrahedron([0, 1, 2, 3])]).expect("a cell");
    let middle = |node, ends| mesh().with_middle_nodes(vec![MiddleNode::new(node, ends)]);
    assert!(middle(4, [1, 0]).is_ok());
    // Out of range, a corner, an end that is no corner, and an end that is out of range.
    for (node, ends) in [(6, [0, 1]), (3, [0, 1]), (4, [0, 5]), (4, [0, 6])] {
        assert_eq!(middle(node, ends), Err(VolumeError::MiddleNode { node, ends }));
    }
    // One node on two edges.
    let twice = vec![MiddleNode::new(4, [0, 1]), MiddleNode::new(4, [2, 1])];
    let refused = VolumeError::MiddleNode { node: 4, ends: [1, 2] };
    assert_eq!(mesh().with_middle_nodes(twice), Err(refused));
}

/// Presses the middle of the top by a depth, fading to the sides.
fn pressed(boundary: &Boundary, rest: &[DVec3], depth: f64) -> Vec<DVec3> {
    let mut target = boundary.positions(rest);
    for x in &mut target {
        if x.z >= SIZE.z {
            let along = (std::f64::consts::PI * x.x / SIZE.x).sin();
            let across = (std::f64::consts::PI * x.y / SIZE.y).sin();
            x.z -= depth * along * across;
        }
    }
    target
}

/// A dent as deep as two layers of cells would invert those below if the interior stayed; inside a
/// block whose interior follows, all keep their shape.
#[test]
fn a_dent_is_followed() {
    for (mesh, rest) in blocks() {
        let boundary = boundary(&mesh);
        let target = pressed(&boundary, &rest, 0.5);
        let mut alone = rest.clone();
        for (&node, x) in boundary.nodes.iter().zip(&target) {
            alone[node as usize] = *x;
        }
        assert!(mesh.quality(&alone).inverted > 0, "the interior has to follow");

        let followed = follow(&mesh, &rest, &target);
        assert_eq!((followed.share, followed.blocking), (1.0, None));
        assert_eq!(followed.after.inverted, 0);
        assert!(followed.after.min_scaled_jacobian > 0.05, "{:?}", followed.after);
        assert_eq!(boundary.positions(&followed.positions), target);
    }
}

/// In equilibrium cells of the upper layers would be inverted from a depth of 0.8 on: nodes inside give way to them.
#[test]
fn cells_in_the_way_of_a_deep_dent_are_opened() {
    for (mesh, rest) in blocks() {
        let boundary = boundary(&mesh);
        let target = pressed(&boundary, &rest, 0.9);
        let followed = follow(&mesh, &rest, &target);
        assert_eq!((followed.share, followed.blocking), (1.0, None), "{followed:?}");
        assert_eq!(boundary.positions(&followed.positions), target);
        assert!(followed.after.min_scaled_jacobian > 0.01, "{:?}", followed.after);
    }
}

/// Two cells along each axis: all nodes but the one in the middle are on the boundary.
#[test]
fn corners_without_a_node_inside_are_listed() {
    let block = Block::new(SIZE, [2, 2, 2]);
    let cells = block.hexahedra.iter().copied().map(Cell::Hexahedron).collect();
    let mesh = VolumeMesh::new(block.nodes.len(), cells).expect("valid nodes");
    let boundary = boundary(&mesh);
    let x = boundary.positions(&block.nodes);
    let corners = boundary.corners(&mesh);
    assert_eq!(
        corners.len(),
        8 * 4,
        "of each cell those at the middle and next to it are left out"
    );
    for corner in corners {
        let [p, a, b, c] = corner.map(|place| x[place as usize]);
        let volume = DMat3::from_cols(a - p, b - p, c - p).determinant();
        assert!((volume - SIZE.x * SIZE.y * SIZE.z / 8.0).abs() < 1e-12, "{corner:?}: {volume}");
    }
}

/// The top is pushed through the base: the mesh comes as far as cells keep a tenth of their scaled
/// Jacobian, and names the one in the way.
#[test]
fn a_push_that_inverts_is_cut_and_named() {
    for (mesh, rest) in blocks() {
        let boundary = boundary(&mesh);
        let target = pressed(&boundary, &rest, 1.2 * SIZE.z);
        let followed = follow(&mesh, &rest, &target);
        assert!(0.2 < followed.share && followed.share < 0.9, "{}", followed.share);
        assert_eq!(followed.after.inverted, 0);
        let blocking = followed.blocking.expect("a cell in the way");
        assert!(blocking.scaled_jacobian < blocking.limit, "{blocking:?}");

        // Every cell keeps its share.
        for (number, cell) in mesh.cells().iter().enumerate() {
            let single = VolumeMesh::new(rest.len(), vec![*cell]).expect("a cell");
            let [before, after] = [&rest, &followed.positions]
                .map(|positions| single.quality(positions).min_scaled_jacobian);
            assert!(after >= 0.1 * before, "cell {number}: {before} -> {after}");
        }
    }
}

#[test]
fn invalid_meshes_are_refused() {
    let tetrahedron = |nodes| vec![Cell::Tetrahedron(nodes)];
    assert_eq!(VolumeMesh::new(4, vec![]), Err(VolumeError::NoCells { nodes: 4 }));
    let out = VolumeError::NodeOutOfRange { cell: 0, node: 4, node_count: 4 };
    assert_eq!(VolumeMesh::new(4, tetrahedron([0, 1, 2, 4])), Err(out));
    let twice = VolumeError::RepeatedNode { cell: 0, node: 1 };
    assert_eq!(VolumeMesh::new(4, tetrahedron([0, 1, 2, 1])), Err(twice));

    // Three cells on one face.
    let cells = [[0, 1, 2, 3], [0, 2, 1, 4], [0, 1, 2, 5]].map(Cell::Tetrahedron).to_vec();
    let shared = VolumeMesh::new(6, cells).expect("valid nodes");
    assert_eq!(shared.boundary(), Err(VolumeError::SharedFace { cells: [0, 1, 2] }));

    // One cell twice, beside another one; and all five sides of a simplex in four dimensions.
    let cells = [[4, 5, 6, 7], [0, 1, 2, 3], [1, 0, 3, 2]].map(Cell::Tetrahedron).to_vec();
    let repeated = VolumeMesh::new(8, cells).expect("valid nodes");
    assert_eq!(repeated.boundary(), Err(VolumeError::RepeatedCell { cells: [1, 2] }));
    let sides = [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 3, 4], [0, 2, 3, 4], [1, 2, 3, 4]];
    let closed = VolumeMesh::new(5, sides.map(Cell::Tetrahedron).to_vec()).expect("valid nodes");
    assert_eq!(closed.boundary(), Err(VolumeError::NoBoundary { cells: 5 }));

    // Turned inside out at the start.
    let nodes = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mesh = VolumeMesh::new(4, tetrahedron([1, 0, 2, 3])).expect("valid nodes");
    let (boundary, params) = (boundary(&mesh), FollowParams::default());
    let refused = mesh.follow(&nodes, &boundary, &nodes, &params, Progress::none());
    assert!(matches!(refused, Err(VolumeError::Inverted { count: 1, cell: 0, .. })), "{refused:?}");
}

#[test]
fn a_cell_is_not_pressed_flat_though_it_may_keep_any_share() {
    let rest = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mesh = VolumeMesh::new(4, vec![Cell::Tetrahedron([0, 1, 2, 3])]).expect("a cell");
    let boundary = boundary(&mesh);
    let target: Vec<DVec3> =
        boundary.positions(&rest).iter().map(|x| DVec3::new(x.x, x.y, 0.0)).collect();
    let params = FollowParams { min_jacobian_share: 0.0, ..FollowParams::default() };
    let followed = mesh.follow(&rest, &boundary, &target, &params, Progress::none());
    let followed = followed.expect("valid input");
    assert!(followed.share < 1.0 && followed.after.inverted == 0, "{followed:?}");
}

#[test]
fn cells_too_large_to_measure_are_inverted() {
    let huge = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|x| 1e160 * x);
    let mesh = VolumeMesh::new(4, vec![Cell::Tetrahedron([0, 1, 2, 3])]).expect("a cell");
    let quality = mesh.quality(&huge);
    assert_eq!((quality.min_scaled_jacobian, quality.inverted), (-1.0, 1));
}

/// Positions that are not finite are named by their nodes, at the start and at the end; those of
/// nodes without a cell concern nothing.
#[test]
fn positions_that_are_not_finite_are_named() {
    let mut rest = vec![DVec3::NAN, DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mesh = VolumeMesh::new(5, vec![Cell::Tetrahedron([1, 2, 3, 4])]).expect("a cell");
    let boundary = boundary(&mesh);
    let mut target = boundary.positions(&rest);
    let params = FollowParams::default();
    assert!(mesh.follow(&rest, &boundary, &target, &params, Progress::none()).is_ok());
    target[1].y = f64::INFINITY;
    let refused = mesh.follow(&rest, &boundary, &target, &params, Progress::none());
    assert_eq!(refused, Err(VolumeError::NotFinite { node: 2 }));
    target[1].y = 0.0;
    rest[3].z = f64::NAN;
    let refused = mesh.follow(&rest, &boundary, &target, &params, Progress::none());
    assert_eq!(refused, Err(VolumeError::NotFinite { node: 3 }));
}

#[test]
fn parameters_out_of_range_are_refused() {
    let (mesh, rest) = &blocks()[1];
    let boundary = boundary(mesh);
    let target = boundary.positions(rest);
    let default = FollowParams::default();
    let poisson_ratios =
        [-1.0, 0.5, f64::NAN].map(|poisson_ratio| FollowParams { poisson_ratio, ..default });
    let shares =
        [-0.1, 1.0].map(|min_jacobian_share| FollowParams { min_jacobian_share, ..default });
    for params in poisson_ratios.iter().chain(&shares) {
        let refused = mesh.follow(rest, &boundary, &target, params, Progress::none());
        assert!(matches!(refused, Err(VolumeError::Parameter { .. })), "{params:?}");
    }
}

#[test]
fn progress_goes_forward_within_steps_and_from_one_to_the_next() {
    for (mesh, rest) in blocks() {
        let boundary = boundary(&mesh);
        let mut target = boundary.positions(&rest);
        // The top is pushed into the body, farther than cells let it in one step.
        target.iter_mut().filter(|x| x.z >= SIZE.z).for_each(|x| x.z -= 0.7 * SIZE.z);
        let fractions = Mutex::new(Vec::new());
        let handler = |fraction: f64| {
            fractions.lock().expect("one thread").push(fraction);
            ControlFlow::Continue(())
        };
        let params = FollowParams { max_steps: 3, ..FollowParams::default() };
        let followed = mesh.follow(&rest, &boundary, &target, &params, Progress::new(&handler));
        assert_eq!(followed.expect("valid input").steps, 3);

        let fractions = fractions.into_inner().expect("one thread");
        assert!(fractions.is_sorted(), "{fractions:?}");
        for [lower, upper] in [[0.0, 0.5], [0.5, 0.75], [0.75, 0.875]] {
            let is_within = |fraction: &&f64| lower < **fraction && **fraction < upper;
            assert!(fractions.iter().any(|fraction| is_within(&fraction)), "{fractions:?}");
        }
    }
}
