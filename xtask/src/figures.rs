//! Figures of the program `benches`: speeds and costs beside what they are compared with.
//!
//! `cargo xtask ratios` holds each figure to its bound. `verify` spends less time on each and
//! allows more, because times on a shared machine vary; it builds no other library, so that figures
//! beside those are held by `cargo xtask ratios` and, quickly, by `cargo xtask ratios --quick`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::TaskResult;
use crate::process::read_lines;
use crate::table::{Row, Verdict};

/// Factor by which a figure may exceed its bound in [`generous_rows`].
///
/// Two runs on a shared machine of two cores differ by up to a half. A factor of two lets that
/// pass, and still shows a lost vectorization or a lost order of growth. Counts that must be zero
/// stay zero.
const GENEROUS: f64 = 2.0;

/// Units of times.
const TIME_UNITS: [&str; 4] = ["ns", "us", "ms", "s"];

/// Arguments of cargo that build `benches` for verification, without charts and other libraries.
///
/// The features are those of the program, which is named for their sake: cargo then takes all
/// libraries from its build, if there is one, as from the first command of the README.
const WITHOUT_PEERS: &[&str] = &[
    "--release",
    "--locked",
    "-p=cli",
    "-p=benches",
    "--bin=benches",
    "--no-default-features",
    "--features=benches/figures",
];

/// Arguments that build it with other libraries, as users build it.
const WITHOUT_CHARTS: &[&str] =
    &["--release", "--locked", "-p=benches", "--no-default-features", "--features=peers"];

/// The same with all.
const WITH_CHARTS: &[&str] = &["--release", "--locked", "-p=benches", "--features=peers"];

/// Crates whose figures are of few crates.
const OF_FEW_CRATES: [&str; 6] = ["ccd", "distance-field", "kdop", "medial", "overlap", "response"];

/// Group of [`OF_FEW_CRATES`] whose figures take longest.
const LONGEST: &str = "response";

/// One figure, as `benches` prints it.
#[derive(Clone, Debug, PartialEq)]
struct Figure {
    group: String,
    name: String,
    ours: f64,
    other: Option<f64>,
    unit: String,
    /// Value that is bounded.
    measured: f64,
    /// Upper bound; `None` where nothing is promised.
    allowed: Option<f64>,
    /// `ok` or `SHORT`.
    verdict: String,
}

/// Prints the figures of the named crates, or of all; fails where one exceeds its bound.
pub(crate) fn ratios(root: &Path, names: &[&str]) -> TaskResult {
    let crates = if names.first() == Some(&"--only") { names.get(2..) } else { Some(names) };
    let crates = crates.unwrap_or_default();

    // Figures of few crates build without the features of charts.
    let mut needs_charts = crates.is_empty();
    for name in crates {
        needs_charts |= !OF_FEW_CRATES.contains(name);
    }
    let package = if needs_charts { WITH_CHARTS } else { WITHOUT_CHARTS };
    report(&run_benches(root, package, &[&["ratios"], names].concat())?)
}

/// Prints the figures of the endurance test; fails where memory is left behind.
pub(crate) fn soak(root: &Path) -> TaskResult {
    report(&run_benches(root, WITH_CHARTS, &["soak"])?)
}

fn report(figures: &[Figure]) -> TaskResult {
    let short = figures.iter().filter(|figure| figure.is_short()).count();
    println!("{} figures, {short} short", figures.len());
    if short == 0 { Ok(()) } else { Err(format!("{short} figures exceed their bounds")) }
}

/// Builds the program of the figures that verification holds.
pub(crate) fn build(root: &Path) -> TaskResult {
    build_program(root, WITHOUT_PEERS)?;
    Ok(())
}

/// Prints the figures of the named crates, or of all, that need no charts, those beside other libraries
/// among them, with less time on each and bounds that are wider by [`GENEROUS`]; fails where one exceeds
/// its bound twice.
pub(crate) fn quick_ratios(root: &Path, names: &[&str]) -> TaskResult {
    if let Some(name) = names.iter().find(|name| !OF_FEW_CRATES.contains(name)) {
        return Err(format!("no quick figures of {name}: there are those of {OF_FEW_CRATES:?}"));
    }
    let rows = generous_rows(root, WITHOUT_CHARTS, names)?;
    let short = rows.iter().filter(|row| row.verdict == Verdict::Failed).count();
    println!("{} figures, {short} beyond twice their bounds", rows.len());
    if short == 0 { Ok(()) } else { Err(format!("{short} figures exceed twice their bounds")) }
}

/// Returns the figures that verification holds: those beside plain references.
pub(crate) fn verified_rows(root: &Path) -> Result<Vec<Row>, String> {
    generous_rows(root, WITHOUT_PEERS, &[])
}

