//! Time and memory over the number of faces, by one thread and by two.
//!
//! A bone with twelve muscles around it, all of them spheres: each muscle overlaps the bone and no
//! other muscle, so that there are twelve pairs to share. Every size has the same shapes.

mod draw;
pub(crate) mod operations;

use std::error::Error;
use std::path::{Path, PathBuf};

use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::curves::machine;
use super::sheet::{Settings, Sheet};
use crate::measure::{as_f64, thread_time, wall_time};
use operations::{OPERATIONS, Operation, Spheres};

/// Splits of each sphere's faces in four: 1,040 to 1,064,960 faces in all.
const LEVELS: [u32; 6] = [1, 2, 3, 4, 5, 6];

/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];

/// Rounds, of which the quickest counts, and the time after which there are no more \[s\].
const ROUNDS: u32 = 7;
const LONG: f64 = 20.0;

/// Time that the processor's clock resolves \[s\].
const CLOCK: f64 = 0.02;

/// Cost of an operation: a row of the table.
#[derive(Clone, Debug, Serialize)]
struct Measurement {
    operation: &'static str,
    threads: usize,
    /// Of all bodies that the operation works on.
    faces: usize,
    #[serde(rename = "time [ms]")]
    time: f64,
    /// Most that was allocated at once, by one thread, beyond what the bodies hold.
    #[serde(rename = "memory [MB]")]
    memory: Option<f64>,
    /// Power of the number of faces that the time grew with since the size before.
    #[serde(rename = "slope of time")]
    slope: Option<f64>,
    /// Time of one thread over this one.
    #[serde(rename = "gain by threads")]
    gain: Option<f64>,
}

/// Draws time and memory over the number of faces.
///
/// # Errors
///
/// When an operation fails, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut rows: Vec<Measurement> = Vec::new();
    for level in LEVELS {
        for operation in OPERATIONS {
            for row in measure(operation, level)? {
                rows.push(row.beside(&rows));
            }
        }
    }
    let sheet = Sheet::new("size", settings(), &rows)?;
    let svg = draw::draw(&rows, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings() -> Settings {
    vec![
        ("scene", "a bone and twelve muscles around it, spheres of radius 30 mm that overlap the bone by 1.5 mm; field: of a bone alone with more faces, at nodes every mm".to_owned()),
        ("operations", "refit: trees of all bodies after they moved; check: all measures, after muscles moved; sweep: muscles move 1 mm to the bone; overlap: measures of the twelve pairs, one after the other; resolve: to a gap of 0.05 mm".to_owned()),
        ("time", format!("the quickest of {ROUNDS} rounds, fewer where they are long; one thread (filled) by its processor's clock where that resolves it, two threads (hollow) by the ratio of wall times in turns; slope: power of the number of faces over the last two sizes")),
        ("to take from it", "all grow about as the faces do, in time and in memory, and a check of a million faces takes under a second. Two threads gain from some ten thousand faces on; refitting and single overlaps are of one thread".to_owned()),
        ("memory", "most that one thread allocates at once beyond what the bodies hold".to_owned()),
        ("machine", machine().replace("one thread", "threads")),
    ]
}

/// Bodies of an operation with threads of their own, and the least times of a round \[s\].
struct Side {
    pool: ThreadPool,
    spheres: Spheres,
    wall: f64,
    /// Of the first thread.
    processor: f64,
}

impl Side {
    fn new(operation: Operation, level: u32, threads: usize) -> Result<Self, Box<dyn Error>> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        let spheres = operation.spheres(level)?;
        Ok(Self { pool, spheres, wall: f64::INFINITY, processor: f64::INFINITY })
    }

    /// Runs once; returns the most memory that the first thread took at once \[bytes\].
    fn round(&mut self, operation: Operation) -> Result<u64, String> {
        let Self { pool, spheres, wall, processor } = self;
        pool.install(|| {
            let (mut outcome, start) = (Ok(0), [wall_time(), thread_time()]);
            let allocated = allocation_counter::measure(|| {
                outcome = operation.run(spheres).map_err(|error| error.to_string());
            });
            *wall = wall.min((wall_time() - start[0]).as_secs_f64());
            *processor = processor.min((thread_time() - start[1]).as_secs_f64());
            outcome.map(|_| allocated.bytes_max)
        })
    }
}

/// Runs an operation by one thread and by two, in turns.
fn measure(operation: Operation, level: u32) -> Result<[Measurement; 2], Box<dyn Error>> {
    let [one, two] = THREADS.map(|threads| Side::new(operation, level, threads));
    let (mut one, mut two) = (one?, two?);

    // The first round takes memory, and is not timed.
    let bytes = one.round(operation)?;
    two.round(operation)?;
    (one.wall, one.processor, two.wall) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let (start, mut rounds) = (wall_time(), 0);
    while rounds < ROUNDS && (wall_time() - start).as_secs_f64() < LONG {
        one.round(operation)?;
        two.round(operation)?;
        rounds += 1;
    }

    // Other work on the machine adds nothing to the time of the processor, which only long rounds
    // resolve, and little to the ratio of wall times.
    let time = if one.processor < CLOCK { one.wall } else { one.wall.min(one.processor) };
    let gain = one.wall / two.wall;
    #[expect(clippy::cast_precision_loss, reason = "bytes far below 2^53")]
    let memory = 1e-6 * bytes as f64;
    let row = Measurement {
        operation: operation.name(),
        threads: 1,
        faces: one.spheres.faces(),
        time: 1e3 * time,
        memory: Some(memory),
        slope: None,
        gain: None,
    };
    let by_two =
        Measurement { threads: 2, time: row.time / gain, memory: None, gain: Some(gain), ..row };
    Ok([row, by_two])
}

impl Measurement {
    /// Adds the growth since the size before.
    fn beside(mut self, earlier: &[Self]) -> Self {
        let is_same = |row: &&Self| row.operation == self.operation && row.threads == self.threads;
        let smaller = earlier.iter().rev().find(is_same);
        self.slope = smaller
            .map(|row| (self.time / row.time).ln() / (as_f64(self.faces) / as_f64(row.faces)).ln());
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_a_power_of_the_faces() {
        let row = |threads, faces, time| Measurement {
            operation: "check",
            threads,
            faces,
            time,
            memory: None,
            slope: None,
            gain: None,
        };
        let earlier = [row(1, 100, 1.0), row(2, 100, 0.6), row(1, 400, 8.0)];
        let last = row(2, 400, 4.8).beside(&earlier);
        assert!((last.slope.unwrap_or_default() - 1.5).abs() < 1e-12, "{last:?}");
    }

    /// Every operation runs, and finds what is planted: twelve pairs.
    #[test]
    fn all_operations_run() {
        for operation in OPERATIONS {
            let mut spheres = operation.spheres(2).unwrap();
            let count = operation.run(&mut spheres).unwrap();
            match operation {
                Operation::Check | Operation::Overlap | Operation::Sweep => assert_eq!(count, 12),
                Operation::Refit => assert_eq!(count, 13),
                Operation::Field | Operation::Resolve => assert!(count > 0, "{operation:?}"),
            }
        }
    }
}
