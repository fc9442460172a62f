//! `cargo xtask ratios [CRATE]`: every speed and cost that is claimed, beside
//! what it is compared with, in one run.
//!
//! The programs are those of the package `benches` named `CRATE_ratios` or
//! `CRATE_peers`; a crate with a hyphen has an underscore there. `verify` runs
//! the same programs and allows more, because seconds on a shared machine vary.

use std::path::Path;
use std::process::Command;

use crate::TaskResult;
use crate::number::{Bound, leading};
use crate::process::{cargo, read_lines};
use crate::table::{Row, Verdict};

/// How much worse than claimed a ratio may be in [`generous`].
///
/// Two runs on a shared machine of two cores differ by up to a half; a factor
/// of two lets that pass and still shows a lost vectorisation or a lost order
/// of growth. Counts that must be zero stay zero.
const GENEROUS: f64 = 2.0;

/// How the names of times end.
const TIME_UNITS: [&str; 5] = ["[ns]", "[us]", "[µs]", "[ms]", "[s]"];

/// One printed line, taken apart.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    name: String,
    measured: String,
    allowed: String,
    ok: bool,
    /// A time beside nothing: it depends on the machine and what else it does.
    bare_time: bool,
}

/// Prints the programs' lines as they come; fails where one falls short.
pub(crate) fn run(root: &Path, only: Option<&str>) -> TaskResult {
    let mut lines = Vec::new();
    for name in build(root, only)? {
        lines.extend(measure(root, &name)?);
    }
    let short = lines.iter().filter(|line| !line.ok).count();
    println!("{} figures, {short} short", lines.len());
    if short == 0 { Ok(()) } else { Err(format!("{short} figures fall short of what is claimed")) }
}

/// Runs all programs; a row fails where it falls short by more than
/// [`GENEROUS`] in two runs. Times beside nothing are told and promise nothing.
pub(crate) fn generous(root: &Path) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for name in build(root, None)? {
        let again = || -> Result<Vec<Row>, String> {
            Ok(measure(root, &name)?.into_iter().map(Line::into_generous_row).collect())
        };
        let mut first = again()?;
        if first.iter().any(failed) {
            println!("\nonce more, since a figure fell short:");
            let second = again()?;
            for row in first.iter_mut().filter(|row| failed(row)) {
                if let Some(better) = second.iter().find(|s| s.name == row.name && !failed(s)) {
                    *row = better.clone();
                }
            }
        }
        rows.extend(first);
    }
    Ok(rows)
}

fn failed(row: &Row) -> bool {
    row.verdict == Verdict::Failed
}

/// Builds the programs and returns their names.
fn build(root: &Path, only: Option<&str>) -> Result<Vec<String>, String> {
    let names = programs(root, only)?;
    if !names.is_empty() {
        cargo(root, &["build", "--release", "--locked", "-p", "benches", "--bins"])?;
    }
    Ok(names)
}

/// Runs one program, and reads its lines as they come.
fn measure(root: &Path, name: &str) -> Result<Vec<Line>, String> {
    println!("\n{name}: ours, the other's, ratio, allowed");
    let mut command = Command::new("cargo");
    command.args(["run", "--quiet", "--release", "--locked", "-p", "benches", "--bin", name]);
    // A program that prints tables too leaves them out.
    command.args(["--", "ratios"]);
    let mut lines = Vec::new();
    let status = read_lines(command.current_dir(root), |text| {
        println!("{text}");
        lines.extend(Line::read(text));
    })?;
    if lines.is_empty() {
        return Err(format!("{name} printed no figure"));
    }
    let told = lines.iter().any(|line| !line.ok);
    if !status.success() && !told {
        return Err(format!("{name} ended with {status}"));
    }
    Ok(lines)
}

/// The ratio programs there are, in the order of their names.
fn programs(root: &Path, only: Option<&str>) -> Result<Vec<String>, String> {
    let folder = root.join("benches/src/bin");
    let entries = folder.read_dir().map_err(|error| format!("{}: {error}", folder.display()))?;
    let stems = entries.flatten().filter_map(|entry| {
        let stem = entry.path().file_stem()?.to_str()?.to_owned();
        (stem.ends_with("_ratios") || stem.ends_with("_peers")).then_some(stem)
    });
    let mut names: Vec<String> = stems.collect();
    names.sort_unstable();
    if let Some(only) = only {
        let crate_name = only.replace('-', "_");
        names.retain(|name| name.rsplit_once('_').is_some_and(|(of, _)| of == crate_name));
        if names.is_empty() {
            return Err(format!("no program in benches/src/bin measures {only}"));
        }
    }
    Ok(names)
}

