//! What `cargo test` prints, read line by line.

use crate::number::{Bound, leading};
use crate::table::{Row, Verdict};

/// Tests of one package, the numbers that they printed, and which failed.
#[derive(Debug, Default)]
pub(crate) struct TestOutput {
    packages: Vec<Package>,
    measured: Vec<Row>,
    failed: Vec<String>,
    skipped: usize,
}

#[derive(Debug)]
struct Package {
    name: String,
    passed: usize,
    failed: usize,
}

impl TestOutput {
    /// Takes the next line.
    pub(crate) fn read(&mut self, line: &str) {
        let text = line.trim();
        if let Some(name) = package_of(text) {
            self.begin(name);
        } else if let Some(rest) = text.strip_prefix("test result: ") {
            self.count(rest);
        } else if let Some(name) =
            text.strip_prefix("test ").and_then(|t| t.strip_suffix("... FAILED"))
        {
            let package = self.packages.last().map_or("", |package| &package.name);
            self.failed.push(format!("{package}: {}", name.trim()));
        } else if let Some(row) = text.strip_prefix("measured: ").and_then(measured) {
            self.measured.push(row);
        } else if text.ends_with("skipped, MUSCULO_DATA is not set")
            || text.contains("skipped: MUSCULO_DATA")
        {
            self.skipped += 1;
        }
    }

    /// A row for each package that has tests.
    pub(crate) fn package_rows(&self) -> Vec<Row> {
        let tested = self.packages.iter().filter(|package| package.passed + package.failed > 0);
        let row = |package: &Package| Row {
            name: package.name.clone(),
            measured: format!("{} of {}", package.passed, package.passed + package.failed),
            allowed: "all".to_owned(),
            verdict: Verdict::of(package.failed == 0),
        };
        tested.map(row).collect()
    }

    /// The numbers that tests printed, each once.
    pub(crate) fn measured_rows(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = Vec::new();
        for row in &self.measured {
            if !rows.contains(row) {
                rows.push(row.clone());
            }
        }
        rows
    }

    /// Tests that failed, as `package: test`.
    pub(crate) fn failed(&self) -> &[String] {
        &self.failed
    }

    /// How many tests passed and failed.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let sum = |count: fn(&Package) -> usize| self.packages.iter().map(count).sum();
        (sum(|package| package.passed), sum(|package| package.failed))
    }

    /// How many tests said that they need the data folder and found none.
    pub(crate) fn skipped(&self) -> usize {
        self.skipped
    }

    fn begin(&mut self, name: String) {
        if self.packages.iter().all(|package| package.name != name) {
            self.packages.push(Package { name, passed: 0, failed: 0 });
        } else if let Some(at) = self.packages.iter().position(|package| package.name == name) {
            let package = self.packages.remove(at);
            self.packages.push(package);
        }
    }

    /// Reads `ok. 12 passed; 1 failed; 0 ignored; …`.
    fn count(&mut self, result: &str) {
        if self.packages.is_empty() {
            self.begin("tests".to_owned());
        }
        let number = |word: &str| {
            let before = result.split(word).next()?.trim_end();
            before.rsplit(' ').next()?.parse::<usize>().ok()
        };
        if let Some(package) = self.packages.last_mut() {
            package.passed += number(" passed").unwrap_or(0);
            package.failed += number(" failed").unwrap_or(0);
        }
    }
}

/// The package that a line opens: by the unit tests that cargo runs first in
/// each, or by its documentation's tests. Integration tests follow the unit
/// tests of their package.
fn package_of(line: &str) -> Option<String> {
    if let Some(name) = line.strip_prefix("Doc-tests ") {
        return Some(name.replace('_', "-"));
    }
    let binary = line.strip_prefix("Running unittests ")?.rsplit('/').next()?;
    let name = binary.trim_end_matches(')');
    Some(name.rsplit_once('-').map_or(name, |(name, _)| name).replace('_', "-"))
}

fn measured(text: &str) -> Option<Row> {
    let [name, measured, allowed] = text.split('|').map(str::trim).collect::<Vec<_>>()[..] else {
        return None;
    };
    let verdict = match (leading(measured), Bound::read(allowed)) {
        (Some(value), Some(bound)) => Verdict::of(bound.holds(value)),
        _ => Verdict::Unbounded,
    };
    Some(Row { name: name.into(), measured: measured.into(), allowed: allowed.into(), verdict })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = "\
   Compiling kdop v0.1.0
     Running unittests src/lib.rs (target/debug/deps/kdop-0a1b)
running 2 tests
test tree::refits ... ok
test tree::pairs ... FAILED
measured: lost pairs | 0 | 0
measured: time [ms] | 3.5 | 2
measured: speed-up | 12x | >= 10x
measured: bodies | 25 | -
test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out
     Running tests/brute_force.rs (target/debug/deps/brute_force-2c3d)
anatomy: skipped, MUSCULO_DATA is not set
test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out
     Running unittests src/lib.rs (target/debug/deps/musculo_collide-4e5f)
test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out
   Doc-tests kdop
test result: ok. 4 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out
";

    #[test]
    fn counts_by_package_and_collects_numbers() {
        use Verdict::{Failed, Passed, Unbounded};
        let mut output = TestOutput::default();
        OUTPUT.lines().for_each(|line| output.read(line));
        let rows = output.package_rows();
        assert_eq!(rows.len(), 1, "a package without tests has no row");
        assert_eq!((rows[0].name.as_str(), rows[0].measured.as_str()), ("kdop", "8 of 9"));
        assert_eq!(rows[0].verdict, Failed);
        assert_eq!((output.counts(), output.skipped()), ((8, 1), 1));
        assert_eq!(output.failed(), ["kdop: tree::pairs"]);
        let verdicts: Vec<Verdict> = output.measured_rows().iter().map(|row| row.verdict).collect();
        assert_eq!(verdicts, [Passed, Failed, Passed, Unbounded]);
    }
}
