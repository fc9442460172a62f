//! Interiors against a dense solution of the elastic equilibrium.

use fixtures::random::Random;
use fixtures::volume::Block;
use volume_mesh::glam::{DMat3, DVec3};
use volume_mesh::{Cell, FollowParams, Progress, VolumeMesh};

/// Blocks with displaced nodes: of hexahedra, of wedges, of tetrahedra, and of hexahedra and tetrahedra,
/// none of which shares a node with another kind.
fn blocks() -> [(VolumeMesh, Vec<DVec3>); 4] {
    let size = DVec3::new(3.0, 2.0, 2.0);
    let block = Block::new(size, [3, 2, 2]).with_noise(size, 0.08);
    let hexahedra: Vec<Cell> = block.hexahedra.iter().copied().map(Cell::Hexahedron).collect();
    let tetrahedra: Vec<Cell> = block.tetrahedra().into_iter().map(Cell::Tetrahedron).collect();

    let wedges: Vec<Cell> = block.wedges().into_iter().map(Cell::Wedge).collect();

    let count = u32::try_from(block.nodes.len()).expect("few nodes");
    let mut both = hexahedra.clone();
    for nodes in block.tetrahedra() {
        both.push(Cell::Tetrahedron(nodes.map(|node| node + count)));
    }
    let mut nodes = block.nodes.clone();
    nodes.extend(block.nodes.iter().map(|x| *x + 10.0 * DVec3::X));
    let of_block = [hexahedra, wedges, tetrahedra].map(|cells| (cells, block.nodes.clone()));
    let [hexahedra, wedges, tetrahedra] = of_block;
    [hexahedra, wedges, tetrahedra, (both, nodes)]
        .map(|(cells, nodes)| (VolumeMesh::new(nodes.len(), cells).expect("valid nodes"), nodes))
}

/// Interpolates between the nodes of a cell, in its reference cell.
fn interpolate(cell: &Cell, at: DVec3, value: impl Fn(u32) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (place, &node) in cell.nodes().iter().enumerate() {
        let weight = match cell {
            Cell::Tetrahedron(_) => [1.0 - at.x - at.y - at.z, at.x, at.y, at.z][place],
            Cell::Wedge(_) => {
                // A right triangle at the bottom, and again at the top.
                let corner = [1.0 - at.x - at.y, at.x, at.y][place % 3];
                corner * if place < 3 { 1.0 - at.z } else { at.z }
            }
            Cell::Hexahedron(_) => {
                // A unit cube, around its base and then around its top.
                let is_far =
                    [[1, 2, 5, 6], [2, 3, 6, 7], [4, 5, 6, 7]].map(|ends| ends.contains(&place));
                let along = |axis: usize| if is_far[axis] { at[axis] } else { 1.0 - at[axis] };
                along(0) * along(1) * along(2)
            }
        };
        sum += weight * value(node);
    }
    sum
}

/// Computes the elastic energy of a displacement, for λ/μ and μ = 1: the integral of |ε|² + λ/2 (tr ε)².
fn energy(mesh: &VolumeMesh, x: &[DVec3], u: &[DVec3], lambda: f64) -> f64 {
    let mut energy = 0.0;
    for cell in mesh.cells() {
        let gauss = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
        let points: Vec<(DVec3, f64)> = match cell {
            Cell::Tetrahedron(_) => vec![(DVec3::splat(0.25), 1.0 / 6.0)],
            Cell::Wedge(_) => (0..6)
                .map(|k| {
                    let [x, y] =
                        [[1, 1], [4, 1], [1, 4]][k % 3].map(|sixths| f64::from(sixths) / 6.0);
                    (DVec3::new(x, y, gauss[k / 3]), 1.0 / 12.0)
                })
                .collect(),
            Cell::Hexahedron(_) => (0..8)
                .map(|k| (DVec3::new(gauss[k & 1], gauss[k >> 1 & 1], gauss[k >> 2]), 1.0 / 8.0))
                .collect(),
        };
        for (at, weight) in points {
            // Along an axis both are linear, so that differences are their slopes.
            let slopes = |value: &[DVec3]| {
                let along = |axis: DVec3| {
                    let [below, above] = [at, at + axis]
                        .map(|at| interpolate(cell, at, |node| value[node as usize]));
                    above - below
                };
                DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
            };
            let to_space = slopes(x);
            let gradient = slopes(u) * to_space.inverse();
            let strain = 0.5 * (gradient + gradient.transpose());
            let square: f64 = strain.to_cols_array().iter().map(|entry| entry * entry).sum();
            let trace = strain.x_axis.x + strain.y_axis.y + strain.z_axis.z;
            energy += weight * to_space.determinant() * (square + 0.5 * lambda * trace * trace);
        }
    }
    energy
}

