//! Scenes whose overlap is known in closed form.

use fixtures::Mesh;
use fixtures::random::Random;
use fixtures::shapes::{cube, icosphere};
use glam::DVec3;
use overlap::{Depth, DepthParams, Overlap, OverlapDetector};
use proximity::SurfaceTree;

/// What a scene is known to measure.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    volume: f64,
    /// Area of A inside B, and of B inside A.
    areas: [f64; 2],
    touching: f64,
    flush: f64,
    length: f64,
    loops: usize,
    /// Depth of A in B, and of B in A; 0 where nothing is inside.
    depths: [f64; 2],
}

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("planted bodies are finite")
}

/// A box between two values on each axis.
fn corners(x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Mesh {
    let [lower, upper] = [0, 1].map(|k| DVec3::new(x[k], y[k], z[k]));
    cube(1.0).scaled(upper - lower).translated(0.5 * (lower + upper))
}

/// A tetrahedron between two opposite edges, faces outward.
fn between_edges([p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> Mesh {
    let mesh = Mesh {
        positions: vec![p, q, r, s],
        faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    };
    if mesh.volume() > 0.0 { mesh } else { mesh.flipped() }
}

/// Width of the brackets of depths: narrower ones take long where a whole ridge is equally deep.
const WIDTH: f64 = 1e-4;

fn measure(a: &Mesh, b: &Mesh) -> (Overlap, [Option<Depth>; 2]) {
    let (a, b) = (tree(a), tree(b));
    let mut detector = OverlapDetector::default();
    let overlap = detector.measure(&a, &b);
    let params = DepthParams { relative_tolerance: 0.0, tolerance: WIDTH, max_queries: 1_000_000 };
    let depths = detector.depths([&a, &b], &params);
    for depth in depths.iter().flatten() {
        assert!(depth.is_narrow && depth.upper - depth.lower <= WIDTH, "{depth:?}");
    }
    (overlap, depths)
}

/// Compares a scene, and the same with the bodies swapped and with both turned.
fn check(name: &str, a: &Mesh, b: &Mesh, known: Known) {
    let cyclic = |mesh: &Mesh| mesh.clone().mapped(|p| DVec3::new(p.y, p.z, p.x));
    let half_turn = |mesh: &Mesh| mesh.clone().mapped(|p| DVec3::new(-p.x, p.y, -p.z));
    let swapped = Known {
        areas: [known.areas[1], known.areas[0]],
        depths: [known.depths[1], known.depths[0]],
        ..known
    };
    check_once(name, a, b, known);
    check_once(&format!("{name}, swapped"), b, a, swapped);
    check_once(&format!("{name}, cyclic"), &cyclic(a), &cyclic(b), known);
    check_once(&format!("{name}, half turn, swapped"), &half_turn(b), &half_turn(a), swapped);
}

fn check_once(name: &str, a: &Mesh, b: &Mesh, known: Known) {
    let (overlap, depths) = measure(a, b);
    let total = overlap.total;
    let size = [a, b]
        .iter()
        .flat_map(|mesh| &mesh.positions)
        .fold(1.0, |size: f64, p| size.max(p.abs().max_element()));
    let near = |measured: f64, exact: f64, power: i32| {
        (measured - exact).abs() <= 1e-14 * size.powi(power)
    };
    assert!(near(total.volume.expect("closed"), known.volume, 3), "{name}: {total:?}");
    let areas =
        [total.area_of_a_inside_b, total.area_of_b_inside_a].map(|area| area.expect("closed"));
    for side in 0..2 {
        assert!(near(areas[side], known.areas[side], 2), "{name}: {total:?}");
        let [lower, upper] = depths[side].map_or([0.0; 2], |depth| [depth.lower, depth.upper]);
        let holds = lower <= known.depths[side] + 1e-14 && known.depths[side] <= upper + 1e-14;
        assert!(holds, "{name}: {} {depths:?}", known.depths[side]);
    }
    assert!(near(total.touching_area, known.touching, 2), "{name}: {total:?}");
    assert!(near(total.flush_area, known.flush, 2), "{name}: {total:?}");
    if !overlap.has_ties {
        assert!(near(total.curve_length, known.length, 1), "{name}: {total:?}");
        assert_eq!(total.curve_loops, known.loops, "{name}: {total:?}");
    }
    let sum: f64 = overlap.regions.iter().map(|region| region.volume.expect("closed")).sum();
    assert!(near(sum, known.volume, 3), "{name}: {:?}", overlap.regions);
}

#[test]
fn boxes_at_a_corner() {
    let [a, b] = [
        corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]),
        corners([0.5, 2.0], [0.25, 2.0], [0.75, 2.0]),
    ];
    let area = 0.5 * 0.75 + 0.75 * 0.25 + 0.5 * 0.25;
    let known = Known {
        volume: 0.5 * 0.75 * 0.25,
        areas: [area; 2],
        length: 3.0,
        loops: 1,
        depths: [0.25; 2],
        ..Known::default()
    };
    check("boxes at a corner", &a, &b, known);
}

#[test]
fn a_box_inside_a_box() {
    let [a, b] = [
        corners([-1.0, 4.0], [-1.0, 4.0], [-1.0, 4.0]),
        corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]),
    ];
    let known = Known { volume: 1.0, areas: [0.0, 6.0], depths: [0.0, 2.0], ..Known::default() };
    check("box in box", &a, &b, known);
}

