//! Properties that a reduced surface keeps: topology, vertices, shape; and rejected input.

use std::ops::ControlFlow;

use decimate::{DecimateError, Decimation};
use fixtures::{Mesh, damage, femur, shapes};
use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{SurfaceError, TriangleSurface, inspect};

use crate::{bodies, decimation, gathered, reduced, tree};

/// Returns a box of `n × n` squares per side.
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

#[test]
fn it_stays_a_closed_surface_of_the_same_genus() {
    for (name, mesh) in bodies() {
        let (surface, decimation) = (mesh.surface(), decimation(&mesh).unwrap());
        let euler = |surface: &TriangleSurface, x: &[DVec3]| {
            inspect(surface, surface.positions(x).unwrap()).euler
        };
        for (max_deviation, max_change) in [(0.1, 0.02), (0.5, 0.05), (2.0, 0.2)] {
            let reduced = decimation.within(max_deviation, Progress::none()).unwrap();
            reduced.surface.require_closed().unwrap();
            reduced.surface.require_manifold().unwrap();
            reduced.surface.require_oriented().unwrap();

            let coarse = gathered(&mesh, &reduced);
            let found = euler(&reduced.surface, &coarse.positions);
            assert_eq!(found, euler(&surface, &mesh.positions), "{name}");
            let change = (coarse.volume() / mesh.volume() - 1.0).abs();
            assert!(change < max_change, "{name}: volume changed by {change}");
        }
    }
}

#[test]
fn the_coarsest_surface_is_still_closed() {
    for (name, mesh) in bodies() {
        let coarsest = reduced(&mesh, 1e6);
        coarsest.surface.require_closed().unwrap();
        coarsest.surface.require_manifold().unwrap();
        coarsest.surface.require_oriented().unwrap();
        let faces = coarsest.surface.faces().len();
        assert!(faces < mesh.faces.len() / 12, "{name} keeps {faces} faces");
    }
}

#[test]
fn vertices_keep_their_positions() {
    for (name, mesh) in bodies() {
        let reduced = reduced(&mesh, 0.5);
        assert!(reduced.kept.is_sorted_by(|a, b| a < b), "{name}");
        let less = gathered(&mesh, &reduced);
        assert_eq!(less.positions.len(), reduced.surface.vertex_count(), "{name}");
        for (kept, position) in reduced.kept.iter().zip(&less.positions) {
            assert_eq!(mesh.positions[*kept as usize], *position, "{name}");
        }
    }
}

#[test]
fn collapses_up_to_a_deviation_give_the_surfaces_of_all() {
    for (name, mesh) in bodies() {
        let all = decimation(&mesh).unwrap();
        let some = Decimation::up_to(tree(&mesh), 0.5, Progress::none()).unwrap();
        for deviation in [0.1, 0.5] {
            let [expected, found] = [&all, &some]
                .map(|decimation| decimation.within(deviation, Progress::none()).unwrap());
            assert_eq!(found.kept, expected.kept, "{name} within {deviation}");
            assert_eq!(found.surface.faces(), expected.surface.faces(), "{name}");
        }
        // None is coarser, and each keeps what is asked.
        let beyond = some.within(2.0, Progress::none()).unwrap();
        assert!(beyond.deviation <= 2.0, "{name}: {}", beyond.deviation);
        let most = some.within(0.5, Progress::none()).unwrap().surface.faces().len();
        assert!(beyond.surface.faces().len() <= most, "{name}");
    }
}

#[test]
fn a_larger_deviation_has_no_more_faces() {
    for (name, mesh) in bodies() {
        let decimation = decimation(&mesh).unwrap();
        let mut last = mesh.faces.len() + 1;
        for deviation in [0.01, 0.05, 0.2, 0.5, 2.0] {
            let reduced = decimation.within(deviation, Progress::none()).unwrap();
            let faces = reduced.surface.faces().len();
            assert!(reduced.deviation <= deviation, "{name}: {}", reduced.deviation);
            assert!(faces <= last, "{name}: {faces} faces within {deviation}, {last} within less");
            last = faces;
        }
        assert!(last < mesh.faces.len() / 8, "{name}: {last} faces");
    }
}

