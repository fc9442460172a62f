//! Cavities are parts of the regions around them.

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere};
use glam::{DVec2, DVec3};
use overlap::{Overlap, OverlapDetector};
use proximity::SurfaceTree;

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("bodies are finite")
}

fn measure(a: &Mesh, b: &Mesh) -> Overlap {
    OverlapDetector::default().measure(&tree(a), &tree(b))
}

/// Checks the volumes of the regions, the largest first.
fn check(name: &str, a: &Mesh, b: &Mesh, expected: &[f64]) {
    for (a, b) in [(a, b), (b, a)] {
        let overlap = measure(a, b);
        let volumes: Vec<f64> =
            overlap.regions.iter().map(|region| region.volume.expect("both are closed")).collect();
        assert_eq!(volumes.len(), expected.len(), "{name}: {volumes:?} for {expected:?}");
        for (volume, expected) in volumes.iter().zip(expected) {
            assert!((volume - expected).abs() < 1e-5, "{name}: {volumes:?}, {expected:?}");
        }
    }
}

/// Extrudes a polygon that is counter-clockwise, split into triangles, to both sides of z = 0.
fn prism(polygon: &[[f64; 2]], triangles: &[[u32; 3]], half_height: f64) -> Mesh {
    let count = u32::try_from(polygon.len()).expect("a few corners");
    let mut mesh = Mesh { positions: Vec::new(), faces: Vec::new() };
    for z in [-half_height, half_height] {
        mesh.positions.extend(polygon.iter().map(|&p| DVec2::from(p).extend(z)));
    }
    for i in 0..count {
        let j = (i + 1) % count;
        mesh.faces.extend([[i, j, count + j], [i, count + j, count + i]]);
    }
    for &[p, q, r] in triangles {
        mesh.faces.extend([[p, r, q], [count + p, count + q, count + r]]);
    }
    mesh
}

/// A ball with a concentric one taken out.
fn shell(outer: f64, inner: f64) -> (Mesh, f64) {
    let [outer, inner] = [outer, inner].map(|radius| icosphere(radius, 3));
    let volume = outer.volume() - inner.volume();
    (outer.joined(&inner.flipped()), volume)
}

#[test]
fn shells_in_each_other_keep_their_own_cavities() {
    let around = cube(100.0);
    let shells = [shell(9.0, 8.8), shell(7.0, 6.9), shell(5.0, 4.5), shell(3.0, 1.0)];
    let mut volumes: Vec<f64> = shells.iter().map(|(_, volume)| *volume).collect();
    volumes.sort_by(|p, q| q.total_cmp(p));
    let mut body = Mesh { positions: Vec::new(), faces: Vec::new() };
    for (mesh, _) in &shells {
        body = body.joined(mesh);
    }
    check("shells", &around, &body, &volumes);
}

/// An angle of walls of 0.5 along x and y, whose box reaches from `-size` to `size` there.
fn bracket(size: f64) -> (Mesh, f64) {
    let inner = 0.5 - size;
    let polygon = [
        [-size, -size],
        [size, -size],
        [size, inner],
        [inner, inner],
        [inner, size],
        [-size, size],
    ];
    let mesh = prism(&polygon, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 6.0);
    let volume = 12.0 * (2.0 * size - 0.25);
    assert!((mesh.volume() - volume).abs() < 1e-9, "{} for {volume}", mesh.volume());
    (mesh, volume)
}

/// The box of the bracket holds the hollow box, which is not in the bracket.
#[test]
fn a_cavity_is_of_the_region_that_contains_it() {
    let (bracket, of_bracket) = bracket(7.0);
    let hollow = cube(10.0).joined(&cube(8.0).flipped());
    check("bracket", &cube(100.0), &bracket.joined(&hollow), &[488.0, of_bracket]);
}

/// Both bodies leave out a part of the cavity in a ball, beside a bracket whose box holds it.
#[test]
fn a_cavity_of_both_bodies_is_of_the_region_that_contains_it() {
    let room = cube(100.0).joined(&cube(4.0).flipped());
    let hole = cube(4.0).translated(DVec3::new(2.0, 1.0, 0.5)).flipped();
    let (bracket, of_bracket) = bracket(13.0);
    let ball = icosphere(12.0, 3);
    let of_ball = ball.volume() - (64.0 + 64.0 - 2.0 * 3.0 * 3.5);
    check("both", &room, &bracket.joined(&ball).joined(&hole), &[of_ball, of_bracket]);
}

/// Grids of hollow cubes: each cavity is in the box of one of them.
#[test]
fn many_cavities_have_an_owner_each() {
    let mut body = Mesh { positions: Vec::new(), faces: Vec::new() };
    for place in 0..1000_u32 {
        let [i, j, k] = [place / 100, place / 10 % 10, place % 10].map(f64::from);
        let hollow = cube(2.0).joined(&cube(1.0).flipped());
        let place = hollow.translated(3.0 * DVec3::new(i, j, k));
        let offset = u32::try_from(body.positions.len()).expect("a few vertices");
        body.positions.extend(&place.positions);
        body.faces.extend(place.faces.iter().map(|face| face.map(|corner| corner + offset)));
    }
    check("grid", &cube(200.0), &body, &[7.0; 1000]);
}
