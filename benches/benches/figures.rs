//! Figures of all crates under Criterion: `cargo bench -p benches --features criterion -- kdop`.
//!
//! The functions are those of `cargo xtask ratios`, with Criterion as their timer. A side of a
//! comparison is a benchmark, named by crate, comparison and side; arguments filter them.

use std::error::Error;
use std::hint::black_box;

use benches::measure::{Pace, Report, Side, Timer};
use benches::ratios;
use criterion::{Bencher, Criterion};

/// Timer that runs each side as a benchmark.
#[derive(Debug)]
struct CriterionTimer;

impl Timer for CriterionTimer {
    fn times(&mut self, name: &str, pace: Pace, sides: &mut [Side<'_>]) -> Vec<f64> {
        let mut criterion = Criterion::default().configure_from_args();
        let mut group = criterion.benchmark_group(name);
        if pace.calls == 1 {
            // Long calls: the fewest samples that Criterion takes.
            group.sample_size(10);
        }

        // A side that is filtered out has no time.
        let mut times = Vec::new();
        for (side, work) in sides {
            let mut least = f64::NAN;
            group.bench_function(*side, |bencher| least = run(bencher, pace, *work));
            times.push(least);
        }
        group.finish();
        times
    }
}

/// Runs a side as often as Criterion wants; returns its minimum time \[ns\].
fn run(bencher: &mut Bencher<'_>, pace: Pace, work: &mut dyn FnMut() -> usize) -> f64 {
    let mut least = f64::INFINITY;
    bencher.iter_custom(|calls| {
        let start = (pace.clock)();
        for _ in 0..calls {
            least = least.min(pace.call_time(&mut *work));
        }
        black_box((pace.clock)() - start)
    });
    least
}

fn main() -> Result<(), Box<dyn Error>> {
    // An argument that names a crate sets up the scenes of that crate only.
    let is_crate = |argument: &String| ratios::GROUPS.iter().any(|(group, _)| group == argument);
    let crates: Vec<String> = std::env::args().filter(is_crate).collect();

    // Figures follow from the times, but a report of Criterion's own has taken their place.
    let mut report = Report::with_timer(Box::new(CriterionTimer));
    ratios::run(&crates, &mut report)?;
    Criterion::default().configure_from_args().final_summary();
    Ok(())
}