/// Returns the figures of the named crates, or all, as rows of the closing table, which fail where they
/// exceed [`GENEROUS`] times their bounds in two runs.
fn generous_rows(root: &Path, package: &[&str], names: &[&str]) -> Result<Vec<Row>, String> {
    let mut figures = run_quickly(root, package, names)?;

    // A second run of the crates whose figures fail, alone and for as long as `ratios` measures: the better
    // one counts.
    let failed: Vec<Figure> = figures.extract_if(.., |figure| figure.fails_generously()).collect();
    if !failed.is_empty() {
        println!("\nonce more, alone, since a figure exceeds its bound:");
        let mut groups = BTreeSet::new();
        for figure in &failed {
            groups.insert(figure.group.as_str());
        }
        let task: Vec<&str> = ["ratios"].into_iter().chain(groups).collect();
        let mut again = run_benches(root, package, &task)?;
        again.retain(|figure| !figure.fails_generously());
        for figure in failed {
            let better = again.iter().find(|again| again.name == figure.name);
            figures.push(better.unwrap_or(&figure).clone());
        }
    }
    Ok(figures.iter().map(Figure::generous_row).collect())
}

/// Runs a task of the program `benches`, and prints its figures as they come.
fn run_benches(root: &Path, package: &[&str], task: &[&str]) -> Result<Vec<Figure>, String> {
    let program = build_program(root, package)?;
    print_heading();
    read_figures(root, &program, task)
}

/// Builds the program `benches`; returns its path.
fn build_program(root: &Path, package: &[&str]) -> Result<PathBuf, String> {
    let mut command = Command::new("cargo");
    command.args(["build", "--quiet", "--message-format=json-render-diagnostics"]).args(package);
    command.current_dir(root);

    // Messages of the compiler are for reading; that about the last target names the program.
    let mut program = None;
    let status = read_lines(&mut command, |line| {
        if !line.starts_with('{') {
            println!("{line}");
        } else if let Some(path) = field(line, "executable")
            && path != "null"
        {
            program = Some(PathBuf::from(path.replace("\\\\", "\\")));
        }
    })?;
    match program {
        Some(program) if status.success() => Ok(program),
        _ => Err(format!("the build of benches ended with {status}")),
    }
}

/// Runs the figures of the named crates, or of all, in little time, those of two crates at a time.
///
/// Sides of a comparison take turns, so that what the other lane takes of the machine is taken from
/// both.
fn run_quickly(root: &Path, package: &[&str], names: &[&str]) -> Result<Vec<Figure>, String> {
    let program = build_program(root, package)?;
    let mut groups = Vec::new();
    let listed = read_lines(Command::new(&program).args(["ratios", "--list"]), |line| {
        if names.is_empty() || names.contains(&line) {
            groups.push(line.to_owned());
        }
    })?;
    if groups.is_empty() || !listed.success() {
        return Err(format!("benches ratios --list ended with {listed}"));
    }

    // The group that takes longest first: shorter ones then fill up what it leaves. One lane on a thread of its
    // own, the other here.
    groups.sort_by_key(|group| group != LONGEST);
    print_heading();
    let next = AtomicUsize::new(0);
    let (figures, others) = thread::scope(|scope| {
        let others = scope.spawn(|| run_lane(root, &program, &groups, &next));
        (run_lane(root, &program, &groups, &next), others.join())
    });
    let Ok(others) = others else { return Err("a lane of figures panicked".to_owned()) };

    // By crate, whichever lane was quicker.
    let mut figures = figures?;
    figures.extend(others?);
    figures.sort_by(Figure::compare_groups);
    Ok(figures)
}

/// Runs the figures of one crate after the other, each time the next that no lane has taken.
fn run_lane(
    root: &Path,
    program: &Path,
    groups: &[String],
    next: &AtomicUsize,
) -> Result<Vec<Figure>, String> {
    let mut figures = Vec::new();
    while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed)) {
        figures.extend(read_figures(root, program, &["ratios", "--quick", group])?);
    }
    Ok(figures)
}

fn print_heading() {
    println!(
        "\n{:<52} {:>10} {:>10}    {:>9} {:>9}",
        "figure", "ours", "other", "measured", "bound"
    );
}

/// Runs a task, and prints its figures as they come.
fn read_figures(root: &Path, program: &Path, task: &[&str]) -> Result<Vec<Figure>, String> {
    let mut figures = Vec::new();
    let status = read_lines(Command::new(program).args(task).current_dir(root), |line| {
        let figure = Figure::read(line);
        match &figure {
            Some(figure) => println!("{}", figure.line()),
            None => println!("{line}"),
        }
        figures.extend(figure);
    })?;

    // A program that fails without a figure beyond its bound has another fault.
    let is_explained = figures.iter().any(Figure::is_short);
    if figures.is_empty() || !(status.success() || is_explained) {
        return Err(format!("benches {} ended with {status}", task.join(" ")));
    }
    Ok(figures)
}

impl Figure {
    /// Reads a line of JSON; `None` for any other line.
    fn read(line: &str) -> Option<Self> {
        let text = |name: &str| field(line, name).map(str::to_owned);
        let number = |name: &str| field(line, name)?.parse().ok();
        Some(Self {
            group: text("group")?,
            name: text("name")?,
            ours: number("ours").unwrap_or(f64::NAN),
            other: number("other"),
            unit: text("unit")?,
            measured: number("measured").unwrap_or(f64::NAN),
            allowed: number("allowed"),
            verdict: text("verdict")?,
        })
    }

