//! Methods against brute force and known answers.

use baselines::average_case::{AverageCaseParams, AverageCaseTree};
use baselines::layered_depth::{self, LayeredDepthParams};
use baselines::selected_pairs::{SelectedPairs, SelectedPairsParams};
use baselines::spatial_hash::{self, SpatialHashParams};
use baselines::{BaselineError, PairFindings, PlacedSurface, VertexInside};
use fixtures::shapes::{capsule, cube, octasphere, plate};
use fixtures::{Mesh, reference};
use glam::DVec3;
use surface::TriangleSurface;

/// A mesh with its connectivity.
struct Shape {
    mesh: Mesh,
    surface: TriangleSurface,
}

impl Shape {
    fn new(mesh: Mesh) -> Self {
        let surface = mesh.surface();
        Self { mesh, surface }
    }

    fn body(&self) -> PlacedSurface<'_> {
        let x = self.surface.positions(&self.mesh.positions).expect("fixtures are finite");
        PlacedSurface { surface: &self.surface, x }
    }
}

/// Returns two spheres of radius 10 with centers at a distance, slightly rotated.
fn spheres(apart: f64) -> [Shape; 2] {
    let direction = DVec3::new(0.6, 0.48, 0.64);
    let other = octasphere(10.0, 3).rotated(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.13);
    [Shape::new(octasphere(10.0, 3)), Shape::new(other.translated(direction * apart))]
}

fn vertices(inside: &[VertexInside]) -> Vec<u32> {
    inside.iter().map(|vertex| vertex.vertex).collect()
}

fn inside_of(found: &PairFindings) -> &[Vec<VertexInside>; 2] {
    found.inside.as_ref().expect("the method finds vertices inside")
}

/// Returns pairs of shapes in several poses, most with crossings.
fn scenes() -> Vec<[Shape; 2]> {
    let stick = capsule(3.0, 30.0, 24).rotated(DVec3::Y, 0.11);
    let turned = cube(12.0).rotated(DVec3::new(1.0, 1.0, 0.2).normalize(), 0.07);
    let mut scenes = vec![
        [Shape::new(octasphere(10.0, 3)), Shape::new(stick.translated(DVec3::new(8.0, 1.0, 2.0)))],
        [Shape::new(plate(DVec3::new(30.0, 30.0, 2.0), [6, 6])), Shape::new(turned)],
    ];
    scenes.extend([25.0, 19.5, 15.0, 5.0].map(spheres));
    scenes
}

#[test]
fn hashing_finds_every_crossing_whatever_the_cells() {
    let mut crossings = 0;
    for [a, b] in scenes() {
        let expected = reference::crossing_faces(&a.mesh, &b.mesh);
        crossings += expected.len();
        for (cell_size, slots) in [(0.7, 4001), (3.0, 4001), (3.0, 1), (100.0, 17)] {
            let params = SpatialHashParams { cell_size, slots };
            let found = spatial_hash::detect(a.body(), b.body(), &params).unwrap();
            assert_eq!(found.crossing_faces.as_ref(), Some(&expected), "cells of {cell_size}");
            assert_eq!(found.overlap, !expected.is_empty());
        }
    }
    assert!(crossings > 200, "the scenes cross: {crossings}");
}

#[test]
fn vertices_inside_spread_from_crossings() {
    let params = SpatialHashParams { cell_size: 3.0, slots: 4001 };
    for [a, b] in scenes() {
        let found = spatial_hash::detect(a.body(), b.body(), &params).unwrap();
        let [of_a, of_b] = inside_of(&found);
        assert_eq!(vertices(of_a), reference::vertices_inside(&a.mesh, &b.mesh));
        assert_eq!(vertices(of_b), reference::vertices_inside(&b.mesh, &a.mesh));
    }
}

