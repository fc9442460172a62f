//! Gaps planted so that one failure would show: edges that are nearer than all vertices, faces that
//! are nearer than both, a body between two others, ties, fixed vertices.

use fixtures::{Mesh, labels, shapes};
use glam::DVec3;
use kdop::Workspace;
use proximity::{SeparationBounds, SurfaceTree};
use resolve::{
    BodyChange, Conditions, FixedVertices, GapObstacle, Resolution, ResolveError, ResolveParams,
    Resolver, Tie, WrittenPrecision,
};
use scene::{BodyId, BodyKind, PairId, Scene};
use surface::closest_between_triangles;
use surface::progress::Progress;

use crate::thigh::planted;
use crate::{PARAMS, scene_of};

const GAP: f64 = 0.05;
const WITH_GAP: ResolveParams = ResolveParams { gap: GAP, ..PARAMS };

fn resolve(scene: &mut Scene, conditions: Conditions) -> Resolution {
    let mut resolver = Resolver::new(WITH_GAP).expect("parameters").with_conditions(conditions);
    resolver.resolve(scene, Progress::none()).expect("a resolution")
}

/// Computes the distance of two bodies by all pairs of their faces.
pub(crate) fn brute_distance(scene: &Scene, a: BodyId, b: BodyId) -> f64 {
    let [a, b] = [a, b].map(|id| scene.body(id));
    let count = |body: &scene::Body| u32::try_from(body.surface().faces().len()).expect("few");
    let mut distance = f64::INFINITY;
    for face_a in 0..count(a) {
        for face_b in 0..count(b) {
            let feet = closest_between_triangles(a.corners(face_a), b.corners(face_b));
            distance = distance.min(feet.distance());
        }
    }
    distance
}

/// Checks that all pairs keep the gap, by certified bounds.
fn assert_all_apart(scene: &Scene) {
    let trees = scene.bodies().iter().map(|body| {
        SurfaceTree::new(body.surface().clone(), body.positions().to_vec()).expect("a tree")
    });
    let trees: Vec<SurfaceTree> = trees.collect();
    for (i, a) in trees.iter().enumerate() {
        for b in &trees[..i] {
            let bounds = SeparationBounds::compute(a, b, GAP, &mut Workspace::default());
            assert!(bounds.is_none_or(|bounds| bounds.lower >= GAP), "{bounds:?}");
        }
    }
}

/// Two bodies whose surfaces are at a distance below the gap, soft above rigid.
fn bone_below(bone: Mesh, muscle: Mesh) -> (Scene, [BodyId; 2]) {
    let bodies = [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)];
    let scene = scene_of(bodies);
    let ids = ["bone", "muscle"].map(|name| scene.find(name).expect("a body of the scene"));
    (scene, ids)
}

/// Checks the proof against all pairs of faces, and that shapes are kept.
fn assert_gap(scene: &Scene, resolution: &Resolution, [a, b]: [BodyId; 2]) {
    assert!(resolution.resolved && resolution.gap.holds(), "{:?}", resolution.gap_rounds);
    let distance = brute_distance(scene, a, b);
    assert!(distance >= GAP, "{distance}");
    assert!(distance < 1.5 * GAP, "little farther than was asked: {distance}");
    for change in &resolution.bodies {
        assert_eq!(change.flipped_faces, 0, "{:?}", change.body);
        assert_eq!(change.self_crossings, [0, 0], "{:?}", change.body);
        let ratio = change.volume_ratio.expect("closed");
        assert!((ratio - 1.0).abs() < 0.002, "volume times {ratio}");
    }
}

#[test]
fn edges_nearer_than_all_vertices_are_brought_to_the_gap() {
    // Two octahedra whose edges cross at right angles, 0.01 apart.
    let bone = shapes::octasphere(10.0, 0).rotated(DVec3::Y, 0.125);
    let edge = 10.0 / f64::sqrt(2.0);
    let muscle = bone.clone().rotated(DVec3::Z, 0.25).translated(DVec3::Z * (2.0 * edge + 0.01));
    let (mut scene, ids) = bone_below(bone, muscle);
    assert!((brute_distance(&scene, ids[0], ids[1]) - 0.01).abs() < 1e-9, "by edges");
    let resolution = resolve(&mut scene, Conditions::default());
    assert_gap(&scene, &resolution, ids);
}

