//! The bounds hold, and are near the truth: against dense samples by brute force.

use decimate::{Decimation, DirectedHausdorff, deviation};
use fixtures::{Mesh, arithmetic, femur, reference, shapes};
use glam::DVec3;
use surface::{TriangleSurface, closest_on_triangle};

/// A number in `0.0..1.0` that follows from two others.
fn random(seed: u32, i: u32) -> f64 {
    f64::from(arithmetic::hash(arithmetic::hash(seed).wrapping_add(i))) / 4_294_967_296.0
}

/// A point of a face, spread evenly.
fn sample(corners: [DVec3; 3], i: u32) -> DVec3 {
    let (s, t) = (random(1, i), random(2, i));
    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
    corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t
}

/// Points all over a mesh, as many on each face.
fn samples(mesh: &Mesh, count: u32) -> impl Iterator<Item = DVec3> {
    let faces = u32::try_from(mesh.faces.len()).expect("few faces");
    (0..count).map(move |i| {
        let face = u64::from(i) * u64::from(faces) / u64::from(count);
        sample(mesh.corners(usize::try_from(face).expect("few faces")), i)
    })
}

/// The largest of the points' distances from the nearest triangle, by looking at all
/// whose bounding sphere is near enough.
fn farthest(points: impl Iterator<Item = DVec3>, mesh: &Mesh) -> f64 {
    let spheres: Vec<(DVec3, f64)> = (0..mesh.faces.len())
        .map(|face| {
            let (center, corners) = (mesh.centroid(face), mesh.corners(face));
            (center, corners.iter().map(|p| p.distance(center)).fold(0.0, f64::max))
        })
        .collect();
    let mut nearest = 0;
    let distance = |p: DVec3| {
        let to = |face: usize| closest_on_triangle(p, mesh.corners(face)).point.distance(p);
        let mut best = to(nearest); // of the point before: near where points follow faces
        for (face, (center, radius)) in spheres.iter().enumerate() {
            if center.distance_squared(p) < (best + radius).powi(2) && to(face) < best {
                (best, nearest) = (to(face), face);
            }
        }
        best
    };
    points.map(distance).fold(0.0, f64::max)
}

fn both(mesh: &Mesh, deviation: f64) -> (Mesh, decimate::Deviation) {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite positions");
    let decimation = Decimation::new(&surface, x).expect("a closed surface");
    let reduced = decimation.within(deviation).expect("a deviation in range");
    let mut positions = Vec::new();
    reduced.gather(&mesh.positions, &mut positions);
    (Mesh { positions, faces: reduced.surface.faces().to_vec() }, reduced.deviation)
}

/// That no sample is farther than the bound, and that what was seen is in reach of
/// samples: within a fifth.
fn hold(name: &str, side: DirectedHausdorff, from: &Mesh, to: &Mesh, count: u32) {
    let farthest = farthest(samples(from, count), to);
    assert!(farthest <= side.upper * (1.0 + 1e-12), "{name}: {farthest} exceeds {side:?}");
    assert!(side.lower <= side.upper && side.upper <= 1.06 * side.lower, "{name}: {side:?}");
    assert!(farthest >= 0.8 * side.lower, "{name}: {farthest} at most of {side:?}");
}

#[test]
fn no_sample_is_farther() {
    let bodies = [
        ("sphere", shapes::icosphere(40.0, 4), 0.5),
        ("torus", shapes::torus(40.0, 12.0, [72, 32]), 0.3),
        ("femur", femur::femur(6.0), 0.6),
    ];
    for (name, full, within) in bodies {
        let (reduced, deviation) = both(&full, within);
        hold(name, deviation.full_to_reduced, &full, &reduced, 17_000);
        hold(name, deviation.reduced_to_full, &reduced, &full, 17_000);
    }
}

#[test]
fn measured_anew_it_is_the_same_within_slack() {
    let full = femur::femur(6.0);
    let (reduced, known) = both(&full, 0.6);
    let anew = measured(&full, &reduced);
    for (known, anew) in [
        (known.full_to_reduced, anew.full_to_reduced),
        (known.reduced_to_full, anew.reduced_to_full),
    ] {
        assert!(anew.lower <= known.upper && known.lower <= anew.upper, "{known:?} {anew:?}");
    }
}

#[test]
fn holds_after_a_deformation() {
    let full = shapes::icosphere(40.0, 4);
    let (reduced, _) = both(&full, 0.5);
    let bend = |p: DVec3| DVec3::new(p.x, p.y + 0.01 * p.x * p.x, 1.3 * p.z);
    let (full, reduced) = (full.mapped(bend), reduced.mapped(bend));
    let deviation = measured(&full, &reduced);
    hold("bent", deviation.full_to_reduced, &full, &reduced, 10_000);
    hold("bent", deviation.reduced_to_full, &reduced, &full, 10_000);
}

/// One side says nothing about the other: a bump that only one surface has.
#[test]
fn each_side_is_measured() {
    let flat = shapes::plate(DVec3::new(40.0, 40.0, 4.0), [8, 8]);
    let mut bump = shapes::plate(DVec3::new(40.0, 40.0, 4.0), [8, 8]);
    let apex = (0..bump.positions.len())
        .find(|v| bump.positions[*v].abs_diff_eq(DVec3::new(0.0, 0.0, 2.0), 1e-9))
        .expect("a vertex in the middle of the upper side");
    bump.positions[apex].z += 30.0;
    let deviation = measured(&bump, &flat);
    assert!((deviation.full_to_reduced.lower - 30.0).abs() < 1e-9, "{deviation:?}");
    assert!(deviation.reduced_to_full.upper < 6.0, "{deviation:?}");
    let turned = measured(&flat, &bump);
    assert!((turned.reduced_to_full.lower - 30.0).abs() < 1e-9, "{turned:?}");
    assert!(turned.largest() >= 30.0);
}

/// Pairs of any two surfaces: the bound of each side against every face.
#[test]
fn any_two_surfaces() {
    arbtest::arbtest(|u| {
        let a = fixtures::generate::convex(u)?;
        let b = fixtures::generate::convex(u)?;
        let deviation = measured(&a, &b);
        for (side, from, to) in
            [(deviation.full_to_reduced, &a, &b), (deviation.reduced_to_full, &b, &a)]
        {
            let size = from.bounds().diagonal();
            let farthest = (0..60)
                .map(|i| sample(from.corners(i as usize % from.faces.len()), i))
                .chain(from.positions.iter().copied())
                .filter_map(|p| reference::closest(to, p))
                .map(|closest| closest.distance)
                .fold(0.0, f64::max);
            assert!(farthest <= side.upper + 1e-12 * (size + farthest), "{farthest} {side:?}");
        }
        Ok(())
    })
    .budget_ms(2_000);
}

fn measured(full: &Mesh, reduced: &Mesh) -> decimate::Deviation {
    let surfaces: [TriangleSurface; 2] = [full.surface(), reduced.surface()];
    let x_full = surfaces[0].positions(&full.positions).expect("finite positions");
    let x_reduced = surfaces[1].positions(&reduced.positions).expect("finite positions");
    deviation(&surfaces[0], x_full, &surfaces[1], x_reduced).expect("faces")
}