/// Two spheres of radius 10 with middles 15 apart are 5 deep; spreading from a
/// rim where surfaces meet at a slant makes that more.
#[test]
fn depths_spread_from_crossings_are_near_the_true_ones() {
    let params = SpatialHashParams { cell_size: 3.0, slots: 4001 };
    let [a, b] = spheres(15.0);
    let found = spatial_hash::detect(a.body(), b.body(), &params).unwrap();
    let deepest = reference::deepest_vertex(&a.mesh, &b.mesh).expect("they overlap").distance;
    let depth = max_depth(&found);
    assert!((0.9..1.3).contains(&(depth / deepest)), "{depth} for {deepest}");
}

fn max_depth(found: &PairFindings) -> f64 {
    inside_of(found).iter().flatten().map(|inside| inside.depth).fold(0.0, f64::max)
}

/// Returns the volume that two spheres share, from the height of their caps.
fn lens(radius: f64, apart: f64) -> f64 {
    let height = radius - 0.5 * apart;
    2.0 * std::f64::consts::PI * height * height * (radius - height / 3.0)
}

#[test]
fn volumes_of_boxes_are_exact_where_pixels_fit() {
    let a = Shape::new(cube(8.0));
    for axis in DVec3::AXES {
        let b = Shape::new(cube(8.0).translated(DVec3::splat(4.0) + axis));
        let params = LayeredDepthParams { resolution: 16 };
        let found = layered_depth::detect(a.body(), b.body(), &params).unwrap();
        let volume = found.volume.expect("images give volumes");
        assert!((volume - 48.0).abs() < 1e-9, "{volume} along {axis}");
    }
}

/// The corner of a cube of half the height along the rays: the sum over the centers of 16 x 16
/// pixels is half of 42.5 / 256 in closed form, along each axis.
#[test]
fn rays_pass_the_centers_of_pixels() {
    let all = Shape::new(cube(4.0));
    for axis in DVec3::AXES {
        let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let corner = Shape::new(Mesh { positions, faces }.scaled(DVec3::ONE - 0.5 * axis));
        let params = LayeredDepthParams { resolution: 16 };
        let found = layered_depth::detect(corner.body(), all.body(), &params).unwrap();
        let volume = found.volume.expect("images give volumes");
        assert!((volume - 21.25 / 256.0).abs() < 1e-12, "{volume} along {axis}");
    }
}

#[test]
fn volumes_of_spheres_converge() {
    let sphere = |by: f64| Shape::new(octasphere(10.0, 5).translated(DVec3::X * by));
    let (a, b) = (sphere(0.0), sphere(12.0));
    let expected = lens(10.0, 12.0);
    for (resolution, worst) in [(16, 0.04), (64, 0.015), (256, 0.01)] {
        let params = LayeredDepthParams { resolution };
        let found = layered_depth::detect(a.body(), b.body(), &params).unwrap();
        let error = found.volume.expect("images give volumes") / expected - 1.0;
        assert!(error.abs() < worst, "off by {error} at {resolution}");
    }
}

/// A vertex within half a pixel of the surface may be placed wrongly, no other.
#[test]
fn images_place_vertices_up_to_a_pixel() {
    let [a, b] = spheres(12.0);
    let params = LayeredDepthParams { resolution: 256 };
    let found = layered_depth::detect(a.body(), b.body(), &params).unwrap();
    for (inside, mesh, other) in
        [(&inside_of(&found)[0], &a.mesh, &b.mesh), (&inside_of(&found)[1], &b.mesh, &a.mesh)]
    {
        let (found, expected) = (vertices(inside), reference::vertices_inside(mesh, other));
        assert!(expected.len() > 20, "many are inside");
        let wrong = (0..u32::try_from(mesh.positions.len()).unwrap())
            .filter(|v| found.contains(v) != expected.contains(v));
        for vertex in wrong {
            let x = mesh.positions[vertex as usize];
            let distance = reference::closest(other, x).expect("it has faces").distance;
            assert!(distance < 0.04, "vertex {vertex} is {distance} from the surface");
        }
        for VertexInside { vertex, depth } in inside {
            let x = mesh.positions[*vertex as usize];
            let distance = reference::closest(other, x).expect("it has faces").distance;
            assert!(*depth >= distance - 0.1, "{depth} along a ray, {distance} at least");
        }
    }
}

