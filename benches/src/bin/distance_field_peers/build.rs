//! Builds of a femur's field: in all, by phase, by threads, and what they hold.

use std::time::{Duration, Instant};

use benches::clock::running;
use benches::ratio::{Ratio, Report, amount};
use distance_field::{DistanceField, FieldParams};
use fixtures::Mesh;
use glam::DVec3;
use surface::TriangleSurface;

/// Builds that are timed; the least counts, since other work only ever adds.
const TURNS: usize = 9;

/// Room around the femur that makes its grid one of 6.4 million voxels at 1 mm, 51 million at 0.5.
const ROOM: f64 = 18.0;

/// Passes over memory that are timed together.
const PASSES: usize = 30;

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// A bone that is built from again and again.
struct Bone<'a> {
    surface: TriangleSurface,
    positions: &'a [DVec3],
}

impl<'a> Bone<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        Self { surface: mesh.surface(), positions: &mesh.positions }
    }

    fn build(&self, params: &FieldParams) -> DistanceField {
        let x = self.surface.positions(self.positions).expect("a generated bone is finite");
        DistanceField::build(&self.surface, x, params).expect("a bone fits")
    }
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start")
}

/// The default and the voxel method in turns with a pass over memory of the same size.
pub(crate) fn one_thread(mesh: &Mesh, report: &mut Report) {
    let defaults = FieldParams::new(1.0);
    let untruncated = FieldParams { truncation: None, ..defaults };
    let roomy = FieldParams { padding: ROOM, ..defaults };
    let voxel = FieldParams { samples: 0, ..FieldParams::voxel(1.0) };
    let bone = Bone::new(mesh);
    let time = |params: &FieldParams| {
        let start = running();
        std::hint::black_box(bone.build(params));
        milliseconds(running() - start)
    };
    let [mut exact, mut voxels, mut large, mut whole, mut pass] = [f64::INFINITY; 5];
    pool(1).install(|| {
        let mut values = bone.build(&defaults).values();
        for _ in 0..TURNS {
            // Often enough for the clock, which ticks in milliseconds.
            let start = running();
            for _ in 0..PASSES {
                values.iter_mut().for_each(|value| *value = -*value);
                std::hint::black_box(&mut values);
            }
            pass = pass.min(milliseconds(running() - start) / amount(PASSES));
            exact = exact.min(time(&defaults));
            voxels = voxels.min(time(&voxel));
            large = large.min(time(&roomy));
            whole = whole.min(time(&untruncated));
        }
        println!("{} voxels of 1 mm", values.len());
    });
    println!("exact band of 3, not truncated: {whole:.1} ms");
    let mut add = |name: &str, ours: f64, theirs: f64, allowed: f64| {
        report.add(&Ratio::new(name, ours, theirs, "ms", allowed));
    };
    add("exact band at 1 mm / 300 ms", exact, 300.0, 1.0);
    add("exact band, 6.4 million voxels / 300 ms", large, 300.0, 1.0);
    add("voxel method at 1 mm / 250 ms", voxels, 250.0, 1.0);
    add("exact band / voxel method", exact, voxels, 2.5);
    println!("a pass over its bytes: {pass:.2} ms, the exact band {:.0} times that", exact / pass);
}

/// One thread and two, in turns. What is held to its bound is how long the busier of the two
/// runs: all that only one can do is part of that, but not the waiting for a processor that
/// others use. Wall times are told beside it, and what two builds at once, each of one thread,
/// take from each other: more than that no two threads can gain.
pub(crate) fn threads(mesh: &Mesh, report: &mut Report) {
    let params = FieldParams::new(1.0);
    let (bone, pools, other) = (Bone::new(mesh), [pool(1), pool(2)], pool(1));
    let mut walls = [f64::INFINITY; 2];
    let mut busier = [f64::INFINITY; 2];
    let mut at_once = f64::INFINITY;
    for _ in 0..TURNS {
        for ((pool, wall), busier) in pools.iter().zip(&mut walls).zip(&mut busier) {
            let start = Instant::now();
            let time = build_in(pool, &bone, &params);
            *wall = wall.min(milliseconds(start.elapsed()));
            *busier = busier.min(time);
        }
        let both = std::thread::scope(|scope| {
            let beside = scope.spawn(|| build_in(&other, &bone, &params));
            let here = build_in(&pools[0], &bone, &params);
            here + beside.join().expect("the other build ends")
        });
        at_once = at_once.min(0.5 * both);
    }
    let [one, two] = walls;
    println!("wall time of one thread: {one:.1} ms, of two {two:.1} ms");
    let possible = 2.0 * busier[0] / at_once;
    println!("two builds at once: {at_once:.1} ms each, so that {possible:.2} is possible");
    report.add(&Ratio::new("busier of two threads / one", busier[1], busier[0], "ms", 1.0 / 1.7));
}

/// Builds a field, and returns how long the busiest thread of a pool ran for it \[ms\].
fn build_in(pool: &rayon::ThreadPool, bone: &Bone<'_>, params: &FieldParams) -> f64 {
    let before = pool.broadcast(|_| running());
    pool.install(|| std::hint::black_box(bone.build(params)));
    let after = pool.broadcast(|_| running());
    let each = after.iter().zip(before).map(|(after, before)| milliseconds(*after - before));
    each.fold(0.0, f64::max)
}

/// What a build at 0.5 mm adds to the memory of the process at its highest, over its grid.
pub(crate) fn memory(mesh: &Mesh, report: &mut Report) {
    let bone = Bone::new(mesh);
    let Some(before) = highest_memory() else {
        println!("no /proc/self/status here: memory is not measured");
        return;
    };
    let params = FieldParams { padding: ROOM, truncation: Some(15.0), ..FieldParams::new(0.5) };
    let field = bone.build(&params);
    let added = highest_memory().unwrap_or(before) - before;
    let grid = amount(field.bytes()) / 1e6;
    println!("{} voxels of 0.5 mm", field.grid().node_count());
    report.add(&Ratio::new("memory to build at 0.5 mm / grid", added, grid, "MB", 3.0));
}

/// Most memory that the process has held \[MB\].
fn highest_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes / 1e3)
}
