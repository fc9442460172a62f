//! What the deviation of a reduced surface proves, against brute force: distances both ways, and
//! the same winding numbers farther away.

use decimate::{CoarseSurface, ReducedSurface};
use fixtures::random::Random;
use fixtures::{Mesh, arithmetic, reference, sampling, shapes};
use glam::DVec3;
use surface::closest_on_triangle;

use crate::{bodies, gathered, reduced, tree};

/// Returns points all over a mesh: its vertices, and as many points in each face as on its edges.
fn samples(mesh: &Mesh, count: usize) -> Vec<DVec3> {
    let mut random = Random(7);
    let mut points = mesh.positions.clone();
    for i in 0..count {
        let ([a, b, c], [u, v, w]) = (mesh.corners(i * mesh.faces.len() / count), random.weights());
        points.extend([u * a + v * b + w * c, a.lerp(b, u)]);
    }
    points
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

/// Computes the largest distance of a sample of either mesh from the other one.
fn sampled_distance(a: &Mesh, b: &Mesh) -> f64 {
    let directed = |from, to| max_distance(samples(from, 1500).into_iter(), to);
    directed(a, b).max(directed(b, a))
}

/// Points with different winding numbers about a full surface and a reduced one.
#[derive(Default)]
struct Differing {
    count: usize,
    /// Largest sum of the distances from both surfaces, over the deviation.
    max_share: f64,
}

/// Checks that samples of both surfaces are as near as the deviation says, and that points with
/// different winding numbers are between them.
fn assert_proof(name: &str, full: &Mesh, reduced: &Mesh, deviation: f64) -> Differing {
    let limit = deviation * (1.0 + 1e-9);
    let distance = sampled_distance(full, reduced);
    assert!(distance <= limit, "{name}: {distance} exceeds {deviation}");

    let mut differing = Differing::default();
    for p in sampling::points_near(full, 800, 0.4 * deviation) {
        let [w, v] = [full, reduced].map(|mesh| reference::winding(mesh, p));
        if (w - v).abs() > 0.5 {
            let distance = |mesh| reference::closest(mesh, p).expect("faces").distance;
            let sum = distance(full) + distance(reduced);
            assert!(sum <= limit, "{name}: {w} and {v} about {p}, {sum} exceeds {deviation}");
            differing.count += 1;
            differing.max_share = differing.max_share.max(sum / deviation);
        }
    }
    differing
}

/// Builds a sheet of a thickness with bumps on both sides.
fn sheet(thickness: f64, bump: f64) -> Mesh {
    shapes::plate(DVec3::new(40.0, 40.0, thickness), [40, 40]).mapped(|p| {
        let height = arithmetic::noise(0.3 * p.x, 0.3 * p.y, 1 << 20, u32::from(p.z > 0.0));
        p + DVec3::Z * bump * height
    })
}

/// Both sides of the sheets are nearer to each other than the tolerance: a search for the
/// nearest point finds either.
#[test]
fn no_plate_or_crack_opens_or_closes_unseen() {
    let plate = sheet(0.3, 0.4);
    let block = shapes::plate(DVec3::new(44.0, 44.0, 6.0), [4, 4]);
    let crack = block.joined(&sheet(0.3, 0.4).flipped());
    for (name, full) in [("plate", plate), ("crack", crack)] {
        for max_deviation in [0.2, 0.5, 1.0] {
            let reduced = reduced(&full, max_deviation);
            let coarse = gathered(&full, &reduced);
            assert!(coarse.faces.len() < full.faces.len() / 2, "{name}: {}", coarse.faces.len());
            let differing = assert_proof(name, &full, &coarse, reduced.deviation);
            assert!(differing.count > 10, "{name}: {} points", differing.count);
        }
    }
}

/// Returns a bumpy body.
fn body(random: &mut Random) -> Mesh {
    let mesh = match random.below(4) {
        0 => shapes::icosphere(20.0, 3),
        1 => shapes::torus(25.0, 7.0, [36, 16]),
        2 => shapes::plate(DVec3::new(60.0, 30.0, 1.0 + 9.0 * random.unit()), [24, 12]),
        _ => shapes::ellipsoid(DVec3::new(40.0, 12.0, 5.0), 3),
    };
    let (bump, seed) = (2.0 * random.unit(), u32::from(random.byte()));
    mesh.mapped(|p| {
        let height = arithmetic::noise(0.2 * (p.x + p.z), 0.2 * (p.y - p.z), 1 << 20, seed);
        p + p.normalize_or_zero() * bump * height
    })
}

/// Returns a smooth deformation: a bend, a twist and a wave.
fn deformation(random: &mut Random) -> impl Fn(DVec3) -> DVec3 + use<> {
    let [bend, twist] = [0, 1].map(|_| 0.03 * (random.unit() - 0.5));
    let (wave, phase) = (3.0 * random.unit(), random.unit());
    move |p: DVec3| {
        let turned = arithmetic::rotation(DVec3::X, twist * p.x) * p;
        let bent = turned + DVec3::Y * bend * turned.x * turned.x;
        bent + DVec3::Z * wave * arithmetic::circle(0.02 * bent.x + phase).y
    }
}

/// Returns a reduced surface of a mesh that follows it.
fn coarse(mesh: &Mesh, reduced: ReducedSurface) -> CoarseSurface {
    CoarseSurface::new(reduced, &tree(mesh)).expect("a reduced surface")
}

#[test]
fn proofs_hold_for_random_bodies_at_rest_and_deformed() {
    let mut random = Random(18);
    let (mut differing, mut max_share) = (0, 0.0_f64);
    for number in 0..14 {
        let (mesh, max_deviation) = (body(&mut random), 0.1 + 1.5 * random.unit());
        let reduced = reduced(&mesh, max_deviation);
        assert!(reduced.deviation <= max_deviation, "{number}: {}", reduced.deviation);
        let name = format!("{number} at rest");
        let found = assert_proof(&name, &mesh, &gathered(&mesh, &reduced), reduced.deviation);
        differing += found.count;
        max_share = max_share.max(found.max_share);

        let deformed = mesh.clone().mapped(deformation(&mut random));
        let deformed_coarse = gathered(&deformed, &reduced);
        let mut coarse = coarse(&mesh, reduced);
        coarse.follow(&deformed.positions).expect("finite positions");
        let name = format!("{number} deformed");
        differing += assert_proof(&name, &deformed, &deformed_coarse, coarse.deviation()).count;
    }
    assert!(differing > 500 && max_share > 0.7, "{differing} points, up to {max_share}");
}

/// A long muscle that bends by 60°: its ends are centimeters from any rigid motion of the whole,
/// but every part is nearly rigid.
#[test]
fn a_bend_of_a_long_body_hardly_changes_its_deviation() {
    let (length, radius) = (200.0, 200.0 / 60.0_f64.to_radians());
    let muscle = shapes::ellipsoid(DVec3::new(0.5 * length, 12.0, 9.0), 5)
        .mapped(|p| p * (1.0 + 0.1 * arithmetic::noise(0.3 * p.x, 0.3 * p.y, 1 << 20, 3)));
    let reduced = reduced(&muscle, 0.5);
    let bend = |p: DVec3| {
        let (sin, cos) = (p.x / radius).sin_cos();
        DVec3::new((radius + p.y) * sin, (radius + p.y) * cos - radius, p.z)
    };
    let bent = muscle.clone().mapped(bend);
    let bent_coarse = gathered(&bent, &reduced);
    let mut coarse = coarse(&muscle, reduced);
    coarse.follow(&bent.positions).expect("finite positions");
    let (deviation, sampled) = (coarse.deviation(), sampled_distance(&bent, &bent_coarse));
    assert!(deviation <= 1.5 * 0.5 && deviation <= 1.1 * sampled, "{deviation} {sampled}");
    assert!(sampled <= deviation, "{deviation} {sampled}");

    // Back at rest, it is as it was.
    coarse.follow(&muscle.positions).expect("finite positions");
    assert!((coarse.deviation() - coarse.reduced().deviation).abs() <= 1e-12);
}

/// A cylinder stays where it is as a surface, while its vertices slide along it by millimeters.
#[test]
fn a_surface_that_slides_along_itself_deviates_no_more() {
    let rod = shapes::capsule(10.0, 60.0, 32);
    let mut coarse = coarse(&rod, reduced(&rod, 0.3));
    let slide = |p: DVec3| p + DVec3::Z * 4.0 * (1.0 - (p.z / 30.0).powi(2)).max(0.0);
    coarse.follow(&rod.mapped(slide).positions).expect("finite positions");
    assert!(coarse.deviation() <= 1.03 * coarse.reduced().deviation, "{}", coarse.deviation());
}

/// A body far from the origin is turned and brought back to it: its shape is rounded where it was, not
/// where it is.
#[test]
fn a_pose_is_rounded_at_the_size_of_its_reference() {
    let ball = shapes::icosphere(10.0, 3);
    let far = ball.clone().translated(DVec3::splat(1e6));
    let mut followed = coarse(&ball, reduced(&ball, 0.5));
    let mut bounded = followed.clone();
    let mut grown = 0;
    for number in 0..20 {
        let turn =
            arithmetic::rotation(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.04 * f64::from(number));
        let center = DVec3::splat(1e6);
        let posed: Vec<DVec3> = far.positions.iter().map(|p| turn * *p - turn * center).collect();
        if number == 0 {
            followed.follow(&posed).expect("finite positions");
        }
        followed.follow_rigidly(&posed, &far.positions).expect("finite positions");
        bounded.follow(&posed).expect("finite positions");
        assert!(bounded.deviation() <= followed.deviation(), "{number}");
        grown += usize::from(bounded.deviation() > followed.reduced().deviation + 1e-11);
    }
    assert!(grown > 0, "rounding shows");
    assert!(followed.deviation() < followed.reduced().deviation + 1e-7);
}

/// The deviation bounds more than distances, and is hardly larger.
#[test]
fn deviations_are_tight() {
    for (name, full) in bodies() {
        for max_deviation in [0.3, 1.0] {
            let reduced = reduced(&full, max_deviation);
            let sampled = sampled_distance(&full, &gathered(&full, &reduced));
            let deviation = reduced.deviation;
            assert!(sampled <= deviation * (1.0 + 1e-12), "{name}: {deviation}, {sampled}");
            assert!(deviation <= 1.3 * sampled, "{name}: {deviation}, {sampled}");
        }
    }
}