#[test]
fn images_find_a_body_within_another() {
    let (a, b) = (Shape::new(cube(10.0)), Shape::new(cube(2.0)));
    let found = layered_depth::detect(a.body(), b.body(), &LayeredDepthParams::DEFAULT).unwrap();
    assert!((found.volume.expect("images give volumes") - 8.0).abs() < 1e-9);
    assert_eq!(inside_of(&found)[1].len(), b.mesh.positions.len());
    assert!((max_depth(&found) - 4.0).abs() < 1e-9);
}

fn average_case(a: &Shape, b: &Shape, params: &AverageCaseParams) -> PairFindings {
    let trees = [a, b].map(|shape| AverageCaseTree::new(shape.body(), params).expect("valid"));
    trees[0].detect(a.body(), &trees[1], b.body(), params).expect("valid")
}

#[test]
fn trees_with_acceptance_one_are_exact() {
    let params = AverageCaseParams { acceptance: 1.0, ..AverageCaseParams::DEFAULT };
    for [a, b] in scenes() {
        let expected = !reference::crossing_faces(&a.mesh, &b.mesh).is_empty();
        let found = average_case(&a, &b, &params);
        assert_eq!((found.overlap, found.probability), (expected, Some(f64::from(expected))));
    }
}

/// Over spheres from apart to deep, a higher acceptance costs more tests. No overlap is reported
/// where boxes are apart.
#[test]
fn trees_trade_certainty_for_tests() {
    let tests = |acceptance: f64| {
        let params = AverageCaseParams { acceptance, ..AverageCaseParams::DEFAULT };
        let found = (0..12).map(|i| {
            let [a, b] = spheres(22.0 - f64::from(i));
            average_case(&a, &b, &params).tests
        });
        found.sum::<u64>()
    };
    assert!(tests(0.1) < tests(1.0), "{} and {}", tests(0.1), tests(1.0));
    let [a, b] = spheres(60.0);
    assert!(!average_case(&a, &b, &AverageCaseParams::DEFAULT).overlap);
    let [a, b] = spheres(10.0);
    let spent = AverageCaseParams { max_tests: 1, acceptance: 1.0, ..AverageCaseParams::DEFAULT };
    let found = average_case(&a, &b, &spent);
    assert!(!found.overlap && found.probability > Some(0.0), "{found:?}");
}

/// Returns the mean share of the crossings found in one step, over a number of seeds.
fn recall([a, b]: &[Shape; 2], expected: &[[u32; 2]], draws: u32, max_moves: u32) -> f64 {
    const SEEDS: u32 = 8;
    let params = SelectedPairsParams { draws, max_moves, ..SelectedPairsParams::new(5.0) };
    let found = (0..SEEDS).map(|seed| {
        let mut pairs = SelectedPairs::new(u64::from(seed));
        let found = pairs.step(a.body(), b.body(), &params).expect("valid").crossing_faces;
        let found = found.expect("pairs report crossings");
        assert!(found.iter().all(|pair| expected.contains(pair)), "no crossing is made up");
        let count = |pairs: &[[u32; 2]]| u32::try_from(pairs.len()).expect("few");
        f64::from(count(&found)) / f64::from(count(expected))
    });
    found.sum::<f64>() / f64::from(SEEDS)
}

