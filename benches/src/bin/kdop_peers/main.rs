//! Trees of k-DOPs beside trees of boxes, on the same meshes in one run, on one thread.
//!
//! ```text
//! cargo run --release -p benches --bin kdop_peers [ratios|k|memory|slope|threads|motion|sizes]
//! ```
//!
//! Without a word it prints everything. Lines that begin with `ratio` hold name, ours, the other's,
//! ratio, allowed and `ok` or `SHORT`; the exit code tells whether one falls short.

mod beside;
mod peers;

use std::process::ExitCode;

use benches::ratio::Report;

fn main() -> ExitCode {
    let mut report = Report::default();
    beside::compare(&mut report);
    report.finish()
}