#[test]
fn a_vertex_over_the_middle_of_a_face_is_brought_to_the_gap() {
    let bone = shapes::plate(DVec3::new(60.0, 60.0, 6.0), [2, 2]).translated(DVec3::Z * -3.0);
    let muscle = shapes::icosphere(8.0, 3);
    let lowest = muscle.positions.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
    let muscle = muscle.translated(DVec3::new(3.0, 11.0, 0.02 - lowest));
    let (mut scene, ids) = bone_below(bone, muscle);
    let resolution = resolve(&mut scene, Conditions::default());
    assert_gap(&scene, &resolution, ids);
}

#[test]
fn overlaps_are_freed_and_brought_to_the_gap() {
    let bone = shapes::icosphere(10.0, 3);
    let muscle = shapes::icosphere(10.0, 3).rotated(DVec3::Z, 0.1).translated(DVec3::X * 18.6);
    let (mut scene, ids) = bone_below(bone, muscle);
    let resolution = resolve(&mut scene, Conditions::default());
    assert_gap(&scene, &resolution, ids);
}

#[test]
fn bodies_cut_out_of_one_image_are_brought_to_the_gap() {
    let [bone, muscle, other] = labels::limb(6);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, bone),
        ("muscle", BodyKind::Deformable, muscle),
        ("other", BodyKind::Deformable, other),
    ]);
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(resolution.resolved, "{:?}", resolution.gap_rounds);
    assert_all_apart(&scene);

    // Round by round, faces that are shared come apart.
    let touching: Vec<usize> = resolution.rounds.iter().map(|round| round.touching_faces).collect();
    assert!(touching[0] > 1000 && touching[touching.len() - 1] == 0, "{touching:?}");

    // All opens at once or nearly so: no corner is thrown far for the little that an edge misses.
    assert!(resolution.gap_rounds.len() < 8, "{:?}", resolution.gap_rounds);
    for change in &resolution.bodies {
        assert!(change.max_displacement < 0.5, "{}", change.max_displacement);
    }
}

/// Two halves of a plate along a zigzag, with all vertices there on its ridges: a suture of a skull.
fn suture(teeth: u32, height: f64) -> [Mesh; 2] {
    let mut line = Vec::new();
    for number in 0..=2 * teeth {
        let side = if number % 2 == 0 { -1.0 } else { 1.0 };
        line.push([side * height, 4.0 * f64::from(number)]);
    }
    [-20.0, 20.0].map(|end: f64| {
        // Upper and lower corners of the line, then of the straight end.
        let mut positions = Vec::new();
        for x_of in [|x: f64, _| x, |_, end: f64| end] {
            for &[x, y] in &line {
                for z in [0.0, 5.0] {
                    positions.push(DVec3::new(x_of(x, end), y, z));
                }
            }
        }
        let behind = 2 * u32::try_from(line.len()).expect("few points");
        let mut faces = Vec::new();
        let mut add = |[a, b, c, d]: [u32; 4]| faces.extend([[a, b, c], [a, c, d]]);
        for low in (0..behind - 2).step_by(2) {
            add([low, low + 2, low + 3, low + 1]);
            add([low + 1, low + 3, low + 3 + behind, low + 1 + behind]);
            add([low + behind, low + 2 + behind, low + 2, low]);
            add([low + 1 + behind, low + 3 + behind, low + 2 + behind, low + behind]);
        }
        add([0, 1, 1 + behind, behind]);
        add([behind - 2, 2 * behind - 2, 2 * behind - 1, behind - 1]);
        let half = Mesh { positions, faces };
        if end < 0.0 { half } else { half.flipped() }
    })
}

