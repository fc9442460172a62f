//! `cargo xtask verify`: everything that is claimed, checked once.
//!
//! Tests run in the development profile: with debug assertions and checks for
//! overflow, which are part of what they test, and with dependencies optimised.
//! Golden files are compared by the tests and never rewritten here.

use std::path::Path;
use std::process::Command;

use crate::process::read_lines;
use crate::table::{Row, Table, Verdict};
use crate::test_output::TestOutput;
use crate::{TaskResult, figures, tidy};

/// All but those of `benches`, whose peers take longer to build than all else;
/// its programs are run for their figures.
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
    let (tests, tests_ran) = run_tests(root)?;
    let layout = layout_rows(root);
    let timing = figures::generous_rows(root)?;
    let (mut passed, mut failed) = tests.counts();
    // A build that failed, or a test that took its whole program down.
    failed += usize::from(failed == 0 && !tests_ran);

    let rest = [("layout", layout), ("numbers", tests.measured_rows()), ("figures", timing)];
    let rows = || rest.iter().flat_map(|(_, rows)| rows);
    passed += rows().filter(|row| row.verdict == Verdict::Passed).count();
    failed += rows().filter(|row| row.verdict == Verdict::Failed).count();

    let mut table = Table::default();
    table.add("tests", tests.package_rows());
    rest.into_iter().for_each(|(heading, rows)| table.add(heading, rows));
    println!("\n{table}");
    report_tests(&tests, tests_ran);
    println!("{passed} passed, {failed} failed");
    if failed == 0 { Ok(()) } else { Err("not everything that is claimed holds".to_owned()) }
}

fn run_tests(root: &Path) -> Result<(TestOutput, bool), String> {
    let mut output = TestOutput::default();
    let mut command = Command::new("cargo");
    command.args(TESTS).current_dir(root).env("INSTA_UPDATE", "no").env_remove("INSTA_FORCE_PASS");
    let status = read_lines(&mut command, |line| {
        println!("{line}");
        output.read(line);
    })?;
    Ok((output, status.success()))
}

/// One row a rule of the layout, however many places break it.
fn layout_rows(root: &Path) -> Vec<Row> {
    let row = |(rule, problems): (&str, Vec<String>)| {
        problems.iter().for_each(|problem| println!("{problem}"));
        let measured = format!("{} breaks", problems.len());
        let verdict = Verdict::of(problems.is_empty());
        Row { name: rule.to_owned(), measured, allowed: "none".to_owned(), verdict }
    };
    tidy::problems(root).into_iter().map(row).collect()
}

fn report_tests(tests: &TestOutput, ran: bool) {
    if tests.skipped() > 0 {
        println!("{} tests skipped: MUSCULO_DATA is not set", tests.skipped());
    }
    for name in tests.failed() {
        println!("failed: {name}");
    }
    if !ran && tests.failed().is_empty() {
        println!("failed: cargo test did not get through; see its messages above");
    }
}
