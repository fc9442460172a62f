//! Trees of k-DOPs beside trees of boxes, on the same meshes in one run, on one thread.
//!
//! ```text
//! cargo run --release -p benches --bin kdop_peers -- [ratios] [volumes] [memory] [growth]
//!                                                    [threads] [motion] [sizes]
//! ```
//!
//! Without a word it prints all tables. Lines that begin with `ratio` hold name, ours, the other's,
//! ratio, allowed and `ok` or `SHORT`; the exit code tells whether one falls short.
#![expect(clippy::print_stdout, reason = "a program that prints tables")]

mod beside;
mod peers;
mod sizes;
mod tables;

use std::process::ExitCode;

use benches::ratio::Report;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |table: &str| words.is_empty() || words.iter().any(|word| word == table);
    let mut report = Report::default();
    if wanted("ratios") {
        beside::compare(&mut report);
    }
    if wanted("memory") {
        tables::memory(&mut report);
    }
    if wanted("volumes") {
        tables::volumes();
    }
    if wanted("growth") {
        tables::growth();
    }
    if wanted("threads") {
        tables::threads();
    }
    if wanted("motion") {
        tables::motion();
    }
    if wanted("sizes") {
        sizes::print();
    }
    report.finish()
}
