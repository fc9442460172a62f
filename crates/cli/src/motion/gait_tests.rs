//! Swept detection against many intermediate states, on a walk of real anatomy.
//!
//! Needs the folder that `MUSCULO_DATA` names. Steps are sampled; with
//! `MUSCULO_ALL_STEPS` set, all of them are taken.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use glam::DVec3;
use musculo_collide::surface::TriangleSurface;
use musculo_collide::{BodyId, BodyKind, BodyMove, CheckParams, Scene, SweepReport, ccd};

use serde_json::{Value, json};

use super::Replay;
use super::tests::parsed;

/// Number of intermediate states per step.
const SUBDIVISIONS: u32 = 64;

/// Distance between sampled steps.
const STRIDE: usize = 24;

fn scene(folder: &std::path::Path) -> Scene {
    let entries = std::fs::read_dir(folder).expect("the set of meshes");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let mut scene = Scene::new();
    for path in &paths {
        let mesh = mesh_io::read_mesh(path).expect("a mesh");
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let rigid = name.starts_with("bone");
        let kind = if rigid { BodyKind::Rigid } else { BodyKind::Deformable };
        let surface = TriangleSurface::new(mesh.positions.len(), mesh.faces).expect("a surface");
        scene.add(name, kind, surface, mesh.positions).expect("a body");
    }
    scene
}

/// Reads a walk, whose soft bodies blend from shank to thigh to pelvis at its joints.
fn walk(path: &std::path::Path, scene: &Scene) -> Replay {
    let text = std::fs::read_to_string(path).expect("a motion");
    let mut file: Value = serde_json::from_str(&text).expect("JSON");
    let height = |joint: &str| file["ambient_skin"][joint].as_f64().expect("a height");
    let (hip, knee) = (height("hip_z"), height("knee_z"));
    file["skin"] = json!({
        "axis": [0, 0, 1],
        "segments": ["tibia", "femur", null],
        "blends": [[knee - 40.0, knee + 40.0], [hip - 50.0, hip + 50.0]],
    });
    parsed(&file.to_string()).expect("a motion").bind(scene, &BTreeMap::new()).expect("a walk")
}

fn place(scene: &mut Scene, positions: &[Vec<DVec3>]) {
    let ids: Vec<BodyId> = scene.ids().collect();
    for (id, x) in ids.into_iter().zip(positions) {
        scene.move_body(id, x).expect("positions that fit");
    }
}

/// Pairs of faces that cross, with their bodies.
type Crossings = BTreeSet<(BodyId, BodyId, [u32; 2])>;

fn crossings(scene: &mut Scene) -> Crossings {
    let reports = scene
        .check(&CheckParams::without_measures(0.0), musculo_collide::Progress::none())
        .expect("a check");
    let of_pair = |report: &musculo_collide::PairReport| -> Vec<_> {
        report.crossing_faces.iter().map(|&faces| (report.pair.a, report.pair.b, faces)).collect()
    };
    reports.iter().flat_map(of_pair).collect()
}

/// Returns the earliest contact of each set of four particles of a sweep.
fn times(sweep: &SweepReport) -> BTreeMap<[u32; 4], f64> {
    let mut times = BTreeMap::new();
    for contact in sweep.pairs.iter().flat_map(|pair| &pair.contacts) {
        let terms = contact.contact.stencil.terms();
        let mut particles: [u32; 4] = std::array::from_fn(|k| terms[k].particle);
        particles.sort_unstable();
        times.insert(particles, contact.contact.time.expect("swept contacts have a time"));
    }
    times
}

/// Returns the earliest contact between the corners and edges of two faces.
fn first_contact(
    scene: &Scene,
    times: &BTreeMap<[u32; 4], f64>,
    (a, b, [fa, fb]): (BodyId, BodyId, [u32; 2]),
) -> Option<f64> {
    let corners = |id: BodyId, face: u32| {
        let body = scene.body(id);
        body.surface().faces()[face as usize].map(|vertex| body.particles().start + vertex)
    };
    let (of_a, of_b) = (corners(a, fa), corners(b, fb));
    let mut found: Vec<f64> = Vec::new();
    let mut collect = |mut particles: [u32; 4]| {
        particles.sort_unstable();
        found.extend(times.get(&particles));
    };
    for k in 0..3 {
        collect([of_a[k], of_b[0], of_b[1], of_b[2]]);
        collect([of_b[k], of_a[0], of_a[1], of_a[2]]);
        for l in 0..3 {
            collect([of_a[k], of_a[(k + 1) % 3], of_b[l], of_b[(l + 1) % 3]]);
        }
    }
    found.into_iter().min_by(f64::total_cmp)
}

#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it skips or measures")]
fn sweeps_find_all_crossings_of_intermediate_states() {
    let Some(data) = std::env::var_os("MUSCULO_DATA").map(PathBuf::from) else {
        println!("skipped: MUSCULO_DATA names no folder of anatomy");
        return;
    };
    let mut scene = scene(&data.join("anatomy/vhf_left_thigh_lo"));
    let replay = walk(&data.join("anatomy/motions/gait_walk.json"), &scene);
    let stride = if std::env::var_os("MUSCULO_ALL_STEPS").is_some() { 1 } else { STRIDE };
    let mut compared = 0;
    for frame in (1..replay.frame_count()).step_by(stride) {
        let [x0, x1] = [replay.positions(frame - 1), replay.positions(frame)];
        place(&mut scene, &x0);
        let ids: Vec<BodyId> = scene.ids().collect();
        let moves: Vec<BodyMove<'_>> =
            ids.iter().zip(&x1).map(|(&body, positions)| BodyMove { body, positions }).collect();
        let times = times(
            &scene
                .sweep(&moves, &ccd::CcdParams::EXACT, musculo_collide::Progress::none())
                .unwrap(),
        );
        let at_start = crossings(&mut scene);
        let mut known = at_start;
        for k in 1..=SUBDIVISIONS {
            let share = f64::from(k) / f64::from(SUBDIVISIONS);
            let between = |(p, q): (&Vec<DVec3>, &Vec<DVec3>)| -> Vec<DVec3> {
                p.iter().zip(q).map(|(p, q)| p.lerp(*q, share)).collect()
            };
            let x: Vec<Vec<DVec3>> = x0.iter().zip(&x1).map(between).collect();
            place(&mut scene, &x);
            for crossing in crossings(&mut scene) {
                if known.insert(crossing) {
                    let time = first_contact(&scene, &times, crossing);
                    assert!(
                        time.is_some_and(|time| time <= share),
                        "{crossing:?} cross at {share} of step {frame}, but first met at {time:?}"
                    );
                    compared += 1;
                }
            }
        }
    }
    println!("measured: crossings of gait states met by the sweep before | {compared} | all");
    assert!(compared > 100, "only {compared} crossings were compared");
}