/// At a ridge, the nearest face of a vertex may be the other one of two.
#[test]
fn halves_that_share_a_zigzag_are_brought_to_the_gap() {
    for height in [0.5, 2.0, 4.0] {
        let [bone, muscle] = suture(4, height);
        assert!(bone.volume() > 3000.0 && muscle.volume() > 3000.0, "{height}");
        let (mut scene, ids) = bone_below(bone, muscle);
        let resolution = resolve(&mut scene, Conditions::default());
        assert_eq!(resolution.rounds[0].touching_faces, 2 * 2 * 8, "{height}");
        assert_gap(&scene, &resolution, ids);
    }
}

#[test]
fn every_pair_of_a_thigh_keeps_the_gap_by_all_faces() {
    let mut scene = planted();
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.gap_rounds);
    assert_all_apart(&scene);
    let depth = resolution.rounds[0].surface_depth.expect("overlaps").lower;
    for change in &resolution.bodies {
        assert_eq!((change.flipped_faces, change.self_crossings), (0, [0, 0]));
        assert!((change.volume_ratio.expect("closed") - 1.0).abs() < 0.002);
        let displacement = change.max_displacement / depth;
        assert!(displacement <= 1.3, "{displacement} of the deepest overlap");
    }
}

#[test]
fn the_gap_holds_at_the_written_precision() {
    let far = DVec3::new(700.3, -650.1, 800.7);
    let bone = shapes::icosphere(10.0, 3).translated(far);
    let muscle = shapes::icosphere(10.0, 3).translated(far + DVec3::X * 20.01);
    let (mut scene, [a, b]) = bone_below(bone, muscle);
    let params = ResolveParams { precision: WrittenPrecision::Single, ..WITH_GAP };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("a resolution");
    assert!(resolution.resolved, "{:?}", resolution.gap);
    for x in scene.body(b).positions() {
        assert_eq!(x.as_vec3().as_dvec3(), *x, "representable");
    }

    // The bone is written rounded as well.
    let rounded: Vec<DVec3> =
        scene.body(a).positions().iter().map(|x| x.as_vec3().as_dvec3()).collect();
    assert_ne!(scene.body(a).positions(), rounded, "the bone itself stays");
    scene.move_body(a, &rounded).expect("finite");
    assert!(brute_distance(&scene, a, b) >= GAP);
}

/// Two muscles beside a bone, of which one is written in double precision, and held at half of its vertices.
#[test]
fn what_is_written_in_double_precision_is_not_rounded() {
    let far = DVec3::new(70.3, -65.1, 80.7);
    let ball = |at: DVec3| shapes::icosphere(10.0, 2).translated(far + at);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, ball(DVec3::ZERO)),
        ("single", BodyKind::Deformable, ball(19.7 * DVec3::X)),
        ("double", BodyKind::Deformable, ball(19.8 * DVec3::Y)),
    ]);
    let [_, single, double] =
        ["bone", "single", "double"].map(|name| scene.find(name).expect("a body"));
    let start = scene.body(double).positions().to_vec();
    let is_held = |vertex: u32| start[vertex as usize].y > far.y + 19.8;
    let vertices = (0..).take(start.len()).filter(|vertex| is_held(*vertex)).collect();
    let conditions = Conditions {
        fixed: vec![FixedVertices { body: double, vertices }],
        unrounded: vec![double],
        ..Conditions::default()
    };
    let params = ResolveParams { precision: WrittenPrecision::Single, ..WITH_GAP };
    let mut resolver = Resolver::new(params).expect("parameters").with_conditions(conditions);
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    assert!(resolution.resolved, "{:?}", resolution.gap);

    let is_rounded = |x: &DVec3| x.as_vec3().as_dvec3() == *x;
    assert!(scene.body(single).positions().iter().all(is_rounded));
    let (mut held, mut moved) = (0, 0);
    for (vertex, (x, start)) in (0..).zip(scene.body(double).positions().iter().zip(&start)) {
        assert!(x == start || !is_held(vertex), "{vertex} moved");
        held += usize::from(is_held(vertex));
        moved += usize::from(x != start);
    }
    assert!(held > 70 && moved > 9 && moved == resolution.bodies[2].moved, "{held} {moved}");

    // Of the files, the same is measured.
    let change = BodyChange::since(&mut scene, double, &start, Progress::none());
    assert_eq!(change.as_ref(), Ok(&resolution.bodies[2]));
    let short = BodyChange::since(&mut scene, double, &start[1..], Progress::none());
    assert!(matches!(short, Err(ResolveError::Scene(_))), "{short:?}");
}

