//! Swept detection of bodies that turn, against closed forms and dense samples of static detection.

use std::f64::consts::FRAC_PI_2;

use fixtures::generate::cases;
use fixtures::{Mesh, shapes};
use glam::{DQuat, DVec3};
use scene::{
    BodyId, BodyKind, BodyMove, CheckParams, JointScene, JointTurns, PathMove, Progress, Scene,
    SceneError,
};
use surface::{NearRigidPath, Path, Pose, RigidPath, StraightPath};

use crate::support::{scene_of, share, vector};

/// Rigid motion of a body of a scene.
struct BodyPath {
    rest: Vec<DVec3>,
    path: RigidPath,
    /// True if detection is told that the motion is rigid.
    is_rigid: bool,
}

impl Path for BodyPath {
    fn position(&self, vertex: u32, time: f64) -> DVec3 {
        self.path.transform_point(self.rest[vertex as usize], time)
    }

    fn bend(&self, vertex: u32) -> f64 {
        self.path.bend(self.rest[vertex as usize])
    }

    fn rigid(&self) -> Option<NearRigidPath> {
        self.is_rigid.then_some(NearRigidPath { path: self.path, deviation: 0.0 })
    }
}

fn path_of(scene: &Scene, body: BodyId, path: RigidPath) -> BodyPath {
    BodyPath { rest: scene.body(body).positions().to_vec(), path, is_rigid: true }
}

