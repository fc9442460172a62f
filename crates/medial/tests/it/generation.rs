//! Generated medial surfaces: their bounds beside other samples, their topology, invalid input, and
//! their reproducibility.

use glam::DVec3;
use kdop::Workspace;
use medial::{
    Ball, Deviation, MedialError, MedialParams, MedialSize, PrimitiveTree, Topology, generate_each,
};
use surface::progress::Progress;
use surface::{SurfaceError, closest_on_triangle, winding_number};

use crate::support::{generated as made, grid_weights, muscle};

/// The belly and a ring.
fn all() -> [(&'static str, fixtures::Mesh); 2] {
    [("muscle", muscle()), ("torus", fixtures::shapes::torus(30.0, 9.0, [36, 16]))]
}

/// Minimum distance to any face, by comparison with all.
fn slow_distance(mesh: &fixtures::Mesh, p: DVec3) -> f64 {
    (0..mesh.faces.len())
        .map(|face| closest_on_triangle(p, mesh.corners(face)).point.distance(p))
        .fold(f64::INFINITY, f64::min)
}

/// Both bounds hold at other points, and exceed the largest distance by no more than they promise.
#[test]
fn bounds_hold_at_other_samples() {
    for (name, mesh) in all() {
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).unwrap();
        let generated = made(&mesh, &MedialParams::balls(30)).unwrap();
        let Deviation { surface_to_medial, medial_to_surface, .. } = generated.deviation;
        let medial = &generated.medial;
        let tree = PrimitiveTree::new(medial).unwrap();
        let workspace = &mut Workspace::default();
        let mut out = 0.0_f64;
        for face in 0..mesh.faces.len() {
            let [a, b, c] = mesh.corners(face);
            for weights in grid_weights(4) {
                let p = weights[0] * a + weights[1] * b + weights[2] * c;
                out = out.max(tree.nearest(medial, p, workspace).foot.distance);
            }
        }
        assert!(out <= surface_to_medial.upper, "{name}: {out} {surface_to_medial:?}");
        assert!(
            surface_to_medial.lower <= out + 0.05 * out + 1e-2,
            "{name}: {surface_to_medial:?}"
        );
        let mut over = 0.0_f64;
        for primitive in 0..u32::try_from(medial.primitives().len()).unwrap() {
            let balls = medial.primitive_balls(primitive);
            for weights in grid_weights(3) {
                let ball = Ball::interpolate(&balls, weights);
                let distance = slow_distance(&mesh, ball.center);
                let is_inside = winding_number(&surface, x, ball.center) > 0.5;
                over = over.max(ball.radius - if is_inside { distance } else { -distance });
            }
        }
        assert!(over <= medial_to_surface.upper, "{name}: {over} {medial_to_surface:?}");
        assert!(medial_to_surface.upper <= 1.06 * medial_to_surface.lower + 1e-2, "{name}");
    }
}

#[test]
fn more_balls_have_a_smaller_error() {
    let mesh = muscle();
    let rms = [12, 25, 50].map(|n| made(&mesh, &MedialParams::balls(n)).unwrap().deviation.rms);
    assert!(rms[0] < 1.2 && rms[1] < 0.6 * rms[0] && rms[2] < 0.7 * rms[1], "{rms:?}");
}

/// Starting from more balls and removing those that increase the error least is better than merging
/// alone, which leaves 0.0555 mm.
#[test]
fn balls_that_increase_the_error_least_are_removed() {
    let rms = made(&muscle(), &MedialParams::balls(120)).unwrap().deviation.rms;
    assert!(rms < 0.0545, "{rms}");
}

/// Of more than two hundred, as many are removed as are added where the error is largest.
#[test]
fn many_balls_are_exchanged() {
    let made = made(&muscle(), &MedialParams::balls(240)).unwrap();
    assert_eq!(made.medial.balls().len(), 240);
    assert!(made.deviation.rms < 0.0302, "{:?}", made.deviation);
}

/// A capsule needs two balls, up to the facets of its surface.
#[test]
fn a_capsule_is_a_cone() {
    let mesh = fixtures::shapes::capsule(10.0, 60.0, 32);
    let generated = made(&mesh, &MedialParams::balls(2)).unwrap();
    assert_eq!(generated.medial.cones().len(), 1);
    assert!(generated.deviation.largest() < 0.2, "{:?}", generated.deviation);
    for ball in generated.medial.balls() {
        assert!((ball.radius - 10.0).abs() < 0.1, "{ball:?}");
    }
}

/// The two sides of the belly close into one sheet: a disc of N balls has about
/// 2 N slabs less those at its rim, two layers of it would have 2 N − 4.
#[test]
fn the_sheet_is_one() {
    let made = made(&muscle(), &MedialParams::balls(60)).unwrap();
    let slabs = made.medial.slabs().len();
    assert!((60..105).contains(&slabs), "{slabs} slabs");
}