#[test]
fn recall_grows_with_the_budget_to_all() {
    let bodies = spheres(17.0);
    let expected = reference::crossing_faces(&bodies[0].mesh, &bodies[1].mesh);
    let few = recall(&bodies, &expected, 20, 0);
    let some = recall(&bodies, &expected, 2_000, 0);
    let many = recall(&bodies, &expected, 2_000, 40);
    assert!(few <= some && some <= many, "{few} {some} {many}");
    assert!(few < 0.5 && many > 0.9, "{few} {some} {many}");

    // All pairs are drawn, whatever the seed.
    let [a, b] = bodies;
    let params =
        SelectedPairsParams { draws: u32::MAX, max_moves: 0, ..SelectedPairsParams::new(5.0) };
    let found = SelectedPairs::new(0).step(a.body(), b.body(), &params).unwrap();
    let all = a.mesh.faces.len() * b.mesh.faces.len();
    assert!(found.tests >= u64::try_from(all).unwrap(), "{} of {all} pairs", found.tests);
    let crossings = found.crossing_faces.expect("pairs report crossings");
    assert!(expected.iter().all(|pair| crossings.contains(pair)), "some crossings are missing");
}

#[test]
fn pairs_are_followed_from_step_to_step() {
    let [a, b] = spheres(17.0);
    let params = SelectedPairsParams { draws: 300, ..SelectedPairsParams::new(5.0) };
    let mut pairs = SelectedPairs::new(7);
    for _ in 0..20 {
        pairs.step(a.body(), b.body(), &params).unwrap();
    }
    let followed = SelectedPairsParams { draws: 1, ..params };
    let found = pairs.step(a.body(), b.body(), &followed).unwrap();
    assert!(found.overlap, "{found:?}");
    let spent = SelectedPairsParams { max_tests: 50, ..params };
    let found = pairs.step(a.body(), b.body(), &spent).unwrap();
    assert!(found.tests < 150, "{} tests", found.tests);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let [a, b] = spheres(17.0);
    let run = |seed: u64| {
        let mut pairs = SelectedPairs::new(seed);
        let params = SelectedPairsParams { draws: 50, ..SelectedPairsParams::new(5.0) };
        let found = (0..3).map(|_| pairs.step(a.body(), b.body(), &params).unwrap());
        found.collect::<Vec<_>>()
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn parameters_out_of_range_and_open_surfaces_are_refused() {
    let (a, b) = (Shape::new(cube(8.0)), Shape::new(cube(6.0)));
    let hash = |cell_size, slots| {
        spatial_hash::detect(a.body(), b.body(), &SpatialHashParams { cell_size, slots })
    };
    let refused = |result: Result<PairFindings, BaselineError>| result.unwrap_err().to_string();
    assert_eq!(refused(hash(0.0, 100)), "cell size is 0, but must be a finite length above 0");
    assert_eq!(refused(hash(1.0, 0)), "slots is 0, but must be in 1..=2^26");
    assert!(
        matches!(hash(1e-4, 100), Err(BaselineError::TooManyCells { .. })),
        "{:?}",
        hash(1e-4, 100)
    );
    assert!(matches!(hash(1e-300, 100), Err(BaselineError::TooManyCells { .. })));

    let open = Shape::new(fixtures::damage::hole(octasphere(5.0, 2), DVec3::X * 5.0, 2.0));
    let image = |resolution| LayeredDepthParams { resolution };
    let error = refused(layered_depth::detect(a.body(), open.body(), &image(64)));
    assert!(error.starts_with("the surface is open"), "{error}");
    let error = refused(layered_depth::detect(a.body(), b.body(), &image(10_000)));
    assert_eq!(error, "resolution is 10000, but must be in 1..=8192");

    let params = AverageCaseParams { acceptance: 0.0, ..AverageCaseParams::DEFAULT };
    let error = AverageCaseTree::new(a.body(), &params).unwrap_err().to_string();
    assert_eq!(error, "acceptance is 0, but must be above 0 and at most 1");
    let params = SelectedPairsParams { margin: -1.0, ..SelectedPairsParams::new(5.0) };
    let error = refused(SelectedPairs::new(0).step(a.body(), b.body(), &params));
    assert_eq!(error, "margin is -1, but must be a finite length of at least 0");
}
