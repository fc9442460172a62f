//! Overlap removal in a real thigh at rest: remaining overlaps, as detection finds them, and
//! changes of shape.
//!
//! Needs the folder that `MUSCULO_DATA` names. With `MUSCULO_ALL_STEPS` set, the thigh at full
//! resolution is tested too.

use std::collections::BTreeSet;
use std::time::Instant;

use fixtures::data;
use scene::{BodyId, BodyKind, CheckParams, PairReport, Progress, Scene};

use resolve::{GapObstacle, ResolveParams, WrittenPrecision};

use crate::resolve;

const OVERLAP: CheckParams = CheckParams::new(0.0);

/// Builds the scene of a folder. Bones have names that begin with `bone`.
fn scene(folder: &std::path::Path) -> Scene {
    let mut scene = Scene::new();
    for path in data::bodies(folder) {
        let mesh = data::mesh(&path);
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let rigid = name.starts_with("bone");
        let kind = if rigid { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
    }
    scene
}

/// Returns the vertices inside another body, and the corners of faces that cross one.
fn touched(scene: &Scene, pairs: &[PairReport]) -> BTreeSet<(BodyId, u32)> {
    let mut touched = BTreeSet::new();
    for pair in pairs {
        for (side, id, report) in
            [(0, pair.pair.a, &pair.a_against_b), (1, pair.pair.b, &pair.b_against_a)]
        {
            let inside = report.near.iter().filter(|near| near.gap < 0.0);
            touched.extend(inside.map(|near| (id, near.vertex)));
            let faces = scene.body(id).surface().faces();
            let crossing = pair.crossing_faces.iter().map(|faces| faces[side] as usize);
            touched.extend(crossing.flat_map(|face| faces[face]).map(|vertex| (id, vertex)));
        }
    }
    touched
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[expect(clippy::print_stdout, reason = "the test reports its measurements")]
fn remove_overlaps(folder: &std::path::Path, set: &str) {
    let mut scene = scene(&folder.join(set));
    let before = scene.check(&OVERLAP, Progress::none()).expect("a check");
    let touched = touched(&scene, &before);
    let start = Instant::now();
    let resolution = resolve(&mut scene);
    let seconds = start.elapsed().as_secs_f64();
    let after = scene.check(&OVERLAP, Progress::none()).expect("a check");

    let deepest = after.iter().map(|pair| pair.max_vertex_depth).fold(0.0, f64::max);
    let crossing: usize = after.iter().map(|pair| pair.crossing_faces.len()).sum();
    let bodies = || resolution.bodies.iter();
    let volumes = bodies().filter_map(|change| Some((change.volume_ratio? - 1.0).abs()));
    let volume = 100.0 * volumes.fold(0.0, f64::max);
    let flipped: usize = bodies().map(|change| change.flipped_faces).sum();
    let [crossed, crosses]: [usize; 2] =
        [0, 1].map(|when| bodies().map(|change| change.self_crossings[when]).sum());
    let soft = bodies().filter(|change| scene.body(change.body).kind() != BodyKind::Rigid);
    let untouched = soft.flat_map(|change| {
        let lengths = (0..).zip(&change.displacements).map(|(v, u)| ((change.body, v), u.length()));
        lengths.filter(|(vertex, _)| !touched.contains(vertex)).map(|(_, length)| length)
    });
    let untouched = median(untouched.collect());
    let rounds = resolution.rounds.len() - 1;

    println!("measured: {set}: deepest overlap left [mm] | {deepest:.4} | 0.05");
    println!("measured: {set}: crossing pairs of faces left | {crossing} | 0");
    println!("measured: {set}: change of a muscle's volume [%] | {volume:.3} | 1");
    println!("measured: {set}: flipped faces | {flipped} | 0");
    println!("measured: {set}: self-crossings, {crossed} at first | {crosses} | 0");
    println!("measured: {set}: median displacement of untouched vertices [mm] | {untouched} | 0");
    println!("measured: {set}: rounds | {rounds} | 60");
    println!("measured: {set}: time at the tests' optimization [s] | {seconds:.1} | 120");
    assert!(resolution.resolved && crossing == 0, "{:?}", resolution.remaining);
    let sound = deepest <= 0.05 && volume <= 1.0 && untouched == 0.0;
    assert!(sound, "{deepest} deep, volume by {volume} %, untouched by {untouched}");
    assert_eq!((flipped, crossed, crosses), (0, 0, 0), "flipped, and crossing before, after");
}

#[test]
fn overlaps_of_a_thigh_at_rest_are_removed() {
    let Some(folder) = data::anatomy("overlaps_of_a_thigh_at_rest_are_removed") else { return };
    remove_overlaps(&folder, "vhf_left_thigh_lo");
    if std::env::var_os("MUSCULO_ALL_STEPS").is_some() {
        remove_overlaps(&folder, "vhf_left_thigh");
    }
}

/// Removes overlaps and opens a gap, which all pairs of bodies then keep at single precision.
#[expect(clippy::print_stdout, reason = "the test reports its measurements")]
fn open_gap(folder: &std::path::Path, set: &str) {
    let mut scene = scene(&folder.join(set));
    let before = scene.check(&OVERLAP, Progress::none()).expect("a check");
    let deepest = before.iter().filter_map(PairReport::max_depth).map(|depth| depth.upper);
    let deepest = deepest.fold(0.0, f64::max);
    let params = ResolveParams { gap: 0.05, precision: WrittenPrecision::Single, ..crate::PARAMS };
    let start = Instant::now();
    let resolution = resolve::resolve(&mut scene, &params, Progress::none()).expect("a resolution");
    let seconds = start.elapsed().as_secs_f64();

    let bodies = || resolution.bodies.iter();
    let volumes = bodies().filter_map(|change| Some((change.volume_ratio? - 1.0).abs()));
    let volume = 100.0 * volumes.fold(0.0, f64::max);
    let flipped: usize = bodies().map(|change| change.flipped_faces).sum();
    let crosses: usize = bodies().map(|change| change.self_crossings[1]).sum();
    let displacement = bodies().map(|change| change.max_displacement).fold(0.0, f64::max);
    // Bones of the thigh itself are 0.041 apart, and stay.
    let short = resolution.gap.short.iter();
    let short = short.filter(|short| short.obstacle != GapObstacle::BothRigid).count();
    println!("measured: {set}: pairs below the gap | {short} | 0");
    println!("measured: {set}: with a gap, change of a volume [%] | {volume:.3} | 0.2");
    let strain = bodies().map(|change| change.strain).fold(0.0, f64::max);
    println!("measured: {set}: with a gap, strain | {strain:.3} | 1");
    println!("measured: {set}: with a gap, flipped | {flipped} | 0");
    println!("measured: {set}: with a gap, self-crossings | {crosses} | 0");
    // The aim is 1.3; muscle around the rim of the pelvis has a longer way out than it is deep.
    println!("measured: {set}: displacement over depth | {:.2} | 1.8", displacement / deepest);
    let rounds = [resolution.rounds.len() - 1, resolution.gap_rounds.len()];
    println!("measured: {set}: with a gap, rounds {rounds:?}, time [s] | {seconds:.1} | 120");
    assert!(resolution.remaining.is_empty(), "{:?}", resolution.remaining);
    assert_eq!(short, 0, "{:?}", resolution.gap);
    assert!(volume <= 0.2 && flipped == 0 && crosses == 0, "{volume} %, {flipped}, {crosses}");
}

#[test]
fn a_gap_is_proved_for_every_pair_of_a_thigh() {
    let Some(folder) = data::anatomy("a_gap_is_proved_for_every_pair_of_a_thigh") else { return };
    open_gap(&folder, "vhf_left_thigh_lo");
    if std::env::var_os("MUSCULO_ALL_STEPS").is_some() {
        open_gap(&folder, "vhf_left_thigh");
    }
}