/// A disc of tissue 4 thick between two bones.
fn between_bones(room: f64) -> Scene {
    let bone = shapes::plate(DVec3::new(60.0, 60.0, 6.0), [12, 12]);
    let muscle = shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3);
    let up = DVec3::Z * (3.0 + room / 2.0);
    scene_of([
        ("below", BodyKind::Rigid, bone.clone().translated(-up)),
        ("above", BodyKind::Rigid, bone.translated(up)),
        ("muscle", BodyKind::Deformable, muscle),
    ])
}

#[test]
fn tissue_between_two_bones_keeps_the_gap_to_both() {
    let mut scene = between_bones(4.02);
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.gap_rounds);
    let [below, above, muscle] =
        ["below", "above", "muscle"].map(|name| scene.find(name).expect("a body"));
    for bone in [below, above] {
        assert!(brute_distance(&scene, bone, muscle) >= GAP);
    }
    let ratio = resolution.bodies[2].volume_ratio.expect("closed");
    assert!((ratio - 1.0).abs() < 0.002, "volume times {ratio}");
}

#[test]
fn bones_nearer_than_the_gap_are_named_with_their_distance() {
    let cube = shapes::cube(10.0);
    let other = cube.clone().translated(DVec3::X * 10.02);
    let mut scene = scene_of([("a", BodyKind::Rigid, cube), ("b", BodyKind::Rigid, other)]);
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(!resolution.resolved && resolution.remaining.is_empty());
    let [short] = resolution.gap.short[..] else { panic!("{:?}", resolution.gap) };
    assert_eq!(short.obstacle, GapObstacle::BothRigid);
    assert!(short.distance.lower <= 0.02 && (short.distance.upper - 0.02).abs() < 1e-9);

    // Left out of everything where the pair is ignored.
    scene.ignore(short.pair.a, short.pair.b);
    assert!(resolve(&mut scene, Conditions::default()).resolved);
}

#[test]
fn fixed_vertices_stay_and_are_named_as_the_reason() {
    let bone = shapes::icosphere(10.0, 2);
    let muscle = shapes::icosphere(10.0, 2).translated(DVec3::X * 20.01);
    let (mut scene, [bone, muscle]) = bone_below(bone, muscle);
    let vertices = (0..).take(scene.body(muscle).positions().len()).collect();
    let fixed = vec![FixedVertices { body: muscle, vertices }];
    let before = scene.particle_positions();
    let resolution = resolve(&mut scene, Conditions { fixed, ..Conditions::default() });
    assert_eq!(scene.particle_positions(), before);
    assert_eq!(resolution.gap.short[0].pair, PairId::new(bone, muscle));
    assert_eq!(resolution.gap.short[0].obstacle, GapObstacle::Fixed);
}

