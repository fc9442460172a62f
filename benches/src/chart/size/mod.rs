//! Time and memory over the number of faces, by one thread and by two.
//!
//! A bone with six muscles around it, all of them spheres: each muscle overlaps the bone and no
//! other muscle, so that there are six pairs to share. Every size has the same shapes.

mod draw;
mod operations;

use std::error::Error;
use std::path::{Path, PathBuf};

use rayon::ThreadPoolBuilder;
use serde::Serialize;

use super::curves::machine;
use super::sheet::{Settings, Sheet};
use crate::measure::{as_f64, nanoseconds};
use operations::{OPERATIONS, Operation, Spheres};

/// Splits of each sphere's faces in four: 2,240 to 573,440 faces in all.
const LEVELS: [u32; 5] = [2, 3, 4, 5, 6];

/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];

/// Rounds, of which the quickest counts, and the time after which there are no more \[ns\].
const ROUNDS: u32 = 7;
const LONG: f64 = 2e10;

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
            if level <= operation.largest_level() {
                for threads in THREADS {
                    let row = measure(operation, level, threads)?.beside(&rows);
                    rows.push(row);
                }
            }
        }
    }
    let sheet = Sheet::new("size", settings(), &rows)?;
    let svg = draw::draw(&rows, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings() -> Settings {
    vec![
        ("scene", "a bone and six muscles around it, spheres of radius 30 mm that overlap the bone by 2 mm; field: of the bone alone, at nodes every mm".to_owned()),
        ("operations", "refit: trees of all bodies after they moved; check: all measures, after muscles moved; sweep: muscles move 1 mm to the bone; overlap: measures of the six pairs; resolve: to a gap of 0.05 mm".to_owned()),
        ("time", format!("wall time, the quickest of {ROUNDS} rounds, fewer where they are long; one thread filled, two threads hollow; slope: power of the number of faces over the last two sizes")),
        ("memory", "most that one thread allocates at once beyond what the bodies hold".to_owned()),
        ("machine", machine().replace("one thread", "threads")),
    ]
}

/// Runs an operation on a pool of its own.
fn measure(
    operation: Operation,
    level: u32,
    threads: usize,
) -> Result<Measurement, Box<dyn Error>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let measured = pool.install(|| -> Result<Measurement, String> {
        let mut spheres = Spheres::new(level).map_err(|error| error.to_string())?;
        let mut failure = None;
        let mut run = || match operation.run(&mut spheres) {
            Ok(count) => count,
            Err(error) => {
                failure = Some(error.to_string());
                0
            }
        };

        // The first round takes memory, which the allocator counts for its own thread.
        let allocated = allocation_counter::measure(|| {
            run();
        });
        let (mut time, mut all, mut rounds) = (f64::INFINITY, 0.0, 0);
        while rounds < ROUNDS && all < LONG {
            let round = nanoseconds(&mut run);
            time = time.min(round);
            all += round;
            rounds += 1;
        }
        failure.map_or(Ok(()), Err)?;

        #[expect(clippy::cast_precision_loss, reason = "bytes far below 2^53")]
        let memory = (threads == 1).then_some(1e-6 * allocated.bytes_max as f64);
        Ok(Measurement {
            operation: operation.name(),
            threads,
            faces: operation.faces(&spheres),
            time: 1e-6 * time,
            memory,
            slope: None,
            gain: None,
        })
    })?;
    Ok(measured)
}

impl Measurement {
    /// Adds the growth since the size before, and the gain over one thread.
    fn beside(mut self, earlier: &[Self]) -> Self {
        let mut same = earlier.iter().rev().filter(|row| row.operation == self.operation);
        let smaller = same.clone().find(|row| row.threads == self.threads);
        self.slope = smaller
            .map(|row| (self.time / row.time).ln() / (as_f64(self.faces) / as_f64(row.faces)).ln());
        let one = same.find(|row| row.faces == self.faces && row.threads == 1);
        self.gain = one.map(|row| row.time / self.time);
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
        let [slope, gain] = [last.slope, last.gain].map(Option::unwrap_or_default);
        assert!((slope - 1.5).abs() < 1e-12 && (gain - 8.0 / 4.8).abs() < 1e-12, "{last:?}");
    }

    /// Every operation runs, and finds what is planted: six pairs.
    #[test]
    fn all_operations_run() {
        let mut spheres = Spheres::new(2).unwrap();
        for operation in OPERATIONS {
            let count = operation.run(&mut spheres).unwrap();
            match operation {
                Operation::Check | Operation::Overlap | Operation::Sweep => assert_eq!(count, 6),
                Operation::Refit => assert_eq!(count, 7),
                Operation::Field | Operation::Resolve => assert!(count > 0, "{operation:?}"),
            }
        }
    }
}
