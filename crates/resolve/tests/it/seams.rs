//! Soft bodies that are tied along common faces, with bone across their seams.

use std::collections::BTreeMap;

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{Conditions, FixedVertices, Obstacle, Resolution, ResolveParams, Resolver, Tie};
use scene::{BodyId, BodyKind, Scene};
use surface::progress::Progress;

use crate::gap::brute_distance;
use crate::{PARAMS, scene_of};

const GAP: f64 = 0.05;
const WITH_GAP: ResolveParams = ResolveParams { gap: GAP, ..PARAMS };

/// Builds the surface of a box of unit cubes along the axes, between two corners. Boxes side by side have the faces
/// between them in common.
fn block(from: [i32; 3], to: [i32; 3]) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), faces: Vec::new() };
    let mut known: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for (side, is_upper) in [(from[axis], false), (to[axis], true)] {
            for (i, j) in (from[u]..to[u]).flat_map(|i| (from[v]..to[v]).map(move |j| (i, j))) {
                let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|corner| {
                    let mut place = [side; 3];
                    [place[u], place[v]] = corner;
                    *known.entry(place).or_insert_with(|| {
                        mesh.positions.push(DVec3::from(place.map(f64::from)));
                        u32::try_from(mesh.positions.len() - 1).expect("few vertices")
                    })
                });
                mesh.faces.extend(match is_upper {
                    true => [[a, b, c], [a, c, d]],
                    false => [[a, c, b], [a, d, c]],
                });
            }
        }
    }
    mesh
}

/// Soft boxes that are tied to each other where they touch, and a bone.
struct Tied {
    scene: Scene,
    soft: Vec<BodyId>,
    bone: BodyId,
    conditions: Conditions,
}

impl Tied {
    fn new(boxes: &[[[i32; 3]; 2]], bone: Mesh) -> Self {
        const NAMES: [&str; 4] = ["a", "b", "c", "d"];
        let boxes = boxes.iter().map(|[from, to]| block(*from, *to));
        let soft =
            NAMES.into_iter().zip(boxes).map(|(name, mesh)| (name, BodyKind::Deformable, mesh));
        let scene = scene_of(soft.chain([("bone", BodyKind::Rigid, bone)]));
        let mut soft: Vec<BodyId> = scene.ids().collect();
        let bone = soft.pop().expect("a bone");
        let mut conditions = Conditions::default();
        for (number, &a) in soft.iter().enumerate() {
            for &b in &soft[..number] {
                conditions.ties.push(Tie { bodies: [a, b], distance: f64::MIN_POSITIVE });
            }
        }
        Self { scene, soft, bone, conditions }
    }

    /// Two boxes side by side.
    fn two(bone: Mesh) -> Self {
        Self::new(&[[[-8, -4, -4], [0, 4, 0]], [[0, -4, -4], [8, 4, 0]]], bone)
    }

    fn resolve(&mut self) -> Resolution {
        let resolver = Resolver::new(WITH_GAP).expect("parameters");
        let mut resolver = resolver.with_conditions(self.conditions.clone());
        resolver.resolve(&mut self.scene, Progress::none()).expect("a resolution")
    }

    /// Resolves, and checks that each box keeps the gap to the bone, its volume, and its place at the others.
    fn assert_apart(mut self, place: &str) {
        let start: Vec<_> = self.scene.bodies().iter().map(|it| it.positions().to_vec()).collect();
        let resolution = self.resolve();
        assert!(resolution.resolved, "{place}: {:?} {:?}", resolution.gap, resolution.gap_rounds);
        for &id in &self.soft {
            let distance = brute_distance(&self.scene, id, self.bone);
            assert!(distance >= GAP, "{place}: {distance}");
            let ratio = resolution.bodies[id.index()].volume_ratio.expect("a closed body");
            assert!((ratio - 1.0).abs() < 0.01, "{place}: volume times {ratio}");
        }

        // Vertices that were at one place still are, to the bit.
        let mut ends: BTreeMap<[u64; 3], DVec3> = BTreeMap::new();
        let mut moved = 0;
        for (start, body) in start.iter().zip(self.scene.bodies()).take(self.soft.len()) {
            for (from, to) in start.iter().zip(body.positions()) {
                let known = ends.insert(from.to_array().map(f64::to_bits), *to);
                assert!(known.is_none_or(|known| known == *to), "{place}: {known:?} and {to}");
                moved += usize::from(known.is_some() && from != to);
            }
        }
        assert!(moved > 3, "{place}: {moved} vertices of a seam have moved");
    }
}

/// Builds a bar of bone, with square ends 2 wide.
fn bar(length: f64) -> Mesh {
    shapes::plate(DVec3::new(2.0, length, 2.0), [3, 9])
}

#[test]
fn bone_across_a_seam_is_taken_off_both_sides() {
    let ball =
        |x: f64, depth: f64| shapes::icosphere(3.0, 3).translated(DVec3::new(x, 0.02, 3.0 - depth));
    Tied::two(ball(0.0, 0.5)).assert_apart("a ball in the middle of the seam");
    Tied::two(ball(0.8, 0.9)).assert_apart("a ball beside it");
    let post = shapes::plate(DVec3::new(4.0, 4.0, 2.0), [5, 5]);
    Tied::two(post.translated(DVec3::new(0.1, -0.1, 0.2))).assert_apart("a post");
    for (turn, x) in [(0.0, 0.5), (0.11, 0.2), (0.25, -0.1)] {
        let ridge = bar(12.0).rotated(DVec3::Y, 0.125).rotated(DVec3::Z, turn);
        let ridge = ridge.translated(DVec3::new(x, 0.1, 0.9));
        Tied::two(ridge).assert_apart(&format!("an edge by {turn} turns to the seam"));
    }
}

