//! `cargo xtask verify`: all claims, checked once.
//!
//! Tests run in the development profile, with debug assertions and overflow checks, which are part
//! of the tests, each program as soon as it is built. Figures are built meanwhile with the settings
//! of a release, and run last, when nothing else does. Golden files are compared by the tests and
//! never rewritten here.

use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::compiler::set_compiler;
use crate::long_tests::LONG_TESTS;
use crate::process::read_lines;
use crate::table::{Row, Table, Verdict};
use crate::test_output::TestOutput;
use crate::test_programs::build_and_run;
use crate::{TaskResult, figures, tidy};

/// Arguments of cargo for all tests. The program has every feature of the libraries; what is left
/// out are the other libraries of `benches`.
const TESTS: [&str; 4] = ["test", "--workspace", "--locked", "--features=benches/figures"];

/// Arguments for the examples of the documentation. `benches` has none, and would be built once more.
const EXAMPLES: [&str; 6] =
    ["test", "--workspace", "--locked", "--exclude=benches", "--doc", "--no-fail-fast"];

/// Extent of a verification.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Everything that is claimed.
    Full,
    /// Tests of at most seconds and layout: a minute for the inner loop, once all is built.
    Quick,
}

pub(crate) fn run(root: &Path, extent: Extent) -> TaskResult {
    // Figures build while tests run, and run once nothing else does.
    let (tests, tests_ran) = run_tests(root, extent)?;
    let figures = match extent {
        Extent::Full => figures::verified_rows(root)?,
        Extent::Quick => Vec::new(),
    };

    // One table: tests with the layout, then numbers of tests, then figures.
    let mut table = Table::default();
    let layout = layout_rows(root);
    table.add("tests", [tests.package_rows(), layout.clone()].concat());
    let measured = tests.measured_rows();
    table.add("accuracy", measured.clone());
    table.add("ratios", figures.clone());
    println!("\n{table}");

    // The result counts tests, and rows with a bound.
    let (mut passed, mut failed) = tests.counts();
    for row in layout.iter().chain(&measured).chain(&figures) {
        passed += usize::from(row.verdict == Verdict::Passed);
        failed += usize::from(row.verdict == Verdict::Failed);
    }

    // A build that failed, or a test that took its whole program down.
    failed += usize::from(failed == 0 && !tests_ran);

    report_tests(&tests, tests_ran);
    println!("{passed} passed, {failed} failed");
    if failed == 0 { Ok(()) } else { Err("not everything that is claimed holds".to_owned()) }
}

/// Runs all tests, or those of the inner loop; returns their output, and whether all ended well.
fn run_tests(root: &Path, extent: Extent) -> Result<(TestOutput, bool), String> {
    let mut build = cargo(&TESTS, extent);
    match extent {
        Extent::Full => build_and_run(root, &mut build, &[], |output| {
            // The build is last: of what is left once all tests have ended, two crates compile at a time. A failure
            // is reported where figures run.
            let ended_well = documentation(root, output);
            let _ = figures::build(root);
            ended_well
        }),
        // Examples and documentation change seldom.
        Extent::Quick => {
            build.args(["--lib", "--bins", "--tests"]);
            let skipped: Vec<&str> = LONG_TESTS.iter().flat_map(|name| ["--skip", name]).collect();
            build_and_run(root, &mut build, &skipped, |_| Ok(true))
        }
    }
}

/// Returns a command that builds tests.
fn cargo(arguments: &[&str], extent: Extent) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments);
    if extent == Extent::Full {
        // Partial results are for the inner loop.
        set_compiler(&mut command);
    }
    command
}

/// Runs the examples of the documentation; returns true if all ended well.
fn documentation(root: &Path, output: &Mutex<TestOutput>) -> Result<bool, String> {
    // With their output shown, rustdoc would compile each example alone.
    let mut command = cargo(&EXAMPLES, Extent::Full);
    command.current_dir(root);
    let mut lines = Vec::new();
    let status = read_lines(&mut command, |line| lines.push(line.to_owned()))?;

    let mut output = output.lock().unwrap_or_else(PoisonError::into_inner);
    for line in &lines {
        println!("{line}");
        output.read(line);
    }
    Ok(status.success())
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
        println!("failed: a build or a test program did not get through; see its messages above");
    }
}
