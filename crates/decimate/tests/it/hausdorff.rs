//! Certified bounds against dense samples by brute force.

use std::ops::ControlFlow;

use arbtest::arbtest;
use decimate::{DecimateError, hausdorff_bounds};
use fixtures::{Mesh, arithmetic, femur, generate, reference, shapes};
use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{DirectedHausdorff, HausdorffBounds, closest_on_triangle};

use crate::{decimation, gathered, reduced, tree};

/// Returns a number in `0.0..1.0` that depends on two others.
fn random(seed: u32, i: u32) -> f64 {
    f64::from(arithmetic::hash(arithmetic::hash(seed).wrapping_add(i))) / 4_294_967_296.0
}

/// Returns a point of a face, evenly distributed.
fn sample(corners: [DVec3; 3], i: u32) -> DVec3 {
    let (s, t) = (random(1, i), random(2, i));
    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
    corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t
}

/// Returns points all over a mesh, as many on each face.
pub(crate) fn samples(mesh: &Mesh, count: u32) -> impl Iterator<Item = DVec3> {
    let faces = u32::try_from(mesh.faces.len()).expect("few faces");
    (0..count).map(move |i| {
        let face = u64::from(i) * u64::from(faces) / u64::from(count);
        sample(mesh.corners(usize::try_from(face).expect("few faces")), i)
    })
}

/// Computes the largest distance of a point from a mesh, over all faces whose bounding sphere
/// is near enough.
pub(crate) fn max_distance(points: impl Iterator<Item = DVec3>, mesh: &Mesh) -> f64 {
    let bounding_sphere = |face: usize| {
        let (center, corners) = (mesh.centroid(face), mesh.corners(face));
        (center, corners.iter().map(|p| p.distance(center)).fold(0.0, f64::max))
    };
    let spheres: Vec<(DVec3, f64)> = (0..mesh.faces.len()).map(bounding_sphere).collect();

    let (mut nearest, mut largest) = (0, 0.0_f64);
    for p in points {
        let to = |face: usize| closest_on_triangle(p, mesh.corners(face)).point.distance(p);
        let mut best = to(nearest); // of the point before: near, where points follow faces
        for (face, (center, radius)) in spheres.iter().enumerate() {
            if center.distance_squared(p) < (best + radius).powi(2) && to(face) < best {
                (best, nearest) = (to(face), face);
            }
        }
        largest = largest.max(best);
    }
    largest
}

/// Decimates a mesh.
fn decimated(mesh: &Mesh, max_deviation: f64) -> Mesh {
    gathered(mesh, &reduced(mesh, max_deviation))
}

/// Computes the bounds between two meshes.
pub(crate) fn measured(full: &Mesh, reduced: &Mesh) -> HausdorffBounds {
    hausdorff_bounds(&tree(full), &tree(reduced), Progress::none()).expect("faces")
}

/// Checks that no sample exceeds the upper bound, that both bounds are close to each other, and
/// that samples come near the lower one.
fn assert_bounds(name: &str, bounds: DirectedHausdorff, from: &Mesh, to: &Mesh, count: u32) {
    let DirectedHausdorff { lower, upper } = bounds;
    let sampled = max_distance(samples(from, count), to);
    assert!(sampled <= upper * (1.0 + 1e-12), "{name}: {sampled} exceeds {bounds:?}");
    assert!(lower <= upper && upper <= 1.06 * lower, "{name}: {bounds:?}");
    assert!(sampled >= 0.8 * lower, "{name}: {sampled}, {bounds:?}");
}

#[test]
fn no_sample_exceeds_the_bounds() {
    let bodies = [
        ("sphere", shapes::icosphere(40.0, 4), 0.5),
        ("torus", shapes::torus(40.0, 12.0, [72, 32]), 0.3),
        ("femur", femur::femur(6.0), 0.6),
    ];
    for (name, full, max_deviation) in bodies {
        let reduced = decimated(&full, max_deviation);
        let deviation = measured(&full, &reduced);
        assert_bounds(name, deviation.forward, &full, &reduced, 17_000);
        assert_bounds(name, deviation.backward, &reduced, &full, 17_000);
    }
}