/// A post is narrower than the elements, and deeper than it is wide: its nearest ways out of each box lead into others.
#[test]
fn bone_leaves_by_no_face_that_has_a_body_behind_it() {
    let boxes = [-8, 0].map(|x| [[[x, -6, -4], [x + 8, 6, -2]], [[x, -6, -2], [x + 8, 6, 0]]]);
    for depth in [0.4, 0.9, 1.4, 1.8] {
        for (turn, x) in [(0.0, 0.0), (0.05, 0.13), (0.1, -0.07)] {
            let post = shapes::plate(DVec3::new(0.9, 0.9, 3.0), [2, 2]).rotated(DVec3::Z, turn);
            let post = post.translated(DVec3::new(x, 0.2, 1.5 - depth));
            let place = format!("{depth} deep, turned by {turn}");
            Tied::new(boxes.as_flattened(), post).assert_apart(&place);
        }
    }
}

#[test]
fn bone_where_three_bodies_meet_is_taken_off_all() {
    let boxes = [[[-8, -6, -4], [0, 6, 0]], [[0, -6, -4], [8, 0, 0]], [[0, 0, -4], [8, 6, 0]]];
    let ball = shapes::icosphere(3.0, 3).translated(DVec3::new(0.1, 0.2, 2.3));
    Tied::new(&boxes, ball).assert_apart("a ball");
    let ridge = bar(12.0).rotated(DVec3::Y, 0.125).rotated(DVec3::Z, 0.19);
    Tied::new(&boxes, ridge.translated(DVec3::new(0.2, 0.1, 0.8))).assert_apart("an edge");
}

#[test]
fn a_seam_ends_in_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let bone = shapes::icosphere(9.0, 3).translated(DVec3::new(0.3, 0.2, 8.0));
            let boxes = [[[-24, -16, -4], [0, 16, 0]], [[0, -16, -4], [24, 16, 0]]];
            let mut tied = Tied::new(&boxes, bone);
            assert!(tied.resolve().resolved, "on {threads} threads");
            tied.scene.particle_positions()
        })
    };
    let one = run(1);
    for threads in [2, 5] {
        assert!(one == run(threads), "{threads} threads");
    }
}

/// The bone is above a vertex of the seam that is fixed in one body only.
#[test]
fn a_vertex_that_is_fixed_in_one_body_is_in_the_other() {
    let bone = shapes::icosphere(3.0, 3).translated(DVec3::new(2.5, 0.0, 2.5));
    let mut tied = Tied::two(bone);
    let fixed = |id: &BodyId, scene: &Scene| {
        let x = scene.body(*id).positions();
        let is_there = |x: &DVec3| *x == DVec3::ZERO;
        u32::try_from(x.iter().position(is_there).expect("a vertex")).expect("few vertices")
    };
    let vertices = [0, 1].map(|k| fixed(&tied.soft[k], &tied.scene));
    let one = FixedVertices { body: tied.soft[1], vertices: vec![vertices[1]] };
    tied.conditions.fixed.push(one);
    let resolution = tied.resolve();
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.gap_rounds);
    for (id, vertex) in tied.soft.iter().zip(vertices) {
        assert_eq!(tied.scene.body(*id).positions()[vertex as usize], DVec3::ZERO);
    }
    assert!(resolution.bodies[0].moved > 0, "the other body moves beside it");
}

/// Soft plates that touch along meshes that differ, tied to each other, and a bone in the upper one: where they bend, corners
/// of one would be below faces of the other.
#[test]
fn bodies_tied_along_meshes_that_differ_yield_together() {
    for depth in [0.02, 0.3, 1.0] {
        let plate = |thickness: f64, cells: u32, z: f64| {
            let plate = shapes::plate(DVec3::new(20.0, 20.0, thickness), [cells, cells]);
            plate.translated(z * DVec3::Z)
        };
        let bone = shapes::icosphere(8.0, 3).translated(DVec3::new(0.3, 0.2, 10.0 - depth));
        let mut scene = scene_of([
            ("upper", BodyKind::Deformable, plate(2.0, 13, 1.0)),
            ("lower", BodyKind::Deformable, plate(4.0, 10, -2.0)),
            ("bone", BodyKind::Rigid, bone),
        ]);
        let ids: Vec<BodyId> = scene.ids().collect();
        let ties = vec![Tie { bodies: [ids[0], ids[1]], distance: 0.1 }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let resolver = Resolver::new(WITH_GAP).expect("parameters");
        let mut resolver = resolver.with_conditions(conditions);
        let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
        assert!(resolution.resolved, "{depth}: {:?} {:?}", resolution.rounds, resolution.remaining);
        assert!(brute_distance(&scene, ids[0], ids[2]) >= GAP, "{depth}");
        assert!(resolution.bodies[1].moved > 0, "{depth}: the lower plate yields");
        for left in &resolution.remaining {
            let is_of_tie = left.obstacle == Obstacle::Tied && left.depth.upper < 1e-6;
            assert!(is_of_tie, "{depth}: {left:?}");
        }
    }
}