#[test]
fn tetrahedra_that_overlap_by_their_edges_alone() {
    let (l, h, d) = (4.0, 3.0, 0.125);
    let a = between_edges(
        [DVec3::new(-l, 0.0, d), DVec3::new(l, 0.0, d)],
        [DVec3::new(0.0, -l, -h), DVec3::new(0.0, l, -h)],
    );
    let b = between_edges(
        [DVec3::new(0.0, -l, -d), DVec3::new(0.0, l, -d)],
        [DVec3::new(-l, 0.0, h), DVec3::new(l, 0.0, h)],
    );
    let (k, slope) = (2.0 * l * d / (d + h), l / (d + h));
    let depth = 2.0 * d * slope / (1.0 + slope * slope).sqrt();
    let known = Known {
        volume: 16.0 * l * l * d.powi(3) / (3.0 * (d + h).powi(2)),
        areas: [2.0 * k * (k * k + 4.0 * d * d).sqrt(); 2],
        length: 4.0 * (2.0 * k * k + 4.0 * d * d).sqrt(),
        loops: 1,
        depths: [depth; 2],
        ..Known::default()
    };
    check("tetrahedra by edges", &a, &b, known);
}

#[test]
fn faces_that_touch() {
    let cube = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]);
    let beside = corners([1.0, 2.0], [0.0, 1.0], [0.0, 1.0]);
    check("touching cubes", &cube, &beside, Known { touching: 1.0, ..Known::default() });
    let smaller = corners([1.0, 2.0], [0.25, 0.75], [0.25, 0.75]);
    check("a smaller one touching", &cube, &smaller, Known { touching: 0.25, ..Known::default() });
}

#[test]
fn the_same_box_twice() {
    let cube = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]);
    let known = Known { volume: 1.0, flush: 6.0, ..Known::default() };
    check("the same box twice", &cube, &cube, known);
    let mut other = cube.clone();
    for face in &mut other.faces {
        face.rotate_left(1);
    }
    check("with its faces turned", &cube, &other, known);
}

#[test]
fn a_box_flush_with_another_inside_it() {
    let cube = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]);
    let inner = corners([0.0, 0.5], [0.25, 0.75], [0.25, 0.75]);
    let known = Known {
        volume: 0.125,
        areas: [0.0, 1.25],
        flush: 0.25,
        depths: [0.0, 0.5],
        ..Known::default()
    };
    check("flush inside", &cube, &inner, known);
}

/// Each region has an origin of its own: far from that of another it would lose six digits.
#[test]
fn regions_far_from_each_other_keep_their_digits() {
    let far = 1e6 + 0.1;
    let boxes = |from: f64| {
        let place = |x: f64| corners([x, x + 1.0], [from, from + 1.0], [from, from + 1.0]);
        place(from).joined(&place(far + from))
    };
    let (a, b) = (boxes(0.0), boxes(0.7));
    let (overlap, _) = measure(&a, &b);
    assert_eq!(overlap.regions.len(), 2, "{:?}", overlap.regions);

    // The sides of what each pair of boxes shares are differences of neighboring numbers.
    for region in &overlap.regions {
        let is_far = region.centroid.is_some_and(|center| center.x > 0.5 * far);
        let of_box = if is_far { 8..16 } else { 0..8 };
        let upper = a.positions[of_box.clone()].iter().copied().reduce(DVec3::max).unwrap();
        let lower = b.positions[of_box].iter().copied().reduce(DVec3::min).unwrap();
        let exact = (upper - lower).element_product();
        let error = (region.volume.unwrap() / exact - 1.0).abs();
        assert!(error < 1e-14, "{error:e} in {region:?}");
    }
}