#[test]
fn a_tolerance_is_met_or_refused() {
    let mesh = muscle();
    let params = MedialParams::tolerance(1.0);
    let generated = made(&mesh, &params).unwrap();
    assert!(generated.deviation.largest() <= 1.0, "{:?}", generated.deviation);
    let fewer = generated.medial.balls().len() / 2;
    let coarser = made(&mesh, &MedialParams { size: MedialSize::Balls(fewer), ..params }).unwrap();
    assert!(coarser.deviation.largest() > 1.0, "half as many balls would have done");
    // A little below the deviation of the fewest that are tried: one or two more meet it.
    let fewest = made(&mesh, &MedialParams::balls(8)).unwrap().deviation.largest();
    let next = made(&mesh, &MedialParams::tolerance(0.99 * fewest)).unwrap();
    assert!(next.deviation.largest() < fewest && next.medial.balls().len() <= 16);
}

/// One ball is a sphere, up to the facets of its surface.
#[test]
fn a_tolerance_takes_no_more_balls_than_it_needs() {
    let mesh = fixtures::shapes::icosphere(10.0, 3);
    let generated = made(&mesh, &MedialParams::tolerance(1.0)).expect("a sphere");
    assert_eq!(generated.medial.balls().len(), 1, "{:?}", generated.deviation);
}

/// The size is named that came nearest to the tolerance, which is not always the last.
#[test]
fn a_refused_tolerance_names_the_smallest_deviation() {
    let mesh = fixtures::shapes::icosphere(10.0, 3);
    let refused = made(&mesh, &MedialParams::tolerance(1e-6));
    let Err(MedialError::ToleranceNotReached { reached, balls, .. }) = refused else {
        panic!("{refused:?}");
    };
    let deviations = [8, 16, 32, 64].map(|count| {
        let generated = made(&mesh, &MedialParams::balls(count)).expect("a sphere");
        generated.deviation.largest()
    });
    assert!(deviations.iter().all(|deviation| reached <= *deviation), "{deviations:?}");
    assert_eq!((reached, balls), (deviations[0], 8), "{deviations:?}");
}

#[test]
fn the_union_has_the_topology_of_the_surface() {
    for (name, mesh) in all() {
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).unwrap();
        let inside = Topology::of_inside(&surface, x).unwrap();
        let generated = made(&mesh, &MedialParams::balls(60)).unwrap();
        assert_eq!(
            Topology::of_union(&generated.medial, 1.5, Progress::none()).unwrap(),
            inside,
            "{name}"
        );
    }
    let far_apart = "2 0 0\nv 0 0 0 2\nv 9 0 0 2\n";
    let two = medial::MedialSurface::from_ma(far_apart).unwrap();
    let expected = Topology { components: 2, tunnels: 0, cavities: 0 };
    assert_eq!(Topology::of_union(&two, 0.5, Progress::none()).unwrap(), expected);
    let fine = Topology::of_union(&two, 1e-6, Progress::none());
    assert!(matches!(fine, Err(MedialError::TooMany { kind: "grid points", .. })), "{fine:?}");
}

#[test]
fn invalid_input_is_refused_by_name() {
    let mesh = muscle();
    let balls = MedialParams::balls(20);
    let surface = mesh.surface();

    let mut open = mesh.clone();
    open.faces.pop();
    let error = made(&open, &balls).unwrap_err();
    assert!(matches!(error, MedialError::Surface(SurfaceError::Open { count: 3, .. })), "{error}");

    // A vertex without a face has no normal, and no ball.
    let mut loose = mesh.clone();
    loose.positions.push(DVec3::splat(3.0));
    let error = made(&loose, &balls).unwrap_err();
    let vertex = mesh.positions.len();
    assert!(error.to_string().contains(&format!("isolated vertex, vertex {vertex}")), "{error}");

    let mut repeating = mesh.clone();
    repeating.faces.push([5, 5, 5]);
    let error = made(&repeating, &balls).unwrap_err();
    assert!(matches!(error, MedialError::Defect(_) | MedialError::Surface(_)), "{error}");

    let two = mesh.clone().joined(&mesh.clone().translated(500.0 * DVec3::X));
    assert_eq!(made(&two, &balls), Err(MedialError::Disconnected { components: 2 }));

    let error = made(&mesh.clone().flipped(), &balls).unwrap_err();
    assert!(matches!(error, MedialError::InsideOut { volume } if volume < 0.0), "{error}");

    // One vertex pulled through the other side.
    let mut crossed = mesh.clone();
    let top = (0..mesh.positions.len())
        .max_by(|&i, &j| mesh.positions[i].z.total_cmp(&mesh.positions[j].z))
        .unwrap();
    crossed.positions[top].z = -100.0;
    let error = made(&crossed, &balls).unwrap_err();
    assert!(matches!(error, MedialError::SelfCrossing { count, .. } if count > 0), "{error}");

    let thin = fixtures::shapes::plate(DVec3::new(40.0, 40.0, 0.5), [10, 10]);
    let error = made(&thin, &balls).unwrap_err();
    assert!(matches!(error, MedialError::TooThin { .. }), "{error}");

    let vertices = mesh.positions.len();
    let many = MedialError::TooManyBalls { requested: vertices + 1, vertices };
    assert_eq!(made(&mesh, &MedialParams::balls(vertices + 1)), Err(many));
    for params in
        [MedialParams::balls(0), MedialParams::tolerance(f64::NAN), MedialParams::tolerance(-1.0)]
    {
        let error = made(&mesh, &params).unwrap_err();
        assert!(matches!(error, MedialError::Parameter { .. }), "{error}");
    }

    let mut broken = mesh.positions.clone();
    broken[7].y = f64::NAN;
    let error = surface.positions(&broken).map(|_| ()).unwrap_err();
    assert!(matches!(error, SurfaceError::NotFinite { vertex: 7, .. }), "{error}");
}

