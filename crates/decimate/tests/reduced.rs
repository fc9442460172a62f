//! What a reduced surface keeps of the full one: topology, vertices, shape; and what
//! is refused.

use decimate::{DecimateError, Decimation, ReducedSurface};
use fixtures::{Mesh, damage, femur, shapes};
use glam::DVec3;
use surface::{SurfaceError, TriangleSurface, inspect};

fn decimation(mesh: &Mesh) -> Decimation {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite positions");
    Decimation::new(&surface, x).expect("a closed surface")
}

fn gathered(mesh: &Mesh, reduced: &ReducedSurface) -> Mesh {
    let mut positions = Vec::new();
    reduced.gather(&mesh.positions, &mut positions);
    Mesh { positions, faces: reduced.surface.faces().to_vec() }
}

/// A box of `n × n` squares a side, all of them flat.
fn grid_cube(edge: f64, n: u32) -> Mesh {
    let share = |i: u32| f64::from(i) / f64::from(n) - 0.5;
    let mut mesh = Mesh::default();
    let mut places = std::collections::HashMap::new();
    for axis in 0..3_usize {
        for side in [0, n] {
            let mut at = |i: u32, j: u32| {
                let mut cell = [0; 3];
                (cell[axis], cell[(axis + 1) % 3], cell[(axis + 2) % 3]) = (side, i, j);
                *places.entry(cell).or_insert_with(|| {
                    mesh.positions.push(DVec3::from(cell.map(share)) * edge);
                    u32::try_from(mesh.positions.len() - 1).expect("few vertices")
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let faces = [[a, b, c], [a, c, d]];
                mesh.faces
                    .extend(faces.map(|[a, b, c]| if side == n { [a, b, c] } else { [a, c, b] }));
            }
        }
    }
    mesh
}

fn bodies() -> [(&'static str, Mesh); 3] {
    [
        ("sphere", shapes::icosphere(40.0, 4)),
        ("torus", shapes::torus(40.0, 12.0, [72, 32])),
        ("femur", femur::femur(6.0)),
    ]
}

#[test]
fn stays_a_closed_surface_of_the_same_kind() {
    for (name, mesh) in bodies() {
        let (surface, decimation) = (mesh.surface(), decimation(&mesh));
        let euler = |surface: &TriangleSurface, x: &[DVec3]| {
            inspect(surface, surface.positions(x).unwrap()).euler
        };
        let volume = mesh.volume();
        for share in [2, 5, 20] {
            let reduced = decimation.with_faces(surface.faces().len() / share).unwrap();
            let faces = reduced.surface.faces().len();
            assert!(faces <= surface.faces().len() / share, "{name}: {faces} faces");
            reduced.surface.require_closed().unwrap();
            reduced.surface.require_manifold().unwrap();
            reduced.surface.require_oriented().unwrap();
            let less = gathered(&mesh, &reduced);
            let change = (less.volume() / volume - 1.0).abs();
            let kept = euler(&reduced.surface, &less.positions);
            assert_eq!(kept, euler(&surface, &mesh.positions), "{name}");
            assert!(
                change < 0.01 * f64::from(u32::try_from(share).unwrap()),
                "{name}: volume by {change}"
            );
        }
    }
}

#[test]
fn as_far_as_it_goes_it_is_still_closed() {
    for (name, mesh) in bodies() {
        let Err(DecimateError::TooFewFaces { asked: 0, fewest }) = decimation(&mesh).with_faces(0)
        else {
            panic!("{name} has vanished")
        };
        let last = decimation(&mesh).with_faces(fewest).unwrap();
        assert_eq!(last.surface.faces().len(), fewest, "{name}");
        last.surface.require_closed().unwrap();
        last.surface.require_manifold().unwrap();
        last.surface.require_oriented().unwrap();
        assert!(fewest < mesh.faces.len() / 20, "{name} keeps {fewest} faces");
    }
}

#[test]
fn keeps_vertices_where_they_are() {
    for (name, mesh) in bodies() {
        let reduced = decimation(&mesh).within(0.5).unwrap();
        assert!(reduced.kept.is_sorted_by(|a, b| a < b), "{name}");
        let less = gathered(&mesh, &reduced);
        assert_eq!(less.positions.len(), reduced.surface.vertex_count(), "{name}");
        for (kept, position) in reduced.kept.iter().zip(&less.positions) {
            assert_eq!(mesh.positions[*kept as usize], *position, "{name}");
        }
    }
}

#[test]
fn a_larger_deviation_has_no_more_faces() {
    for (name, mesh) in bodies() {
        let decimation = decimation(&mesh);
        let mut last = mesh.faces.len() + 1;
        for deviation in [0.01, 0.05, 0.2, 0.5, 2.0] {
            let reduced = decimation.within(deviation).unwrap();
            let faces = reduced.surface.faces().len();
            assert!(reduced.deviation.largest() <= deviation, "{name}: {:?}", reduced.deviation);
            assert!(faces <= last, "{name}: {faces} faces within {deviation}, {last} within less");
            last = faces;
        }
        assert!(last < mesh.faces.len() / 8, "{name}: {last} faces");
    }
}

#[test]
fn the_full_surface_deviates_by_nothing() {
    let mesh = shapes::icosphere(40.0, 3);
    let reduced = decimation(&mesh).within(1e-9).unwrap();
    assert_eq!(reduced.surface, mesh.surface());
    assert!(reduced.deviation.largest() <= 0.0, "{:?}", reduced.deviation);
}

#[test]
fn flat_sides_need_two_faces_each() {
    let mesh = grid_cube(20.0, 9);
    let reduced = decimation(&mesh).within(1e-6).unwrap();
    assert_eq!(reduced.surface.faces().len(), 12);
    assert!(reduced.deviation.largest() < 1e-9, "{:?}", reduced.deviation);
}

#[test]
fn a_spike_is_kept() {
    let mut mesh = shapes::icosphere(40.0, 4);
    mesh.positions[1234] *= 1.1;
    let decimation = decimation(&mesh);
    for deviation in [0.3, 1.0, 2.0] {
        let reduced = decimation.within(deviation).unwrap();
        assert!(reduced.kept.contains(&1234), "{deviation}");
    }
}

#[test]
fn same_bits_every_time() {
    let mesh = femur::femur(7.0);
    let [a, b] = [0, 1].map(|_| decimation(&mesh).within(0.4).unwrap());
    assert_eq!((a.surface, a.kept), (b.surface, b.kept));
    assert_eq!(a.deviation, b.deviation);
}

#[test]
fn gathering_again_allocates_nothing() {
    let mesh = shapes::icosphere(40.0, 3);
    let reduced = decimation(&mesh).with_faces(200).unwrap();
    let mut x = Vec::with_capacity(reduced.kept.len());
    let place = x.as_ptr();
    for _ in 0..3 {
        reduced.gather(&mesh.positions, &mut x);
    }
    assert_eq!(x.as_ptr(), place);
}

#[test]
fn vertices_without_faces_are_left_out() {
    let mut mesh = shapes::icosphere(40.0, 3);
    mesh.positions.push(DVec3::splat(500.0));
    let reduced = decimation(&mesh).within(0.5).unwrap();
    assert!(reduced.kept.iter().all(|v| (*v as usize) < mesh.positions.len() - 1));
    assert!(reduced.deviation.largest() <= 0.5);
}

#[test]
fn parts_stay_apart() {
    let mesh =
        shapes::icosphere(20.0, 3).joined(&shapes::tetrahedron(9.0).translated(50.0 * DVec3::X));
    let reduced = decimation(&mesh).within(1.0).unwrap();
    let x = gathered(&mesh, &reduced).positions;
    let inspection = inspect(&reduced.surface, reduced.surface.positions(&x).unwrap());
    assert_eq!((inspection.components, inspection.euler), (2, 4));
}

#[test]
fn refuses_what_has_no_inside() {
    let refused = |mesh: &Mesh| {
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).unwrap();
        Decimation::new(&surface, x).map(drop).unwrap_err()
    };
    let ball = || shapes::icosphere(10.0, 2);
    let mut open = ball();
    open.faces.pop();
    assert!(matches!(refused(&open), DecimateError::Surface(SurfaceError::Open { count: 3, .. })));
    let mut fin = ball();
    let [a, b, _] = fin.faces[7];
    fin.faces.push([b, a, 100]);
    assert!(matches!(refused(&fin), DecimateError::Surface(SurfaceError::Open { .. })));
    let doubled = shapes::tetrahedron(3.0);
    let doubled = Mesh { faces: doubled.faces.repeat(2), ..doubled };
    assert!(matches!(
        refused(&doubled),
        DecimateError::Surface(SurfaceError::NonManifold { count: 6, .. })
    ));
    let turned = damage::flipped_faces(ball(), 0.2, 5);
    assert!(matches!(refused(&turned), DecimateError::Surface(SurfaceError::Misoriented { .. })));
    let nothing = Mesh::default();
    assert_eq!(refused(&nothing), DecimateError::TooSmall { faces: 0 });
    let pillow = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        faces: vec![[0, 1, 2], [0, 2, 1]],
    };
    assert_eq!(refused(&pillow), DecimateError::TooSmall { faces: 2 });
    let edge = Mesh { faces: vec![[0, 1, 2], [0, 2, 1], [1, 2, 2], [1, 1, 2]], ..pillow };
    assert_eq!(refused(&edge), DecimateError::RepeatedVertex { face: 2, vertex: 2 });
    let nan = damage::not_a_number(ball(), 3);
    let unplaced = nan.surface();
    assert!(matches!(
        unplaced.positions(&nan.positions).map(drop),
        Err(SurfaceError::NotFinite { vertex: 3, .. })
    ));
    let other = shapes::tetrahedron(1.0);
    let few = other.surface();
    let few = Decimation::new(&ball().surface(), few.positions(&other.positions).unwrap());
    assert!(matches!(
        few.map(drop),
        Err(DecimateError::Surface(SurfaceError::PositionCount { got: 4, .. }))
    ));
}

#[test]
fn refuses_a_deviation_that_is_none() {
    let decimation = decimation(&shapes::icosphere(10.0, 2));
    for value in [0.0, -1.0, f64::INFINITY] {
        let range = "positive and finite";
        let expected = DecimateError::Parameter { name: "deviation", value, range };
        assert_eq!(decimation.within(value).map(drop), Err(expected));
    }
    assert!(matches!(
        decimation.within(f64::NAN).map(drop),
        Err(DecimateError::Parameter { name: "deviation", .. })
    ));
}