#[test]
fn a_bar_through_a_slab_and_through_both_legs_of_a_ring() {
    let slab = corners([-3.0, 3.0], [-3.0, 3.0], [-0.5, 0.5]);
    let bar = corners([-1.0, 1.0], [-1.0, 1.0], [-5.0, 5.0]);
    let known = Known {
        volume: 4.0,
        areas: [8.0; 2],
        length: 16.0,
        loops: 2,
        depths: [1.0, 0.5],
        ..Known::default()
    };
    check("bar through slab", &slab, &bar, known);

    let legs = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]).joined(&corners(
        [3.0, 4.0],
        [0.0, 1.0],
        [0.0, 1.0],
    ));
    let bar = corners([-1.0, 5.0], [0.25, 0.5], [0.25, 0.75]);
    let known = Known {
        volume: 0.25,
        areas: [0.5, 3.0],
        length: 6.0,
        loops: 4,
        depths: [0.125, 0.5],
        ..Known::default()
    };
    check("bar through legs", &legs, &bar, known);
    let (overlap, _) = measure(&legs, &bar);
    assert_eq!(overlap.regions.len(), 2, "{:?}", overlap.regions);
    assert!(overlap.regions.iter().all(|region| (region.volume.unwrap() - 0.125).abs() < 1e-15));
}

/// As in surfaces of voxels, where two of one body meet at an edge.
#[test]
fn two_boxes_that_share_an_edge_are_one_body() {
    let boxes = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]).joined(&corners(
        [1.0, 2.0],
        [1.0, 2.0],
        [0.0, 1.0],
    ));
    let staircase = welded(&boxes);
    assert_eq!(staircase.positions.len(), 14);
    assert!(staircase.surface().require_oriented().is_err(), "four faces at the edge");

    let around_the_edge = corners([0.5, 1.75], [0.25, 1.5], [0.5, 3.0]);
    let known = Known {
        volume: 0.375,
        areas: [2.0; 2],
        length: 7.0,
        loops: 2,
        depths: [0.5; 2],
        ..Known::default()
    };
    check("a box around the edge", &staircase, &around_the_edge, known);

    // The same as of two bodies in one list, which share nothing.
    let across = corners([0.5, 1.5], [0.75, 1.75], [0.25, 0.75]);
    let [one, two] = [&staircase, &boxes].map(|mesh| measure(mesh, &across).0.total);
    let pairs = [
        (one.volume, two.volume),
        (one.area_of_a_inside_b, two.area_of_a_inside_b),
        (one.area_of_b_inside_a, two.area_of_b_inside_a),
    ];
    for (one, two) in pairs {
        assert!((one.expect("balanced") - two.expect("closed")).abs() < 1e-14, "{pairs:?}");
    }
    let around = corners([-1.0, 3.0], [-1.0, 3.0], [-1.0, 3.0]);
    let (inside, _) = measure(&staircase, &around);
    assert!((inside.total.volume.expect("balanced") - 2.0).abs() < 1e-14);
    assert_eq!(inside.regions.len(), 1);
}

/// Joins corners of equal positions.
fn welded(mesh: &Mesh) -> Mesh {
    let mut welded = Mesh { positions: Vec::new(), faces: Vec::new() };
    for face in &mesh.faces {
        welded.faces.push(face.map(|corner| {
            let position = mesh.positions[corner as usize];
            let number = welded.positions.iter().position(|p| *p == position);
            let number = number.unwrap_or_else(|| {
                welded.positions.push(position);
                welded.positions.len() - 1
            });
            u32::try_from(number).expect("a small mesh")
        }));
    }
    welded
}

