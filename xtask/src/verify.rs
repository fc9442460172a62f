//! `cargo xtask verify`: all claims, checked once.
//!
//! Tests run in the development profile, with debug assertions and overflow checks, which are part
//! of the tests. Golden files are compared by the tests and never rewritten here.

use std::path::Path;
use std::process::Command;

use crate::process::read_lines;
use crate::table::{Row, Table, Verdict};
use crate::test_output::TestOutput;
use crate::{TaskResult, figures, tidy};

/// Arguments of cargo for all tests but those of `benches`, whose peers take long to build; its
/// program is run for the figures.
const TESTS: [&str; 9] = [
    "test",
    "--workspace",
    "--exclude",
    "benches",
    "--all-features",
    "--locked",
    "--no-fail-fast",
    "--",
    "--show-output",
];

pub(crate) fn run(root: &Path) -> TaskResult {
    // Figures build beside the tests, which leave a core idle at times, and run after them.
    let mut build = figures::start_build(root)?;
    let outcome = run_tests(root);
    let _ = build.wait();
    let (tests, tests_ran) = outcome?;

    let mut rows = layout_rows(root);
    let mut table = Table::default();
    table.add("tests", tests.package_rows());
    table.add("layout", rows.clone());
    for (heading, more) in
        [("numbers", tests.measured.clone()), ("figures", figures::generous_rows(root)?)]
    {
        rows.extend(more.clone());
        table.add(heading, more);
    }
    println!("\n{table}");

    // The result counts tests, and rows with a bound.
    let (mut passed, mut failed) = tests.counts();
    for row in &rows {
        passed += usize::from(row.verdict == Verdict::Passed);
        failed += usize::from(row.verdict == Verdict::Failed);
    }

    // A build that failed, or a test that took its whole program down.
    failed += usize::from(failed == 0 && !tests_ran);

    report_tests(&tests, tests_ran);
    println!("{passed} passed, {failed} failed");
    if failed == 0 { Ok(()) } else { Err("not everything that is claimed holds".to_owned()) }
}

fn run_tests(root: &Path) -> Result<(TestOutput, bool), String> {
    // Golden files are only compared.
    let mut command = Command::new("cargo");
    command.args(TESTS).current_dir(root).env("INSTA_UPDATE", "no").env_remove("INSTA_FORCE_PASS");

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
