//! Medial surfaces that follow a deforming surface.
#![expect(clippy::print_stdout, reason = "measured values are printed")]

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DVec3};
use medial::{Ball, Deviation, FollowScratch, Links, MedialError, MedialSurface, REFIT_PASSES};
use surface::SurfaceError;

use crate::support::{muscle, with_balls};

/// The muscle with its medial surface and their links.
fn linked(balls: usize) -> (fixtures::Mesh, MedialSurface, Links) {
    let mesh = muscle();
    let medial = with_balls(&mesh, balls);
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite");
    let links = Links::new(&medial, &surface, x).expect("finite");
    (mesh, medial, links)
}

#[test]
fn centers_follow_affine_motions_exactly() {
    let (mesh, medial, links) = linked(30);
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 1.0);
    let stretch = DMat3::from_diagonal(DVec3::new(1.3, 0.9, 0.85));
    let map = |p: DVec3| turn * stretch * p + DVec3::new(5.0, -7.0, 100.0);
    let moved = mesh.clone().mapped(map);
    let mut following = medial.clone();
    let x = mesh.surface();
    links.move_centers(&mut following, x.positions(&moved.positions).unwrap()).unwrap();
    for (before, after) in medial.balls().iter().zip(following.balls()) {
        let error = after.center.distance(map(before.center));
        assert!(error < 0.02, "{error}");
    }
    for ball in 0..30 {
        let sum: f64 = links.carriers(ball).iter().map(|term| term.weight).sum();
        assert!((sum - 1.0).abs() < 1e-12, "ball {ball}: {sum}");
    }
    assert!(links.links().iter().any(|link| link.side == 1));
    assert!(links.links().iter().any(|link| link.side == -1));
}

/// With a ball for every third vertex, some are touched by no vertex and some by a few in one plane;
/// none may stay behind, or jump to the surface.
#[test]
fn balls_that_few_vertices_touch_follow_too() {
    let (mesh, medial, links) = linked(muscle().positions.len() / 3);
    let touched = |ball: u32| {
        let touches = |link: &&medial::Link| {
            let balls = medial.primitives()[link.primitive as usize];
            balls.into_iter().zip(link.weights).any(|(b, weight)| b == ball && weight > 0.0)
        };
        links.links().iter().filter(touches).count()
    };
    let count = u32::try_from(medial.balls().len()).unwrap();
    let few = (0..count).filter(|ball| touched(*ball) < 4).count();
    assert!(few > 5, "{few} balls are touched by fewer than four vertices");
    let map = |p: DVec3| DMat3::from_rotation_z(0.7) * p * 1.1 + DVec3::new(5.0, -7.0, 100.0);
    let moved = mesh.clone().mapped(map);
    let mut following = medial.clone();
    let surface = mesh.surface();
    links.move_centers(&mut following, surface.positions(&moved.positions).unwrap()).unwrap();
    for (before, after) in medial.balls().iter().zip(following.balls()) {
        let error = after.center.distance(map(before.center));
        assert!(error < 0.01 * before.radius, "{error} of a ball of {}", before.radius);
    }
}

/// A ball that the vertices touching it define is carried by these alone, so that it follows them
/// and nothing farther away.
#[test]
fn balls_are_carried_by_the_vertices_that_touch_them() {
    let (mesh, medial, links) = linked(30);
    let mut alone = 0;
    for ball in 0..30_u32 {
        let mut touching = Vec::new();
        for (vertex, link) in (0_u32..).zip(links.links()) {
            let balls = medial.primitives()[link.primitive as usize].into_iter();
            if balls.zip(link.weights).any(|(b, weight)| b == ball && weight > 0.0) {
                touching.push(vertex);
            }
        }
        let carriers: Vec<u32> = links.carriers(ball).iter().map(|term| term.particle).collect();
        assert!(touching.iter().all(|vertex| carriers.contains(vertex)), "ball {ball}");
        alone += u32::from(carriers.len() == touching.len());

        // The combination is the center, and multiplies noise of the vertices by 8 at most.
        let mut center = DVec3::ZERO;
        let mut magnitudes = 0.0;
        for term in links.carriers(ball) {
            center += term.weight * mesh.positions[term.particle as usize];
            magnitudes += term.weight.abs();
        }
        let Ball { center: expected, radius } = medial.balls()[ball as usize];
        assert!(center.distance(expected) <= 1e-3 * radius && magnitudes <= 8.0, "ball {ball}");
    }
    assert!(alone > 20, "{alone} of 30 balls");
}