#[test]
fn a_thin_sheet_through_a_box() {
    let e = 2.0_f64.powi(-20);
    let cube = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]);
    let sheet = corners([-1.0, 2.0], [-1.0, 2.0], [0.5, 0.5 + e]);
    let known = Known {
        volume: e,
        areas: [4.0 * e, 2.0],
        length: 8.0,
        loops: 2,
        depths: [e / 2.0, 0.5],
        ..Known::default()
    };
    check("thin sheet", &cube, &sheet, known);
}

#[test]
fn a_hollow_box() {
    let hollow = corners([-4.0, 4.0], [-4.0, 4.0], [-4.0, 4.0])
        .joined(&corners([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]).flipped());
    let bar = corners([0.0, 2.0], [0.0, 0.5], [0.0, 0.5]);
    let known = Known {
        volume: 0.25,
        areas: [0.25, 2.25],
        length: 2.0,
        loops: 1,
        depths: [0.25, 1.0],
        ..Known::default()
    };
    check("bar in the wall of a hollow box", &hollow, &bar, known);
    let small = corners([-0.25, 0.25], [-0.25, 0.25], [-0.25, 0.25]);
    check("a box in the hollow", &hollow, &small, Known::default());

    // Its cavity belongs to the wall around it, whatever region finds it first.
    let around = corners([-9.0, 9.0], [-9.0, 9.0], [-9.0, 9.0]);
    let known = Known {
        volume: 512.0 - 8.0,
        areas: [384.0 + 24.0, 0.0],
        depths: [8.0, 0.0],
        ..Known::default()
    };
    check("a hollow box inside a box", &hollow, &around, known);
    assert_eq!(measure(&hollow, &around).0.regions.len(), 1);
}

#[test]
fn two_spheres_converge() {
    let mut before = f64::INFINITY;
    for level in 2..=5 {
        let a = icosphere(1.0, level);
        let b = a.clone().translated(DVec3::X);
        let (overlap, _) = measure(&a, &b);
        let error = (overlap.total.volume.unwrap() - 5.0 * std::f64::consts::PI / 12.0).abs();
        assert!(error < 0.27 * before, "level {level}: {error}");
        assert_eq!(overlap.total.curve_loops, 1);
        before = error;
    }
}

#[test]
fn corners_and_edges_that_touch() {
    let cube = corners([0.0, 1.0], [0.0, 1.0], [0.0, 1.0]);
    let on_corner = corners([1.0, 2.0], [1.0, 2.0], [1.0, 2.0]);
    check("corner on corner", &cube, &on_corner, Known::default());
    let on_edge = corners([1.0, 2.0], [1.0, 2.0], [0.25, 0.75]);
    check("edge along edge", &cube, &on_edge, Known::default());
    let tip = between_edges(
        [DVec3::new(0.25, 0.25, 1.0), DVec3::new(0.0, 0.0, 2.0)],
        [DVec3::new(1.0, 0.0, 2.0), DVec3::new(0.0, 1.0, 2.0)],
    );
    check("corner on face", &cube, &tip, Known::default());
    for (a, b) in [(&cube, &on_corner), (&cube, &on_edge), (&cube, &tip)] {
        for (a, b) in [(a, b), (b, a)] {
            let (overlap, _) = measure(a, b);
            assert_eq!((overlap.total.curve_loops, overlap.total.curve_length), (0, 0.0));
        }
    }
}

#[test]
fn a_doubled_body_is_named() {
    let cube = corners([0.0, 4.0], [0.0, 4.0], [0.0, 4.0]);
    let doubled = cube.clone().joined(&cube);
    let small = corners([1.0, 2.0], [1.0, 2.0], [1.0, 2.0]);
    let (overlap, depths) = measure(&doubled, &small);
    assert!((overlap.total.volume.unwrap() - 2.0).abs() < 1e-14);
    assert_eq!(overlap.covers_twice, [true, false]);
    assert_eq!(depths[1], None);
}