/// The deviation of a reduced surface bounds more than distances, and is hardly larger.
#[test]
fn deviations_of_reduced_surfaces_are_tight() {
    for (name, full) in crate::bodies() {
        for max_deviation in [0.3, 1.0] {
            let reduced = reduced(&full, max_deviation);
            let bounds = measured(&full, &gathered(&full, &reduced));
            let deviation = reduced.deviation;
            assert!(bounds.lower() <= deviation, "{name}: {deviation} under {bounds:?}");
            assert!(deviation <= 1.25 * bounds.upper(), "{name}: {deviation} over {bounds:?}");
        }
    }
}

#[test]
fn bounds_hold_after_a_deformation() {
    let full = shapes::icosphere(40.0, 4);
    let reduced = decimated(&full, 0.5);
    let bend = |p: DVec3| DVec3::new(p.x, p.y + 0.01 * p.x * p.x, 1.3 * p.z);
    let (full, reduced) = (full.mapped(bend), reduced.mapped(bend));
    let deviation = measured(&full, &reduced);
    assert_bounds("bent", deviation.forward, &full, &reduced, 10_000);
    assert_bounds("bent", deviation.backward, &reduced, &full, 10_000);
}

/// A bump that only one surface has shows in one direction alone.
#[test]
fn directions_are_measured_independently() {
    let flat = shapes::plate(DVec3::new(40.0, 40.0, 4.0), [8, 8]);
    let mut bump = flat.clone();
    let apex = (0..bump.positions.len())
        .find(|v| bump.positions[*v].abs_diff_eq(DVec3::new(0.0, 0.0, 2.0), 1e-9))
        .expect("a vertex in the middle of the upper side");
    bump.positions[apex].z += 30.0;

    let deviation = measured(&bump, &flat);
    assert!((deviation.forward.lower - 30.0).abs() < 1e-9, "{deviation:?}");
    assert!(deviation.backward.upper < 6.0, "{deviation:?}");
    let reversed = measured(&flat, &bump);
    assert!((reversed.backward.lower - 30.0).abs() < 1e-9, "{reversed:?}");
    assert!(reversed.upper() >= 30.0);
}

/// Two hundred pairs of unrelated surfaces, against every face.
#[test]
fn bounds_hold_for_unrelated_surfaces() {
    for i in 0..200_u64 {
        // The lower half of a seed is the number of random bytes.
        let size = 64 << (i % 8);
        let random = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        arbtest(|u| {
            let (a, b) = (generate::convex(u)?, generate::convex(u)?);
            let deviation = measured(&a, &b);
            for (bounds, from, to) in [(deviation.forward, &a, &b), (deviation.backward, &b, &a)] {
                let size = from.bounds().diagonal();
                let sampled = (0..60)
                    .map(|i| sample(from.corners(i as usize % from.faces.len()), i))
                    .chain(from.positions.iter().copied())
                    .filter_map(|p| reference::closest(to, p))
                    .map(|closest| closest.distance)
                    .fold(0.0, f64::max);
                let rounding = 1e-12 * (size + sampled);
                assert!(sampled <= bounds.upper + rounding, "{sampled} {bounds:?}");
            }
            Ok(())
        })
        .seed(random << 32 | size)
        .run();
    }
}

#[test]
fn a_surface_without_faces_is_refused() {
    let error =
        hausdorff_bounds(&tree(&Mesh::default()), &tree(&shapes::cube(1.0)), Progress::none());
    assert_eq!(error, Err(DecimateError::TooSmall { faces: 0 }));
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
        let interrupted = decimate::Decimation::new(full.clone(), Progress::new(&stop));
        assert_eq!(interrupted.map(drop), Err(DecimateError::Interrupted(Interrupted)));
        let decimation = decimation(&mesh).expect("closed");
        let interrupted = decimation.within(0.5, Progress::new(&stop));
        assert_eq!(interrupted.map(drop), Err(DecimateError::Interrupted(Interrupted)));
    }
}