/// A sheet of cartilage, 1 mm thick with 0.9 mm edges, is accepted.
#[test]
fn thin_cartilage_is_accepted() {
    let mesh = fixtures::shapes::plate(DVec3::new(20.0, 20.0, 1.0), [22, 22]);
    let generated = made(&mesh, &MedialParams::balls(80)).unwrap();
    assert!(generated.deviation.rms < 0.1, "{:?}", generated.deviation);
}

#[test]
fn results_are_reproducible_to_the_bit() {
    let mesh = muscle();
    let [first, second] = [0; 2].map(|_| made(&mesh, &MedialParams::balls(25)).unwrap());
    assert_eq!(first, second);
}

/// At a tip that hangs over, a ball shrinks to nothing; far from the origin, rounding
/// is all that would be left of it.
#[test]
fn tips_that_hang_over_are_points() {
    let mut mesh = muscle();
    let tops: Vec<usize> = (0..mesh.positions.len())
        .filter(|&k| mesh.positions[k].z > 6.0 && mesh.positions[k].x.abs() < 30.0)
        .step_by(17)
        .collect();
    assert!(tops.len() > 3, "{tops:?}");
    for top in tops {
        mesh.positions[top] += DVec3::new(14.0, 0.0, 3.0);
    }
    let mesh = mesh.translated(DVec3::new(425.0, 438.0, 794.0));
    let generated = made(&mesh, &MedialParams::balls(12)).unwrap();
    assert!(generated.medial.balls().iter().all(|ball| ball.center.is_finite()));
    assert!(generated.deviation.largest() < 12.0, "{:?}", generated.deviation);
}

/// Several sizes of one collapse are what each is alone.
#[test]
fn each_of_several_sizes_is_as_alone() {
    let mesh = muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let counts = [20, 40, 30];
    let each =
        generate_each(&surface, x, &counts, &MedialParams::balls(1), Progress::none()).unwrap();
    for (count, of_several) in counts.into_iter().zip(each) {
        assert_eq!(of_several, made(&mesh, &MedialParams::balls(count)).unwrap(), "{count}");
    }
    assert_eq!(
        generate_each(&surface, x, &[], &MedialParams::balls(1), Progress::none()),
        Ok(Vec::new())
    );
    let vertices = mesh.positions.len();
    let many = MedialError::TooManyBalls { requested: vertices + 1, vertices };
    let refused =
        generate_each(&surface, x, &[20, vertices + 1], &MedialParams::balls(1), Progress::none());
    assert_eq!(refused, Err(many));
}

/// A vertex on an edge whose faces have no area has no normal, and no ball of its own: the others are
/// as without it.
#[test]
fn vertices_without_a_normal_take_that_of_a_neighbor() {
    // The first edge of face 0 is straight: two vertices on it, one of them in faces without area.
    let mut mesh = fixtures::shapes::plate(DVec3::new(16.0, 16.0, 2.0), [16, 16]);
    let [p, q, r] = mesh.faces[0];
    let [from, to] = [p, q].map(|vertex| mesh.positions[vertex as usize]);
    let count = u32::try_from(mesh.positions.len()).expect("a small mesh");
    let (m, n) = (count, count + 1);
    mesh.positions.extend([from.lerp(to, 0.5), from.lerp(to, 0.25)]);
    mesh.faces[0] = [p, m, r];
    mesh.faces.extend([[m, q, r], [p, q, n], [q, m, n], [m, p, n]]);

    // As the last vertex, and as the first, into whose ball others merge.
    let mut first = mesh.clone();
    first.positions.rotate_right(1);
    for face in &mut first.faces {
        *face = face.map(|vertex| if vertex == n { 0 } else { vertex + 1 });
    }
    for mesh in [mesh, first] {
        for balls in [60, 100] {
            let generated = made(&mesh, &MedialParams::balls(balls)).expect("a closed surface");
            assert!(generated.medial.balls().len() >= balls, "{balls}");
            assert!(generated.deviation.largest() < 0.7, "{balls}: {:?}", generated.deviation);
        }
    }
}