    /// Orders by crate.
    fn compare_groups(&self, other: &Self) -> std::cmp::Ordering {
        self.group.cmp(&other.group)
    }

    fn is_short(&self) -> bool {
        self.verdict != "ok"
    }

    /// Returns the bound that `verify` holds the figure to; `None` where it promises nothing, as
    /// a time beside nothing does, which depends on the machine and its load.
    fn generous_bound(&self) -> Option<f64> {
        let is_bare_time = self.other.is_none() && TIME_UNITS.contains(&self.unit.as_str());
        self.allowed.filter(|_| !is_bare_time).map(|allowed| allowed * GENEROUS)
    }

    fn fails_generously(&self) -> bool {
        // A value that is not a number keeps no bound.
        self.generous_bound().is_some_and(|bound| self.measured.is_nan() || self.measured > bound)
    }

    /// Formats a row for reading: costs, measured value, bound and verdict.
    fn line(&self) -> String {
        let Self { name, unit, verdict, .. } = self;
        let [ours, measured] = [self.ours, self.measured].map(digits);
        let [other, allowed] = [self.other, self.allowed].map(digits_or_dash);
        format!("{name:<52} {ours:>10} {other:>10} {unit:<2} {measured:>9} {allowed:>9} {verdict}")
    }

    /// Returns a row of the closing table.
    fn generous_row(&self) -> Row {
        let bound = self.generous_bound();
        // A figure without a bound is shown, and promises nothing.
        let verdict = match bound {
            Some(_) => Verdict::of(!self.fails_generously()),
            None => Verdict::Unbounded,
        };
        Row {
            name: self.name.clone(),
            measured: digits(self.measured),
            allowed: digits_or_dash(bound),
            verdict,
            command: format!("cargo xtask ratios --only \"{}\" {}", self.name, self.group),
        }
    }
}

/// Returns the value of a field of a flat object, whose texts have no escapes: a crate that reads
/// all of JSON would take longer to build than everything else here.
pub(crate) fn field<'a>(object: &'a str, name: &str) -> Option<&'a str> {
    let (_, value) = object.split_once(&format!("\"{name}\":"))?;
    match value.strip_prefix('"') {
        Some(text) => text.split('"').next(),
        None => value.split([',', '}']).next(),
    }
}

fn digits_or_dash(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), digits)
}

/// Formats about three digits, as short as they can be written.
fn digits(value: f64) -> String {
    match value.abs() {
        v if v != 0.0 && !(1e-2..1e6).contains(&v) => format!("{value:.1e}"),
        v if v >= 100.0 => format!("{value:.0}"),
        _ => {
            let text = format!("{value:.3}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(measured: f64, other: Option<f64>, unit: &str, allowed: Option<f64>) -> Figure {
        let [group, name, unit] = ["kdop", "refit", unit].map(str::to_owned);
        let ours = measured * other.unwrap_or(1.0);
        let holds = allowed.is_none_or(|allowed| measured <= allowed);
        let verdict = if holds { "ok" } else { "SHORT" }.to_owned();
        Figure { group, name, ours, other, unit, measured, allowed, verdict }
    }

    #[test]
    fn lines_of_json_are_figures_and_nothing_else_is() {
        let line = r#"{"group":"kdop","name":"refit","ours":2.0,"other":null,"unit":"us",
                       "measured":2.0,"allowed":0.5,"verdict":"SHORT"}"#;
        let read = Figure::read;
        assert_eq!(read(line), Some(figure(2.0, None, "us", Some(0.5))));
        assert_eq!(read("MUSCULO_DATA is not set"), None);
        assert_eq!(read("3"), None);
    }

    #[test]
    fn bounds_are_generous_by_a_factor() {
        let verdict = |figure: Figure| figure.generous_row().verdict;
        assert_eq!(verdict(figure(0.9, Some(1.0), "us", Some(1.0))), Verdict::Passed);
        assert_eq!(verdict(figure(1.9, Some(1.0), "us", Some(1.0))), Verdict::Passed);
        assert_eq!(verdict(figure(2.1, Some(1.0), "us", Some(1.0))), Verdict::Failed);
        assert_eq!(verdict(figure(1.0, None, "", Some(0.0))), Verdict::Failed);
        assert_eq!(verdict(figure(f64::NAN, None, "", Some(1.0))), Verdict::Failed);
        assert_eq!(verdict(figure(1.0, None, "", None)), Verdict::Unbounded);
        assert_eq!(verdict(figure(300.0, None, "us", Some(100.0))), Verdict::Unbounded);
        assert_eq!(verdict(figure(3.0, Some(100.0), "us", Some(1.0))), Verdict::Failed);
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 2.0, 2.0 / 3.0, 1e-8, 150.25, 2e7].map(digits);
        assert_eq!(texts, ["0", "2", "0.667", "1.0e-8", "150", "2.0e7"]);
    }
}
