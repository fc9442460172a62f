//! Output of test programs, read line by line.

use crate::number::{Bound, leading};
use crate::table::{Row, Verdict};

/// Tests by package, the numbers that they printed, and the names of failed tests.
#[derive(Debug, Default)]
pub(crate) struct TestOutput {
    packages: Vec<Package>,
    /// Number of the package whose tests run.
    current: usize,
    /// Test whose output is shown.
    shown: String,
    /// Failed tests, as `package: test`.
    pub(crate) failed: Vec<String>,
    /// Number of tests that need the data folder and found none.
    pub(crate) skipped: usize,
}

#[derive(Debug, Default)]
struct Package {
    name: String,
    passed: usize,
    failed: usize,
    /// Numbers that its tests printed.
    measured: Vec<Row>,
}

impl TestOutput {
    /// Reads the next line.
    pub(crate) fn read(&mut self, line: &str) {
        let text = line.trim();
        if let Some(name) = text.strip_prefix("Doc-tests ") {
            self.begin(&name.replace('_', "-"));
        } else if let Some(result) = text.strip_prefix("test result: ") {
            self.count(result);
        } else if let Some(test) = text.strip_prefix("test ")
            && let Some(name) = test.strip_suffix("... FAILED")
        {
            self.failed.push(format!("{}: {}", self.package(), name.trim()));
        } else if let Some(name) = text.strip_prefix("---- ") {
            name.trim_end_matches(" stdout ----").clone_into(&mut self.shown);
        } else if let Some(row) = text.strip_prefix("measured: ").and_then(measured) {
            self.add_measured(row);
        } else if text.contains("skipped") && text.contains("MUSCULO_DATA") {
            self.skipped += 1;
        }
    }

    /// Adds a number unless it is there: a helper that several tests call prints it several times.
    fn add_measured(&mut self, row: Row) {
        let test = &self.shown;
        let Some(package) = self.packages.get_mut(self.current) else { return };
        let is_same = |other: &Row| other.name == row.name && other.measured == row.measured;
        if !package.measured.iter().any(is_same) {
            let command = format!("cargo test -p {} {test} -- --show-output", package.name);
            package.measured.push(Row { command, ..row });
        }
    }

    /// Returns the name of the package whose tests run.
    fn package(&self) -> &str {
        self.packages.get(self.current).map_or("", |package| &package.name)
    }

    /// Returns a row per package that has tests, by name: programs end in any order.
    pub(crate) fn package_rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        for Package { name, passed, failed, .. } in self.by_name() {
            let count = passed + failed;
            if count > 0 {
                rows.push(Row {
                    name: name.clone(),
                    measured: format!("{passed} of {count}"),
                    allowed: "all".to_owned(),
                    verdict: Verdict::of(*failed == 0),
                    command: format!("cargo test -p {name}"),
                });
            }
        }
        rows
    }

    /// Returns the numbers that tests printed, package by package.
    pub(crate) fn measured_rows(&self) -> Vec<Row> {
        self.by_name().into_iter().flat_map(|package| package.measured.clone()).collect()
    }

    fn by_name(&self) -> Vec<&Package> {
        let mut packages: Vec<&Package> = self.packages.iter().collect();
        packages.sort_by_key(|package| &package.name);
        packages
    }

    /// Returns the numbers of passed and failed tests.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let (mut passed, mut failed) = (0, 0);
        for package in &self.packages {
            passed += package.passed;
            failed += package.failed;
        }
        (passed, failed)
    }

    /// Makes a package the current one, and adds it if it is new.
    pub(crate) fn begin(&mut self, name: &str) {
        self.current = 0;
        while self.packages.get(self.current).is_some_and(|package| package.name != name) {
            self.current += 1;
        }
        if self.current == self.packages.len() {
            self.packages.push(Package { name: name.to_owned(), ..Package::default() });
        }
    }

    /// Reads `ok. 12 passed; 1 failed; 0 ignored; …`.
    fn count(&mut self, result: &str) {
        if self.packages.is_empty() {
            self.begin("tests");
        }
        let package = &mut self.packages[self.current];
        package.passed += number_before(result, " passed");
        package.failed += number_before(result, " failed");
    }
}

/// Reads the number before a word, 0 without one.
fn number_before(text: &str, word: &str) -> usize {
    let before = text.split(word).next().unwrap_or("").trim_end();
    before.rsplit(' ').next().and_then(|number| number.parse().ok()).unwrap_or(0)
}

/// Reads `name | value | bound`.
fn measured(text: &str) -> Option<Row> {
    let [name, measured, allowed] = text.split('|').map(str::trim).collect::<Vec<_>>()[..] else {
        return None;
    };
    let verdict = match (leading(measured), Bound::read(allowed)) {
        (Some(value), Some(bound)) => Verdict::of(bound.holds(value)),
        _ => Verdict::Unbounded,
    };
    let [name, measured, allowed] = [name, measured, allowed].map(str::to_owned);
    Some(Row { name, measured, allowed, verdict, command: String::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: &str = "\
running 2 tests
test tree::refits ... ok
test tree::pairs ... FAILED
---- tree::refits stdout ----
measured: lost pairs | 0 | 0
measured: time [ms] | 3.5 | 2
measured: speed-up | 12x | >= 10x
measured: bodies | 25 | -
test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out
";
    const INTEGRATION: &str = "\
anatomy: skipped, MUSCULO_DATA is not set
test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out
";
    const NONE: &str = "test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out";
    const DOCUMENTATION: &str = "\
   Doc-tests kdop
test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out
";

    #[test]
    fn counts_by_package_and_collects_numbers() {
        use Verdict::{Failed, Passed, Unbounded};
        let mut output = TestOutput::default();
        for (package, text) in [
            ("kdop", UNIT),
            ("musculo-collide", NONE),
            ("kdop", INTEGRATION),
            ("ccd", DOCUMENTATION),
        ] {
            output.begin(package);
            text.lines().for_each(|line| output.read(line));
        }
        let rows = output.package_rows();
        assert_eq!(rows.len(), 1, "a package without tests has no row");
        assert_eq!((rows[0].name.as_str(), rows[0].measured.as_str()), ("kdop", "8 of 9"));
        assert_eq!(rows[0].verdict, Failed);
        assert_eq!((output.counts(), output.skipped), ((8, 1), 1));
        assert_eq!(output.failed, ["kdop: tree::pairs"]);
        let verdicts: Vec<Verdict> = output.measured_rows().iter().map(|row| row.verdict).collect();
        assert_eq!(verdicts, [Passed, Failed, Passed, Unbounded]);
        assert_eq!(
            output.measured_rows()[0].command,
            "cargo test -p kdop tree::refits -- --show-output"
        );
    }
}