/// Returns the time of the first contact of the scene while bodies follow paths, if there is one.
fn first_contact(scene: &mut Scene, moves: &[PathMove<'_>]) -> Option<f64> {
    let report = scene.sweep_paths(moves, &ccd::CcdParams::DEFAULT, Progress::none());
    let report = report.expect("a swept step");
    let first = report.pairs.first().and_then(|pair| pair.first_time());
    assert_eq!(report.pairs.is_empty(), report.largest_free_step >= 1.0, "{report:?}");

    // The first contacts of pairs alone are the first of all.
    let firsts = scene.first_contacts(moves, &ccd::CcdParams::DEFAULT, Progress::none());
    let firsts = firsts.expect("a swept step").pairs;
    assert_eq!(firsts.len(), report.pairs.len(), "{firsts:?}");
    for (alone, among) in firsts.iter().zip(&report.pairs) {
        let [alone, among] = [alone, among].map(|pair| (pair.pair, pair.first_time()));
        assert_eq!(alone, among, "the first contact of a pair");
    }
    first
}

/// A box between two corners.
fn cuboid(from: DVec3, to: DVec3) -> Mesh {
    shapes::cube(1.0).mapped(|x| (from + to) / 2.0 + x * (to - from))
}

/// A rod turns about the origin toward a wall: its leading corner meets the wall where the cosine of
/// its angle says, for arms of 1 to 1000 and steps of 20 to 90 degrees.
#[test]
fn a_rod_on_an_arm_meets_a_wall_at_a_known_angle() {
    for arm in [1.0, 30.0, 1000.0] {
        for step in [20.0_f64, 60.0, 90.0] {
            let (from, step) = (-step.to_radians(), step.to_radians());
            let half = 0.02 * arm;
            let turned = |x: DVec3| DQuat::from_rotation_z(from) * x;
            let rod = cuboid(DVec3::new(0.1 * arm, -half, -half), DVec3::new(arm, half, half));
            let rod = rod.mapped(turned);

            // The corner ahead is by this angle before the middle of the rod.
            let (radius, ahead) = (arm.hypot(half), (half / arm).atan());
            let angle = from + 0.4 * step;
            let plane = radius * (angle + ahead).cos();
            assert!(angle + ahead < 0.0, "the corner still goes outward");
            let wall = [plane, -9.0 * arm, -arm];
            let wall = cuboid(wall.into(), DVec3::new(plane + arm, 9.0 * arm, arm));

            let (mut scene, ids) = scene_of(&[&rod, &wall]);
            let body = ids[0];
            let path = path_of(&scene, body, RigidPath::turn(DVec3::ZERO, DVec3::Z, step));
            let first = first_contact(&mut scene, &[PathMove { body, path: &path }]);
            let first = first.expect("the rod meets the wall");
            assert!(first <= 0.4 + 1e-12, "late: {first} at arm {arm}, step {step}");
            assert!(first > 0.4 - 1e-6, "early: {first} at arm {arm}, step {step}");
        }
    }
}

/// Both bodies turn about skew axes by up to a radian. Where any of many states overlaps, a contact is
/// found, and not after the last state before the overlap.
#[test]
fn bodies_that_turn_about_skew_axes_are_never_late() {
    const SAMPLES: u32 = 200;
    let mut met = 0;
    cases(7, 60, |u| {
        let a = shapes::ellipsoid(DVec3::new(4.0, 9.0, 3.0), 1);
        let b = shapes::ellipsoid(DVec3::new(3.0, 5.0, 8.0), 1).translated(vector(u, 14.0)?);
        let (mut scene, ids) = scene_of(&[&a, &b]);
        let mut paths = Vec::new();
        for &id in &ids {
            let axis = vector(u, 1.0)?.normalize_or(DVec3::X);
            let rotation = DQuat::from_axis_angle(axis, share(u, 0.2, 1.0)?);
            let path = RigidPath::new(rotation, vector(u, 6.0)?, vector(u, 20.0)?);
            paths.push(path_of(&scene, id, path));
        }

        // In the relative motion, and in pieces of straight motion.
        let rest = scene.particle_positions();
        let [first, in_pieces] = [true, false].map(|is_rigid| {
            for path in &mut paths {
                path.is_rigid = is_rigid;
            }
            let moves: Vec<PathMove<'_>> =
                ids.iter().zip(&paths).map(|(&body, path)| PathMove { body, path }).collect();
            first_contact(&mut scene, &moves)
        });
        assert_eq!(scene.particle_positions(), rest, "bodies stay where they were");
        let times = [first, in_pieces].map(|time| time.unwrap_or(2.0));
        assert!((times[0] - times[1]).abs() < 1e-6, "both are the same contact: {times:?}");

        for sample in 0..=SAMPLES {
            let time = f64::from(sample) / f64::from(SAMPLES);
            for (&id, path) in ids.iter().zip(&paths) {
                let count = u32::try_from(path.rest.len()).expect("few");
                let x: Vec<DVec3> = (0..count).map(|v| path.position(v, time)).collect();
                scene.move_body(id, &x).expect("finite positions");
            }
            let params = CheckParams { measures: false, ..CheckParams::new(0.0) };
            let reports = scene.check(&params, Progress::none()).expect("a checked state");
            if reports.iter().any(|report| !report.crossing_faces.is_empty()) {
                // What overlaps from the start has no first contact.
                if sample == 0 {
                    break;
                }
                let first = first.unwrap_or_else(|| panic!("missed at {time}"));
                assert!(first <= time, "late: {first} after {time}");
                met += 1;
                break;
            }
        }
        Ok(())
    });
    assert!(met >= 8, "only {met} of the steps meet");
}

/// Finds the first contacts of all vertices, edges and faces of different bodies on their paths, one by
/// one over the whole step, in the order of their particles.
fn slow_contacts(
    scene: &Scene,
    ids: &[BodyId],
    paths: &[BodyPath],
    params: &ccd::CcdParams,
) -> Vec<([u32; 4], f64, bool)> {
    let rest = scene.particle_positions();
    let owner = |particle: u32| {
        ids.iter().position(|id| scene.body(*id).particles().contains(&particle)).expect("a body")
    };
    let vertex = |particle: u32| particle - scene.body(ids[owner(particle)]).particles().start;
    let place = |particle: u32, time| paths[owner(particle)].position(vertex(particle), time);
    let bend = |particle: u32| paths[owner(particle)].bend(vertex(particle));
    let extent = rest.iter().map(|x| x.abs().max_element()).fold(100.0, f64::max);

    let mut found = Vec::new();
    let mut search = |primitives, points: [u32; 4], first: usize| {
        let largest = |points: &[u32]| points.iter().map(|p| bend(*p)).fold(0.0, f64::max);
        let bend = largest(&points[..first]) + largest(&points[first..]);
        let bounds = ccd::PathBounds { bend, rounding: 256.0 * f64::EPSILON * extent };
        let at = |time: f64| points.map(|particle| place(particle, time));
        let answer = ccd::first_contact_on_paths(primitives, at, bounds, [0.0, 1.0], params);
        let answer = answer.expect("finite");
        found.extend(answer.map(|contact| (points, contact.lo, contact.at_start)));
    };
    for (k, a) in ids.iter().enumerate() {
        for b in &ids[k + 1..] {
            let [a, b] = [a, b].map(|id| scene.body(*id));
            for (of, on) in [(a, b), (b, a)] {
                for vertex in of.particles() {
                    for face in on.surface().faces() {
                        let [p, q, r] = face.map(|corner| on.particles().start + corner);
                        search(ccd::Primitives::VertexFace, [vertex, p, q, r], 1);
                    }
                }
            }
            for of_a in a.surface().edges() {
                for of_b in b.surface().edges() {
                    let [p, q] = of_a.map(|end| a.particles().start + end);
                    let [r, s] = of_b.map(|end| b.particles().start + end);
                    search(ccd::Primitives::EdgeEdge, [p, q, r, s], 2);
                }
            }
        }
    }
    found.sort_by_key(|&(points, ..)| points);
    found
}

/// Three bodies turn at once, two as rigid ones and one vertex by vertex: all first contacts of their
/// vertices, edges and faces are found, by the right particles and at the right times.
#[test]
fn all_contacts_of_bodies_that_turn_are_those_of_brute_force() {
    let (mut met, mut started, mut pairs) = (0, 0, std::collections::BTreeSet::new());
    cases(11, 24, |u| {
        let a = shapes::ellipsoid(DVec3::new(4.0, 9.0, 3.0), 0);
        let b = shapes::icosphere(5.0, 0).translated(DVec3::X * 12.0 + vector(u, 4.0)?);
        let c = shapes::ellipsoid(DVec3::new(3.0, 5.0, 8.0), 0);
        let c = c.translated(DVec3::Y * 15.0 + vector(u, 4.0)?);
        let (mut scene, ids) = scene_of(&[&a, &b, &c]);
        let mut paths = Vec::new();
        for (number, &id) in ids.iter().enumerate() {
            let axis = vector(u, 1.0)?.normalize_or(DVec3::X);
            let rotation = DQuat::from_axis_angle(axis, share(u, 0.2, 1.0)?);
            let path = RigidPath::new(rotation, vector(u, 6.0)?, vector(u, 14.0)?);
            paths.push(BodyPath { is_rigid: number != 1, ..path_of(&scene, id, path) });
        }
        let params = ccd::CcdParams { min_separation: 0.25, ..ccd::CcdParams::DEFAULT };
        for params in [ccd::CcdParams::DEFAULT, params] {
            let moves: Vec<PathMove<'_>> =
                ids.iter().zip(&paths).map(|(&body, path)| PathMove { body, path }).collect();
            let report = scene.sweep_paths(&moves, &params, Progress::none()).expect("a sweep");
            let mut found = Vec::new();
            for pair in &report.pairs {
                pairs.insert(pair.pair);
                for contact in &pair.contacts {
                    let terms = contact.contact.stencil.terms();
                    let points: [u32; 4] = std::array::from_fn(|k| terms[k].particle);
                    found.push((points, contact.contact.time.expect("a time"), contact.at_start));
                }
            }
            found.sort_by_key(|&(points, ..)| points);
            let slow = slow_contacts(&scene, &ids, &paths, &params);
            let features = |list: &[([u32; 4], f64, bool)]| -> Vec<([u32; 4], bool)> {
                list.iter().map(|&(points, _, at_start)| (points, at_start)).collect()
            };
            assert_eq!(features(&found), features(&slow));
            for ((points, time, at_start), (_, slow, _)) in found.iter().zip(&slow) {
                assert!((time - slow).abs() < 1e-6, "{points:?}: {time}, {slow} by brute force");
                started += usize::from(*at_start);
            }
            met += found.len();
        }
        Ok(())
    });
    assert!(met > 100 && pairs.len() == 3, "{met} contacts of {pairs:?}");
    assert!(started > 0 && started < met, "{started} of {met} at the start");
}

/// Straight paths are swept as such.
#[test]
fn straight_paths_find_what_a_straight_sweep_finds() {
    let a = shapes::icosphere(10.0, 2);
    let b = shapes::icosphere(6.0, 1).translated(DVec3::new(20.0, 1.0, 2.0));
    let (mut scene, ids) = scene_of(&[&a, &b]);
    let body = ids[1];
    let from = scene.body(body).positions().to_vec();
    let to: Vec<DVec3> = from.iter().map(|x| *x - 12.0 * DVec3::X).collect();

    let moves = [BodyMove { body, positions: &to }];
    let straight =
        scene.sweep(&moves, &ccd::CcdParams::DEFAULT, Progress::none()).expect("a sweep");
    let path = StraightPath { from: &from, to: &to };
    let moves = [PathMove { body, path: &path }];
    let curved = scene.sweep_paths(&moves, &ccd::CcdParams::DEFAULT, Progress::none());
    let curved = curved.expect("a sweep");

    assert!(straight.pairs[0].contacts.len() > 20, "many contacts: {straight:?}");
    assert_eq!(curved, straight);
}

/// A rigid body keeps its pose, and what it measures its pose from.
#[test]
fn a_sweep_leaves_poses_alone() {
    let ball = shapes::icosphere(5.0, 1);
    let mut scene = Scene::new();
    for number in 0..2 {
        let body = ball.clone().translated(20.0 * f64::from(number) * DVec3::X);
        let (surface, x) = (body.surface(), body.positions);
        scene.add(number.to_string(), BodyKind::Rigid, surface, x).expect("a body");
    }
    let [first, second] = scene.ids().collect::<Vec<_>>()[..] else { panic!("two bodies") };
    let pose = Pose::new(DQuat::from_rotation_y(0.3), DVec3::Z);
    scene.pose_body(second, &pose).expect("a pose");

    for body in [first, second] {
        let (before, reference) =
            (scene.body(body).pose(), scene.body(body).reference().map(<[DVec3]>::to_vec));
        let turn = RigidPath::turn(DVec3::new(10.0, 0.0, 0.0), DVec3::Z, 1.5);
        let path = path_of(&scene, body, turn);
        first_contact(&mut scene, &[PathMove { body, path: &path }]);
        assert_eq!(scene.body(body).pose(), before, "the pose of {body:?}");
        assert_eq!(scene.body(body).reference().map(<[DVec3]>::to_vec), reference);
    }
}

/// A turn about no axis leads nowhere: it is refused, not swept without a contact.
#[test]
fn paths_that_are_not_finite_are_refused() {
    let ball = shapes::icosphere(5.0, 1);
    let (mut scene, ids) = scene_of(&[&ball, &ball.clone().translated(DVec3::X * 12.0)]);
    let turns = [
        RigidPath::turn(DVec3::ZERO, DVec3::ZERO, 1.0),
        RigidPath::turn(DVec3::Y * f64::INFINITY, DVec3::Z, 1.0),
    ];
    for turn in turns {
        let path = path_of(&scene, ids[1], turn);
        let moves = [PathMove { body: ids[1], path: &path }];
        let params = ccd::CcdParams::DEFAULT;
        let swept = scene.sweep_paths(&moves, &params, Progress::none());
        assert!(matches!(swept, Err(SceneError::Surface { .. })), "{swept:?}");
        let first = scene.first_contacts(&moves, &params, Progress::none());
        assert!(matches!(first, Err(SceneError::Surface { .. })), "{first:?}");
    }
}

/// A cube turns past a wall, its edge nearer to it than the separation but never in touch.
#[test]
fn rigid_bodies_that_come_within_the_separation_meet() {
    let (half, turn) = (1.0, 90.0_f64.to_radians());
    let nearest = half * 2.0_f64.sqrt();
    let wall = cuboid(DVec3::new(nearest + 0.2, -5.0, -5.0), DVec3::new(nearest + 2.0, 5.0, 5.0));
    let (mut scene, bodies) = scene_of(&[&shapes::cube(2.0 * half), &wall]);
    let cube = bodies[0];
    let path = path_of(&scene, cube, RigidPath::turn(DVec3::ZERO, DVec3::Z, turn));
    for (min_separation, meets) in [(0.1, false), (0.3, true)] {
        let params = ccd::CcdParams { min_separation, ..ccd::CcdParams::DEFAULT };
        let moves = [PathMove { body: cube, path: &path }];
        let report = scene.sweep_paths(&moves, &params, Progress::none()).expect("a swept step");
        assert_eq!(report.largest_free_step < 1.0, meets, "{min_separation}: {report:?}");
    }
}

/// The last turn of a state is its own, whatever the one is that contacts are searched for.
#[test]
fn states_of_a_joint_turn_by_their_own_angles() {
    let rod = cuboid(DVec3::new(1.0, -0.1, -0.1), DVec3::new(3.0, 0.1, 0.1));
    let wall = cuboid(DVec3::new(-0.5, 1.5, -0.5), DVec3::new(0.5, 2.5, 0.5));
    for to in [0.0, 1.0, -2.0] {
        let (scene, ids) = scene_of(&[&rod, &wall]);
        let turns = JointTurns { center: DVec3::ZERO, axes: [DVec3::X, DVec3::Y, DVec3::Z], to };
        let mut joint = JointScene::new(scene, &ids[..1], turns).expect("small");
        for (last, overlaps) in [(FRAC_PI_2, true), (0.0, false), (-FRAC_PI_2, false)] {
            let found = joint.overlaps([0.0; 2], last).expect("finite");
            assert_eq!(found, overlaps, "{last} of {to}");
        }
    }
}