#[test]
fn links_of_another_medial_surface_are_refused() {
    let (mesh, _, links) = linked(30);
    let mut other = MedialSurface::from_ma("1 0 0\nv 0 0 0 1\n").unwrap();
    let surface = mesh.surface();
    let error = links.follow(&mut other, surface.positions(&mesh.positions).unwrap()).unwrap_err();
    assert_eq!(error, MedialError::BallCount { expected: 30, got: 1 });

    // As many balls, without cones and slabs.
    let (_, medial, _) = linked(30);
    let mut beads = MedialSurface::new(medial.balls().to_vec(), Vec::new(), Vec::new()).unwrap();
    let x = surface.positions(&mesh.positions).unwrap();
    let refused = links.refit(&mut beads, x, 1);
    assert!(matches!(refused, Err(MedialError::PrimitiveCount { .. })), "{refused:?}");
}

/// Positions of a surface with fewer or more vertices are refused, and move no ball.
#[test]
fn positions_of_another_surface_are_refused() {
    let (mesh, medial, links) = linked(30);
    let vertices = mesh.positions.len();
    for other in [fixtures::shapes::cube(9.0), mesh.clone().joined(&mesh)] {
        let other_surface = other.surface();
        let x = other_surface.positions(&other.positions).expect("finite");
        let got = other.positions.len();
        let error = MedialError::Surface(SurfaceError::PositionCount { expected: vertices, got });

        let mut following = medial.clone();
        assert_eq!(links.follow(&mut following, x), Err(error));
        assert_eq!(links.move_centers(&mut following, x), Err(error));
        assert_eq!(links.refit(&mut following, x, 1), Err(error));
        assert_eq!(following, medial);
        assert_eq!(Links::new(&medial, &mesh.surface(), x), Err(error));
    }
}

/// The belly stretched and shortened along x with its volume kept, bent by a
/// quarter circle and twisted by 60°.
fn deformed(mesh: &fixtures::Mesh) -> [(&'static str, fixtures::Mesh); 4] {
    let bounds = mesh.bounds();
    let (low, high) = (bounds.min, bounds.max);
    let length = high.x - low.x;
    let along = |s: f64| mesh.clone().scaled(DVec3::new(s, s.powf(-0.5), s.powf(-0.5)));
    let radius = length / FRAC_PI_2;
    let bend = |p: DVec3| {
        let (sin, cos) = (p.x / radius).sin_cos();
        DVec3::new((radius + p.z) * sin, p.y, (radius + p.z) * cos - radius)
    };
    let twist = |p: DVec3| DMat3::from_rotation_x(p.x / length * 60.0_f64.to_radians()) * p;
    [
        ("stretch 1.3", along(1.3)),
        ("shorten 0.75", along(0.75)),
        ("bend 90", mesh.clone().mapped(bend)),
        ("twist 60", mesh.clone().mapped(twist)),
    ]
}

/// Constant radii are the dominant error at muscle strains; refitted balls bring the error back to
/// about that at rest.
#[test]
fn refitted_balls_keep_their_error_under_strain() {
    let (mesh, medial, links) = linked(40);
    let surface = mesh.surface();
    let rms = |medial: &MedialSurface, x: &[DVec3]| {
        Deviation::measure(medial, &surface, surface.positions(x).unwrap()).unwrap().rms
    };
    let rest = rms(&medial, &mesh.positions);
    let limits = [(0.6, 1.0, 0.6), (0.6, 1.2, 0.6), (0.0, 1.1, 0.6), (0.0, 1.2, 0.8)];
    for ((strain, moved), (min_constant, max_ratio, share)) in
        deformed(&mesh).into_iter().zip(limits)
    {
        let x = surface.positions(&moved.positions).unwrap();
        let mut following = medial.clone();
        links.move_centers(&mut following, x).unwrap();
        let constant = rms(&following, &moved.positions);
        links.refit(&mut following, x, REFIT_PASSES).unwrap();
        let refitted = rms(&following, &moved.positions);
        println!(
            "measured: 40 balls, {strain}, refitted over rest | {:.2} | {max_ratio}",
            refitted / rest
        );
        assert!(constant > min_constant, "{strain}: constant radii {constant}");
        assert!(refitted < max_ratio * rest, "{strain}: refitted {refitted}, rest {rest}");
        assert!(refitted < share * constant, "{strain}: {refitted} {constant}");
        let mut at_once = medial.clone();
        links.follow(&mut at_once, x).unwrap();
        assert_eq!(at_once, following, "{strain}");
    }
}

#[test]
fn following_allocates_in_its_first_step_alone() {
    let (mesh, mut medial, links) = linked(30);
    let surface = mesh.surface();
    let moved = deformed(&mesh).map(|(_, moved)| moved);
    let mut scratch = FollowScratch::default();
    for (step, moved) in moved.iter().cycle().take(12).enumerate() {
        let x = surface.positions(&moved.positions).unwrap();
        let allocated = allocation_counter::measure(|| {
            links.follow_in(&mut medial, x, &mut scratch).expect("its own links");
        });
        assert!(step == 0 || allocated.count_total == 0, "step {step}: {allocated:?}");
    }
}