#[test]
fn tied_bodies_move_together() {
    // Cartilage on a muscle, which a bone pushes from the other side.
    let plate = |thickness: f64, cells: u32| {
        shapes::plate(DVec3::new(20.0, 20.0, thickness), [cells, cells])
    };
    let bone = plate(4.0, 9).translated(DVec3::Z * -2.0);
    let muscle = plate(4.0, 10).translated(DVec3::Z * 2.01);
    let cartilage = plate(1.0, 11).translated(DVec3::Z * 4.52);
    let mut scene = scene_of([
        ("bone", BodyKind::Rigid, bone),
        ("muscle", BodyKind::Deformable, muscle),
        ("cartilage", BodyKind::Deformable, cartilage),
    ]);
    let [bone, muscle, cartilage] =
        ["bone", "muscle", "cartilage"].map(|name| scene.find(name).expect("a body"));
    let tie = Tie { bodies: [cartilage, muscle], distance: 0.1 };
    let resolution = resolve(&mut scene, Conditions { ties: vec![tie], ..Conditions::default() });
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.gap_rounds);
    assert!(brute_distance(&scene, bone, muscle) >= GAP);
    let between = brute_distance(&scene, muscle, cartilage);
    assert!((between - 0.01).abs() < 4e-3, "{between} instead of 0.01");
    let [count] = resolution.ties[..] else { panic!("one tie: {:?}", resolution.ties) };
    assert_eq!((count.follower, count.leader, count.crossing), (cartilage, muscle, 0));
    assert_eq!(count.tied, 144, "one side of the plate");
}

/// Cartilage of which one end is sunk into the bone that it is tied to, and the other one off it.
#[test]
fn what_is_sunk_is_not_tied() {
    let sheet = shapes::plate(DVec3::new(20.0, 20.0, 0.8), [20, 20]);
    let sheet = sheet.mapped(|p| p + 0.06 * p.x * DVec3::Z);
    let bone = shapes::plate(DVec3::new(30.0, 30.0, 6.0), [7, 7]).translated(DVec3::Z * -3.0);
    let (mut scene, bodies) = bone_below(bone, sheet);
    let ties = vec![Tie { bodies, distance: 0.5 }];
    let resolution = resolve(&mut scene, Conditions { ties, ..Conditions::default() });
    assert!(resolution.resolved, "{:?} {:?}", resolution.remaining, resolution.broken_limits);

    // Eleven of 21 rows of the lower side are sunk or cross, and the outer side goes with what is below it.
    let [count] = resolution.ties[..] else { panic!("one tie: {:?}", resolution.ties) };
    assert!(count.tied > 0 && count.crossing >= 11 * 21, "{count:?}");

    // Else the outer side would stay, where the inner one goes.
    let strain = resolution.bodies[bodies[1].index()].strain;
    assert!(strain < 0.1, "{strain}");
}

/// Returns tetrahedra in a row whose upper or lower edges run along x, or along y where `across`.
fn ridges(across: bool, height: f64) -> Mesh {
    let positions = [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, -1.5, -1.5], [0.0, 1.5, -1.5]];
    let ridge = Mesh {
        positions: positions.map(DVec3::from).to_vec(),
        faces: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    let ridge = if across { ridge.mapped(|p| DVec3::new(p.y, p.x, height - p.z)) } else { ridge };
    let ridge = if ridge.volume() > 0.0 { ridge } else { ridge.flipped() };
    let mut row = ridge.clone();
    for number in 1..25 {
        row = row.joined(&ridge.clone().translated(DVec3::X * 8.0 * f64::from(number)));
    }
    row
}

#[test]
fn each_of_many_edges_has_its_row() {
    let (mut scene, ids) = bone_below(ridges(false, 0.0), ridges(true, 0.02));
    assert!((brute_distance(&scene, ids[0], ids[1]) - 0.02).abs() < 1e-12, "edges alone");
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(resolution.resolved, "{:?} {:?}", resolution.gap, resolution.gap_rounds);
    assert!(brute_distance(&scene, ids[0], ids[1]) >= GAP);
}

/// Each plate is pushed toward the other by as much as rows can ask for, while they are just too
/// far from each other to have a row.
#[test]
fn plates_that_are_pushed_toward_each_other_do_not_cross() {
    let bone = shapes::plate(DVec3::new(30.0, 30.0, 6.0), [7, 7]);
    let plate = shapes::plate(DVec3::new(20.0, 20.0, 2.0), [10, 10]);
    let (near, between) = (1e-5, 0.1012);
    let up = |height: f64| DVec3::Z * height;
    let mut scene = scene_of([
        ("below", BodyKind::Rigid, bone.clone().translated(up(-3.0 - near - 2.0 - 0.5 * between))),
        ("lower", BodyKind::Deformable, plate.clone().translated(up(-1.0 - 0.5 * between))),
        ("upper", BodyKind::Deformable, plate.translated(up(1.0 + 0.5 * between))),
        ("above", BodyKind::Rigid, bone.translated(up(3.0 + near + 2.0 + 0.5 * between))),
    ]);
    let resolution = resolve(&mut scene, Conditions::default());
    assert!(resolution.remaining.is_empty(), "{:?}", resolution.remaining);
    assert!(resolution.gap_rounds.len() > 1, "they were pushed");
}