/// A wide bracket is one that ends early, when most bounds are still far above the depth.
#[test]
fn wide_brackets_hold_the_depth_that_narrow_ones_attain() {
    let mut random = Random(7);
    let mut point = |size: f64| size * DVec3::new(random.unit(), random.unit(), random.unit());
    let mut compared = 0;
    for _ in 0..600 {
        let [a, b] = [0, 1].map(|_| {
            let [p, q, r, s] = [0, 1, 2, 3].map(|_| point(1.0));
            tree(&between_edges([p, q], [r, s]))
        });
        let mut detector = OverlapDetector::default();
        detector.measure(&a, &b);
        let mut depths = |relative_tolerance: f64| {
            let params =
                DepthParams { relative_tolerance, tolerance: 1e-9, max_queries: 1_000_000 };
            detector.depths([&a, &b], &params)
        };
        let narrow = depths(1e-3);
        for relative_tolerance in [0.05, 0.5, 2.0] {
            for (wide, narrow) in depths(relative_tolerance).iter().zip(&narrow) {
                let (Some(wide), Some(narrow)) = (wide, narrow) else { continue };
                assert!(wide.lower <= narrow.upper && narrow.lower <= wide.upper, "{wide:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 600, "{compared} brackets");
}

/// The corner of an octahedron with whole coordinates: its depth is a whole number over √3.
#[test]
#[expect(clippy::disallowed_methods, reason = "squares without rounding, in a test")]
fn upper_bounds_of_depths_cover_rounding() {
    let around = tree(&fixtures::shapes::octasphere(4096.0, 0));
    let mut random = Random(9);
    for _ in 0..200 {
        let [x, y, z] = [(); 3].map(|()| (1.0 + 1000.0 * random.unit()).round());
        let tip = DVec3::new(x, y, z);
        let [p, q, r] = DVec3::AXES.map(|axis| tip + 7.0 * axis);
        let mut detector = OverlapDetector::default();
        let small = tree(&between_edges([tip, p], [q, r]));
        detector.measure(&small, &around);
        let [depth, _] = detector.depths(
            [&small, &around],
            &DepthParams { tolerance: 0.0, relative_tolerance: 0.0, max_queries: 100 },
        );
        let depth = depth.expect("inside");

        // 3 upper² against the square of the whole number, without rounding.
        let whole = 4096.0 - x - y - z;
        let square = depth.upper * depth.upper;
        let rest = depth.upper.mul_add(depth.upper, -square);
        let excess = 3.0_f64.mul_add(square, -whole * whole) + 3.0 * rest;
        assert!(excess >= 0.0 && depth.upper < 1.001 * whole / 3.0_f64.sqrt(), "{depth:?}");
    }
}

#[test]
fn a_corner_in_a_doubled_body_is_inside_it() {
    let cube = corners([0.0, 4.0], [0.0, 4.0], [0.0, 4.0]);
    let doubled = cube.clone().joined(&cube);
    let small = corners([3.0, 5.0], [3.0, 5.0], [3.0, 5.0]);
    let (overlap, _) = measure(&doubled, &small);
    assert!((overlap.total.volume.unwrap() - 2.0).abs() < 1e-14);
    assert_eq!(overlap.total.inside_vertices[1], 1);
    assert!((overlap.total.area_of_b_inside_a.unwrap() - 6.0).abs() < 1e-14);
}

/// Faces that repeat a vertex have no area, and sides that are no edges.
#[test]
fn faces_that_repeat_a_vertex_change_nothing() {
    let ball = icosphere(2.0, 2);
    for center in [DVec3::ZERO, DVec3::new(1.7, 0.2, 0.1)] {
        let whole = cube(1.0).translated(center);
        let mut dirty = whole.clone();
        // Each edge of a face that repeats a vertex comes twice: the body stays closed.
        dirty.faces.extend([[0, 0, 0], [1, 1, 5], [5, 1, 1], [7, 7, 7]]);
        let [(expected, depths), (found, found_depths)] =
            [&whole, &dirty].map(|mesh| measure(mesh, &ball));
        let volume = |overlap: &Overlap| overlap.total.volume.expect("closed");
        assert!((volume(&found) - volume(&expected)).abs() < 1e-12, "at {center}");
        let upper = |depths: &[Option<Depth>; 2]| depths.map(|depth| depth.map(|it| it.upper));
        for (depth, expected) in upper(&found_depths).into_iter().zip(upper(&depths)) {
            let apart = depth.unwrap_or(0.0) - expected.unwrap_or(0.0);
            assert!(apart.abs() <= WIDTH, "{found_depths:?} at {center}");
        }
    }
}
