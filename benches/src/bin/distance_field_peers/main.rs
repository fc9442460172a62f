//! Building and asking signed distance grids, beside a pass over the same bytes, the seed method,
//! and exact projection by parry3d, in one run.
//!
//! ```text
//! cargo run --release -p benches --bin distance_field_peers -- [ratios|build|threads|memory|query]...
//! ```
//!
//! Without a word, or for `ratios`, it prints all. Lines that begin with `ratio` hold name, ours, the other's, ratio,
//! allowed and `ok` or `SHORT`; the exit code tells whether one falls short.
#![expect(clippy::print_stdout, reason = "a program that prints tables")]

mod build;
mod query;

use std::process::ExitCode;

use benches::ratio::Report;
use fixtures::femur::femur;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |table: &str| {
        words.is_empty() || words.iter().any(|word| word == table || word == "ratios")
    };
    let mut report = Report::default();
    let bone = femur(2.0);
    println!("femur of {} vertices, {} faces", bone.positions.len(), bone.faces.len());
    if wanted("memory") {
        // First, while nothing larger has been held.
        build::memory(&bone, &mut report);
    }
    if wanted("build") {
        build::one_thread(&bone, &mut report);
    }
    if wanted("threads") {
        build::threads(&bone, &mut report);
    }
    if wanted("query") {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
        one.install(|| query::beside_projection(&bone, &mut report));
    }
    report.finish()
}