impl Line {
    /// Reads a figure, in either form that `main.rs` tells of; `None` for other
    /// text.
    fn read(text: &str) -> Option<Self> {
        let columns: Vec<&str> = if text.contains('\t') {
            text.split('\t').map(str::trim).collect()
        } else {
            text.split_whitespace().collect()
        };
        let [name @ .., _ours, other, measured, allowed, verdict] = &columns[..] else {
            return None;
        };
        let ok = match *verdict {
            "ok" => true,
            "SHORT" => false,
            _ => return None,
        };
        let name = name.strip_prefix(&["ratio"]).unwrap_or(name).join(" ");
        let bare_time = *other == "-" && TIME_UNITS.iter().any(|unit| name.ends_with(unit));
        let [measured, allowed] = [*measured, *allowed].map(str::to_owned);
        Some(Self { name, measured, allowed, ok, bare_time })
    }

    fn into_generous_row(self) -> Row {
        if self.bare_time {
            let Self { name, measured, .. } = self;
            return Row { name, measured, allowed: "-".to_owned(), verdict: Verdict::Told };
        }
        let (Some(value), Some(bound)) = (leading(&self.measured), self.bound()) else {
            let verdict = if self.ok { Verdict::Told } else { Verdict::Failed };
            return Row {
                name: self.name,
                measured: self.measured,
                allowed: self.allowed,
                verdict,
            };
        };
        let (bound, sign) = match bound.widened(GENEROUS) {
            wide @ Bound::AtMost(limit) => (wide, short(limit)),
            wide @ Bound::AtLeast(limit) => (wide, format!(">= {}", short(limit))),
        };
        let verdict = Verdict::of(self.ok || bound.holds(value));
        Row { name: self.name, measured: self.measured, allowed: sign, verdict }
    }

    /// What is allowed, as a bound. Whether a bare number is a most or a least
    /// is told by the program's own verdict.
    fn bound(&self) -> Option<Bound> {
        let bound = Bound::read(&self.allowed)?;
        match bound {
            Bound::AtMost(limit) if bound.holds(leading(&self.measured)?) != self.ok => {
                Some(Bound::AtLeast(limit))
            }
            _ => Some(bound),
        }
    }
}

/// A limit in three digits after the point at most, without idle zeros.
fn short(limit: f64) -> String {
    if limit != 0.0 && limit.abs() < 1e-2 {
        return format!("{limit:.0e}");
    }
    let text = format!("{limit:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_lines_and_nothing_else() {
        let line = Line::read("simbp_vf: certified [ns]   57.1   63.0   0.91   1  ok").unwrap();
        assert_eq!((line.name.as_str(), line.ok), ("simbp_vf: certified [ns]", true));
        assert_eq!((line.measured.as_str(), line.allowed.as_str()), ("0.91", "1"));
        assert_eq!(Line::read("MUSCULO_DATA is not set: random queries"), None);
        assert_eq!(Line::read("ok"), None);
        let line = Line::read("ratio\trefit, 80k  \t  12.0 us\t 48.0 us\t0.250\t0.45\tok").unwrap();
        assert_eq!((line.name.as_str(), line.allowed.as_str()), ("refit, 80k", "0.45"));
    }

    #[test]
    fn limits_are_short() {
        let texts = [0.0, 2.0, 2.0 / 3.0, 1e-8, 150.0].map(short);
        assert_eq!(texts, ["0", "2", "0.667", "1e-8", "150"]);
    }

    #[test]
    fn generous_by_a_factor_on_the_right_side() {
        let verdict = |text: &str| Line::read(text).unwrap().into_generous_row().verdict;
        assert_eq!(verdict("time 1 1 0.9 1 ok"), Verdict::Passed);
        assert_eq!(verdict("time 1 1 1.9 1 SHORT"), Verdict::Passed);
        assert_eq!(verdict("time 1 1 2.1 1 SHORT"), Verdict::Failed);
        assert_eq!(verdict("speed-up 1 1 6 >=10 SHORT"), Verdict::Passed);
        assert_eq!(verdict("speed-up 1 1 4 >=10 SHORT"), Verdict::Failed);
        assert_eq!(verdict("speed-up 1 1 4 10 SHORT"), Verdict::Failed);
        assert_eq!(verdict("missed 1 - 1 0 SHORT"), Verdict::Failed);
        assert_eq!(verdict("anything 1 - 1 - ok"), Verdict::Told);
        assert_eq!(verdict("worst [us] 300 - 300 100 SHORT"), Verdict::Told);
        assert_eq!(verdict("mean [us] 300 100 3 1 SHORT"), Verdict::Failed);
    }
}
