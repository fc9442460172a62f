//! `cargo xtask verify`: all claims, checked once.
//!
//! Tests run in the development profile, with debug assertions and overflow checks, which are part
//! of the tests. Golden files are compared by the tests and never rewritten here.

use std::path::Path;
use std::process::Command;

use crate::long_tests::LONG_TESTS;
use crate::process::read_lines;
use crate::table::{Row, Table, Verdict};
use crate::test_output::TestOutput;
use crate::{TaskResult, figures, tidy};

/// Arguments of cargo for all tests. The program has every feature of the libraries; what is left
/// out are the other libraries of `benches`.
const TESTS: [&str; 4] = ["test", "--workspace", "--locked", "--no-fail-fast"];

/// Extent of a verification.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Everything that is claimed.
    Full,
    /// Tests of at most seconds and layout: a minute for the inner loop, once all is built.
    Quick,
}

pub(crate) fn run(root: &Path, extent: Extent) -> TaskResult {
    // Figures build beside the tests, which leave a core idle at times, and run after them.
    let build = (extent == Extent::Full).then(|| figures::start_build(root)).transpose()?;
    let outcome = run_tests(root, extent);
    let figures = match build {
        Some(mut build) => {
            let _ = build.wait();
            figures::generous_rows(root)?
        }
        None => Vec::new(),
    };
    let (tests, tests_ran) = outcome?;

    // One table: tests with the layout, then numbers of tests, then figures.
    let mut table = Table::default();
    let layout = layout_rows(root);
    table.add("tests", [tests.package_rows(), layout.clone()].concat());
    table.add("accuracy", tests.measured.clone());
    table.add("ratios", figures.clone());
    println!("\n{table}");

    // The result counts tests, and rows with a bound.
    let (mut passed, mut failed) = tests.counts();
    for row in layout.iter().chain(&tests.measured).chain(&figures) {
        passed += usize::from(row.verdict == Verdict::Passed);
        failed += usize::from(row.verdict == Verdict::Failed);
    }

    // A build that failed, or a test that took its whole program down.
    failed += usize::from(failed == 0 && !tests_ran);

    report_tests(&tests, tests_ran);
    println!("{passed} passed, {failed} failed");
    if failed == 0 { Ok(()) } else { Err("not everything that is claimed holds".to_owned()) }
}

fn run_tests(root: &Path, extent: Extent) -> Result<(TestOutput, bool), String> {
    // Golden files are only compared.
    let mut command = Command::new("cargo");
    command.args(TESTS).current_dir(root).env("INSTA_UPDATE", "no").env_remove("INSTA_FORCE_PASS");
    if extent == Extent::Full {
        // Partial results are for the inner loop, and take a third more of the compiler's time.
        command.env("CARGO_INCREMENTAL", "0").env("CARGO_PROFILE_DEV_CODEGEN_UNITS", "1");
    }
    if extent == Extent::Quick {
        // Examples and documentation change seldom.
        command.args(["--lib", "--bins", "--tests"]);
    }
    command.args(["--", "--show-output"]);
    if extent == Extent::Quick {
        for name in LONG_TESTS {
            command.args(["--skip", name]);
        }
    }

    let mut output = TestOutput::default();
    let status = read_lines(&mut command, |line| {
        println!("{line}");
        output.read(line);
    })?;
    Ok((output, status.success()))
}

/// Returns one row per layout rule.
fn layout_rows(root: &Path) -> Vec<Row> {
    let mut rows = Vec::new();
    for (rule, problems) in tidy::problems(root) {
        for problem in &problems {
            println!("{problem}");
        }
        rows.push(Row {
            name: rule.to_owned(),
            measured: format!("{} breaches", problems.len()),
            allowed: "none".to_owned(),
            verdict: Verdict::of(problems.is_empty()),
            command: "cargo xtask tidy".to_owned(),
        });
    }
    rows
}

fn report_tests(tests: &TestOutput, ran: bool) {
    if tests.skipped > 0 {
        println!("{} tests skipped: MUSCULO_DATA is not set", tests.skipped);
    }
    for name in &tests.failed {
        println!("failed: {name}");
    }
    if !ran && tests.failed.is_empty() {
        println!("failed: cargo test did not get through; see its messages above");
    }
}
