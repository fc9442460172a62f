//! Closing table: checks with measured values and bounds.

use std::fmt;

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Passed,
    Failed,
    /// Measured without a bound.
    Unbounded,
}

/// Line of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) measured: String,
    pub(crate) allowed: String,
    pub(crate) verdict: Verdict,
    /// Command that prints the line alone.
    pub(crate) command: String,
}

/// Rows under headings.
#[derive(Default)]
pub(crate) struct Table {
    parts: Vec<(&'static str, Vec<Row>)>,
}

impl Verdict {
    pub(crate) fn of(passed: bool) -> Self {
        if passed { Self::Passed } else { Self::Failed }
    }
}

impl Table {
    /// Adds the rows of a part; without rows, nothing.
    pub(crate) fn add(&mut self, heading: &'static str, rows: Vec<Row>) {
        if !rows.is_empty() {
            self.parts.push((heading, rows));
        }
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Columns are as wide as their widest entries.
        let (mut name, mut measured, mut allowed) = (0, "measured".len(), "allowed".len());
        for (_, rows) in &self.parts {
            for row in rows {
                name = name.max(row.name.chars().count());
                measured = measured.max(row.measured.chars().count());
                allowed = allowed.max(row.allowed.chars().count());
            }
        }
        writeln!(f, "{:name$}  {:>measured$}  {:>allowed$}", "checked", "measured", "allowed")?;

        for (heading, rows) in &self.parts {
            writeln!(f, "\n{heading}")?;
            for row in rows {
                let mark = match row.verdict {
                    Verdict::Passed => "ok",
                    Verdict::Failed => "FAILED",
                    Verdict::Unbounded => "",
                };

                let line = format!(
                    "{:name$}  {:>measured$}  {:>allowed$}  {mark:6}  {}",
                    row.name, row.measured, row.allowed, row.command
                );
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_and_empty_parts_are_left_out() {
        let row = |name: &str, verdict| Row {
            name: name.into(),
            measured: "1".into(),
            allowed: "2".into(),
            verdict,
            command: "cargo test".into(),
        };
        let mut table = Table::default();
        table.add("none", vec![]);
        table.add("some", vec![row("a", Verdict::Passed), row("longer", Verdict::Failed)]);
        let expected = "\
checked  measured  allowed

some
a              1        2  ok      cargo test
longer         1        2  FAILED  cargo test
";
        assert_eq!(table.to_string(), expected);
    }
}