/// A few places where the map fails do not hold the rest back: the best triangles of a sphere of radius
/// R within δ are 0.38 · 4π R / δ, those on given vertices twice as many.
#[test]
fn all_places_take_the_deviation_that_is_allowed() {
    let ball = shapes::icosphere(40.0, 4);
    let decimation = decimation(&ball).expect("closed");
    for deviation in [0.5, 1.0] {
        let reduced = decimation.within(deviation, Progress::none()).expect("in range");
        let faces = f64::from(u32::try_from(reduced.surface.faces().len()).expect("few"));
        let best = 0.38 * 4.0 * std::f64::consts::PI * 40.0 / deviation;
        assert!(faces < 2.4 * best, "{faces} within {deviation}, {best} at best");
    }
}

#[test]
fn the_full_surface_deviates_by_nothing() {
    let mesh = shapes::icosphere(40.0, 3);
    let reduced = reduced(&mesh, 1e-9);
    assert_eq!(*reduced.surface, mesh.surface());
    assert!(reduced.deviation <= 0.0, "{}", reduced.deviation);
}

#[test]
fn flat_sides_need_two_faces_each() {
    let mesh = grid_cube(20.0, 9);
    let reduced = reduced(&mesh, 1e-6);
    assert_eq!(reduced.surface.faces().len(), 12);
    assert!(reduced.deviation < 1e-9, "{}", reduced.deviation);
}

#[test]
fn a_spike_is_kept() {
    let mut mesh = shapes::icosphere(40.0, 4);
    mesh.positions[1234] *= 1.1;
    let decimation = decimation(&mesh).unwrap();
    for deviation in [0.3, 1.0, 2.0] {
        let reduced = decimation.within(deviation, Progress::none()).unwrap();
        assert!(reduced.kept.contains(&1234), "{deviation}");
    }
}

#[test]
fn same_bits_every_time() {
    let mesh = femur::femur(7.0);
    let [a, b] = [0, 1].map(|_| reduced(&mesh, 0.4));
    assert_eq!((a.surface, a.kept), (b.surface, b.kept));
    assert_eq!(a.deviation.to_bits(), b.deviation.to_bits());
}

#[test]
fn gathering_again_allocates_nothing() {
    let mesh = shapes::icosphere(40.0, 3);
    let reduced = reduced(&mesh, 1.0);
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
    let reduced = reduced(&mesh, 0.5);
    assert!(reduced.kept.iter().all(|v| (*v as usize) < mesh.positions.len() - 1));
    assert!(reduced.deviation <= 0.5);
}

#[test]
fn parts_stay_apart() {
    let mesh =
        shapes::icosphere(20.0, 3).joined(&shapes::tetrahedron(9.0).translated(50.0 * DVec3::X));
    let reduced = reduced(&mesh, 1.0);
    let x = gathered(&mesh, &reduced).positions;
    let inspection = inspect(&reduced.surface, reduced.surface.positions(&x).unwrap());
    assert_eq!((inspection.components, inspection.euler), (2, 4));
}

#[test]
fn surfaces_that_enclose_nothing_are_refused() {
    let refused = |mesh: &Mesh| decimation(mesh).map(drop).unwrap_err();
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
}

#[test]
fn deviations_out_of_range_are_refused() {
    let decimation = decimation(&shapes::icosphere(10.0, 2)).unwrap();
    for value in [0.0, -1.0, f64::INFINITY] {
        let error = decimation.within(value, Progress::none()).map(drop);
        assert_eq!(error, Err(DecimateError::MaxDeviation { value }));
    }
    let error = decimation.within(f64::NAN, Progress::none()).map(drop);
    assert!(matches!(error, Err(DecimateError::MaxDeviation { .. })));
    for value in [0.0, -1.0, f64::NAN] {
        let error = Decimation::up_to(decimation.full().clone(), value, Progress::none());
        assert!(matches!(error, Err(DecimateError::MaxDeviation { .. })), "{value}");
    }
}

/// Handlers that end the call when it begins, or later.
#[test]
fn long_calls_can_be_interrupted() {
    let mesh = shapes::icosphere(40.0, 5);
    let full = tree(&mesh);
    for until in [0.0, 0.3] {
        let stop = |fraction: f64| {
            if fraction < until { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let interrupted = Decimation::new(full.clone(), Progress::new(&stop));
        assert_eq!(interrupted.map(drop), Err(DecimateError::Interrupted(Interrupted)));
        let decimation = decimation(&mesh).expect("closed");
        let interrupted = decimation.within(0.5, Progress::new(&stop));
        assert_eq!(interrupted.map(drop), Err(DecimateError::Interrupted(Interrupted)));
    }
}