#[test]
fn a_rigid_pair_that_rounding_brings_too_near_is_named() {
    // In single precision the second box begins at 1.04999995, as if by less than the gap.
    let corner = |x: f64| shapes::plate(DVec3::new(1.0, 1.0, 1.0), [1, 1]).translated(DVec3::X * x);
    let bodies = [
        ("first", BodyKind::Rigid, corner(0.5)),
        ("second", BodyKind::Rigid, corner(1.550_000_001)),
    ];
    let mut scene = scene_of(bodies);
    let params = ResolveParams { precision: WrittenPrecision::Single, ..WITH_GAP };
    let mut resolver = Resolver::new(params).expect("parameters");
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    let [short] = &resolution.gap.short[..] else { panic!("{:?}", resolution.gap) };
    assert_eq!(short.obstacle, GapObstacle::BothRigid);
    assert!(!resolution.resolved);
}

#[test]
fn a_tie_that_reaches_nothing_is_refused() {
    let bone = shapes::plate(DVec3::new(30.0, 30.0, 6.0), [7, 7]);
    let muscle = shapes::plate(DVec3::new(20.0, 20.0, 2.0), [10, 10]).translated(DVec3::Z * 5.0);
    let (mut scene, bodies) = bone_below(bone, muscle);
    let ties = vec![Tie { bodies, distance: 1e-3 }];
    let conditions = Conditions { ties, ..Conditions::default() };
    let mut resolver = Resolver::new(WITH_GAP).expect("parameters").with_conditions(conditions);
    let refused = resolver.resolve(&mut scene, Progress::none()).expect_err("nothing is tied");
    assert!(matches!(refused, ResolveError::NothingTied { .. }), "{refused}");
}

#[test]
fn a_gap_that_only_the_upper_bound_reaches_is_not_proved() {
    let cube = shapes::cube(10.0);
    let apart = DVec3::new(10.02, 0.3, 0.1);
    let other = shapes::icosphere(5.0, 1).translated(apart);
    let mut scene = scene_of([("a", BodyKind::Rigid, cube), ("b", BodyKind::Rigid, other)]);
    let resolution = resolve(&mut scene, Conditions::default());
    let [short] = resolution.gap.short[..] else { panic!("{:?}", resolution.gap) };
    let gap = short.distance.upper;
    assert!(short.distance.lower < gap, "{short:?}");

    let params = ResolveParams { gap, ..PARAMS };
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("a resolution");
    assert!(!resolution.resolved && resolution.gap.short.len() == 1, "{:?}", resolution.gap);
}

#[test]
fn bones_that_rounding_brings_nearer_than_the_gap_are_named() {
    // One side is rounded up by half a unit in the last place, the other down.
    let unit = 1.0 / 256.0;
    let (side, gap) = (40_000.0, 12.1 * unit);
    let cube = shapes::cube(16.0);
    let below = cube.clone().translated(DVec3::X * (side - 8.0 + 0.51 * unit));
    let above = cube.translated(DVec3::X * (side + 8.0 + 13.49 * unit));
    let mut scene = scene_of([("a", BodyKind::Rigid, below), ("b", BodyKind::Rigid, above)]);
    for (precision, is_kept) in
        [(WrittenPrecision::Double, true), (WrittenPrecision::Single, false)]
    {
        let params = ResolveParams { precision, gap, ..PARAMS };
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        assert_eq!(resolution.expect("a resolution").gap.holds(), is_kept, "{precision:?}");
    }
}