/// Finds the displacement of the least energy in which nodes that are not free keep theirs.
fn dense(
    mesh: &VolumeMesh,
    x: &[DVec3],
    given: &[DVec3],
    free: &[usize],
    lambda: f64,
) -> Vec<DVec3> {
    // The energy is a quadratic form: its values at sums of two displacements are all of it.
    let of = |u: &[DVec3]| energy(mesh, x, u, lambda);
    let n = 3 * free.len();
    let unit = |k: usize| {
        let mut u = vec![DVec3::ZERO; x.len()];
        u[free[k / 3]][k % 3] = 1.0;
        u
    };
    let sum = |a: &[DVec3], b: &[DVec3]| -> Vec<DVec3> {
        a.iter().zip(b).map(|(a, b)| *a + *b).collect()
    };
    let own: Vec<f64> = (0..n).map(|k| of(&unit(k))).collect();
    let of_given = of(given);
    let mut matrix = vec![vec![0.0; n + 1]; n];
    for i in 0..n {
        for j in 0..n {
            let both = if i == j { 4.0 * own[i] } else { of(&sum(&unit(i), &unit(j))) };
            matrix[i][j] = both - own[i] - own[j];
        }
        matrix[i][n] = -(of(&sum(&unit(i), given)) - own[i] - of_given);
    }

    let mut u = given.to_vec();
    for (k, value) in gauss_jordan(matrix).into_iter().enumerate() {
        u[free[k / 3]][k % 3] += value;
    }
    u
}

/// Solves a positive definite system by elimination.
fn gauss_jordan(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for pivot in 0..n {
        let top = rows[pivot].clone();
        for (number, row) in rows.iter_mut().enumerate() {
            if number != pivot {
                let factor = row[pivot] / top[pivot];
                row.iter_mut().zip(&top).for_each(|(entry, of_top)| *entry -= factor * of_top);
            }
        }
    }
    (0..n).map(|k| rows[k][n] / rows[k][k]).collect()
}

#[test]
fn interiors_are_in_the_equilibrium_of_the_dense_system() {
    let mut random = Random(5);
    for (mesh, rest) in blocks() {
        let boundary = mesh.boundary().expect("faces of one or two cells");
        let is_outer = |node: &usize| boundary.nodes.iter().any(|outer| *outer as usize == *node);
        let free: Vec<usize> = (0..rest.len()).filter(|node| !is_outer(node)).collect();
        for poisson_ratio in [-0.4, 0.3] {
            let mut given = vec![DVec3::ZERO; rest.len()];
            for &node in &boundary.nodes {
                let any = DVec3::from_array([(); 3].map(|()| random.unit()));
                given[node as usize] = 0.2 * (any - 0.5);
            }
            let moved: Vec<DVec3> = rest.iter().zip(&given).map(|(x, u)| *x + *u).collect();
            let params = FollowParams { poisson_ratio, ..FollowParams::default() };
            let target = boundary.positions(&moved);
            let followed = mesh.follow(&rest, &boundary, &target, &params, Progress::none());
            let followed = followed.expect("valid input");
            assert_eq!((followed.share, followed.steps), (1.0, 1));

            let lambda = 2.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio);
            let u = dense(&mesh, &rest, &given, &free, lambda);
            for ((found, x), u) in followed.positions.iter().zip(&rest).zip(u) {
                let error = found.distance(*x + u);
                assert!(error < 1e-8, "{error} with a ratio of {poisson_ratio}");
            }
        }
    }
}

/// In units of any size, interiors are the same to the bit: these are powers of two.
#[test]
fn interiors_are_the_same_in_any_unit() {
    for (mesh, rest) in blocks() {
        let boundary = mesh.boundary().expect("faces of one or two cells");
        let follow = |unit: f64| {
            let scaled: Vec<DVec3> = rest.iter().map(|x| unit * *x).collect();
            let mut target = boundary.positions(&scaled);
            // The top is pushed into the body, farther than cells let it.
            target.iter_mut().filter(|x| x.z >= 2.0 * unit).for_each(|x| x.z -= 1.4 * unit);
            let params = FollowParams { max_steps: 4, ..FollowParams::default() };
            let followed = mesh.follow(&scaled, &boundary, &target, &params, Progress::none());
            followed.expect("valid input")
        };
        let expected = follow(1.0);
        assert!(expected.share > 0.2 && expected.blocking.is_some(), "{expected:?}");
        for unit in [-90, 90].map(|power| 2.0_f64.powi(power)) {
            let mut followed = follow(unit);
            followed.positions.iter_mut().for_each(|x| *x /= unit);
            assert_eq!(followed, expected, "in {unit}");
        }
    }
}
